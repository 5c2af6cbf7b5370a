//! The materials that an OBJ file names, from its material files.

use super::cursor::Cursor;
use super::mtl::{self, MtlMaterial, name_of};
use crate::formats::diagnostics::{DiagnosticSink, Span, quoted};
use crate::formats::folder::{Folder, Found};
use crate::formats::texture::TextureLibrary;
use phalanx_scene::{MaterialTable, MeshMaterial, NO_TEXTURE, Scene, Texture};
use std::collections::{HashMap, HashSet};

/// Most names of material files of one scene.
const MAX_LIBRARIES: usize = 1000;

/// Memory for a material, its name, its row and the tables that refer to it.
const MATERIAL_BYTES: u64 = 1024;

/// All materials of the files that a scene names, and its textures so far.
pub(super) struct MaterialLibrary<'a> {
    text: Cursor<'a>,
    materials: HashMap<Vec<u8>, KnownMaterial>,
    textures: TextureLibrary<'a>,
    /// Material files that have been read, and the number of further names that may be looked up.
    read: HashSet<Found>,
    names_left: usize,
}

/// A material, and the `mtllib` that it comes from.
struct KnownMaterial {
    material: MtlMaterial,
    library: Span,
}

impl<'a> MaterialLibrary<'a> {
    /// Reads the files that `libraries`, operands of `mtllib`, name.
    pub(super) fn new(
        text: &'a [u8],
        asset_dir: &'a Folder,
        libraries: &[Span],
        report: &mut DiagnosticSink,
    ) -> MaterialLibrary<'a> {
        let mut library = MaterialLibrary {
            text: Cursor { text, at: 0 },
            materials: HashMap::new(),
            textures: TextureLibrary::new(asset_dir),
            read: HashSet::new(),
            names_left: MAX_LIBRARIES,
        };
        let mut operands = HashSet::new();
        for &span in libraries {
            // Exporters repeat the statement before every group.
            if operands.insert(library.text.bytes(span)) {
                let operands = name_of(&library.text, span);
                library.add(asset_dir, &operands, span, report);
            }
        }
        library
    }

    /// Adds one file whose name may hold blanks, or several between blanks.
    fn add(&mut self, asset_dir: &Folder, operands: &str, span: Span, report: &mut DiagnosticSink) {
        if self.names_left == 0 {
            return;
        }
        self.names_left -= 1;
        let whole = asset_dir.find(operands);
        let mut names = operands.split_ascii_whitespace();
        if operands.is_empty() {
            return report.warning(span, "a file name is missing");
        }
        if whole.is_ok() || names.clone().nth(1).is_none() {
            return self.add_file(asset_dir, operands, whole, span, report);
        }
        for name in names.by_ref().take(self.names_left) {
            self.names_left -= 1;
            self.add_file(asset_dir, name, asset_dir.find(name), span, report);
        }
    }

    fn add_file(
        &mut self,
        asset_dir: &Folder,
        name: &str,
        file: Result<Found, String>,
        span: Span,
        report: &mut DiagnosticSink,
    ) {
        if let Ok(file) = &file
            && !self.read.insert(file.clone())
        {
            return;
        }
        let budget = asset_dir.allowance();
        let read = file
            .and_then(|file| asset_dir.read(&file))
            .and_then(|bytes| {
                let materials = memchr::memmem::find_iter(&bytes, b"newmtl").count() as u64;
                let what = || format!("for the materials of {}", quoted(name));
                budget.take(bytes.len() as u64 + materials * MATERIAL_BYTES, what)?;
                Ok(bytes)
            });
        let bytes = match read {
            Ok(bytes) => bytes,
            Err(reason) => {
                let message = format!("the material file {} is left out: {reason}", quoted(name));
                return match budget.refusal() {
                    Some(_) => report.error(span, message),
                    None => report.warning(span, message),
                };
            }
        };
        let library = mtl::read(&bytes);
        library.errors.emit_for_file(name, &bytes, span, report);
        for material in library.materials {
            // If two have one name the first counts, because a file is searched from its beginning.
            let known = KnownMaterial {
                material,
                library: span,
            };
            self.materials
                .entry(known.material.name.clone())
                .or_insert(known);
        }
    }

    /// Material rows for `triangles` triangles whose materials change at `runs`. Triangles before
    /// the first change, and those of an unknown name, have row 0.
    pub(super) fn material_rows(
        &mut self,
        mut runs: Vec<(usize, Span)>,
        triangles: usize,
        scene: &mut Scene,
        table: &mut MaterialTable,
        report: &mut DiagnosticSink,
    ) -> MeshMaterial {
        // If several changes fall on one triangle, only the last has an effect.
        runs.dedup_by(|later, earlier| {
            let same = later.0 == earlier.0;
            if same {
                earlier.1 = later.1;
            }
            same
        });
        runs.retain(|run| run.0 < triangles);
        let mut known = HashMap::new();
        let text = self.text;
        let named: Vec<(usize, u32)> = runs
            .into_iter()
            .map(|(first, span)| {
                let name = text.bytes(span);
                let row = known.entry(name);
                let row = row.or_insert_with(|| self.material_row(span, scene, table, report));
                (first, *row)
            })
            .collect();
        expand_runs(&named, triangles)
    }

    /// The row of the material whose name has this span.
    fn material_row(
        &mut self,
        span: Span,
        scene: &mut Scene,
        table: &mut MaterialTable,
        report: &mut DiagnosticSink,
    ) -> u32 {
        let Some(KnownMaterial { material, library }) = self.materials.get(self.text.bytes(span))
        else {
            let name = name_of(&self.text, span);
            let message = format!(
                "there is no material {}: the default one is used",
                quoted(&name)
            );
            report.warning(span, message);
            return 0;
        };
        let texture = match &material.map {
            Some(map) => self
                .textures
                .named(&map.file, map.wrap, || *library, report),
            None => NO_TEXTURE,
        };
        table.intern(&material.to_material(texture), &mut scene.materials)
    }

    /// The textures that the materials in use name.
    pub(super) fn into_textures(self) -> Vec<Texture> {
        self.textures.into_textures()
    }
}

/// One row for all triangles, or one for each.
fn expand_runs(runs: &[(usize, u32)], triangles: usize) -> MeshMaterial {
    match runs {
        [] => return MeshMaterial::One(0),
        [(0, row), rest @ ..] if rest.iter().all(|(_, other)| other == row) => {
            return MeshMaterial::One(*row);
        }
        _ => {}
    }
    let mut rows = vec![0; triangles];
    let ends = runs.iter().skip(1).map(|run| run.0).chain([triangles]);
    for (&(first, row), end) in runs.iter().zip(ends) {
        rows[first..end].fill(row);
    }
    MeshMaterial::Each(rows.into())
}
