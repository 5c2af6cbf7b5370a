//! Pictures that a scene file names or carries: each is decoded once, and one that cannot be had is a warning.

use super::folder::{Folder, Found};
use super::report::{Place, Report, quoted};
use crate::scene::{MAX_TEXTURE_SIDE, NO_TEXTURE, Texture, Wrap};
use ::image::codecs::png::PngDecoder;
use ::image::{DynamicImage, ImageDecoder, Limits};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::io::Cursor;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// The textures of a scene while it is read.
pub(super) struct TextureShelf<'a> {
    beside: &'a Folder,
    textures: Vec<Texture>,
    /// Where each picture stands first; [`NO_TEXTURE`] for one that cannot be had.
    pictures: HashMap<Origin, u32>,
    /// Where a picture stands with a wrapping.
    wrapped: HashMap<(u32, [Wrap; 2]), u32>,
    /// Pictures that have got a wrapping.
    worn: HashSet<u32>,
    texels_left: u64,
}

/// Texels of all textures together, of three bytes each: small files may decode to a thousand times their size.
const MOST_TEXELS: u64 = 1 << 30;

/// What tells pictures apart.
#[derive(PartialEq, Eq, Hash)]
enum Origin {
    File(Found),
    /// A name that means no file.
    Missing(String),
    Embedded(Embedded),
}

/// Where in the scene file a picture is.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Embedded {
    /// In the text, as the picture of this number.
    Text(usize),
    /// In the buffer view of this number, which several pictures may share.
    View(usize),
}

impl Embedded {
    fn name(self) -> String {
        match self {
            Embedded::Text(number) => format!("picture {number}"),
            Embedded::View(number) => format!("in buffer view {number}"),
        }
    }
}

impl<'a> TextureShelf<'a> {
    /// An empty shelf for the pictures of a folder.
    pub(super) fn new(beside: &'a Folder) -> Self {
        TextureShelf {
            beside,
            textures: Vec::new(),
            pictures: HashMap::new(),
            wrapped: HashMap::new(),
            worn: HashSet::new(),
            texels_left: MOST_TEXELS,
        }
    }

    /// The texture in a file beside the scene file: an index for [`crate::scene::Surface::texture`], which is
    /// [`NO_TEXTURE`] where the picture cannot be had; that is a warning at `place`, once for each picture.
    pub(super) fn named(
        &mut self,
        name: &str,
        wrap: [Wrap; 2],
        place: impl FnOnce() -> Place,
        report: &mut Report,
    ) -> u32 {
        let found = self.beside.find(name);
        let origin = match &found {
            Ok(file) => Origin::File(file.clone()),
            Err(_) => Origin::Missing(name.to_owned()),
        };
        let bytes = || found?.read().map(Cow::Owned);
        self.picture(origin, &quoted(name), bytes, wrap, place, report)
    }

