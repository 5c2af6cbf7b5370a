//! Description of a picture file, and the films from which it is written.

use super::encoder::Exposure;
use super::format::ImageFormat;
use super::header::PictureHeader;
use phalanx_scene::film::{Aovs, Film};
use std::io;

/// The height of every band but the last is a multiple of this, because it is a multiple of the
/// rows of a JPEG's blocks and of an OpenEXR file's tiles.
pub const BAND_ROWS: u32 = 64;

/// Bits of the samples of PNG, and of the colours of OpenEXR.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// PNG: integers of 8 bits. OpenEXR: floats of 32 bits.
    #[default]
    Standard,
    /// PNG: integers of 16 bits. OpenEXR: half floats for radiance and [layers of colour], floats
    /// of 32 bits for all others.
    ///
    /// [layers of colour]: phalanx_scene::film::Aov::is_color
    Sixteen,
}

/// Place of a picture that is a part of a larger one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Column and row of its upper left pixel in the whole picture.
    pub corner: (u32, u32),
    /// Width and height of the whole picture.
    pub of: (u32, u32),
}

/// Description of a picture file to be written. JPEG and PNG use the exposure, which linear formats
/// ignore; PNG and OpenEXR use the depth.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureFile {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Place in a larger picture; only OpenEXR can store it.
    pub crop: Option<Crop>,
    /// Kind of file.
    pub format: ImageFormat,
    /// Layers in addition to radiance, which the films must have. OpenEXR stores all of them, PNG
    /// only alpha: see [`ImageFormat::holds`].
    pub aovs: Aovs,
    /// Origin of the scene in its file's coordinates, for the header of a file with positions: see
    /// [`Scene::origin`].
    ///
    /// [`Scene::origin`]: phalanx_scene::Scene::origin
    pub origin: [f64; 3],
    /// Exposure and tone.
    pub exposure: Exposure,
    /// Bits a sample.
    pub depth: Depth,
    /// Texts and numbers about the picture, as far as the format can store them.
    pub header: PictureHeader,
}

/// Radiance from which on sRGB of eight bits is not black.
const VISIBLE: f32 = 0.5 / 255.0 / 12.92;

impl PictureFile {
    /// Radiance as the file shows it: on a screen, the dark is black, and all from 1 on is white.
    pub fn shown(&self) -> impl Fn([f32; 3]) -> [f32; 3] + use<> {
        let (map, is_linear) = (self.exposure.mapping(), self.format.is_linear());
        let on_screen = |shown: f32| if shown < VISIBLE { 0.0 } else { shown.min(1.0) };
        move |radiance| if is_linear { radiance } else { map(radiance).map(on_screen) }
    }

    /// The colour that all pixels of a film show, if it is the same.
    pub fn even_color(&self, film: &Film) -> Option<[f32; 3]> {
        let ([red, green, blue], shown) = (film.planes.each_ref(), self.shown());
        let pixels = red.iter().zip(green).zip(blue);
        let mut colors = pixels.map(|((&r, &g), &b)| shown([r, g, b]));
        let color = colors.next().unwrap_or_default();
        colors.all(|c| c == color).then_some(color)
    }
}

/// Films in the form for writers.
pub(super) type Films<'a> = &'a mut dyn Iterator<Item = io::Result<Film>>;
