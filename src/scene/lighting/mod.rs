//! Lights as something to choose from, and the units that all light of a scene has.
//!
//! # Units
//! A picture holds radiance. Light of a file with units is converted so that a white Lambert
//! surface under E lux has radiance E/π:
//!
//! | light | unit of its file | value in the scene |
//! |---|---|---|
//! | directional | lux | colour E/π |
//! | point, spot | candela | colour I/π, fading with the square of the distance |
//! | emission, with KHR_materials_emissive_strength | nits | Ke = L |
//! | environment | nits | L |
//!
//! All of them are then multiplied by [`Scene::light_scale`], so that their ratios stay. A colour
//! that is shown as it is (KHR_materials_unlit, the ambient share) is no light, and is not.
//! Blender's glTF exporter multiplies watts of lamps by 683 lumens per watt unless told otherwise,
//! but not the strength of emission. Nothing tells such files apart, so nothing is undone: their
//! emission is 683 times too dim beside their lamps.

mod alias;
mod emitters;
mod light_table;

pub use alias::AliasTable;
pub use light_table::{LightShare, LightSource, LightTable};

use crate::bounds::Bounds;
use crate::scene::Scene;
use glam::{DVec3, Vec3};

/// Luminance of linear sRGB (Rec. 709).
pub fn luminance(color: Vec3) -> f64 {
    color.as_dvec3().dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// The point at which lights are compared by their irradiance.
#[derive(Clone, Copy, Debug)]
pub struct SceneMiddle {
    middle: DVec3,
    /// Distance from there to the corners of the bounds.
    reach: f64,
}

impl SceneMiddle {
    /// The middle of these bounds.
    pub fn of(bounds: Bounds) -> SceneMiddle {
        let corners = if bounds.is_empty() { [Vec3::ZERO; 2] } else { [bounds.lo, bounds.hi] };
        let [lo, hi] = corners.map(Vec3::as_dvec3);
        let reach = (hi - lo).length() / 2.0;
        SceneMiddle {
            middle: (lo + hi) / 2.0,
            reach: if reach > 0.0 { reach } else { 1.0 },
        }
    }

    /// Divisor of a light's colour by its attenuation: see [`Lights`](crate::Lights). A light
    /// inside the scene counts as if it stood at its edge.
    pub fn attenuation(&self, position: DVec3, [constant, linear, quadratic]: [f64; 3]) -> f64 {
        let squared = (position - self.middle).length_squared();
        let squared = squared.max(self.reach * self.reach);
        constant + linear * squared.sqrt() + quadratic * squared
    }
}

impl Scene {
    /// Sets [`Scene::light_scale`], and scales the emission of all materials with it. Lamps keep
    /// their colours.
    pub fn set_light_scale(&mut self, scale: f32) {
        let ratio = f64::from(scale) / f64::from(self.light_scale);
        if ratio == 1.0 {
            return;
        }
        self.light_scale = scale;
        for part in self.materials.ke.parts_mut() {
            for c in part.make_mut() {
                *c = (f64::from(*c) * ratio).min(MAX_EMISSION) as f32;
            }
        }
    }
}

/// Largest emission that is made by scaling: sums of it are finite.
const MAX_EMISSION: f64 = 1e30;

#[cfg(test)]
mod tests;
