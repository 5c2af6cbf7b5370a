//! Columns of the lights.

use super::{Column, Vec2s, Vec3s};
use glam::{Vec2, Vec3};

/// Lights of all shapes, in file order.
///
/// An area light is a point light spread out. Each shadow ray goes to one position on it, as to a
/// point light of the full colour. Positions are uniform by area, and the pixel is the mean. So a
/// small light approaches the point light of its colour, and its brightness hardly depends on its
/// size. This is a model, not radiometry: there is no cosine at the light, each of whose positions
/// emits in all directions. Lights themselves are invisible, and block no rays.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// True if the light is directional (else it has a position).
    pub directional: Column<bool>,
    /// Position of a point light, centre of a sphere light, or corner of a rectangle light. For a
    /// directional light, the unit direction toward it.
    pub position: Vec3s,
    /// Colour L0.
    pub color: Vec3s,
    /// Attenuation const, lin and quad of a light with a position, as the components x, y and z.
    pub attenuation: Vec3s,
    /// Radius of a sphere light, whose surface shines; else 0.
    pub radius: Column<f32>,
    /// The two edges of a rectangle light, or of any parallelogram, from its corner; else zero.
    pub edges: [Vec3s; 2],
    /// Unit direction of a spot light; zero for a light that emits in all directions.
    pub axis: Vec3s,
    /// Slope and intercept of a spot light's cone, as set by [`Lights::add_spot`]; (0, 1) for a
    /// light that emits in all directions.
    pub cone: Vec2s,
    /// Bits of each light, such as [`SHADOWLESS`].
    pub flags: Column<u8>,
}

/// Bit of [`Lights::flags`] for a light that nothing blocks: a fill light, which shows forms in the
/// shadow of others. No shadow ray is traced toward it.
pub const SHADOWLESS: u8 = 1;

/// Shape of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// A single point.
    Point,
    /// A direction: infinitely far away.
    Directional,
    /// The surface of a sphere of this radius.
    Sphere(f32),
    /// A parallelogram of these edges.
    Rectangle([Vec3; 2]),
}

impl LightShape {
    /// Returns true if each point may be lit from a different position.
    #[inline]
    pub fn is_area(self) -> bool {
        matches!(self, LightShape::Sphere(_) | LightShape::Rectangle(_))
    }
}

/// Smallest difference of the cosines of a spot light's two angles, as recommended by glTF.
const LEAST_CONE: f64 = 1e-3;

impl Lights {
    /// Number of lights.
    #[inline]
    pub fn len(&self) -> usize {
        self.directional.len()
    }

    /// Returns true if there are no lights.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.directional.is_empty()
    }

    /// The shape of light `i`.
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

    /// Returns true if light `i` is an area light.
    #[inline]
    pub fn is_area(&self, i: usize) -> bool {
        self.shape(i).is_area()
    }

    /// The centre of a light that has a position.
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

    /// Adds a spot light: a point light of which only a cone about the unit direction `axis` is
    /// lit. `inner` and `outer` are the angles from the axis, in radians, at which the light begins
    /// to fade and is gone: 0 ≤ inner < outer ≤ π/2.
    ///
    /// At an angle θ it is as bright as a point light times s², where s = cos θ · slope + intercept
    /// is clamped to \[0, 1\], is 1 at the inner angle and 0 at the outer one (glTF,
    /// KHR_lights_punctual).
    pub fn add_spot(
        &mut self,
        position: Vec3,
        color: Vec3,
        attenuation: Vec3,
        axis: Vec3,
        [inner, outer]: [f32; 2],
    ) {
        self.add(false, position, color, attenuation);
        let [inner, outer] = [inner, outer].map(|angle| libm::cos(f64::from(angle)));
        let slope = 1.0 / (inner - outer).max(LEAST_CONE);
        let last = self.len() - 1;
        self.axis.set(last, axis);
        self.cone.x[last] = slope as f32;
        self.cone.y[last] = (-outer * slope) as f32;
    }

    /// Returns true if light `i` is a spot light.
    #[inline]
    pub fn is_spot(&self, i: usize) -> bool {
        self.axis.get(i) != Vec3::ZERO
    }

    /// Returns true if surfaces block the rays of light `i`.
    #[inline]
    pub fn casts_shadows(&self, i: usize) -> bool {
        self.flags[i] & SHADOWLESS == 0
    }

    /// Adds a directional light; `toward` is the unit vector toward it.
    #[inline]
    pub fn add_directional(&mut self, toward: Vec3, color: Vec3) {
        self.add(true, toward, color, Vec3::X);
    }

    /// Adds a directional light that shines through everything: see [`SHADOWLESS`].
    #[inline]
    pub fn add_fill(&mut self, toward: Vec3, color: Vec3) {
        self.add_directional(toward, color);
        let last = self.len() - 1;
        self.flags[last] = SHADOWLESS;
    }

    /// Adds a sphere light, whose surface shines.
    #[inline]
    pub fn add_sphere(&mut self, center: Vec3, radius: f32, color: Vec3, attenuation: Vec3) {
        self.add(false, center, color, attenuation);
        let last = self.len() - 1;
        self.radius[last] = radius;
    }

    /// Adds a rectangle light, or any parallelogram, by a corner and the edges from there.
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
        self.axis.push(Vec3::ZERO);
        self.cone.push(Vec2::Y);
        self.flags.push(0);
    }
}
