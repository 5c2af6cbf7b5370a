//! Writes a scene and its tree into a file.

use super::header::{self, BLOCK, SectionLayout};
use super::settings::{self, Extra};
use phalanx_scene::{Scene, map_on_pool};
use phalanx_trace::bvh::{Bvh, BvhError};
use std::io::{self, Write};

/// The reason why a cache could not be written.
#[derive(Debug, thiserror::Error)]
pub enum CacheWriteError {
    /// The file could not be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A cache cannot hold this tree.
    #[error(transparent)]
    Tree(#[from] BvhError),
}

/// A section: one row after another, from one or several slices.
pub(super) struct SectionData<'a> {
    pub(super) name: &'static str,
    pub(super) row_bytes: usize,
    pub(super) parts: Vec<&'a [u8]>,
}

impl<'a> SectionData<'a> {
    fn of(name: &'static str, row_bytes: usize, bytes: &'a [u8]) -> SectionData<'a> {
        SectionData {
            name,
            row_bytes,
            parts: vec![bytes],
        }
    }

    fn bytes(&self) -> usize {
        self.parts.iter().map(|part| part.len()).sum()
    }

    fn checksum(&self) -> u32 {
        let blocks = self.parts.iter().flat_map(|part| part.chunks(BLOCK));
        let blocks = map_on_pool(blocks, |block| {
            let mut hasher = crc32fast::Hasher::new();
            hasher.update(block);
            hasher
        });
        let mut total = crc32fast::Hasher::new();
        blocks.iter().for_each(|block| total.combine(block));
        total.finalize()
    }
}

/// All sections of a file: settings, texels, their opacity, the environment, columns, arrays of the
/// tree.
pub(super) fn sections<'a>(
    scene: &'a Scene,
    bvh: &'a Bvh,
    settings: &'a [u8],
    levels: &'a [u16],
) -> Vec<SectionData<'a>> {
    let mut all = vec![SectionData::of("settings", 1, settings)];
    let textures = || scene.textures.iter();
    all.push(SectionData {
        name: "texels",
        row_bytes: size_of::<[u8; 3]>(),
        parts: textures()
            .map(|t| bytemuck::cast_slice(&t.texels))
            .collect(),
    });
    all.push(SectionData {
        name: "opacity of texels",
        row_bytes: 1,
        parts: textures().map(|t| &t.alpha[..]).collect(),
    });
    let environment = scene.environment.as_ref();
    let texels = environment.map_or(&[][..], |environment| environment.light.texel_bytes());
    all.push(SectionData::of("environment", 1, texels));
    let columns = scene.prim_columns().chain(scene.other_columns());
    all.extend(
        columns
            .map(|info| SectionData::of(info.section, info.column.row_size(), info.column.bytes())),
    );
    let levels = bytemuck::cast_slice(levels);
    all.push(SectionData::of(
        "levels of the tree",
        size_of::<u16>(),
        levels,
    ));
    let arrays = bvh.arrays().into_iter();
    all.extend(arrays.map(|array| SectionData::of(array.name, array.row_bytes, array.bytes)));
    all
}

/// Names and row sizes of all sections, in their order.
pub(super) fn shapes() -> Vec<SectionLayout> {
    let (scene, bvh) = (Scene::default(), Bvh::default());
    let sections = sections(&scene, &bvh, &[], &[]);
    sections.iter().map(|s| (s.name, s.row_bytes)).collect()
}

/// A number that identifies a scene: a hash of every column, texel and setting, but not of the
/// tree. Equal scenes have equal fingerprints, from any source.
pub fn fingerprint(scene: &Scene) -> u64 {
    let settings = settings::write(scene, &Extra::of(scene, 0.0));
    let tree = Bvh::default();
    let sections = sections(scene, &tree, &settings, &[]);
    // FNV-1a, 64 bits, of sizes and checksums.
    let words = sections
        .iter()
        .flat_map(|s| [s.bytes() as u64, s.checksum().into()]);
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| {
        (hash ^ word).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Writes a scene, which must be valid, and its tree; returns the bytes written. A tree that has
/// followed a scene where things came and went is built anew for the file.
///
/// The same scene and tree give the same bytes on every machine of the same byte order.
///
/// # Errors
/// [`CacheWriteError`]; then part of the file may have been written.
pub fn write(out: &mut dyn Write, scene: &Scene, bvh: &Bvh) -> Result<u64, CacheWriteError> {
    let bvh = &*bvh.as_built(scene);
    let settings = settings::write(scene, &Extra::of(scene, bvh.sah()));
    let levels = bvh.depths()?;
    let sections = sections(scene, bvh, &settings, &levels);
    let shapes: Vec<SectionLayout> = sections.iter().map(|s| (s.name, s.row_bytes)).collect();
    let table: Vec<(u64, u32)> = sections
        .iter()
        .map(|s| ((s.bytes() / s.row_bytes) as u64, s.checksum()))
        .collect();
    let (header, offsets) = header::write(&shapes, &table);
    out.write_all(&header)?;
    let mut end = header.len() as u64;
    for (section, &offset) in sections.iter().zip(&offsets) {
        // Less than a cache line.
        out.write_all(&[0; header::ALIGN as usize][..(offset - end) as usize])?;
        for part in &section.parts {
            out.write_all(part)?;
        }
        end = offset + section.bytes() as u64;
    }
    Ok(end)
}
