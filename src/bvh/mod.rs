//! Boxes to flat nodes: obvhs builds a binary tree, which is flattened into our own 64-byte nodes, and the primitives
//! are copied into leaf order. The only room, beside the peers, that names obvhs.
//!
//! A node holds the boxes of its two children, so that one visit decides about both. A leaf holds primitives of one
//! kind only: where obvhs mixed kinds, the leaf is split by kind, so that no kernel branches on the kind per primitive.

mod build;
mod flatten;
mod node;

pub use node::{Bvh, Child, EllipsoidSlot, Node, SphereSlot, TriangleSlot};
