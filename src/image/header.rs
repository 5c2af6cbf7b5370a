//! Texts and numbers about a picture, which its file holds beside its pixels.

use serde::{Deserialize, Serialize};

/// Name and version of the program that writes the files.
pub(super) const SOFTWARE: &str = concat!("phalanx ", env!("CARGO_PKG_VERSION"));

/// Texts and numbers about a picture. They depend on the picture alone, so that equal pictures are
/// equal files, whoever made them and where. What is empty is left out of the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PictureHeader {
    /// Name of the scene.
    pub scene: String,
    /// Command that makes the picture from the scene.
    pub command: String,
    /// Camera as matrices, for OpenEXR: to the camera's coordinates, and to the picture. See
    /// [`CameraMatrices`](phalanx_scene::CameraMatrices).
    pub matrices: Option<[[f32; 16]; 2]>,
    /// Names of the scene's objects, for OpenEXR files with identifiers of them. Programs show
    /// identifiers without names where there are none.
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

    /// The texts, each with its keyword in PNG files, for formats that have room for texts alone.
    /// They are in one line each.
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
