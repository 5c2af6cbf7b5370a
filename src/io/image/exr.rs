//! OpenEXR files: radiance as it is, in 32-bit floats, in tiles of 64x64 pixels, losslessly
//! compressed.

use super::description::{BAND_ROWS, Films, PictureFile};
use super::file::WriteSeek;
use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::math::{RoundingMode, Vec2};
use exr::meta::attribute::{
    AttributeValue, ChannelDescription, LevelMode, LineOrder, SampleType, Text, TileDescription,
};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{Compression, SmallVec};
use phalanx_scene::film::{Aov, Aovs, Film};
use rayon::prelude::*;
use std::io::{self, BufWriter};

/// Side of a tile in pixels. Bands are multiples of it in height, so that no tile lies in two
/// bands.
const TILE: usize = BAND_ROWS as usize;

/// Writes films, one below the other, as they come. All threads compress their tiles, which are
/// written in order.
pub(super) fn write_exr(
    out: &mut dyn WriteSeek,
    file: &PictureFile,
    bands: Films,
) -> io::Result<()> {
    let channels = channels(file.aovs);
    let header = header(file, &channels);
    // The error of a band is kept here, so that it is not lost among the crate's own errors.
    let mut failed = None;
    let written = exr::block::write(
        BufWriter::new(out),
        SmallVec::from_iter([header]),
        true,
        |meta, chunks| {
            let mut top = 0;
            for film in bands {
                match film {
                    Ok(film) => top += write_band(chunks, &meta, &channels, &film, top)?,
                    Err(error) => {
                        failed = Some(error);
                        return Err(exr::error::Error::Aborted);
                    }
                }
            }
            Ok(())
        },
    );
    match (failed, written) {
        (Some(error), _) => Err(error),
        (None, Err(exr::error::Error::Io(error))) => Err(error),
        (None, other) => other.map_err(io::Error::other),
    }
}

