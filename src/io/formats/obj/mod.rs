//! OBJ with MTL: triangles and polygons over shared vertices, UVs and normals.
//!
//! The text is cut at line ends into chunks, which several threads read. Numbers that count
//! backward, and material names that carry over from the chunk before, are resolved when all chunks
//! have been read. Errors are found in a second reading, which knows the number of rows of each
//! attribute. Most files are correct, so the first reading does without that knowledge.

mod chunk;
mod cursor;
mod materials;
mod mtl;
mod reader;

pub(super) use reader::read;
