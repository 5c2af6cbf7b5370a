//! Header of a file in which finished work is kept: whose work it is, as JSON.

use super::kept_file::KeptFileError;
use super::render_key::{KeyDifference, RenderKey};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Version of the layout of kept files. Version 1 of tiles had its settings as one text, version 2
/// as fields of their own; lists of frames had version 1. In version 3, positions were not relative
/// to the scene's origin; in version 4, default lights stayed where the first frame had them.
pub(super) const LAYOUT_VERSION: u32 = 5;

/// A kind of kept files.
pub(super) struct KeptKind {
    /// Name of the kind.
    pub(super) name: &'static str,
    /// Work of somebody else, in a file of this kind.
    pub(super) foreign: &'static str,
    /// Version of a file that names none; `None` if it is not of this kind.
    pub(super) unnamed_version: Option<u32>,
}

/// The owner of a kept file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptHeader {
    layout_version: u32,
    picture: RenderKey,
    /// Checksum of the camera's path; `None` for one picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    camera_path: Option<String>,
}

/// The version alone, of a header whose other fields may have any names. Lists of version 1 named
/// it otherwise.
#[derive(Deserialize)]
struct LayoutVersion {
    #[serde(alias = "finished_frames")]
    layout_version: Option<u32>,
}

impl KeptHeader {
    pub(super) fn new(key: &RenderKey, camera_path: Option<&str>) -> KeptHeader {
        KeptHeader {
            layout_version: LAYOUT_VERSION,
            picture: key.clone(),
            camera_path: camera_path.map(str::to_owned),
        }
    }

    pub(super) fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Checks that `text` is this header, in a file of this kind at `path`.
    pub(super) fn check(
        &self,
        text: &[u8],
        path: &Path,
        kind: &KeptKind,
    ) -> Result<(), KeptFileError> {
        let other = || KeptFileError::other(path, kind.name);
        let named: LayoutVersion = serde_json::from_slice(text).map_err(|_| other())?;
        let version = named.layout_version.or(kind.unnamed_version);
        let version = version.ok_or_else(other)?;
        if version != LAYOUT_VERSION {
            return Err(KeptFileError::Layout {
                path: path.into(),
                found: version,
                known: LAYOUT_VERSION,
            });
        }
        let stored: KeptHeader = serde_json::from_slice(text).map_err(|_| other())?;
        if !stored.is_sound() {
            return Err(other());
        }
        // Compared as texts, because a zero has a sign.
        if stored.json() == self.json() {
            Ok(())
        } else {
            Err(KeptFileError::Different {
                path: path.into(),
                holds: kind.foreign,
                differences: stored.differences(self),
            })
        }
    }

    /// Returns true if this program could have made the header.
    fn is_sound(&self) -> bool {
        let path = self.camera_path.as_deref().unwrap_or_default();
        self.picture.check().is_ok() && path.chars().all(|c| c.is_ascii_hexdigit())
    }

    fn differences(self, here: &KeptHeader) -> Vec<KeyDifference> {
        let mut differences = self.picture.differences(&here.picture);
        if self.camera_path != here.camera_path {
            differences.push(KeyDifference {
                what: "the checksum of the camera's path".to_owned(),
                there: self.camera_path.unwrap_or_default(),
                here: here.camera_path.clone().unwrap_or_default(),
            });
        }
        differences
    }
}
