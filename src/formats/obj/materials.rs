//! The materials that an OBJ file names, from its material files.

use super::cursor::Cursor;
use super::file_list;
use super::material_rows::{KnownMaterial, MaterialReader, MeshMaterials, MtlSource};
use super::mtl::{self, MtlMaterial};
use super::name::{spellings, text_of, without_comment};
use crate::diagnostics::{DiagnosticSink, Span, quoted, quoted_file};
use crate::folder::{Folder, Found, NamedFile};
use crate::memory::MemoryLedger;
use crate::mesh::named_runs::NameChanges;
use crate::text::utf16;
use crate::texture::TextureLibrary;
use phalanx_scene::{MaterialTable, Scene};
use std::collections::{HashMap, HashSet};

/// Maximum number of names of material files of one scene.
const MAX_LIBRARIES: usize = 1000;

/// Memory for a material, its name, what it leaves out, its row and the tables that refer to it.
const MATERIAL_BYTES: u64 = 2048;

/// All materials of the files that a scene names.
pub(super) struct MaterialLibrary<'a> {
    text: Cursor<'a>,
    asset_dir: &'a Folder,
    files: Vec<MtlSource>,
    materials: Vec<KnownMaterial>,
    /// The first material of each name, and of each name without a comment.
    by_name: HashMap<Vec<u8>, usize>,
    by_short_name: HashMap<Vec<u8>, usize>,
    /// Material files that have been read, and the number of further names that may be looked up.
    read: HashSet<Found>,
    names_left: usize,
    /// True if a file is missing: then its missing materials are not reported.
    incomplete: bool,
}

