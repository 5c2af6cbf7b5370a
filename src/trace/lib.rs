//! Everything a ray meets.

// Numbers side by side.
pub mod simd;

// Rays, where they come from, and how they wait.
pub mod packet;

// The tree over a scene.
pub mod bvh;

// What rays hit.
pub mod traverse;

// What the build may ask of the CPU.
pub mod isa;

pub use traverse::{Kernel, PacketLanes, PacketTracer, Traversal, TraversalStats, isolated};
