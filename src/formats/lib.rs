//! Reads bytes to a [`Scene`](phalanx_scene::Scene). Errors in a scene file are found here.
//!
//! A format is a folder with its grammar and its meaning: `test_scene`, `nff`, `gltf`, `obj`, `ply`
//! and `stl`. Its reader gets bytes and returns a scene and what the file said ([`ReadScene`]);
//! default parts and overrides of the user are for others. All else is shared, and a new format
//! needs a folder, a row of `table`, and whatever it uses of:
//!
//! | module | holds |
//! |---|---|
//! | `scene_file`, `table` | a file in memory, and the table that names its reader |
//! | `read_scene`, `options` | the outcome of a reader, and the options that it is given |
//! | `origin` | the local origin of a scene that lies far away, for which a file is read again |
//! | `diagnostics` | errors and warnings with their places |
//! | `text` | bytes to characters, words and numbers |
//! | `mesh` | faces and columns to triangles, with colours and names |
//! | `texture` | pictures to textures |
//! | `metallic_roughness` | materials of glTF and MTL |
//! | `environment` | pictures of all directions |
//! | `folder`, `memory` | what a file may name, and what it may take |

mod diagnostics;
mod environment;
mod folder;
#[cfg(test)]
#[path = "../../tests/common/full_or.rs"]
mod full_or;
mod gltf;
mod memory;
mod mesh;
mod metallic_roughness;
mod nff;
mod obj;
mod options;
mod origin;
mod ply;
mod read_scene;
mod scene_file;
mod stl;
mod table;
mod test_scene;
#[cfg(test)]
mod tests;
mod text;
mod texture;

pub use diagnostics::{Diagnostic, MAX_DIAGNOSTICS};
pub use environment::read_environment;
pub use folder::foreign;
#[doc(hidden)]
pub use mesh::polygon;
#[doc(hidden)]
pub use nff::level as nff_level;
pub use options::ReadOptions;
pub use origin::Origin;
#[doc(hidden)]
pub use origin::note as origin_note;
pub use read_scene::{LoadError, ReadScene};
pub use scene_file::{SceneFile, endings};
pub use test_scene::is_bare_name;
