//! Pictures that a header names in comments, `TextureFile`, and the materials that show them.

use super::plan::ReadPlan;
use super::uvs::NO_PICTURE;
use crate::diagnostics::{DiagnosticSink, Span};
use crate::folder::Folder;
use crate::mesh::defaults::{WHITE, empty_scene};
use crate::options::ReadOptions;
use crate::texture::{TextureLibrary, TextureSampler};
use phalanx_scene::{Material, MaterialTable, MeshMaterial, NO_TEXTURE, Scene, Texture};

/// The pictures of a file.
#[derive(Default)]
pub(super) struct NamedPictures {
    /// The texture of each name; [`NO_TEXTURE`] for a missing one.
    rows: Vec<u32>,
    textures: Vec<Texture>,
    /// Remarks on what is not shown.
    pub(super) notes: Vec<String>,
}

impl NamedPictures {
    /// Reads the pictures, if there are texture coordinates for them. Coordinates without a picture
    /// are left out of the plan.
    pub(super) fn read(
        bytes: &[u8],
        plan: &mut ReadPlan,
        asset_dir: &Folder,
        report: &mut DiagnosticSink,
    ) -> NamedPictures {
        let mut pictures = NamedPictures::default();
        let mut names = &plan.header.pictures[..];
        match (plan.has_uvs(), names) {
            (false, []) => {}
            (false, _) => pictures.note("the file names a picture and has no texture coordinates: it is not shown"),
            (true, []) => pictures.note(
                "the file has texture coordinates and names no picture for them (`comment TextureFile NAME`)",
            ),
            (true, [_, second, ..]) if plan.face_uvs.picture.is_none() => {
                let message = "the faces do not say which picture is theirs (`texnumber`): the first is used";
                report.warning(*second, message);
                names = &names[..1];
            }
            (true, _) => {}
        }
        for span in &plan.header.pictures {
            asset_dir.note(&String::from_utf8_lossy(&bytes[span.range()]));
        }
        if plan.has_uvs() {
            let mut library = TextureLibrary::new(asset_dir);
            for &span in names {
                let name = String::from_utf8_lossy(&bytes[span.range()]);
                // MeshLab's word for the name of the file itself.
                let name = name.replace("<this>", asset_dir.scene_stem());
                let file = asset_dir.find_for(None, &name);
                let file = file.map(|file| file.accepted(&name, span, report));
                let sampler = TextureSampler::default();
                let row = library.of_file(&name, file, sampler, || span, report);
                pictures.rows.push(row);
            }
            pictures.textures = library.into_textures();
        }
        let missing = pictures.textures.is_empty();
        plan.keep_uvs_for(if missing { 0 } else { pictures.rows.len() });
        pictures
    }

    fn note(&mut self, note: &str) {
        self.notes.push(note.to_owned());
    }

    pub(super) fn is_empty(&self) -> bool {
        self.textures.is_empty()
    }

    /// A scene with the pictures, and the material of each triangle of these numbers of pictures;
    /// all have the first picture if there are none.
    pub(super) fn into_scene(
        self,
        numbers: &[u32],
        options: &ReadOptions,
        span: Span,
        report: &mut DiagnosticSink,
    ) -> (Scene, MeshMaterial) {
        let mut scene = empty_scene();
        let mut table = MaterialTable::default();
        let base = options.material.unwrap_or(WHITE);
        let mut row = |texture| {
            let material = Material { texture, ..base };
            table.intern(&material, &mut scene.materials)
        };
        let rows: Vec<u32> = self.rows.iter().map(|&texture| row(texture)).collect();
        let bare = row(NO_TEXTURE);
        let is_beyond = |&&number: &&u32| number != NO_PICTURE && number as usize >= rows.len();
        let count = numbers.iter().filter(is_beyond).count();
        if count > 0 {
            let what =
                "triangles with a `texnumber` beyond the file's pictures are drawn without one";
            report.warning(span, format!("{what}: {count}"));
        }
        let row_of = |&number: &u32| match number {
            NO_PICTURE => bare,
            _ => rows.get(number as usize).copied().unwrap_or(bare),
        };
        scene.textures = self.textures;
        let material = match numbers {
            [] => MeshMaterial::One(row_of(&0)),
            _ => MeshMaterial::Each(numbers.iter().map(row_of).collect::<Vec<u32>>().into()),
        };
        (scene, material)
    }
}
