//! Files of linear radiance: OpenEXR, Radiance RGBE, portable float maps. What is no number is written as it is where the format
//! can say so.

use super::png::io_error;
use crate::render::Film;
use ::image::Rgb;
use ::image::codecs::hdr::HdrEncoder;
use exr::image::{Encoding, Image, Layer, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::{LineOrder, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::{Blocks, Compression, WritableImage};
use std::io::{self, Cursor, Write};

/// Side of an OpenEXR file's tiles in pixels.
const TILE: usize = 64;

/// A film as OpenEXR: 32-bit floats, tiled, losslessly compressed; the bytes depend on the film alone.
pub(super) fn write_exr(writer: &mut dyn Write, film: &Film) -> io::Result<()> {
    let size = Vec2(film.width as usize, film.height as usize);
    let [r, g, b] = &film.planes;
    let pixel = |at: Vec2<usize>| {
        let i = at.1 * size.0 + at.0;
        (r[i], g[i], b[i])
    };
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::Tiles(Vec2(TILE, TILE)),
        // Else blocks come as threads finish them.
        line_order: LineOrder::Increasing,
    };
    let attributes = LayerAttributes {
        software_name: Text::new_or_none("phalanx"),
        ..LayerAttributes::default()
    };
    let layer = Layer::new(size, attributes, encoding, SpecificChannels::rgb(pixel));
    // The crate goes back in the file to write where tiles are.
    let mut bytes = Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().to_buffered(&mut bytes);
    written.map_err(|error| match error {
        exr::error::Error::Io(error) => error,
        other => io::Error::other(other),
    })?;
    writer.write_all(bytes.get_ref())
}

/// A film as Radiance RGBE, 8 bits of each sample beside the largest of the three. What is negative, or no number, is 0.
pub(super) fn write_hdr(writer: &mut dyn Write, film: &Film) -> io::Result<()> {
    let [r, g, b] = &film.planes;
    let pixels = r
        .iter()
        .zip(g)
        .zip(b)
        .map(|((&r, &g), &b)| Rgb(shared([r, g, b])));
    let pixels: Vec<Rgb<f32>> = pixels.collect();
    let (width, height) = (film.width as usize, film.height as usize);
    let written = HdrEncoder::new(writer).encode(&pixels, width, height);
    written.map_err(io_error)
}

/// Cut to what RGBE can say, by bits. The encoder takes a logarithm for it, of which libraries differ in the last place; of numbers
/// that are cut already it finds the same exponent with any of them.
fn shared(rgb: [f32; 3]) -> [f32; 3] {
    let finite = rgb.map(|c| if c > 0.0 { c.min(LARGEST) } else { 0.0 });
    let most = finite[0].max(finite[1]).max(finite[2]);
    if most < SMALLEST {
        return [0.0; 3];
    }
    // 2^(e - 7), with e the exponent of the largest: eight bits of it are left.
    let step = f32::from_bits((most.to_bits() & EXPONENT) - (7 << 23));
    finite.map(|c| (c / step).trunc() * step)
}

const EXPONENT: u32 = 0xff << 23;

/// 255/256 of the largest power of two that an exponent of 8 bits, less 128, reaches.
const LARGEST: f32 = f32::from_bits(0x7eff_0000);

/// Below it, steps would not be normal numbers.
const SMALLEST: f32 = f32::from_bits(8 << 23);

/// A film as a portable float map, whose rows go upward.
pub(super) fn write_pfm(writer: &mut dyn Write, film: &Film) -> io::Result<()> {
    // The negative number says that floats are little-endian.
    write!(writer, "PF\n{} {}\n-1.0\n", film.width, film.height)?;
    for y in (0..film.height).rev() {
        for x in 0..film.width {
            for c in film.pixel(x, y) {
                writer.write_all(&c.to_le_bytes())?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::codecs::hdr::HdrDecoder;
    use ::image::{DynamicImage, ImageDecoder};
    use exr::prelude::{ReadChannels, ReadLayers};

    /// Wider and higher than a tile, by no round number; small and large, negative, none.
    fn film() -> Film {
        let (width, height) = (70u32, 67u32);
        let value = |k: u32| {
            let size = (k.wrapping_mul(0x9e37_79b9) >> 20) as f32 / 64.0;
            size * [1.0, 1e-6, 300.0, -1.0][k as usize % 4]
        };
        let plane = |c: u32| (0..width * height).map(|i| value(3 * i + c)).collect();
        let mut film = Film {
            width,
            height,
            planes: [plane(0), plane(1), plane(2)],
            hits: None,
        };
        film.planes[0][5] = f32::INFINITY;
        film.planes[1][6] = f32::NAN;
        film
    }

    fn bits(film: &Film, x: u32, y: u32) -> [u32; 3] {
        film.pixel(x, y).map(f32::to_bits)
    }

    #[test]
    fn exr_keeps_every_bit() {
        let film = film();
        let mut bytes = Vec::new();
        write_exr(&mut bytes, &film).unwrap();
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
        let mut again = Vec::new();
        write_exr(&mut again, &film).unwrap();
        assert!(bytes == again, "two times the same bytes");
    }

    #[test]
    fn pfm_keeps_every_bit_from_the_lowest_row_on() {
        let film = film();
        let mut bytes = Vec::new();
        write_pfm(&mut bytes, &film).unwrap();
        let header = b"PF\n70 67\n-1.0\n";
        assert_eq!(bytes[..header.len()], *header);
        let words = bytes[header.len()..].as_chunks::<4>().0;
        assert_eq!(words.len(), 70 * 67 * 3);
        for (i, word) in words.iter().enumerate() {
            let (pixel, c) = (i as u32 / 3, i % 3);
            let want = bits(&film, pixel % 70, 66 - pixel / 70)[c];
            assert_eq!(u32::from_le_bytes(*word), want, "{i}");
        }
    }

    #[test]
    fn hdr_is_within_a_step_of_the_largest_sample() {
        let film = film();
        let mut bytes = Vec::new();
        write_hdr(&mut bytes, &film).unwrap();
        let decoder = HdrDecoder::new(Cursor::new(&bytes)).unwrap();
        assert_eq!(decoder.dimensions(), (70, 67));
        let read = DynamicImage::from_decoder(decoder).unwrap().into_rgb32f();
        for (x, y, pixel) in read.enumerate_pixels() {
            let want = film.pixel(x, y).map(|c| if c > 0.0 { c } else { 0.0 });
            let most = want.iter().fold(0.0f32, |a, &b| a.max(b));
            for (got, want) in pixel.0.into_iter().zip(want) {
                let step = if most.is_finite() {
                    most / 128.0
                } else {
                    f32::INFINITY
                };
                assert!(
                    (want - got).abs() <= step || want.is_infinite(),
                    "{x},{y}: {got} {want}"
                );
            }
        }
    }

    /// By bits, whatever a library's logarithm says: beside every power of two, where one could go wrong.
    #[test]
    fn what_is_cut_has_eight_bits_and_stays_as_it_is() {
        for exponent in 1..255u32 {
            for mantissa in [0, 1, 0x40_0000, 0x7f_0000, 0x7f_ffff] {
                let most = f32::from_bits(exponent << 23 | mantissa);
                let cut = shared([most, most / 3.0, -most]);
                assert_eq!(shared(cut), cut, "{most:e}");
                assert_eq!(cut[0].to_bits() & 0xffff, 0, "{most:e}");
                assert!(
                    cut[0] <= most
                        && (cut[0] >= most * 0.992 || !(SMALLEST..=LARGEST).contains(&most))
                );
                assert_eq!(cut[2], 0.0);
            }
        }
        assert_eq!(shared([f32::NAN, f32::INFINITY, 1.0]), [0.0, LARGEST, 0.0]);
    }
}
