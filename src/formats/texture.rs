//! Pictures that a scene file names or embeds. Each is decoded once, and a missing one is a
//! warning.

use super::diagnostics::{DiagnosticSink, Span, quoted_file};
use super::folder::{Folder, Found};
use super::picture::EncodedImage;
use super::relief::{is_normal_map, normals_of_heights};
use phalanx_scene::{NO_TEXTURE, Texture, Wrap};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// The textures of a scene while it is read.
pub(super) struct TextureLibrary<'a> {
    asset_dir: &'a Folder,
    textures: Vec<Texture>,
    /// Row of the first texture of each picture; [`NO_TEXTURE`] for a missing one.
    pictures: HashMap<ImageKey, u32>,
    /// Row of the texture of a picture with a sampler.
    sampled: HashMap<(u32, TextureSampler), u32>,
    /// Textures whose sampler has been set.
    sampler_assigned: HashSet<u32>,
    /// Textures whose alpha is read; that of others is dropped in the end.
    read_for_alpha: HashSet<u32>,
    /// Row of each texture as a mask, and as a normal map.
    masks: HashMap<u32, u32>,
    normals: HashMap<u32, u32>,
    texels_left: u64,
}

/// Most texels of all textures together, of three bytes each: small files may decode to a thousand
/// times their size.
const MAX_TEXELS: u64 = 1 << 30;

/// The way to read a texture between its texels and beyond its edges: by default, blended and
/// repeated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct TextureSampler {
    pub(super) wrap: [Wrap; 2],
    pub(super) nearest: bool,
}

/// Key that distinguishes pictures.
#[derive(PartialEq, Eq, Hash)]
enum ImageKey {
    File(Found),
    /// A name without a file.
    Missing(String),
    Embedded(Embedded),
}

/// Location of a picture within the scene file.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Embedded {
    /// A picture in the text, by its number.
    Text(usize),
    /// A picture in the buffer view of this number, which several pictures may share.
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

impl<'a> TextureLibrary<'a> {
    /// An empty library for the pictures of a folder.
    pub(super) fn new(asset_dir: &'a Folder) -> Self {
        TextureLibrary {
            asset_dir,
            textures: Vec::new(),
            pictures: HashMap::new(),
            sampled: HashMap::new(),
            sampler_assigned: HashSet::new(),
            read_for_alpha: HashSet::new(),
            masks: HashMap::new(),
            normals: HashMap::new(),
            texels_left: MAX_TEXELS,
        }
    }

    /// The texture in a file beside the scene file: an index for
    /// [`phalanx_scene::Material::texture`]. It is [`NO_TEXTURE`] for a missing picture, which is a
    /// warning at `span`, once for each picture.
    pub(super) fn named(
        &mut self,
        name: &str,
        sampler: TextureSampler,
        span: impl FnOnce() -> Span,
        report: &mut DiagnosticSink,
    ) -> u32 {
        let found = self.asset_dir.find(name);
        self.found(name, found, sampler, span, report)
    }

    /// The texture in a file that was looked for already. Otherwise as [`TextureLibrary::named`].
    pub(super) fn found(
        &mut self,
        name: &str,
        found: Result<Found, String>,
        sampler: TextureSampler,
        span: impl FnOnce() -> Span,
        report: &mut DiagnosticSink,
    ) -> u32 {
        let origin = match &found {
            Ok(file) => ImageKey::File(file.clone()),
            Err(_) => ImageKey::Missing(name.to_owned()),
        };
        let asset_dir = self.asset_dir;
        let bytes = || asset_dir.read(&found?).map(Cow::Owned);
        self.picture(origin, &quoted_file(name), bytes, sampler, span, report)
    }

