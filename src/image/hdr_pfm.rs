//! Files of linear radiance: Radiance RGBE and portable float maps.

use super::description::Films;
use super::header::PictureHeader;
use super::png::io_error;
use ::image::Rgb;
use ::image::codecs::hdr::HdrEncoder;
use phalanx_files::WriteSeek;
use std::io::{self, SeekFrom, Write};

/// Films as Radiance RGBE: three mantissas of 8 bits that share the exponent of the largest
/// component. Negative components and NaN become 0.
pub(super) fn write_hdr(
    out: &mut dyn Write,
    (width, height): (u32, u32),
    header: &PictureHeader,
    bands: Films,
) -> io::Result<()> {
    writeln!(out, "#?RADIANCE")?;
    for (_, text) in header.texts() {
        writeln!(out, "# {text}")?;
    }
    write!(out, "FORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n")?;
    for film in bands {
        let film = film?;
        let [r, g, b] = &film.planes;
        let pixels = r.iter().zip(g).zip(b);
        let pixels = pixels.map(|((&r, &g), &b)| Rgb(shared_exponent_rgb([r, g, b])));
        let pixels: Vec<Rgb<f32>> = pixels.collect();
        // The encoder writes whole files, but rows do not depend on each other, so only the rows of
        // its file are used, without its header.
        let mut file = Vec::new();
        let (width, height) = (film.width as usize, film.height as usize);
        HdrEncoder::new(&mut file)
            .encode(&pixels, width, height)
            .map_err(io_error)?;
        let size = format!("\n-Y {height} +X {width}\n");
        let head = memchr::memmem::find(&file, size.as_bytes());
        let head = head.ok_or_else(|| io::Error::other("the encoder writes another head"))?;
        out.write_all(&file[head + size.len()..])?;
    }
    Ok(())
}

/// Truncates components to the precision of RGBE, by bits. The encoder computes the exponent with a
/// logarithm, which differs between libraries in the last place. For truncated numbers, all
/// libraries give the same exponent.
fn shared_exponent_rgb(rgb: [f32; 3]) -> [f32; 3] {
    let finite = rgb.map(|c| if c > 0.0 { c.min(MAX_COMPONENT) } else { 0.0 });
    let most = finite[0].max(finite[1]).max(finite[2]);
    if most < MIN_COMPONENT {
        return [0.0; 3];
    }
    // 2^(e - 7), with e the exponent of the largest component: eight bits of it are left.
    let step = f32::from_bits((most.to_bits() & EXPONENT) - (7 << 23));
    finite.map(|c| (c / step).trunc() * step)
}

const EXPONENT: u32 = 0xff << 23;

/// 255/256 of the largest power of two that an exponent of 8 bits, less 128, reaches.
const MAX_COMPONENT: f32 = f32::from_bits(0x7eff_0000);

/// Lower bound of the largest component. Below it, steps would not be normal numbers.
const MIN_COMPONENT: f32 = f32::from_bits(8 << 23);

/// Films as a portable float map, with rows from bottom to top: each band is written before the one
/// above it. NaN is written unchanged.
pub(super) fn write_pfm(
    out: &mut dyn WriteSeek,
    width: u32,
    height: u32,
    bands: Films,
) -> io::Result<()> {
    // A negative number in the third line means little-endian floats.
    write!(out, "PF\n{width} {height}\n-1.0\n")?;
    let head = out.stream_position()?;
    let row = 12 * u64::from(width);
    let mut below = u64::from(height);
    for film in bands {
        let film = film?;
        below -= u64::from(film.height);
        out.seek(SeekFrom::Start(head + below * row))?;
        for y in (0..film.height).rev() {
            for x in 0..film.width {
                for c in film.pixel(x, y) {
                    out.write_all(&c.to_le_bytes())?;
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::test_film::{bits, film};
    use super::*;
    use ::image::codecs::hdr::HdrDecoder;
    use ::image::{DynamicImage, ImageDecoder};
    use std::io::Cursor;

    #[test]
    fn pfm_keeps_every_bit_from_the_lowest_row_on() {
        let film = film();
        let mut bytes = Cursor::new(Vec::new());
        write_pfm(&mut bytes, 70, 67, &mut [Ok(film.clone())].into_iter()).unwrap();
        let bytes = bytes.into_inner();
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
        let mut bytes = Cursor::new(Vec::new());
        let header = PictureHeader {
            scene: "a\n-Y 1 +X 1".to_owned(),
            command: "phalanx render ä".to_owned(),
            ..PictureHeader::NONE
        };
        let mut films = [Ok(film.clone())].into_iter();
        write_hdr(&mut bytes, (70, 67), &header, &mut films).unwrap();
        let text = String::from_utf8_lossy(bytes.get_ref());
        let lines: Vec<&str> = text.lines().take(5).collect();
        let version = concat!("# phalanx ", env!("CARGO_PKG_VERSION"));
        let [scene, command] = ["# a-Y 1 +X 1", "# phalanx render ä"];
        let format = "FORMAT=32-bit_rle_rgbe";
        assert_eq!(lines, ["#?RADIANCE", version, scene, command, format]);
        let decoder = HdrDecoder::new(Cursor::new(bytes.into_inner())).unwrap();
        assert_eq!(decoder.dimensions(), (70, 67));
        let read = DynamicImage::from_decoder(decoder).unwrap().into_rgb32f();
        for (x, y, pixel) in read.enumerate_pixels() {
            let want = film.pixel(x, y).map(|c| if c > 0.0 { c } else { 0.0 });
            let most = want.iter().fold(0.0f32, |a, &b| a.max(b));
            for (got, want) in pixel.0.into_iter().zip(want) {
                let step = if most.is_finite() { most / 128.0 } else { f32::INFINITY };
                assert!(
                    (want - got).abs() <= step || want.is_infinite(),
                    "{x},{y}: {got} {want}"
                );
            }
        }
    }

    /// Checks the truncation by bits, independent of a library's logarithm, next to every power of
    /// two, where a logarithm could go wrong.
    #[test]
    fn what_is_cut_has_eight_bits_and_stays_as_it_is() {
        for exponent in 1..255u32 {
            for mantissa in [0, 1, 0x40_0000, 0x7f_0000, 0x7f_ffff] {
                let most = f32::from_bits(exponent << 23 | mantissa);
                let cut = shared_exponent_rgb([most, most / 3.0, -most]);
                assert_eq!(shared_exponent_rgb(cut), cut, "{most:e}");
                assert_eq!(cut[0].to_bits() & 0xffff, 0, "{most:e}");
                assert!(
                    cut[0] <= most
                        && (cut[0] >= most * 0.992
                            || !(MIN_COMPONENT..=MAX_COMPONENT).contains(&most))
                );
                assert_eq!(cut[2], 0.0);
            }
        }
        assert_eq!(
            shared_exponent_rgb([f32::NAN, f32::INFINITY, 1.0]),
            [0.0, MAX_COMPONENT, 0.0]
        );
    }
}
