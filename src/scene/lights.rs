//! Columns of the lights.

use super::{Column, Vec3s};
use glam::Vec3;

/// Lights of all shapes, in file order.
///
/// A light with an area is a point light spread out: each shadow ray goes to a point light of the
/// whole colour at one place of it, places are taken evenly by area, and the pixel is the mean. So
/// the smaller it is, the more it is the point light of its colour, and whatever its size it is
/// about as bright. That is a model and no radiometry: there is no cosine at the light, which
/// shines to all sides of each of its places. Lights themselves are not seen, and stop no rays.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Whether the light is directional (else it has a place).
    pub directional: Column<bool>,
    /// Position of a point light, centre of a sphere's, a corner of a rectangle's; or the unit
    /// direction toward a directional one.
    pub position: Vec3s,
    /// Colour L0.
    pub color: Vec3s,
    /// Attenuation const, lin and quad of what has a place, as the components x, y and z.
    pub attenuation: Vec3s,
    /// Radius of a sphere, whose surface shines; else 0.
    pub radius: Column<f32>,
    /// The two edges of a rectangle, or of any parallelogram, from its corner; else zero.
    pub edges: [Vec3s; 2],
}

/// What a light is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// In one point.
    Point,
    /// Infinitely far away.
    Directional,
    /// The surface of a sphere of this radius.
    Sphere(f32),
    /// A parallelogram of these edges.
    Rectangle([Vec3; 2]),
}

impl Lights {
    /// Number of lights.
    #[inline]
    pub fn len(&self) -> usize {
        self.directional.len()
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.directional.is_empty()
    }

    /// What light `i` is.
    pub fn shape(&self, i: usize) -> LightShape {
        let edges = [self.edges[0].get(i), self.edges[1].get(i)];
        if self.directional[i] {
            LightShape::Directional
        } else if self.radius[i] > 0.0 {
            LightShape::Sphere(self.radius[i])
        } else if edges != [Vec3::ZERO; 2] {
            LightShape::Rectangle(edges)
        } else {
            LightShape::Point
        }
    }

    /// Whether light `i` has an area.
    #[inline]
    pub fn is_area(&self, i: usize) -> bool {
        matches!(
            self.shape(i),
            LightShape::Sphere(_) | LightShape::Rectangle(_)
        )
    }

    /// The middle of a light that has a place.
    #[inline]
    pub fn center(&self, i: usize) -> Vec3 {
        match self.shape(i) {
            LightShape::Rectangle([e, f]) => (self.position.get(i) + e * 0.5) + f * 0.5,
            _ => self.position.get(i),
        }
    }

    /// Adds a point light with attenuation (const, lin, quad).
    #[inline]
    pub fn add_point(&mut self, position: Vec3, color: Vec3, attenuation: Vec3) {
        self.add(false, position, color, attenuation);
    }

    /// Adds a directional light; `toward` is the unit vector toward it.
    #[inline]
    pub fn add_directional(&mut self, toward: Vec3, color: Vec3) {
        self.add(true, toward, color, Vec3::X);
    }

    /// Adds the surface of a sphere.
    #[inline]
    pub fn add_sphere(&mut self, center: Vec3, radius: f32, color: Vec3, attenuation: Vec3) {
        self.add(false, center, color, attenuation);
        let last = self.len() - 1;
        self.radius[last] = radius;
    }

    /// Adds a rectangle, or any parallelogram, by a corner and the edges from there.
    pub fn add_rectangle(
        &mut self,
        corner: Vec3,
        edges: [Vec3; 2],
        color: Vec3,
        attenuation: Vec3,
    ) {
        self.add(false, corner, color, attenuation);
        let last = self.len() - 1;
        for (column, edge) in self.edges.iter_mut().zip(edges) {
            column.set(last, edge);
        }
    }

    fn add(&mut self, directional: bool, position: Vec3, color: Vec3, attenuation: Vec3) {
        self.directional.push(directional);
        self.position.push(position);
        self.color.push(color);
        self.attenuation.push(attenuation);
        self.radius.push(0.0);
        self.edges.iter_mut().for_each(|edge| edge.push(Vec3::ZERO));
    }
}