    /// The texture that is embedded in the scene file, in `bytes`, which are requested once.
    /// Otherwise as [`TextureLibrary::named`].
    pub(super) fn embedded<'b>(
        &mut self,
        picture: Embedded,
        bytes: impl FnOnce() -> Result<Cow<'b, [u8]>, String>,
        sampler: TextureSampler,
        span: impl FnOnce() -> Span,
        report: &mut DiagnosticSink,
    ) -> u32 {
        let origin = ImageKey::Embedded(picture);
        self.picture(origin, &picture.name(), bytes, sampler, span, report)
    }

    /// The same texture for its alpha: an index for [`phalanx_scene::Material::opacity_texture`].
    /// It is [`NO_TEXTURE`] for a missing texture and for one of which all texels are whole.
    pub(super) fn alpha_of(&mut self, texture: u32) -> u32 {
        let known = self.textures.get(texture as usize);
        if known.is_none_or(|texture| texture.alpha.is_empty()) {
            return NO_TEXTURE;
        }
        self.read_for_alpha.insert(texture);
        texture
    }

    /// The same texture as a mask: a picture without alpha has its luminance as alpha, of the bytes
    /// as they are stored. Otherwise as [`TextureLibrary::alpha_of`], with an error at `span` if
    /// there is no memory for it.
    pub(super) fn mask_of(
        &mut self,
        texture: u32,
        span: impl FnOnce() -> Span,
        report: &mut DiagnosticSink,
    ) -> u32 {
        if let Some(&row) = self.masks.get(&texture) {
            return row;
        }
        if let Some(known) = self.textures.get_mut(texture as usize)
            && known.alpha.is_empty()
        {
            let bytes = known.texels.len() as u64;
            let memory = self.asset_dir.memory();
            match memory.take(bytes, "for the texture of an opacity") {
                Ok(()) => known.alpha = luminance(&known.texels).into(),
                Err(reason) => report.error(span(), reason),
            }
        }
        let row = self.alpha_of(texture);
        self.masks.insert(texture, row);
        row
    }

    /// The same texture as a normal map: a picture that is none already is taken as heights. An
    /// error at `span` if there is no memory for it.
    pub(super) fn normals_of(
        &mut self,
        texture: u32,
        span: impl FnOnce() -> Span,
        report: &mut DiagnosticSink,
    ) -> u32 {
        let Some(known) = self.textures.get(texture as usize) else {
            return NO_TEXTURE;
        };
        if let Some(&row) = self.normals.get(&texture) {
            return row;
        }
        let row = if is_normal_map(known) {
            texture
        } else {
            let bytes = 3 * known.texels.len() as u64;
            let memory = self.asset_dir.memory();
            if let Err(reason) = memory.take(bytes, "for the normals of a relief") {
                report.error(span(), reason);
                return NO_TEXTURE;
            }
            let normals = Texture {
                texels: normals_of_heights(known).into(),
                alpha: Default::default(),
                ..*known
            };
            self.push(normals)
        };
        self.normals.insert(texture, row);
        row
    }

    /// All textures, for [`phalanx_scene::Scene::textures`].
    pub(super) fn into_textures(mut self) -> Vec<Texture> {
        for (row, texture) in self.textures.iter_mut().enumerate() {
            if !self.read_for_alpha.contains(&(row as u32)) {
                texture.alpha = Default::default();
            }
        }
        self.textures
    }

    fn picture<'b>(
        &mut self,
        origin: ImageKey,
        name: &str,
        bytes: impl FnOnce() -> Result<Cow<'b, [u8]>, String>,
        sampler: TextureSampler,
        span: impl FnOnce() -> Span,
        report: &mut DiagnosticSink,
    ) -> u32 {
        let row = self.row(origin, name, bytes, sampler);
        row.unwrap_or_else(|reason| {
            let message = format!("the texture {name} is left out: {reason}");
            match self.asset_dir.memory().refusal() {
                Some(_) => report.error(span(), message),
                None => report.texture_left_out(span(), name, reason),
            }
            NO_TEXTURE
        })
    }

    /// The row of a picture with a sampler. The error says why there is none, the first time;
    /// later it is [`NO_TEXTURE`].
    fn row<'b>(
        &mut self,
        origin: ImageKey,
        name: &str,
        bytes: impl FnOnce() -> Result<Cow<'b, [u8]>, String>,
        sampler: TextureSampler,
    ) -> Result<u32, String> {
        let first = match self.pictures.get(&origin) {
            Some(&first) => first,
            None => {
                let decoded = bytes().and_then(|bytes| self.decode(name, &bytes));
                let first = decoded.map(|texture| self.push(texture));
                self.pictures.insert(origin, known(&first));
                first?
            }
        };
        if first == NO_TEXTURE {
            return Ok(first);
        }
        if let Some(&row) = self.sampled.get(&(first, sampler)) {
            return Ok(row);
        }
        let row = self.copy_for(name, first, sampler);
        self.sampled.insert((first, sampler), known(&row));
        row
    }

    /// Decodes a picture into sRGB bytes, if there is memory for it.
    fn decode(&mut self, name: &str, bytes: &[u8]) -> Result<Texture, String> {
        let picture = EncodedImage::open(bytes)?;
        let (width, height) = (picture.width, picture.height);
        checked_budget(width, height, self.texels_left)?;
        let what = format!("to decode the texture {name} of {width}×{height} texels");
        let (texels, alpha) = (picture.pixels() * 3, picture.alpha_bytes());
        let memory = self.asset_dir.memory();
        memory.lend(texels + alpha + picture.scratch + bytes.len() as u64, &what)?;
        memory.take(texels, &what)?;
        // Counted even if it turns out to be broken, so that many broken ones stay cheap.
        self.texels_left -= picture.pixels();
        let decoded = picture.decode()?;
        memory.take(decoded.alpha.len() as u64, &what)?;
        Ok(Texture {
            width,
            height,
            wrap: [Wrap::Repeat; 2],
            nearest: false,
            texels: decoded.colors.into(),
            alpha: decoded.alpha.into(),
        })
    }

    /// Row of a picture with another sampler. The first use sets the sampler of the texture itself,
    /// and only another one needs a copy.
    fn copy_for(&mut self, name: &str, first: u32, sampler: TextureSampler) -> Result<u32, String> {
        let mut row = first;
        if !self.sampler_assigned.insert(first) {
            let texture = &self.textures[first as usize];
            let texels = checked_budget(texture.width, texture.height, self.texels_left)?;
            let bytes = texels * 3 + texture.alpha.len() as u64;
            let what = format!("for the texture {name} with another sampler");
            self.asset_dir.memory().take(bytes, what)?;
            self.texels_left -= texels;
            row = self.push(texture.clone());
        }
        let texture = &mut self.textures[row as usize];
        (texture.wrap, texture.nearest) = (sampler.wrap, sampler.nearest);
        Ok(row)
    }

    /// Adds a texture for which there is memory.
    fn push(&mut self, texture: Texture) -> u32 {
        self.textures.push(texture);
        self.textures.len() as u32 - 1
    }
}

