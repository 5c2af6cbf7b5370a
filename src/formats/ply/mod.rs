//! PLY: a header that describes the elements, then rows as text or as numbers of either byte order.
//!
//! The reader uses the vertices' `x y z` and `nx ny nz`, the faces' `vertex_indices` (or
//! `vertex_index`), triangle strips, colours of vertices or faces, and texture coordinates of
//! vertices or corners with the pictures that the header names. Everything else is skipped. Counts
//! in the header are trusted only as far as there are bytes. Surplus operands of an ascii row are
//! only a warning here: files of a widespread program have them.

mod ascii;
mod binary;
mod colors;
mod columns;
mod header;
mod lexer;
mod pictures;
mod plan;
mod reader;
mod row_reader;
mod rows;
mod uvs;

pub(super) use reader::{read, text};
