//! Boxes to flat nodes: obvhs builds binary trees, which are flattened into our own 64-byte nodes,
//! and the primitives are copied into leaf order. The only room, beside the peers, that names
//! obvhs.
//!
//! | file | what |
//! |---|---|
//! | `node`, `leaf` | what is traced: nodes, and primitives in leaf order |
//! | `tree` | both, whole |
//! | `wide` | the tree once more, with as many children a node as there are lanes |
//! | `build_input` | what a tree is built over |
//! | `chunks` | neighbourhoods that are built side by side |
//! | `ploc` | a binary tree over the boxes of one, as obvhs builds it, in bounded time |
//! | `subtree` | one subtree of obvhs's, made ours |
//! | `merge` | pieces put together |
//! | `huge_pages` | where rows lie in memory |
//! | `validate` | arrays from elsewhere, proven to be a tree |
//! | `build` | the order of all that, on all threads |
//!
//! A node holds the boxes of its two children, so that one visit decides about both. A leaf holds
//! primitives of one kind only: where obvhs mixed kinds, the leaf is split by kind, so that no
//! kernel branches on the kind per primitive.

mod build;
mod build_input;
mod chunks;
#[allow(unsafe_code, reason = "the system takes advice by address alone")]
mod huge_pages;
mod leaf;
mod merge;
mod node;
mod ploc;
mod subtree;
mod tree;
mod validate;
mod wide;

pub use self::wide::{ChildRef, OtherLeaf, SphereBlock, TriangleBlock, WideBvh, WideNode};
pub use build::{BuildSettings, Quality};
pub use leaf::{LeafCone, LeafEllipsoid, LeafInstance, LeafPrims, LeafSphere, LeafTriangle};
pub use node::{Child, LeafKind, Node};
pub use tree::Bvh;
pub use validate::{Array, BvhArrays, BvhError, UnverifiedBvh};
