//! Ray tracing: packets of rays, the tree over a scene, and the traversal that finds hits.

// Numbers, masks and vectors in lanes.
pub mod simd;

// Memory that will be needed.
#[allow(unsafe_code, reason = "the one instruction that has no safe name")]
mod prefetch;

// Packets of rays, camera rays, and queues.
pub mod packet;

// The tree over a scene.
pub mod bvh;

// Traversal and intersection.
mod intersect;
pub mod traverse;

// One ray, or columns of them: what embedders call.
pub mod cast;

// Instruction sets of the build and the CPU, and its caches.
pub mod cpu_caches;
pub mod isa;

// Time, even without a clock.
pub mod stopwatch;

#[cfg(test)]
#[path = "../../tests/common/full_or.rs"]
mod full_or;

pub use cast::{
    BatchError, Hit, HitBuffer, HitColumns, HitLists, Ray, RayBatch, RayBuffer, RayColumns,
};
pub use cast::{BatchFilter, PerRay, RayFilter, RayRows, RefinedHit, TMax, refine, world_corners};
#[cfg(feature = "counters")]
pub use traverse::{CountingTraversal, PacketLanes, PacketTracer};
pub use traverse::{HitWalk, Kernel, Traversal, TraversalStats};
