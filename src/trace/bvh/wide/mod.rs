//! A second tree with as many children a node as the build has lanes (`NATIVE`: sixteen or eight),
//! for beams and for single rays. A node's boxes are columns, so that one ray, or one beam, is
//! tested against all of them at once. Triangles and spheres are stored in blocks of as many.
//! Hits do not depend on that number (`perf/notes/sixteen-children.md` has what it saves).
//!
//! `rows` has what is traced. `collapse` chooses which nodes of the binary tree become children of
//! one wide node, `emit` makes drafts of the nodes, and `layout` assigns all positions. The tree
//! does not depend on the number of threads.

mod collapse;
mod emit;
mod layout;
mod rows;

pub(super) use layout::widen;
pub use rows::{ChildRef, OtherLeaf, SphereBlock, TriangleBlock, WideBvh, WideNode};
