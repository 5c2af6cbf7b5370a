//! Rays against boxes and primitives: the definition of a hit.
//!
//! | file | contents |
//! |---|---|
//! | `ray_setup` | rays, with what the tests derive from them once |
//! | `aabb` | the slab test of a ray against a padded box |
//! | `slab_conservative` | the same for boxes of nodes, with less arithmetic and a little slack |
//! | `shear` | the frame in which a ray is the z axis |
//! | `leaf_prim` | the interface of primitives |
//! | `triangle`, `sphere`, `cone` | one test per primitive |
//! | `instance` | rays into the space of a mesh, hits back out of it |
//! | `hit` | candidates, and the record of the closest |
//!
//! # Why no tree can lose a hit
//!
//! A hit's ray passes the slab test of the primitive's *own* padded box. The slab test is monotone:
//! subtraction, multiplication by a constant, min and max all preserve order under rounding. So a
//! ray that passes a box passes every box around it, with no later entry and no earlier exit. What
//! remains is the distance:
//!
//! - The distance of a triangle that is not seen at a very grazing angle is within
//!   [`ENTRY_SLACK`](aabb::ENTRY_SLACK) of the ray's interval in its box, as is proven in
//!   `triangle/distance.rs`.
//! - All others are clamped to that interval, and are hits only if there is one.
//!
//! Boxes are entered if they begin before the closest hit so far and twice that slack. So every
//! ancestor of the primitive is visited, regardless of the tree: the closest hit is the brute-force
//! one bit for bit. An argument about error bounds (Ize, "Robust BVH Ray Traversal", JCGT 2013) is
//! needed once, for a triangle and its own box. For all boxes around it, order is enough.
//!
//! Through instances the argument holds twice, with a clamp to the interval in the instance's own
//! box outside: see `instance`.
//!
//! Ties in distance go to the smaller `prim_id`.

pub(crate) mod aabb;
pub(crate) mod cone;
pub(crate) mod hit;
pub(crate) mod instance;
pub(crate) mod leaf_prim;
#[cfg(test)]
pub(crate) mod random;
pub(crate) mod ray_setup;
pub(crate) mod shear;
pub(crate) mod slab_conservative;
pub(crate) mod sphere;
pub(crate) mod triangle;