    /// The texture that the scene file carries, in `bytes`, which are asked for once. As [`TextureShelf::named`].
    pub(super) fn embedded<'b>(
        &mut self,
        picture: Embedded,
        bytes: impl FnOnce() -> Result<Cow<'b, [u8]>, String>,
        wrap: [Wrap; 2],
        place: impl FnOnce() -> Place,
        report: &mut Report,
    ) -> u32 {
        let origin = Origin::Embedded(picture);
        self.picture(origin, &picture.name(), bytes, wrap, place, report)
    }

    /// All textures, for [`crate::scene::Scene::textures`].
    pub(super) fn into_textures(self) -> Vec<Texture> {
        self.textures
    }

    fn picture<'b>(
        &mut self,
        origin: Origin,
        name: &str,
        bytes: impl FnOnce() -> Result<Cow<'b, [u8]>, String>,
        wrap: [Wrap; 2],
        place: impl FnOnce() -> Place,
        report: &mut Report,
    ) -> u32 {
        let told = |reason: String| {
            let message = format!("the texture {name} is left out: {reason}");
            report.warning(place(), message);
            NO_TEXTURE
        };
        let first = match self.pictures.get(&origin) {
            Some(&first) => first,
            None => {
                let decoded = bytes().and_then(|bytes| decode(&bytes, self.texels_left));
                let (first, reason) = match decoded {
                    Ok(texture) => (self.push(texture), None),
                    Err(reason) => (NO_TEXTURE, Some(reason)),
                };
                self.pictures.insert(origin, first);
                if let Some(reason) = reason {
                    return told(reason);
                }
                first
            }
        };
        if first == NO_TEXTURE {
            return first;
        }
        if let Some(&row) = self.wrapped.get(&(first, wrap)) {
            return row;
        }
        let (row, reason) = match self.copy_for(first, wrap) {
            Ok(row) => (row, None),
            Err(reason) => (NO_TEXTURE, Some(reason)),
        };
        self.wrapped.insert((first, wrap), row);
        reason.map_or(row, told)
    }

    /// Where a picture may stand with another wrapping: the first use gives it one, and only another needs a copy.
    fn copy_for(&mut self, first: u32, wrap: [Wrap; 2]) -> Result<u32, String> {
        let row = match self.worn.insert(first) {
            true => first,
            false => {
                let texture = &self.textures[first as usize];
                checked_budget(texture.width, texture.height, self.texels_left)?;
                let copy = texture.clone();
                self.push(copy)
            }
        };
        self.textures[row as usize].wrap = wrap;
        Ok(row)
    }

    /// Takes a texture for which there is room.
    fn push(&mut self, texture: Texture) -> u32 {
        self.texels_left -= texture.texels.len() as u64;
        self.textures.push(texture);
        self.textures.len() as u32 - 1
    }
}

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG: &[u8] = b"\xff\xd8\xff";

/// A picture in sRGB bytes, whatever its file's name says it is. Grey becomes equal parts, 16 bits the nearest of 8,
/// alpha and colour profiles are ignored. One of more than `most` texels is refused before room is made for it.
fn decode(bytes: &[u8], most: u64) -> Result<Texture, String> {
    if bytes.starts_with(PNG) {
        decode_png(bytes, most)
    } else if bytes.starts_with(JPEG) {
        decode_jpeg(bytes, most)
    } else {
        Err("it is neither a PNG nor a JPEG picture".into())
    }
}

/// More than deflate can make of a byte (1032), so that a picture's size is believed only as far as its bytes reach.
const MOST_PER_BYTE: u64 = 1040;
/// A JPEG spends at least a bit on the mean of 8×8 pixels.
const MOST_PIXELS_PER_BYTE: u64 = 8 * 64;

/// Room for the largest texture, RGBA of 16 bits.
const MOST_MEMORY: u64 = MAX_TEXTURE_SIDE as u64 * MAX_TEXTURE_SIDE as u64 * 8;

fn decode_png(bytes: &[u8], most: u64) -> Result<Texture, String> {
    let broken = |error: ::image::ImageError| error.to_string();
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_MEMORY);
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let bits = u64::from(decoder.original_color_type().bits_per_pixel());
    let pixels = checked_pixels(width, height, most)?;
    if pixels * bits / 8 > bytes.len() as u64 * MOST_PER_BYTE {
        return Err(short(width, height));
    }
    let picture = DynamicImage::from_decoder(decoder).map_err(broken)?;
    texture(width, height, picture.into_rgb8().into_raw())
}

/// The decoder's SIMD variants are neither built nor asked for: its plain integer code gives the same bytes everywhere.
fn decode_jpeg(bytes: &[u8], most: u64) -> Result<Texture, String> {
    let broken = |error: zune_jpeg::errors::DecodeErrors| error.to_string();
    let options = DecoderOptions::new_safe()
        .set_strict_mode(false)
        .set_max_width(MAX_TEXTURE_SIDE as usize)
        .set_max_height(MAX_TEXTURE_SIDE as usize)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let (width, height) = decoder.dimensions().ok_or("it has no size")?;
    let (width, height) = (width as u32, height as u32);
    if checked_pixels(width, height, most)? > bytes.len() as u64 * MOST_PIXELS_PER_BYTE {
        return Err(short(width, height));
    }
    texture(width, height, decoder.decode().map_err(broken)?)
}

