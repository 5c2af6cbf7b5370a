//! Closest hit and occlusion for queues of rays.
//!
//! | file | contents |
//! |---|---|
//! | `aabb` | the slab test of a ray against a padded box |
//! | `slab_conservative` | the same for boxes of nodes, with less arithmetic and a little slack |
//! | `triangle`, `sphere`, `cone` | one test per primitive: the definition of a hit |
//! | `instance` | rays into the space of a mesh, hits back out of it |
//! | `query` | the closest hit or any: the work in a leaf for either |
//! | `packet` | packets of rays, together through the binary tree |
//! | `beam` | rays that share a point, together through the wide tree |
//! | `wide_stack` | the children of a wide node onto a stack |
//! | `single_ray` | single rays through the wide tree |
//! | `coherence` | the divergence of rays |
//! | `batch_slice` | packets of a batch, for each of two kernels |
//! | `kernel_tuner` | the choice of the faster of two kernels |
//! | `counters` | counters of work |
//! | `traversal` | queues in, hits out: the choice of kernels |
//! | `isolated` | each test without a tree, for benchmarks |
//!
//! The choice between kernels stands in one place, [`Kernel`] with [`Traversal`].
//!
//! # Why no tree can lose a hit
//!
//! A hit counts only if its ray also passes the slab test of the primitive's *own* padded box, and
//! its distance is clamped to the ray's interval in that box. The slab test is monotone:
//! subtraction, multiplication by a constant, min and max all preserve order under rounding. So a
//! ray that passes a box passes every box around it, with no later entry and no earlier exit. Hence
//! every ancestor of the primitive is visited with an entry distance not beyond the hit, whatever
//! the tree: the closest hit is the brute-force one to the bit. This replaces an argument about
//! error bounds (Ize, "Robust BVH Ray Traversal", JCGT 2013) by one about order. The padding only
//! has to make sure that genuine hits pass, and the clamp only ever makes a distance more accurate.
//!
//! Through instances the argument holds twice, with a clamp to the interval in the instance's own
//! box outside: see `instance`.
//!
//! Ties in distance go to the smaller `prim_id`.

mod aabb;
mod batch_slice;
mod beam;
mod coherence;
mod cone;
mod counters;
mod instance;
pub mod isolated;
mod kernel_tuner;
#[allow(
    unsafe_code,
    reason = "the inner loop has no bounds checks; each block says why it may"
)]
mod packet;
#[allow(unsafe_code, reason = "the one instruction that has no safe name")]
mod prefetch;
mod query;
#[cfg(test)]
mod random;
#[allow(
    unsafe_code,
    reason = "the inner loop has no bounds checks; each block says why it may"
)]
mod single_ray;
mod slab_conservative;
mod sphere;
mod tracer;
mod traversal;
mod triangle;
#[allow(unsafe_code, reason = "shuffles by a table have no safe name")]
mod wide_stack;

pub use counters::TraversalStats;
pub use tracer::{PacketLanes, PacketTracer};
pub use traversal::{Kernel, Traversal};