/// A material file's bytes, as UTF-8 if they are text in UTF-16.
fn as_utf8(bytes: Vec<u8>, memory: &MemoryLedger) -> Result<Vec<u8>, String> {
    match utf16::to_utf8(&bytes, memory) {
        Ok(text) => Ok(text.unwrap_or(bytes)),
        Err(mut faults) => Err(faults.pop().map_or_else(String::new, |fault| fault.message)),
    }
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
            asset_dir,
            files: Vec::new(),
            materials: Vec::new(),
            by_name: HashMap::new(),
            by_short_name: HashMap::new(),
            read: HashSet::new(),
            names_left: MAX_LIBRARIES,
            incomplete: false,
        };
        let mut operands = HashSet::new();
        for &span in libraries {
            // Exporters repeat the statement before every group.
            if operands.insert(library.text.bytes(span)) {
                library.add(span, report);
            }
        }
        library
    }

    /// Adds one file whose name may hold blanks, or several between blanks.
    fn add(&mut self, span: Span, report: &mut DiagnosticSink) {
        let text = self.text.bytes(span);
        let short = text_of(without_comment(text));
        if self.names_left == 0 {
            return;
        }
        self.names_left -= 1;
        if short.is_empty() {
            return report.warning(span, "a file name is missing");
        }
        let asset_dir = self.asset_dir;
        let mut names = spellings(text).map(text_of);
        let exact = |name: String| Some((asset_dir.find_exact(&name)?, name));
        if let Some((file, name)) = names.find_map(exact) {
            return self.add_file(&name, Ok(file), span, report);
        }
        let exists = |name: &str| asset_dir.find_exact(name).is_some();
        let parts = file_list::split(&short, self.names_left, exists);
        // A search by the last component would mistake a list for its last file.
        let list = parts.len() > 1 || parts.iter().any(|part| exists(part));
        let mut names = spellings(text).map(text_of).filter(|_| !list);
        let search = |name: String| Some((asset_dir.find_for(None, &name).ok()?, name));
        match names.find_map(search) {
            Some((file, name)) => self.add_file(&name, Ok(file), span, report),
            None => (parts.iter()).for_each(|part| self.add_parts(part, span, report)),
        }
    }

    /// Adds a file whose name may hold blanks, or one for each word if some are files.
    fn add_parts(&mut self, name: &str, span: Span, report: &mut DiagnosticSink) {
        let find = |name| (name, self.asset_dir.find_for(None, name));
        let unsplit = find(name);
        let one = unsplit.1.is_ok() || name.contains("\\ ");
        let words = name.split_ascii_whitespace().take(self.names_left);
        let words = words.filter(|&word| word != name && !one);
        let mut files: Vec<_> = words.map(find).collect();
        if files.iter().all(|(_, file)| file.is_err()) {
            files = vec![unsplit];
        }
        for (name, file) in files {
            self.names_left = self.names_left.saturating_sub(1);
            self.add_file(name, file, span, report);
        }
    }

    fn add_file(
        &mut self,
        name: &str,
        file: Result<NamedFile, String>,
        span: Span,
        report: &mut DiagnosticSink,
    ) {
        let file = file.map(|file| file.accepted(name, span, report));
        if let Ok(file) = &file
            && !self.read.insert(file.clone())
        {
            return;
        }
        let memory = self.asset_dir.memory();
        let read = file.and_then(|file| {
            let bytes = as_utf8(self.asset_dir.read(&file)?, memory)?;
            let needed = bytes.len() as u64 + mtl::most_materials(&bytes) * MATERIAL_BYTES;
            let name = quoted_file(name);
            memory.take(needed, format_args!("for the materials of {name}"))?;
            Ok((file, bytes))
        });
        let (file, bytes) = match read {
            Ok(read) => read,
            Err(reason) => {
                self.incomplete = true;
                let name = quoted_file(name);
                let message = format!("the material file {name} is left out: {reason}");
                return match memory.refusal() {
                    Some(_) => report.error(span, message),
                    None => report.warning(span, message),
                };
            }
        };
        mtl::named_files(&bytes).for_each(|name| self.asset_dir.note(&text_of(name)));
        let mut materials = mtl::read(&bytes);
        if materials.iter().all(MtlMaterial::is_invisible) {
            materials.iter_mut().for_each(MtlMaterial::show);
        }
        for material in materials {
            // If two have the same name the first counts, because a file is searched from its
            // beginning.
            let (number, name) = (self.materials.len(), &bytes[material.name.range()]);
            let short = without_comment(name);
            self.by_name.entry(name.to_vec()).or_insert(number);
            self.by_short_name.entry(short.to_vec()).or_insert(number);
            self.materials.push(KnownMaterial {
                material,
                source: self.files.len(),
            });
        }
        self.files.push(MtlSource {
            file,
            name: name.to_owned(),
            bytes,
            library: span,
        });
    }

    /// The material that a `usemtl` names, and the spelling of its name.
    fn find<'n>(&self, name: &'n [u8]) -> Option<(&'n [u8], &KnownMaterial)> {
        spellings(name).find_map(|name| {
            let number = self.by_name.get(name).or(self.by_short_name.get(name))?;
            Some((name, &self.materials[*number]))
        })
    }

    /// Materials of `triangles` triangles whose materials change at `runs`. Triangles before the
    /// first change, and those of an unknown name, have row 0. Textures become the scene's. The
    /// other results are the changes of the materials' names, and notes on textures.
    pub(super) fn resolve(
        &self,
        mut runs: Vec<(usize, Span)>,
        triangles: usize,
        scene: &mut Scene,
        table: &mut MaterialTable,
        report: &mut DiagnosticSink,
    ) -> (MeshMaterials, NameChanges, Vec<String>) {
        runs.retain(|run| run.0 < triangles);
        let textures = TextureLibrary::new(self.asset_dir);
        let mut reader = MaterialReader::new(self.asset_dir, &self.files, textures);
        let mut rows = HashMap::new();
        let mut missing = HashSet::new();
        let mut named = Vec::with_capacity(runs.len());
        let mut names = NameChanges::with_capacity(runs.len());
        let mut numbers = HashMap::new();
        for (first, span) in runs {
            let name = self.text.bytes(span);
            let number = *numbers.entry(name).or_insert_with(|| {
                let spelled = self.find(name).map(|(spelled, _)| spelled);
                let spelled = spelled.unwrap_or_else(|| without_comment(name));
                scene.names.intern(spelled)
            });
            names.push((first, number));
            let look = *rows.entry(name).or_insert_with(|| match self.find(name) {
                Some((_, material)) => reader.look(material, scene, table),
                None if self.incomplete || !missing.insert(without_comment(name)) => {
                    Default::default()
                }
                None => {
                    let name = quoted(&text_of(without_comment(name)));
                    let message = format!("there is no material {name}: the default one is used");
                    report.warning(span, message);
                    Default::default()
                }
            });
            named.push((first, look));
        }
        let notes;
        (scene.textures, notes) = reader.finish(report);
        (MeshMaterials::new(&named, triangles), names, notes)
    }
}
