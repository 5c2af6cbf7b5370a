//! Reads bytes to a [`Scene`](phalanx_scene::Scene). All errors in a scene file are found here.
//!
//! `table` has a row for each format, which names the reader in the format's folder. `load` runs
//! that reader on the bytes of a file, and once more if the geometry lies far away; `utf16` makes
//! text in UTF-16 UTF-8 before. A format's folder has its grammar and its meaning; the rest is
//! shared: `text`, `command`, `number` and `decimal` for operands, `chunk_remarks` for what the
//! workers found wrong, `mesh_chunk`, `mesh` and `faces` for triangles, `texture` and `picture` for
//! images, `folder` and `memory` for what a file may name and take, and `defaults` for the last
//! step, with `framing` for its camera, which shows the `visible_vertices`.

mod bytes;
mod chunk_remarks;
mod command;
mod decimal;
mod diagnostics;
mod faces;
mod folder;
pub mod foreign;
mod gltf;
mod large_polygon;
mod memory;
mod mesh;
mod mesh_chunk;
mod mesh_defaults;
mod metallic_roughness;
mod named_runs;
mod nff;
mod number;
mod obj;
mod options;
mod origin;
mod picture;
mod ply;
#[doc(hidden)]
pub mod polygon;
mod read_scene;
mod relief;
mod scene_file;
mod stl;
mod table;
mod test_scene;
mod text;
mod texture;
mod utf16;
mod vertex_colors;
mod workers;

pub use diagnostics::{Diagnostic, MAX_DIAGNOSTICS};
pub use options::ReadOptions;
pub use origin::Origin;
#[doc(hidden)]
pub use origin::note as origin_note;
pub use read_scene::{LoadError, ReadScene};
pub use scene_file::{SceneFile, endings};
pub use test_scene::is_bare_name;
