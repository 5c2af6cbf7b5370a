//! Meshes, from the faces of a chunk of a file to a scene.
//!
//! | file | holds |
//! |---|---|
//! | `chunk` | rows of a chunk of a file, and the mesh of all chunks |
//! | `faces` | faces of a chunk, before they are triangulated |
//! | `first_equal` | rows that are equal to an earlier one |
//! | `smooth_normals`, `fan` | vertex normals for triangles whose file gives none |
//! | `polygon`, `large_polygon` | polygons to triangles |
//! | `polygon_mesh` | a mesh of polygons, triangulated |
//! | `mesh_scene` | a mesh put into its scene |
//! | `point_cloud` | points of a file without faces to spheres |
//! | `vertex_colors` | colours of vertices and faces |
//! | `named_runs` | names of triangles |
//! | `defaults` | materials and picture of a mesh whose file says nothing about them |

pub(crate) mod chunk;
pub(crate) mod defaults;
pub(crate) mod faces;
mod fan;
pub(crate) mod first_equal;
mod large_polygon;
mod mesh_scene;
pub(crate) mod named_runs;
mod point_cloud;
pub mod polygon;
mod polygon_mesh;
mod smooth_normals;
pub(crate) mod vertex_colors;

pub(crate) use mesh_scene::{finish, scene_for};
pub(crate) use polygon_mesh::*;
pub(crate) use smooth_normals::add_smooth_normals;