/// The row that stands for a result from then on.
fn known(row: &Result<u32, String>) -> u32 {
    *row.as_ref().unwrap_or(&NO_TEXTURE)
}

/// Luminance of the bytes as they are stored (Rec. 709), none if all are white. Grey keeps its
/// value.
fn luminance(texels: &[[u8; 3]]) -> Vec<u8> {
    if texels.iter().all(|&texel| texel == [255; 3]) {
        return Vec::new();
    }
    let weigh = |&[r, g, b]: &[u8; 3]| 54 * u32::from(r) + 183 * u32::from(g) + 19 * u32::from(b);
    let luminances = texels.iter().map(|texel| ((weigh(texel) + 128) >> 8) as u8);
    luminances.collect()
}

fn checked_budget(width: u32, height: u32, most: u64) -> Result<u64, String> {
    let texels = u64::from(width) * u64::from(height);
    if texels <= most {
        Ok(texels)
    } else {
        Err(format!(
            "with its {width}×{height} texels, all textures together would have more than {MAX_TEXELS}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::tests::encoded;
    use png::{BitDepth::Eight, ColorType};
    use std::path::Path;

    fn sampler(wrap: Wrap) -> TextureSampler {
        TextureSampler {
            wrap: [wrap; 2],
            nearest: false,
        }
    }

    #[test]
    fn a_picture_stands_once_for_each_wrapping() {
        let folder = tempfile::tempdir().unwrap();
        let dot = encoded([1, 1], ColorType::Rgb, Eight, &[1, 2, 3]);
        std::fs::write(folder.path().join("dot.png"), &dot).unwrap();
        std::fs::write(folder.path().join("text.png"), "no picture").unwrap();
        let asset_dir = Folder::of(Path::new(&folder.path().join("scene")));
        let mut report = DiagnosticSink::binary();
        let span = Span::START;
        let mut library = TextureLibrary::new(&asset_dir);
        let (repeat, clamp) = (sampler(Wrap::Repeat), sampler(Wrap::Clamp));
        let mut named = |name, wrap| library.named(name, wrap, || span, &mut report);
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
            let span = || unreachable!("nothing is wrong");
            let row = library.embedded(Embedded::Text(7), bytes, clamp, span, &mut report);
            assert_eq!(row, 2);
        }
        assert_eq!(asked, 1, "decoded once");
        let wraps: Vec<_> = library.into_textures().iter().map(|t| t.wrap).collect();
        assert_eq!(wraps, [clamp, repeat, clamp].map(|sampler| sampler.wrap));
        let warnings = report.finish().expect("no errors");
        let messages: Vec<&str> = warnings.iter().map(|w| w.message.as_str()).collect();
        assert_eq!(messages.len(), 2, "once for each: {messages:?}");
        assert!(messages[0].contains("`text.png`") && messages[0].contains("not a picture"));
    }

    #[test]
    fn textures_count_before_they_are_decoded() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.png", "b.png"] {
            // A megabyte of pixels in a kilobyte.
            let bytes = encoded([1024, 1024], ColorType::Grayscale, Eight, &[7; 1 << 20]);
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        let span = || Span::START;
        let repeat = sampler(Wrap::Repeat);
        let named = |most: u64, names: &[&str]| {
            let asset_dir = Folder::of(&folder.path().join("scene")).within(Some(most));
            let mut report = DiagnosticSink::binary();
            let mut library = TextureLibrary::new(&asset_dir);
            for name in names {
                library.named(name, repeat, span, &mut report);
            }
            (asset_dir.memory().refusal(), report.finish().is_ok())
        };
        const EACH: u64 = 3 << 20;
        const ROOM: u64 = 2 << 20;
        assert_eq!(named(EACH + ROOM, &["a.png", "a.png"]), (None, true));
        assert_eq!(named(2 * EACH + ROOM, &["a.png", "b.png"]), (None, true));
        let (refused, read) = named(EACH + ROOM, &["a.png", "b.png"]);
        let refused = refused.expect("the second");
        assert!(refused.what.contains("`b.png`"), "{refused:?}");
        assert!(!read && refused.needed >= 2 * EACH && refused.allowed == EACH + ROOM);
        assert!(named(EACH, &["a.png"]).0.is_some());
    }

    #[test]
    fn alpha_is_kept_for_those_who_read_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, color, samples: &[u8]| {
            let bytes = encoded([2, 1], color, Eight, samples);
            std::fs::write(folder.path().join(name), bytes).unwrap();
        };
        file("leaf.png", ColorType::Rgba, &[255, 0, 0, 9, 1, 1, 1, 255]);
        file(
            "whole.png",
            ColorType::Rgba,
            &[1, 2, 3, 255, 90, 90, 90, 255],
        );
        file("white.png", ColorType::Grayscale, &[255, 255]);
        let asset_dir = Folder::of(&folder.path().join("scene"));
        let mut report = DiagnosticSink::binary();
        let span = || Span::START;
        let mut library = TextureLibrary::new(&asset_dir);
        let [repeat, clamp] = [Wrap::Repeat, Wrap::Clamp].map(sampler);
        let mut named = |name, wrap| library.named(name, wrap, span, &mut report);
        let leaves = [named("leaf.png", repeat), named("leaf.png", clamp)];
        let wholes = [named("whole.png", repeat), named("whole.png", clamp)];
        let white = named("white.png", clamp);
        assert_eq!(library.alpha_of(leaves[1]), leaves[1]);
        for none in [wholes[0], white, NO_TEXTURE] {
            assert_eq!(library.alpha_of(none), NO_TEXTURE);
        }
        for _ in 0..2 {
            let mut mask = |row| library.mask_of(row, span, &mut report);
            assert_eq!(mask(leaves[1]), leaves[1]);
            assert_eq!(mask(wholes[1]), wholes[1]);
            assert_eq!(mask(white), NO_TEXTURE);
            assert_eq!(mask(NO_TEXTURE), NO_TEXTURE);
        }
        let textures = library.into_textures();
        let alpha = textures.iter().map(|t| &t.alpha[..]);
        // Grey 90 keeps its value, and (1, 2, 3) is as bright as 2.
        let expected: [&[u8]; 5] = [&[], &[9, 255], &[], &[2, 90], &[]];
        assert!(alpha.eq(expected), "{textures:?}");
    }

    #[test]
    fn alpha_counts_before_it_is_made() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, color, sample: &[u8]| {
            let bytes = encoded([1024, 1024], color, Eight, &sample.repeat(1 << 20));
            std::fs::write(folder.path().join(name), bytes).unwrap();
        };
        file("half.png", ColorType::GrayscaleAlpha, &[7, 128]);
        file("grey.png", ColorType::Grayscale, &[7]);
        let refused = |most: u64, name: &str| {
            let asset_dir = Folder::of(&folder.path().join("scene")).within(Some(most));
            let mut report = DiagnosticSink::binary();
            let mut library = TextureLibrary::new(&asset_dir);
            let row = library.named(name, sampler(Wrap::Repeat), || Span::START, &mut report);
            library.mask_of(row, || Span::START, &mut report);
            assert_eq!(
                report.finish().is_err(),
                asset_dir.memory().refusal().is_some()
            );
            asset_dir.memory().refusal().map(|refusal| refusal.what)
        };
        const MEGABYTE: u64 = 1 << 20;
        let what = refused(4 * MEGABYTE, "half.png").expect("no room for its alpha and tables");
        assert!(what.contains("to decode"), "{what}");
        assert_eq!(refused(6 * MEGABYTE, "half.png"), None);
        assert_eq!(refused(5 * MEGABYTE, "grey.png"), None);
        // Tables and the file are lent only, so that a mask fits where they were.
        assert_eq!(refused(4 * MEGABYTE + 8192, "grey.png"), None);
    }

    #[test]
    fn all_textures_together_are_bounded() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, width: u32| {
            let samples = vec![7; width as usize];
            let bytes = encoded([width, 1], ColorType::Grayscale, Eight, &samples);
            std::fs::write(folder.path().join(name), bytes).unwrap();
        };
        file("two.png", 2);
        file("three.png", 3);
        let asset_dir = Folder::of(&folder.path().join("scene"));
        let mut report = DiagnosticSink::binary();
        let span = || Span::START;
        let mut library = TextureLibrary::new(&asset_dir);
        library.texels_left = 4;
        let mut named = |name, wrap| library.named(name, wrap, span, &mut report);
        let [repeat, clamp, mirror] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror].map(sampler);
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
