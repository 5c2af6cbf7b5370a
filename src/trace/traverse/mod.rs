//! Closest hit and occlusion for queues of rays.
//!
//! | file | contents |
//! |---|---|
//! | `query` | the closest hit or any: the work in a leaf for either |
//! | `next_hit` | the next hit after another, or the next few, for rays that go on through a surface |
//! | `hit_walk` | the steps of rays from hit to hit |
//! | `every_hit` | everything that a ray meets |
//! | `filtered_hit` | the closest hit that a filter accepts, for one ray |
//! | `queue_kernel` | the interface of kernels: queues in, hits or occlusion out, counters |
//! | `packet`, `packet_pairs` | packets of rays, together through the binary tree |
//! | `beam` | rays that share a point, together through the wide tree |
//! | `wide_stack` | the children of a wide node onto a stack |
//! | `single_ray` | single rays through the wide tree |
//! | `coherence` | the divergence of rays |
//! | `batch_slice` | packets of a batch, for each of two kernels |
//! | `kernel_tuner` | the choice of the faster of two kernels |
//! | `cost_tuner` | the same by what the first rays of a batch cost |
//! | `counters` | counters of work |
//! | `kernel` | the kernels by name |
//! | `traversal` | queues in, hits out: the choice of kernels |
//! | `leaf_slots` | the primitives of a leaf |
//! | `microbench` | each test without a tree, for benchmarks |
//!
//! The choice between kernels stands in one place, [`Kernel`] with [`Traversal`].

mod batch_slice;
mod beam;
mod coherence;
mod cost_tuner;
mod counters;
pub(crate) mod every_hit;
mod filtered_hit;
mod hit_walk;
mod kernel;
mod kernel_tuner;
#[allow(unsafe_code, reason = "no bounds checks; the block says why it may")]
mod leaf_slots;
#[cfg(feature = "counters")]
mod microbench;
mod next_hit;
#[allow(
    unsafe_code,
    reason = "the inner loop has no bounds checks; each block says why it may"
)]
mod packet;
mod packet_pairs;
mod prefetch;
mod query;
pub(crate) mod queue_kernel;
#[allow(
    unsafe_code,
    reason = "the inner loop has no bounds checks; each block says why it may"
)]
pub(crate) mod single_ray;
#[cfg(feature = "counters")]
mod tracer;
mod traversal;
#[allow(unsafe_code, reason = "shuffles by a table have no safe name")]
mod wide_stack;

pub use counters::TraversalStats;
pub(crate) use filtered_hit::HitFilter;
pub use hit_walk::HitWalk;
pub use kernel::Kernel;
#[cfg(feature = "counters")]
pub use tracer::{PacketLanes, PacketTracer};
#[cfg(feature = "counters")]
pub use traversal::CountingTraversal;
pub use traversal::Traversal;
