//! Scenes as files: the readers of all formats, the standard scenes, and the scene cache.

#[path = "../common/mod.rs"]
mod common;

mod bad_files;
mod cache;
mod environments;
mod folders;
mod gltf_reader;
mod mesh_readers;
mod mutated_text;
mod nff_reader;
mod regressions;
mod standard;
mod test_reader;
