//! Reads a file into a scene and its tree.

use super::error::{CacheError, CacheFault};
use super::header::{self, BLOCK, SectionEntry, SectionLayout};
use super::mapping::Mapping;
use super::settings;
use super::write::shapes;
use phalanx_scene::{
    AnyColumn, Environment, EnvironmentLight, RowCheck, Scene, Texture, map_on_pool,
};
use phalanx_trace::bvh::{Bvh, BvhArrays, LeafPrims, UnverifiedBvh};
use std::path::Path;
use std::sync::Arc;

/// Contents of a cache.
#[derive(Debug)]
pub struct Cached {
    /// The scene, valid; its columns lie in the mapped file.
    pub scene: Scene,
    /// Its tree.
    pub bvh: Bvh,
    /// Bytes of the file, all of which are mapped.
    pub file_bytes: u64,
}

/// Opens a cache: maps it, and checks every byte and every index on the threads of a pool.
///
/// # Errors
/// [`CacheError`]: the file cannot be read, or is not a whole and sound cache of this build's
/// layout.
pub fn open(path: &Path) -> Result<Cached, CacheError> {
    let mapping = Mapping::open(path).map_err(|source| match source.kind() {
        // Some systems refuse to map an empty file.
        _ if std::fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() == 0) => {
            refused(path, CacheFault::NotACache)
        }
        _ => CacheError::Io {
            path: path.to_path_buf(),
            source,
        },
    })?;
    take(&mapping).map_err(|fault| refused(path, fault))
}

/// Opens a cache whose bytes are not in a file; `name` stands for it in errors.
///
/// # Errors
/// As [`open`].
pub fn open_bytes(name: &Path, bytes: &[u8]) -> Result<Cached, CacheError> {
    // No system maps nothing.
    let mapping = Mapping::of_bytes(bytes).map_err(|_| refused(name, CacheFault::NotACache))?;
    take(&mapping).map_err(|fault| refused(name, fault))
}

fn refused(path: &Path, fault: CacheFault) -> CacheError {
    CacheError::Refused {
        path: path.to_path_buf(),
        fault,
    }
}

fn take(mapping: &Arc<Mapping>) -> Result<Cached, CacheFault> {
    let file = mapping.bytes();
    let shapes = shapes();
    let table = header::read(file, &shapes)?;
    if !header::gaps_are_zero(file, &table) {
        return Err(CacheFault::Surplus("between its sections"));
    }
    let mut sections = Sections {
        mapping,
        shapes: &shapes,
        table: &table,
        next: 0,
    };
    let (mut scene, extra) = sections.settings()?;
    let mut texture_has_alpha = extra.has_alpha.into_iter();
    sections.texels(&mut scene, |texture| Some((3, &mut texture.texels)))?;
    sections.texels(&mut scene, |texture| {
        texture_has_alpha.next()?.then_some((1, &mut texture.alpha))
    })?;
    sections.environment(&mut scene)?;
    scene.map_columns(|column| sections.map(column))?;
    let first_array = sections.next + 1;
    let mut parts = BvhArrays {
        sah: extra.sah,
        ..BvhArrays::default()
    };
    sections.map(&mut parts.depths)?;
    sections.map(&mut parts.nodes)?;
    for kind in LeafPrims::FILE_ORDER {
        sections.map(parts.slots.column_mut(kind))?;
    }
    let unverified = UnverifiedBvh::new(parts, &scene);
    verify(file, &shapes, &table, &scene, &unverified, first_array)?;
    scene.validate_settings()?;
    let environment = scene.environment.as_ref();
    let bad_texel = environment.and_then(Environment::first_invalid_texel);
    if bad_texel.is_some() {
        return Err(CacheFault::Nonsense("environment"));
    }
    let bvh = unverified.accept(&scene)?;
    Ok(Cached {
        scene,
        bvh,
        file_bytes: file.len() as u64,
    })
}

/// The sections of a file, one after another.
struct Sections<'a> {
    mapping: &'a Arc<Mapping>,
    shapes: &'a [SectionLayout],
    table: &'a [SectionEntry],
    next: usize,
}