fn checked_pixels(width: u32, height: u32, most: u64) -> Result<u64, String> {
    let side = 1..=MAX_TEXTURE_SIDE;
    match side.contains(&width) && side.contains(&height) {
        true => checked_budget(width, height, most),
        false => Err(format!(
            "its size is {width}×{height}, but a side may have 1 to {MAX_TEXTURE_SIDE} texels"
        )),
    }
}

fn checked_budget(width: u32, height: u32, most: u64) -> Result<u64, String> {
    let texels = u64::from(width) * u64::from(height);
    match texels <= most {
        true => Ok(texels),
        false => Err(format!(
            "with its {width}×{height} texels, all textures together would have more than {MOST_TEXELS}"
        )),
    }
}

fn short(width: u32, height: u32) -> String {
    format!("it is too short for its {width}×{height} texels")
}

fn texture(width: u32, height: u32, rgb: Vec<u8>) -> Result<Texture, String> {
    let (texels, rest) = rgb.as_chunks::<3>();
    if !rest.is_empty() || texels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err("it decodes to another size than it claims".into());
    }
    Ok(Texture {
        width,
        height,
        wrap: [Wrap::Repeat; 2],
        texels: texels.to_vec().into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::codecs::png::PngEncoder;
    use ::image::{ExtendedColorType, ImageEncoder};
    use std::path::Path;

    const HALVED: &[u8] = include_bytes!("../../tests/pictures/halved.jpg");
    const PROGRESSIVE: &[u8] = include_bytes!("../../tests/pictures/progressive.jpg");
    const GREY: &[u8] = include_bytes!("../../tests/pictures/grey.jpg");

    fn whole(bytes: &[u8]) -> Result<Texture, String> {
        decode(bytes, MOST_TEXELS)
    }

    fn png(width: u32, height: u32, kind: ExtendedColorType, samples: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        let written = PngEncoder::new(&mut out).write_image(samples, width, height, kind);
        written.expect("a picture");
        out
    }

    /// FNV-1a.
    fn hash(texture: &Texture) -> u64 {
        texture
            .texels
            .iter()
            .flatten()
            .fold(0xcbf2_9ce4_8422_2325, |h, &b| {
                (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3)
            })
    }

    #[test]
    fn a_jpeg_decodes_to_the_same_bytes_on_every_build() {
        for (bytes, expected) in [
            (HALVED, 0x38a6_379d_341c_816a),
            (PROGRESSIVE, 0xfaa5_6fa3_5769_1093),
            (GREY, 0x19e5_6f92_a072_6fd6),
        ] {
            let texture = whole(bytes).expect("a picture");
            assert_eq!((texture.width, texture.height), (21, 13));
            assert_eq!(hash(&texture), expected, "{:#x}", hash(&texture));
        }
        // A ramp to the right, a ramp downward, and a chequer, as they were painted.
        let texels = whole(PROGRESSIVE).expect("a picture").texels;
        for (i, &[red, green, _]) in texels.iter().enumerate() {
            assert!(red.abs_diff((i % 21 * 12) as u8) < 48, "{i}: {red}");
            assert!(green.abs_diff((i / 21 * 19) as u8) < 48, "{i}: {green}");
        }
        let grey = whole(GREY).expect("a picture").texels;
        assert!(grey.iter().all(|[r, g, b]| r == g && g == b));
    }

    #[test]
    fn every_png_becomes_srgb_bytes() {
        let two = |kind, samples: &[u8]| whole(&png(2, 1, kind, samples)).expect("a picture");
        let expected = [[0, 0, 0], [200, 200, 200]];
        assert_eq!(two(ExtendedColorType::L8, &[0, 200]).texels, expected);
        let alpha = two(ExtendedColorType::La8, &[0, 9, 200, 0]);
        assert_eq!(alpha.texels, expected);
        let samples: Vec<u8> = [0u16, 200 * 257]
            .iter()
            .flat_map(|s| s.to_ne_bytes())
            .collect();
        assert_eq!(two(ExtendedColorType::L16, &samples).texels, expected);
        let color = two(ExtendedColorType::Rgba8, &[1, 2, 3, 0, 4, 5, 6, 255]);
        assert_eq!(color.texels, [[1, 2, 3], [4, 5, 6]]);
    }

    #[test]
    fn a_size_is_believed_as_far_as_the_bytes_reach() {
        let mut huge = png(4, 4, ExtendedColorType::L8, &[7; 16]);
        let side = huge.windows(4).position(|w| w == b"IHDR").unwrap() + 4;
        huge[side..side + 4].copy_from_slice(&16_000u32.to_be_bytes());
        huge[side + 4..side + 8].copy_from_slice(&16_000u32.to_be_bytes());
        assert!(whole(&huge).is_err());
        huge[side..side + 4].copy_from_slice(&16_385u32.to_be_bytes());
        assert!(whole(&huge).is_err());
        let mut jpeg = HALVED.to_vec();
        let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).unwrap() + 5;
        jpeg[frame..frame + 4].copy_from_slice(&[0x3f, 0xff, 0x3f, 0xff]);
        let refused = whole(&jpeg).map(|_| "a picture");
        assert!(refused.unwrap_err().contains("too short"));
    }

    #[test]
    fn a_picture_stands_once_for_each_wrapping() {
        let folder = tempfile::tempdir().unwrap();
        let dot = png(1, 1, ExtendedColorType::Rgb8, &[1, 2, 3]);
        std::fs::write(folder.path().join("dot.png"), &dot).unwrap();
        std::fs::write(folder.path().join("text.png"), "no picture").unwrap();
        let beside = Folder::of(Path::new(&folder.path().join("scene")));
        let mut report = Report::binary();
        let place = Place::START;
        let mut shelf = TextureShelf::new(&beside);
        let (repeat, clamp) = ([Wrap::Repeat; 2], [Wrap::Clamp; 2]);
        let mut named = |name, wrap| shelf.named(name, wrap, || place, &mut report);
        assert_eq!(named("dot.png", clamp), 0);
        assert_eq!(named("dot.png", repeat), 1);
        assert_eq!(named("dot.png", clamp), 0);
        for missing in ["text.png", "absent.png", "text.png", "absent.png"] {
            assert_eq!(named(missing, clamp), NO_TEXTURE);
        }
        let mut asked = 0;
        for _ in 0..2 {
            let bytes = || {
                asked += 1;
                Ok(Cow::Borrowed(&dot[..]))
            };
            let place = || unreachable!("nothing is wrong");
            let row = shelf.embedded(Embedded::Text(7), bytes, clamp, place, &mut report);
            assert_eq!(row, 2);
        }
        assert_eq!(asked, 1, "decoded once");
        let wraps: Vec<_> = shelf.into_textures().iter().map(|t| t.wrap).collect();
        assert_eq!(wraps, [clamp, repeat, clamp]);
        let warnings = report.finish().expect("no errors");
        let messages: Vec<&str> = warnings.iter().map(|w| w.message.as_str()).collect();
        assert_eq!(messages.len(), 2, "once for each: {messages:?}");
        assert!(messages[0].contains("`text.png`") && messages[0].contains("neither a PNG"));
    }

    #[test]
    fn all_textures_together_are_bounded() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, width: u32| {
            let samples = vec![7; width as usize];
            let bytes = png(width, 1, ExtendedColorType::L8, &samples);
            std::fs::write(folder.path().join(name), bytes).unwrap();
        };
        file("two.png", 2);
        file("three.png", 3);
        let beside = Folder::of(&folder.path().join("scene"));
        let mut report = Report::binary();
        let place = || Place::START;
        let mut shelf = TextureShelf::new(&beside);
        shelf.texels_left = 4;
        let mut named = |name, wrap| shelf.named(name, wrap, place, &mut report);
        let [repeat, clamp, mirror] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror].map(|w| [w; 2]);
        assert_eq!(named("two.png", repeat), 0);
        assert_eq!(named("three.png", repeat), NO_TEXTURE);
        assert_eq!(named("./two.png", clamp), 1, "a copy");
        for _ in 0..2 {
            assert_eq!(named("two.png", mirror), NO_TEXTURE, "a copy too many");
        }
        assert_eq!(named(".//two.png", clamp), 1);
        let warnings = report.finish().expect("no errors");
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(
            warnings[0]
                .message
                .contains("`three.png` is left out: with its 3×1 texels")
        );
    }
}
