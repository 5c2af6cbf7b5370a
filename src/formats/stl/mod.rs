//! STL: triangles without shared corners, as text or binary. Corners with the same bits become one
//! vertex.
//!
//! Normals of the file are not used: a facet's side follows from the order of its corners, as the
//! format demands.

mod ascii;
mod binary;
mod colors;
mod lexer;
mod reader;
mod weld;

pub(super) use reader::{read, text};
