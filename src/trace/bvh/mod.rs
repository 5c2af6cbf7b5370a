//! Bounding volume hierarchies. obvhs builds binary trees, which are flattened into 64-byte nodes
//! of this crate, and the primitives are copied into leaf order. Apart from the peers, only this
//! module uses obvhs.
//!
//! | file | contents |
//! |---|---|
//! | `node`, `leaf` | traced data: nodes, and primitives in leaf order |
//! | `tree` | the whole tree of both |
//! | `wide` | a second tree, with as many children a node as there are lanes |
//! | `build_input` | the objects that a tree is built over |
//! | `chunks` | neighbourhoods that are built side by side |
//! | `ploc` | a binary tree over the boxes of a chunk, as obvhs builds it, in bounded time |
//! | `subtree` | conversion of one tree of obvhs's |
//! | `merge` | merging of subtrees |
//! | `huge_pages` | rows on huge pages |
//! | `validate` | proof that arrays from a file are a tree |
//! | `geometry_starts` | from primitives to the geometries they were added with |
//! | `build` | the order of these steps, on all threads |
//!
//! A node holds the boxes of its two children, so that one visit decides about both. A leaf holds
//! primitives of one kind only. If obvhs mixed kinds, the leaf is split by kind, so that no kernel
//! branches on the kind per primitive.

mod build;
mod build_input;
mod chunks;
mod geometry_starts;
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
pub(crate) use geometry_starts::GeometryStarts;
pub use leaf::{LeafCone, LeafEllipsoid, LeafInstance, LeafPrims, LeafSphere, LeafTriangle};
pub use node::{Child, LeafKind, Node};
pub use tree::Bvh;
pub use validate::{Array, BvhArrays, BvhError, UnverifiedBvh};
