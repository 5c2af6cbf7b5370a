//! Beams: hundreds of rays that share a point, the eye or a light, traverse the wide tree together.
//!
//! In projective coordinates such a ray is a point, and a group of rays has a rectangle; boxes and
//! triangles have projections, too. A node's children are projected from the apex once for all
//! rays. Then each child is tested against all sub-beams; a lane is a sub-beam of up to sixteen
//! rays. A leaf's triangles are projected once, and then tested against each sub-beam; a lane is a
//! triangle. Only the remaining pairs are tested ray by ray, with the same test as in every kernel.
//!
//! The idea is that of beam and frustum tracing (Reshetov, Soupikov and Hurley, "Multi-Level Ray
//! Tracing Algorithm", 2005; Wald et al., "Ray Tracing Deformable Scenes Using Dynamic Bounding
//! Volume Hierarchies", 2007). The departures are hundreds of rays instead of a packet, and a mask
//! of sub-beams on the stack instead of a first active ray.
//!
//! | file | contents |
//! |---|---|
//! | `kernel` | rays of a queue into sub-beams, through the tree, and back as hits |
//! | `batch` | the packets of a beam |
//! | `apex` | the common point of rays |
//! | `projection` | projected boxes and triangles, and why nothing is lost |
//! | `ray_extent` | projections of rays, and the rectangle around them |
//! | `sorted` | rays in the order of their projections |
//! | `sub_beams` | the rays, in rectangles |
//! | `block`, `pairs` | the triangles of a block, and their pairs with sub-beams |
//! | `shadow_cull`, `deferred` | culling before the test of shadow rays, several blocks at a time |
//! | `state` | the state of a traversal |
//! | `traverse` | the traversal of the wide tree |

mod apex;
mod batch;
mod block;
#[allow(
    unsafe_code,
    reason = "the inner loop has no bounds checks; each block says why it may"
)]
mod deferred;
mod kernel;
#[allow(
    unsafe_code,
    reason = "the list has no bounds checks; each block says why it may"
)]
mod pairs;
mod projection;
mod ray_extent;
mod shadow_cull;
mod sorted;
#[allow(
    unsafe_code,
    reason = "the inner loop has no bounds checks; each block says why it may"
)]
mod state;
mod sub_beams;
#[allow(
    unsafe_code,
    reason = "the inner loop has no bounds checks; each block says why it may"
)]
mod traverse;

pub(super) use batch::SIZE;
pub(super) use kernel::Beams;
