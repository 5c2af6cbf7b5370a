//! Bounding volume hierarchies: binary trees of 64-byte nodes, with the primitives in leaf order.
//!
//! A build goes through these files in this order:
//!
//! | file | contents |
//! |---|---|
//! | `settings` | the quality, and the threads |
//! | `build`, `subtree` | the order of the steps, on all threads |
//! | `build_input`, `prim_ref` | the objects that a tree is built over, and their boxes |
//! | `division` | chunks of neighbours, from the top |
//! | `clustering` | the tree of a chunk, from below |
//! | `best` | the same by obvhs, for the best quality; no other file but the peers' uses obvhs |
//! | `reinsertion` | nodes of a tree moved to better positions |
//! | `upper` | the upper levels, optimised as one tree, and the whole below them |
//! | `leaf_column` | primitives in leaf order |
//! | `offsets` | trees of several meshes in common arrays |
//! | `update`, `report`, `plan`, `follow` | trees that follow a scene that changes |
//! | `tree_parts`, `free_rows` | parts of a tree, and their rows |
//! | `refit`, `leaving`, `erase` | parts that move, and what leaves them |
//! | `top`, `braid` | the tree that joins them |
//!
//! and these are what it makes:
//!
//! | file | contents |
//! |---|---|
//! | `node`, `leaf` | traced data: nodes, and primitives in leaf order |
//! | `tree` | the whole tree of both |
//! | `wide` | a second tree, with as many children a node as there are lanes |
//! | `validate` | proof that arrays from a file are a tree |
//! | `geometry_starts` | from primitives to the geometries they were added with |
//!
//! A node holds the boxes of its two children, so that one visit decides about both. A leaf holds
//! primitives of one kind only, so that no kernel branches on the kind per primitive.

mod best;
mod braid;
mod build;
mod build_input;
mod clustering;
mod division;
mod erase;
mod follow;
mod free_rows;
mod geometry_starts;
pub mod leaf;
mod leaf_column;
mod leaving;
mod node;
mod offsets;
mod plan;
mod prim_ref;
mod refit;
mod reinsertion;
mod report;
mod settings;
mod subtree;
mod top;
mod tree;
mod tree_parts;
mod update;
mod upper;
mod validate;
mod wide;

pub use self::wide::{ChildRef, OtherLeaf, SphereBlock, TriangleBlock, WideBvh, WideNode};
pub(crate) use geometry_starts::GeometryStarts;
pub use leaf::LeafPrims;
use node::weighted_cost;
pub use node::{Child, LeafKind, Node};
pub use report::{UpdateError, UpdateMode, UpdateReport, UpdateWork};
pub use settings::{BuildSettings, Quality};
pub use tree::Bvh;
pub use validate::{Array, BvhArrays, BvhError, UnverifiedBvh};
