//! Boxes to flat nodes: obvhs builds binary trees, which are flattened into our own 64-byte nodes, and the primitives
//! are copied into leaf order. The only room, beside the peers, that names obvhs.
//!
//! | file | what |
//! |---|---|
//! | `node`, `slots` | what is traced: nodes, and primitives in leaf order |
//! | `tree` | both, whole |
//! | `wide` | the tree once more, with as many children a node as there are lanes |
//! | `objects` | what a tree is built over |
//! | `chunks` | neighbourhoods that are built side by side |
//! | `ploc` | a binary tree over the boxes of one, as obvhs builds it, in bounded time |
//! | `piece` | one subtree of obvhs's, made ours |
//! | `join` | pieces put together |
//! | `pages` | where rows lie in memory |
//! | `claim` | arrays from elsewhere, proven to be a tree |
//! | `build` | the order of all that, on all threads |
//!
//! A node holds the boxes of its two children, so that one visit decides about both. A leaf holds primitives of one
//! kind only: where obvhs mixed kinds, the leaf is split by kind, so that no kernel branches on the kind per primitive.

mod build;
mod chunks;
mod claim;
mod join;
mod node;
mod objects;
#[allow(unsafe_code, reason = "the system takes advice by address alone")]
mod pages;
mod piece;
mod ploc;
mod slots;
mod tree;
mod wide;

pub use self::wide::{OtherLeaf, SphereBlock, Target, TriangleBlock, Wide, WideNode};
pub use build::{BuildSettings, Quality};
pub use claim::{Array, BvhError, Claim, Parts};
pub use node::{Child, LeafKind, Node};
pub use slots::{ConeSlot, EllipsoidSlot, InstanceSlot, Slots, SphereSlot, TriangleSlot};
pub use tree::Bvh;
