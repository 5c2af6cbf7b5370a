//! A second tree with one child per lane of the build in each node (`NATIVE`: sixteen or eight),
//! for beams and for single rays. A node's boxes are columns, so that one ray, or one beam, is
//! tested against all of them at once. Triangles and spheres are stored in blocks of the same size.
//! Hits do not depend on that size (`perf/notes/sixteen-children.md` measures its effect).
//!
//! `rows` defines the traced data. `collapse` chooses which nodes of the binary tree become
//! children of one wide node, `emit` drafts the nodes, and `layout` assigns all positions. The tree
//! does not depend on the number of threads. `wide_parts` puts trees side by side, below a `top`
//! that joins them; `refit` and `erase` follow a scene that changes.

mod collapse;
mod emit;
mod erase;
mod layout;
mod refit;
mod rows;
mod top;
mod wide_parts;

pub use rows::{ChildRef, OtherLeaf, SphereBlock, TriangleBlock, WideBvh, WideNode};