impl Sections<'_> {
    fn next(&mut self) -> (&'static str, SectionEntry) {
        let k = self.next;
        self.next += 1;
        (self.shapes[k].0, self.table[k])
    }

    /// Reads the settings. They are small, and everything else depends on them, so their checksum
    /// is checked first.
    fn settings(&mut self) -> Result<(Scene, settings::Extra), CacheFault> {
        let (name, section) = self.next();
        let bytes = &self.mapping.bytes()[section.range()];
        if crc32fast::hash(bytes) != section.checksum {
            return Err(CacheFault::Damaged(name));
        }
        settings::read(bytes).ok_or(CacheFault::Nonsense(name))
    }

    /// Reads a column of all textures, which are stored one after another. `column` gives it and
    /// the bytes of a texel, if the texture has it.
    fn texels(
        &mut self,
        scene: &mut Scene,
        mut column: impl FnMut(&mut Texture) -> Option<(u64, &mut dyn AnyColumn)>,
    ) -> Result<(), CacheFault> {
        let (name, section) = self.next();
        let mut range = section.range();
        for texture in &mut scene.textures {
            let texels = u64::from(texture.width) * u64::from(texture.height);
            let Some((texel_bytes, column)) = column(texture) else {
                continue;
            };
            let bytes = texel_bytes * texels;
            if bytes > range.len() as u64 {
                return Err(CacheFault::Nonsense(name));
            }
            let end = range.start + bytes as usize;
            if !self.mapping.map(column, range.start..end) {
                return Err(CacheFault::Nonsense(name));
            }
            range.start = end;
        }
        if range.is_empty() { Ok(()) } else { Err(CacheFault::Nonsense(name)) }
    }

    /// Reads the texels of an environment, if its light is a picture.
    fn environment(&mut self, scene: &mut Scene) -> Result<(), CacheFault> {
        let (name, section) = self.next();
        let is_there = match scene.environment.as_mut().map(|sky| &mut sky.light) {
            Some(EnvironmentLight::Map(map)) => {
                let texels = &mut Arc::make_mut(map).texels;
                self.mapping.map(texels.column_mut(), section.range())
            }
            _ => section.range().is_empty(),
        };
        if is_there { Ok(()) } else { Err(CacheFault::Nonsense(name)) }
    }

    fn map(&mut self, column: &mut dyn AnyColumn) -> Result<(), CacheFault> {
        let (name, section) = self.next();
        if self.mapping.map(column, section.range()) {
            Ok(())
        } else {
            Err(CacheFault::Nonsense(name))
        }
    }
}

/// One task: bytes for a checksum, and the condition on the rows in them.
struct VerifyTask<'a> {
    section: usize,
    bytes: &'a [u8],
    check: BlockCheck,
}

#[derive(Clone, Copy)]
enum BlockCheck {
    Rows(RowCheck),
    /// Block of the unverified tree.
    Tree(usize),
}

/// Checks all checksums and all rows. Each block is read from memory once: its rows are checked
/// while its bytes are still in the core's cache.
fn verify(
    file: &[u8],
    shapes: &[SectionLayout],
    table: &[SectionEntry],
    scene: &Scene,
    unverified: &UnverifiedBvh,
    first_array: usize,
) -> Result<(), CacheFault> {
    let blocks = blocks(file, table, scene, unverified, first_array);
    let verified = map_on_pool(&blocks, |block| {
        let holds = match block.check {
            BlockCheck::Rows(check) => check.holds(block.bytes),
            BlockCheck::Tree(k) => unverified.verify(k),
        };
        (crc32fast::hash(block.bytes), holds)
    });
    let mut totals: Vec<crc32fast::Hasher> =
        table.iter().map(|_| crc32fast::Hasher::new()).collect();
    let mut nonsense = None;
    for (block, (sum, holds)) in blocks.iter().zip(verified) {
        let length = block.bytes.len() as u64;
        let sum = crc32fast::Hasher::new_with_initial_len(sum, length);
        totals[block.section].combine(&sum);
        if !holds {
            nonsense = nonsense.or(Some(block.section));
        }
    }
    for (k, (totals, section)) in totals.into_iter().zip(table).enumerate() {
        if totals.finalize() != section.checksum {
            return Err(CacheFault::Damaged(shapes[k].0));
        }
    }
    // Reported last, so that a flipped bit is reported as damage.
    match nonsense {
        None => Ok(()),
        Some(section) => Err(CacheFault::Nonsense(shapes[section].0)),
    }
}

/// All sections in blocks of whole rows: settings, texels and environment, the columns, the levels,
/// the arrays of the tree.
fn blocks<'a>(
    file: &'a [u8],
    table: &[SectionEntry],
    scene: &'a Scene,
    unverified: &'a UnverifiedBvh,
    first_array: usize,
) -> Vec<VerifyTask<'a>> {
    let mut checks = vec![RowCheck::Any; first_array];
    // The other columns are checked in `Scene::validate_settings`.
    for (check, info) in checks[4..].iter_mut().zip(scene.prim_columns()) {
        *check = info.check;
    }
    let mut all = Vec::new();
    for (k, section) in table[..first_array].iter().enumerate() {
        let row_bytes = section.row_bytes as usize;
        let bytes = &file[section.range()];
        all.extend(
            bytes
                .chunks(BLOCK / row_bytes * row_bytes)
                .map(|bytes| VerifyTask {
                    section: k,
                    bytes,
                    check: BlockCheck::Rows(checks[k]),
                }),
        );
    }
    all.extend((0..unverified.blocks()).map(|k| {
        let (array, bytes) = unverified.block(k);
        VerifyTask {
            section: first_array + array,
            bytes,
            check: BlockCheck::Tree(k),
        }
    }));
    all
}
