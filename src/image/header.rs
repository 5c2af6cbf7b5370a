//! Texts and numbers about a picture, stored in its file.

use serde::{Deserialize, Serialize};

/// Name and version of the program that writes the files.
pub(super) const SOFTWARE: &str = concat!("phalanx ", env!("CARGO_PKG_VERSION"));

/// Texts and numbers about a picture. They depend only on the picture, so that equal pictures are
/// equal files, regardless of who rendered them and where. Empty entries are omitted from the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PictureHeader {
    /// Name of the scene.
    pub scene: String,
    /// Command that renders the picture from the scene.
    pub command: String,
    /// Camera as matrices, for OpenEXR: to the camera's coordinates, and to the picture. See
    /// [`CameraMatrices`](phalanx_scene::CameraMatrices).
    pub matrices: Option<[[f32; 16]; 2]>,
    /// Names of the scene's objects, for OpenEXR files with identifiers of them. Without names,
    /// programs show identifiers.
    pub objects: Vec<String>,
    /// Names of the scene's materials.
    pub materials: Vec<String>,
}

impl PictureHeader {
    /// A header without anything.
    pub const NONE: PictureHeader = PictureHeader {
        scene: String::new(),
        command: String::new(),
        matrices: None,
        objects: Vec::new(),
        materials: Vec::new(),
    };

    /// The texts, each with its keyword in PNG files, for formats that only store texts. Each is a
    /// single line.
    pub(super) fn texts(&self) -> Vec<(&'static str, String)> {
        let all = [
            ("Software", SOFTWARE),
            ("Title", &self.scene),
            ("Comment", &self.command),
        ];
        let printable = |text: &str| text.chars().filter(|c| !c.is_control()).collect();
        let all = all.map(|(keyword, text)| (keyword, printable(text)));
        all.into_iter()
            .filter(|(_, text): &(_, String)| !text.is_empty())
            .collect()
    }
}
