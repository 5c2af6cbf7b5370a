//! OpenEXR files: unchanged radiance as 32-bit floats, or rounded to half floats, in tiles of 64x64
//! pixels, with lossless compression.

use super::description::{Depth, Films, PictureFile};
use super::exr_header::{ExrChannel, TILE, header, sorted_header};
use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::SampleType;
use exr::prelude::{SmallVec, f16};
use phalanx_files::WriteSeek;
use phalanx_scene::film::{Aovs, Film};
use phalanx_scene::map_on_pool;
use std::io::{self, BufWriter, SeekFrom};

/// Writes films, one below the other, as they arrive. All threads compress their tiles, which are
/// written in order.
pub(super) fn write_exr(
    out: &mut dyn WriteSeek,
    file: &PictureFile,
    bands: Films,
) -> io::Result<()> {
    let channels = channels(file.aovs, file.depth);
    let header = header(file, &channels);
    let sorted = sorted_header(&header)?;
    // The error of a band is kept here, so that it is not lost among the crate's own errors.
    let mut failed = None;
    let written = exr::block::write(
        BufWriter::new(&mut *out),
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
        (None, Err(other)) => Err(io::Error::other(other)),
        (None, Ok(())) => {
            out.seek(SeekFrom::Start(0))?;
            out.write_all(&sorted)
        }
    }
}

/// Radiance and the layers, named as OpenEXR names those of a single part. They are sorted by name,
/// as the format requires. Only colours have half floats.
fn channels(aovs: Aovs, depth: Depth) -> Vec<ExrChannel> {
    let color = match depth {
        Depth::Standard => SampleType::F32,
        Depth::Sixteen => SampleType::F16,
    };
    let radiance = ["R", "G", "B"].map(|name| (name, color));
    let layers = aovs.iter().flat_map(|aov| {
        let float = if aov.is_color() { color } else { SampleType::F32 };
        let kind = move |id: bool| if id { SampleType::U32 } else { float };
        aov.channels()
            .iter()
            .map(move |&(name, id)| (name, kind(id)))
    });
    let all = radiance.into_iter().chain(layers).zip(0..);
    let mut all: Vec<ExrChannel> = all.map(|((name, kind), k)| (name, kind, k)).collect();
    all.sort_unstable_by_key(|(name, ..)| *name);
    all
}

/// The nearest half float, in integer arithmetic; ties go to the even one. Finite values beyond the
/// largest half float become it, as in Blender: an infinity would spread through every filter of a
/// compositor. Infinities and NaN stay what they are.
fn half(value: f32) -> f16 {
    let most = f16::MAX.to_f32();
    f16::from_f32_const(if value.is_infinite() { value } else { value.clamp(-most, most) })
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
        let compressed = map_on_pool(0..across, |column| {
            let corner = Vec2(column * TILE, row * TILE);
            tile(channels, film, corner, top).compress_to_chunk(&meta.headers)
        });
        let first = (top / TILE + row) * across;
        for (chunk, index) in compressed.into_iter().zip(first..) {
            chunks.write_chunk(index, chunk?)?;
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
        for &(_, kind, plane) in channels {
            let samples = &planes[plane][row.clone()];
            match kind {
                SampleType::F16 => {
                    data.extend(samples.iter().flat_map(|s| half(*s).to_ne_bytes()));
                }
                SampleType::F32 | SampleType::U32 => {
                    data.extend_from_slice(bytemuck::cast_slice(samples));
                }
            }
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
    use super::super::test_film::{PLAIN_EXR, bits, film};
    use super::*;
    use exr::prelude::{ReadChannels, ReadLayers};
    use phalanx_scene::film::Aov;
    use std::io::Cursor;

    #[test]
    fn exr_keeps_every_bit() {
        let film = film();
        let write = || {
            let mut bytes = Cursor::new(Vec::new());
            let file = PictureFile {
                width: 70,
                height: 67,
                ..PLAIN_EXR
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
                |pixels, position, (r, g, b, _): (f32, f32, f32, f32)| {
                    pixels[position.1 * 70 + position.0] = [r, g, b];
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

    #[test]
    fn halves_are_the_nearest_and_stay_finite() {
        for (value, want) in [
            // Halves are 1/1024 apart from 1 on: ties go to the even one.
            (1.0 + 1.0 / 2048.0, 0x3c00),
            (1.0 + 3.0 / 2048.0, 0x3c02),
            (1.0 + 1.1 / 2048.0, 0x3c01),
            (-0.0, 0x8000),
            // The smallest half above 0 is 2^-24.
            (f32::exp2(-24.0), 0x0001),
            (f32::exp2(-25.0), 0x0000),
            (65_504.0, 0x7bff),
            (65_519.9, 0x7bff),
            (65_520.0, 0x7bff),
            (f32::MAX, 0x7bff),
            (-70_000.0, 0xfbff),
            (f32::INFINITY, 0x7c00),
            (f32::NEG_INFINITY, 0xfc00),
            // The NaN of a film.
            (f32::from_bits(0xffc0_0000), 0xfe00),
        ] {
            assert_eq!(half(value).to_bits(), want, "{value}");
        }
    }

    #[test]
    fn only_colours_are_halves() {
        let kinds = |depth| {
            let channels = channels(Aovs::all().with(Aov::Cost), depth);
            let named = |kind| {
                let those = channels.iter().filter(move |(_, other, _)| *other == kind);
                those.map(|(name, ..)| *name).collect::<Vec<_>>()
            };
            [SampleType::F16, SampleType::U32].map(named)
        };
        let integers = ["material.id", "primitive.id", "samples.count"];
        let colors = "A B G R albedo.B albedo.G albedo.R direct.B direct.G direct.R reflection.B \
                      reflection.G reflection.R refraction.B refraction.G refraction.R";
        let colors: Vec<&str> = colors.split_whitespace().collect();
        assert_eq!(kinds(Depth::Sixteen), [&colors[..], &integers]);
        assert_eq!(kinds(Depth::Standard), [&[][..], &integers]);
    }
}
