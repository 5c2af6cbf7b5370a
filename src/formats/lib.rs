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
mod camera_choice;
mod chunk_remarks;
mod command;
mod decimal;
mod defaults;
mod diagnostics;
mod faces;
mod folder;
pub mod foreign;
mod framing;
mod gltf;
mod large_polygon;
mod load;
mod loaded;
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
mod relief;
mod stl;
mod table;
mod test_scene;
mod text;
mod texture;
mod utf16;
mod vertex_colors;
mod visible_vertices;
mod workers;

pub use defaults::{DefaultLights, override_scene};
pub use diagnostics::{Diagnostic, MAX_DIAGNOSTICS};
pub use load::{endings, load, load_as, load_bytes, read_bytes, read_nff, read_test};
pub use loaded::{LoadError, Loaded};
pub use options::{AddedLight, Options};
pub use origin::Origin;
#[doc(hidden)]
pub use origin::note as origin_note;
pub use phalanx_scene::{OrthoHeight, UpAxis};
pub use test_scene::is_bare_name;
