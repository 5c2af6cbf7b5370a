//! Pictures that a scene file names or embeds. Each is decoded once, and a missing one is a
//! warning.
//!
//! | file | holds |
//! |---|---|
//! | `mod` | the textures of a scene, each by its picture and sampler |
//! | `roles` | a texture for its alpha, as a mask, and as a normal map |
//! | `relief` | heights to normals |
//! | `picture` | bytes of a picture to texels |

mod picture;
mod relief;
mod roles;

use crate::diagnostics::{DiagnosticSink, Span, quoted_file};
use crate::folder::{Folder, Found};
use phalanx_scene::{NO_TEXTURE, Texture, Wrap};
use picture::EncodedImage;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// The textures of a scene while it is read.
pub(crate) struct TextureLibrary<'a> {
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
pub(crate) struct TextureSampler {
    pub(crate) wrap: [Wrap; 2],
    pub(crate) nearest: bool,
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
pub(crate) enum Embedded {
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
    pub(crate) fn new(asset_dir: &'a Folder) -> Self {
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
    pub(crate) fn named(
        &mut self,
        name: &str,
        sampler: TextureSampler,
        span: impl FnOnce() -> Span,
        report: &mut DiagnosticSink,
    ) -> u32 {
        let file = self.asset_dir.find(name);
        self.of_file(name, file, sampler, span, report)
    }

    /// The texture in a file that was looked for already. Otherwise as [`TextureLibrary::named`].
    pub(crate) fn of_file(
        &mut self,
        name: &str,
        file: Result<Found, String>,
        sampler: TextureSampler,
        span: impl FnOnce() -> Span,
        report: &mut DiagnosticSink,
    ) -> u32 {
        let origin = match &file {
            Ok(file) => ImageKey::File(file.clone()),
            Err(_) => ImageKey::Missing(name.to_owned()),
        };
        let asset_dir = self.asset_dir;
        let bytes = || asset_dir.read(&file?).map(Cow::Owned);
        self.picture(origin, &quoted_file(name), bytes, sampler, span, report)
    }

    /// The texture that is embedded in the scene file, in `bytes`, which are requested once.
    /// Otherwise as [`TextureLibrary::named`].
    pub(crate) fn embedded<'b>(
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

    /// All textures, for [`phalanx_scene::Scene::textures`].
    pub(crate) fn into_textures(mut self) -> Vec<Texture> {
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
                self.pictures.insert(origin, row_or_none(&first));
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
        self.sampled.insert((first, sampler), row_or_none(&row));
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
fn row_or_none(row: &Result<u32, String>) -> u32 {
    *row.as_ref().unwrap_or(&NO_TEXTURE)
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
mod tests;
