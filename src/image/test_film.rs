//! A film for tests of formats that store radiance unchanged, and a file for one.

use super::{Depth, Exposure, ImageFormat, PictureFile, PictureHeader, ToneCurve};
use phalanx_scene::OutputEncoding;
use phalanx_scene::film::{Aovs, Film};

/// A small OpenEXR file without layers, origin and header.
pub(super) const PLAIN_EXR: PictureFile = PictureFile {
    width: 2,
    height: 2,
    crop: None,
    format: ImageFormat::Exr,
    aovs: Aovs::NONE,
    origin: [0.0; 3],
    exposure: Exposure {
        stops: 0.0,
        curve: ToneCurve::Linear,
        encoding: OutputEncoding::LINEAR,
    },
    depth: Depth::Standard,
    header: PictureHeader::NONE,
};

/// Wider and higher than a tile, with sides that are not round numbers. Radiance is small and
/// large, negative, and NaN.
pub(super) fn film() -> Film {
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
        aovs: Default::default(),
        aov_planes: Vec::new(),
        hits: None,
    };
    film.planes[0][5] = f32::INFINITY;
    film.planes[1][6] = f32::NAN;
    film
}

pub(super) fn bits(film: &Film, x: u32, y: u32) -> [u32; 3] {
    film.pixel(x, y).map(f32::to_bits)
}
