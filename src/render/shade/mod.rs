//! Shading: hits, grouped by material, become local radiance and outgoing rays, which the wavefront
//! queues and traces.
//!
//! | file | design document |
//! |---|---|
//! | `surface` | eight hits of one kind and one material |
//! | `surface_point` | geometry of the hit: point, normals, offset, by kind |
//! | `instance` | the same for hits on instances |
//! | `material` | the material: its row, or what textures make of it |
//! | `light` | "Lighting model" and "Shading model": attenuation, Blinn-Phong |
//! | `bounce` | "Recursive shading model": mirror and refracted rays |
//! | `pow` | the specular power, eight lanes at a time |
//! | `texture` | values of textures, colours of vertices |
//! | `normal_map` | shading normals turned by a texture |
//! | `terminator` | the smooth surface above a hit on one of few triangles |
//!
//! The oracle does the same operations in the same order, one ray at a time.

mod bounce;
mod instance;
mod light;
mod material;
mod normal_map;
mod pow;
mod surface;
mod surface_point;
mod terminator;
mod texture;

pub use bounce::{BounceRays, SecondaryRays, bounces, sample_ao_ray, sample_glossy};
pub use light::{LightSample, ShadeLight};
pub use material::{MaterialRow, ShadeMaterial, VariedMaterial};
pub use pow::pow;
pub use surface::{ShadeGroup, Surface, surface};
pub use terminator::TerminatorShift;

use glam::Vec3;
use phalanx_trace::simd::Vec3x8;

/// Broadcasts a vector to every lane.
fn wide(v: Vec3) -> Vec3x8 {
    Vec3x8::splat(v.x, v.y, v.z)
}
