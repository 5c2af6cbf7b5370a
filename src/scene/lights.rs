//! Columns of the lights.

use super::{Column, Vec3s};
use glam::Vec3;

/// Lights of both kinds, in file order.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Whether the light is directional (else a point light).
    pub directional: Column<bool>,
    /// Position of a point light, or the unit direction toward a directional one.
    pub place: Vec3s,
    /// Colour L0.
    pub color: Vec3s,
    /// Attenuation const, lin and quad of point lights, as the components x, y and z.
    pub attenuation: Vec3s,
}

impl Lights {
    /// Number of lights.
    pub fn len(&self) -> usize {
        self.directional.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.directional.is_empty()
    }

    /// Adds a point light with attenuation (const, lin, quad).
    pub fn add_point(&mut self, position: Vec3, color: Vec3, attenuation: Vec3) {
        self.directional.push(false);
        self.place.push(position);
        self.color.push(color);
        self.attenuation.push(attenuation);
    }

    /// Adds a directional light; `toward` is the unit vector toward it.
    pub fn add_directional(&mut self, toward: Vec3, color: Vec3) {
        self.directional.push(true);
        self.place.push(toward);
        self.color.push(color);
        self.attenuation.push(Vec3::X);
    }
}
