//! OBJ with MTL: triangles and polygons over shared vertices, UVs and normals.
//!
//! The text is cut at line ends into chunks, which several threads read. Numbers that count
//! backward, and material names that carry over from the chunk before, are resolved when all chunks
//! have been read. Errors are found in a second reading, which knows the number of rows of each
//! attribute. Most files are correct, so the first reading does without that knowledge.
//!
//! Statements beyond the plain ones:
//!
//! | statement | meaning |
//! |---|---|
//! | `v x y z r g b` | a vertex with a colour (1), which belongs to it wherever it is used |
//! | `v x y z r g b a` | the same; the opacity is not used, with a warning |
//! | `v x y z w` | the weight is not used |
//! | `#MRGB MMRRGGBB…` | ZBrush: colours of vertices in their order, if no vertex has one itself |
//! | `s 1`, `s off` | smoothing groups: faces of a group without normals get common ones (2) |
//! | `o name`, `g name` | the object of the faces that follow (3) |
//! | `vt`, `vn` out of range or 0 | the face has no UVs or normals, with a warning |
//!
//! 1. Colours are sRGB from 0 to 1, as Blender, three.js and MeshLab write and read them. If any of
//!    the file is above 1, all are from 0 to 255. Vertices without a colour are white.
//! 2. Weighted by the angles of the corners. Files without `s` are flat.
//! 3. As in Blender: objects are those of `o`, and groups make objects only before the first `o`.
//!    The name is the whole line, since names may hold blanks and `#`. Materials have the names of
//!    `usemtl`, with or without a material of that name.

mod chunk;
mod color_operands;
mod colors;
mod conversion;
mod cursor;
mod faces;
mod file_list;
mod material_rows;
mod materials;
mod mtl;
mod name;
mod reader;
mod remarks;
mod runs;
mod smoothing;
mod texture_map;
mod uv_baking;

pub(super) use reader::read;