/// A channel of the file: its name, true if it holds whole numbers, and the index of its plane in a
/// film.
type ExrChannel = (&'static str, bool, usize);

/// Radiance and the layers, named as OpenEXR names those of a single part. They are in the order of
/// their names, as the format demands.
fn channels(aovs: Aovs) -> Vec<ExrChannel> {
    let radiance = ["R", "G", "B"].map(|name| (name, false));
    let all = radiance.into_iter().chain(aovs.channels());
    let mut all: Vec<ExrChannel> = (0..)
        .zip(all)
        .map(|(k, (name, id))| (name, id, k))
        .collect();
    all.sort_unstable();
    all
}

/// Name of the attribute for the scene's origin in the coordinates of its file, as three decimals,
/// in a picture file with positions. Far from the origin, positions in the file's coordinates are
/// rounded to single precision; positions in the scene were not.
const ORIGIN: &str = "phalanx.origin";

fn header(file: &PictureFile, channels: &[ExrChannel]) -> Header {
    let channels = channels.iter().map(|&(name, id, _)| ChannelDescription {
        name: Text::from(name),
        sample_type: if id { SampleType::U32 } else { SampleType::F32 },
        quantize_linearly: false,
        sampling: Vec2(1, 1),
    });
    let blocks = BlockDescription::Tiles(TileDescription {
        tile_size: Vec2(TILE, TILE),
        level_mode: LevelMode::Singular,
        rounding_mode: RoundingMode::Down,
    });
    let size = Vec2(file.width as usize, file.height as usize);
    let name = Text::default();
    let mut header = Header::new(name, size, channels.collect()).with_encoding(
        Compression::ZIP16,
        blocks,
        LineOrder::Increasing,
    );
    header.own_attributes.layer_name = None;
    header.own_attributes.software_name = Text::new_or_none("phalanx");
    if file.aovs.has(Aov::Position) && file.origin != [0.0; 3] {
        let [x, y, z] = file.origin;
        let origin = AttributeValue::Text(Text::from(&format!("{x} {y} {z}")[..]));
        let others = &mut header.own_attributes.other;
        others.insert(Text::from(ORIGIN), origin);
    }
    header
}

/// Writes the tiles of a film that begins in this row of the picture; returns its height.
fn write_band(
    chunks: &mut impl ChunksWriter,
    meta: &MetaData,
    channels: &[ExrChannel],
    film: &Film,
    top: usize,
) -> exr::error::Result<usize> {
    let (width, height) = (film.width as usize, film.height as usize);
    let across = width.div_ceil(TILE);
    for row in 0..height.div_ceil(TILE) {
        let compressed: exr::error::Result<Vec<_>> = (0..across)
            .into_par_iter()
            .map(|column| {
                let corner = Vec2(column * TILE, row * TILE);
                tile(channels, film, corner, top).compress_to_chunk(&meta.headers)
            })
            .collect();
        let first = (top / TILE + row) * across;
        for (chunk, index) in compressed?.into_iter().zip(first..) {
            chunks.write_chunk(index, chunk)?;
        }
    }
    Ok(height)
}

/// The tile of a film with this upper left pixel: for each of its rows all samples of the first
/// channel, then all of the second, and so on.
fn tile(
    channels: &[ExrChannel],
    film: &Film,
    corner: Vec2<usize>,
    top: usize,
) -> UncompressedBlock {
    let (width, height) = (film.width as usize, film.height as usize);
    let size = Vec2(TILE.min(width - corner.0), TILE.min(height - corner.1));
    let planes: Vec<&[f32]> = film.all_planes();
    let mut data = Vec::with_capacity(size.area() * 4 * channels.len());
    for y in corner.1..corner.1 + size.1 {
        let row = y * width + corner.0..y * width + corner.0 + size.0;
        for (.., plane) in channels {
            data.extend_from_slice(bytemuck::cast_slice(&planes[*plane][row.clone()]));
        }
    }
    UncompressedBlock {
        index: BlockIndex {
            layer: 0,
            pixel_position: Vec2(corner.0, top + corner.1),
            pixel_size: size,
            level: Vec2(0, 0),
        },
        data,
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_film::{bits, film};
    use super::*;
    use crate::image::{Depth, Exposure, ImageFormat};
    use exr::prelude::{ReadChannels, ReadLayers};
    use phalanx_scene::OutputEncoding;
    use std::io::Cursor;

    const PLAIN: PictureFile = PictureFile {
        width: 2,
        height: 2,
        format: ImageFormat::Exr,
        aovs: Aovs::NONE,
        origin: [0.0; 3],
        exposure: Exposure {
            stops: 0.0,
            encoding: OutputEncoding::LINEAR,
        },
        depth: Depth::Eight,
    };

    #[test]
    fn only_a_moved_scene_with_positions_has_its_origin_in_the_header() {
        let far = PictureFile {
            aovs: Aovs::NONE.with(Aov::Position),
            origin: [500_000.5, 0.0, -4e6],
            ..PLAIN
        };
        let told = |file: &PictureFile| {
            let header = header(file, &channels(file.aovs));
            let value = header
                .own_attributes
                .other
                .get(&Text::from(ORIGIN))
                .cloned();
            value.map(|value| value.into_text().unwrap().to_string())
        };
        assert_eq!(told(&far).as_deref(), Some("500000.5 0 -4000000"));
        let without = PictureFile {
            aovs: Aovs::NONE,
            ..far
        };
        let near = PictureFile {
            origin: [0.0; 3],
            ..far
        };
        assert_eq!([told(&without), told(&near)], [None, None]);
    }

    #[test]
    fn exr_keeps_every_bit() {
        let film = film();
        let write = || {
            let mut bytes = Cursor::new(Vec::new());
            let file = PictureFile {
                width: 70,
                height: 67,
                ..PLAIN
            };
            write_exr(&mut bytes, &file, &mut [Ok(film.clone())].into_iter()).unwrap();
            bytes.into_inner()
        };
        let bytes = write();
        let read = exr::image::read::read()
            .no_deep_data()
            .largest_resolution_level()
            .rgba_channels(
                |size, _| vec![[0.0f32; 3]; size.area()],
                |pixels, at, (r, g, b, _): (f32, f32, f32, f32)| {
                    pixels[at.1 * 70 + at.0] = [r, g, b];
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(&bytes))
            .unwrap();
        let pixels = &read.layer_data.channel_data.pixels;
        for (x, y) in (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y))) {
            let got = pixels[(y * film.width + x) as usize].map(f32::to_bits);
            assert_eq!(got, bits(&film, x, y), "{x},{y}");
        }
        assert!(bytes == write(), "two times the same bytes");
    }
}
