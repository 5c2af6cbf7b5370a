//! Shading: hits, grouped by material, become local radiance and outgoing rays, which the wavefront
//! queues and traces.
//!
//! | file | design document |
//! |---|---|
//! | `surface` | eight hits of one kind and one material |
//! | `surface_point` | geometry of the hit: point, normals, offset, by kind |
//! | `instance` | the same for hits on instances |
//! | `material` | the material's row |
//! | `light` | "Lighting model" and "Shading model": attenuation, Blinn-Phong |
//! | `bounce` | "Recursive shading model": mirror and refracted rays |
//! | `pow` | the specular power, eight lanes at a time |
//! | `texture` | the colours of textures and vertices, factors of Ka and Kd |
//!
//! The oracle does the same operations in the same order, one ray at a time.

mod bounce;
mod instance;
mod light;
mod material;
mod pow;
mod surface;
mod surface_point;
mod texture;

pub use bounce::{BounceRays, SecondaryRays, bounces, sample_ao_ray, sample_glossy};
pub use light::{LightSample, ShadeLight};
pub use material::{CurrentMaterial, ShadeMaterial};
pub use pow::pow;
pub use surface::{ShadeGroup, Surface, surface};
pub use texture::{WHITE, tint};

use glam::Vec3;
use phalanx_trace::simd::Vec3x8;

/// Broadcasts a vector to every lane.
fn wide(v: Vec3) -> Vec3x8 {
    Vec3x8::splat(v.x, v.y, v.z)
}
