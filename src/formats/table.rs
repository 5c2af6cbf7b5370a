//! The table of scene formats.

use crate::folder::Folder;
use crate::options::ReadOptions;
use crate::origin::ReadStop;
use crate::read_scene::ReadScene;
use crate::{gltf, nff, obj, ply, stl, test_scene, text};
use std::ffi::OsStr;

/// Reads the bytes of a file; other files that it names are looked for in the folder.
pub(super) type SceneReader = fn(&[u8], &Folder, &ReadOptions) -> Result<ReadScene, ReadStop>;

/// A scene format.
pub(super) struct SceneFormat {
    /// Endings of its files.
    pub(super) endings: &'static [&'static str],
    pub(super) read: SceneReader,
    /// The part of a file whose lines can be shown to a person.
    pub(super) text: fn(&[u8]) -> String,
}

const fn row(
    endings: &'static [&'static str],
    read: SceneReader,
    text: fn(&[u8]) -> String,
) -> SceneFormat {
    SceneFormat {
        endings,
        read,
        text,
    }
}

pub(super) static FORMATS: [SceneFormat; 6] = [
    row(&["test"], test_scene::read, text::lossy),
    row(&["nff"], nff::read, text::lossy),
    row(&["gltf", "glb"], gltf::read, gltf::text),
    row(&["obj"], obj::read, text::lossy_same_length),
    row(&["ply"], ply::read, ply::text),
    row(&["stl"], stl::read, stl::text),
];

/// The format of files with this ending.
pub(super) fn find(ending: &OsStr) -> Option<&'static SceneFormat> {
    let named = |name: &&str| ending.eq_ignore_ascii_case(name);
    FORMATS
        .iter()
        .find(|format| format.endings.iter().any(named))
}
