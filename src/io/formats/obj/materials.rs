//! The materials that an OBJ file names, found in its material files.

use super::cursor::Cursor;
use super::mtl::{self, Material, name_of};
use crate::formats::folder::{Folder, Found};
use crate::formats::report::{Place, Report, quoted};
use crate::formats::texture::TextureShelf;
use phalanx_scene::{MeshMaterial, NO_TEXTURE, Palette, Scene, Texture};
use std::collections::{HashMap, HashSet};

/// Most names of material files of one scene.
const MAX_LIBRARIES: usize = 1000;

/// Memory for a material, its name, its row and the tables that lead there.
const MATERIAL_BYTES: u64 = 1024;

/// All materials of the files that a scene names, and its textures so far.
pub(super) struct Shelf<'a> {
    text: Cursor<'a>,
    materials: HashMap<Vec<u8>, Known>,
    textures: TextureShelf<'a>,
    /// Material files that have been read, and how many more names are looked up.
    read: HashSet<Found>,
    names_left: usize,
}

/// A material, and the `mtllib` that it comes from.
struct Known {
    material: Material,
    library: Place,
}

impl<'a> Shelf<'a> {
    /// Reads the files that `libraries`, operands of `mtllib`, name.
    pub(super) fn new(
        text: &'a [u8],
        beside: &'a Folder,
        libraries: &[Place],
        report: &mut Report,
    ) -> Shelf<'a> {
        let mut shelf = Shelf {
            text: Cursor { text, at: 0 },
            materials: HashMap::new(),
            textures: TextureShelf::new(beside),
            read: HashSet::new(),
            names_left: MAX_LIBRARIES,
        };
        let mut operands = HashSet::new();
        for &place in libraries {
            // Exporters repeat the statement before every group.
            if operands.insert(shelf.text.bytes(place)) {
                let operands = name_of(&shelf.text, place);
                shelf.add(beside, &operands, place, report);
            }
        }
        shelf
    }

    /// One file whose name may hold blanks, or several between blanks.
    fn add(&mut self, beside: &Folder, operands: &str, place: Place, report: &mut Report) {
        if self.names_left == 0 {
            return;
        }
        self.names_left -= 1;
        let whole = beside.find(operands);
        let mut names = operands.split_ascii_whitespace();
        if operands.is_empty() {
            return report.warning(place, "a file name is missing");
        }
        if whole.is_ok() || names.clone().nth(1).is_none() {
            return self.add_file(beside, operands, whole, place, report);
        }
        for name in names.by_ref().take(self.names_left) {
            self.names_left -= 1;
            self.add_file(beside, name, beside.find(name), place, report);
        }
    }

    fn add_file(
        &mut self,
        beside: &Folder,
        name: &str,
        file: Result<Found, String>,
        place: Place,
        report: &mut Report,
    ) {
        if let Ok(file) = &file
            && !self.read.insert(file.clone())
        {
            return;
        }
        let allowance = beside.allowance();
        let read = file.and_then(|file| beside.read(&file)).and_then(|bytes| {
            let materials = memchr::memmem::find_iter(&bytes, b"newmtl").count() as u64;
            let what = || format!("for the materials of {}", quoted(name));
            allowance.take(bytes.len() as u64 + materials * MATERIAL_BYTES, what)?;
            Ok(bytes)
        });
        let bytes = match read {
            Ok(bytes) => bytes,
            Err(reason) => {
                let message = format!("the material file {} is left out: {reason}", quoted(name));
                return match allowance.refusal() {
                    Some(_) => report.error(place, message),
                    None => report.warning(place, message),
                };
            }
        };
        let library = mtl::read(&bytes);
        library.faults.tell_of_other(name, &bytes, place, report);
        for material in library.materials {
            // Of two with one name the first counts, as the file is searched from its beginning.
            let known = Known {
                material,
                library: place,
            };
            self.materials
                .entry(known.material.name.clone())
                .or_insert(known);
        }
    }

    /// Material rows for `triangles` triangles whose materials change at `runs`. Before the first, and where a name is
    /// unknown, it is row 0.
    pub(super) fn rows(
        &mut self,
        mut runs: Vec<(usize, Place)>,
        triangles: usize,
        scene: &mut Scene,
        palette: &mut Palette,
        report: &mut Report,
    ) -> MeshMaterial {
        // Only the last of several changes at one place is for any triangle.
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
            .map(|(first, place)| {
                let name = text.bytes(place);
                let row = known.entry(name);
                let row = row.or_insert_with(|| self.row(place, scene, palette, report));
                (first, *row)
            })
            .collect();
        spread(&named, triangles)
    }

    /// The row of the material whose name stands at a place.
    fn row(
        &mut self,
        place: Place,
        scene: &mut Scene,
        palette: &mut Palette,
        report: &mut Report,
    ) -> u32 {
        let Some(Known { material, library }) = self.materials.get(self.text.bytes(place)) else {
            let name = name_of(&self.text, place);
            let message = format!(
                "there is no material {}: the default one is used",
                quoted(&name)
            );
            report.warning(place, message);
            return 0;
        };
        let texture = match &material.map {
            Some(map) => self
                .textures
                .named(&map.file, map.wrap, || *library, report),
            None => NO_TEXTURE,
        };
        palette.row(&material.surface(texture), &mut scene.materials)
    }

    /// The textures that the materials in use name.
    pub(super) fn into_textures(self) -> Vec<Texture> {
        self.textures.into_textures()
    }
}

/// One row for all triangles, or one for each.
fn spread(runs: &[(usize, u32)], triangles: usize) -> MeshMaterial {
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
