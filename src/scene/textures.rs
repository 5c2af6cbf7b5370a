//! Textures, and their colour at a position.

use super::Column;
use crate::sampling::{linear_of_srgb, share_of_byte};
use glam::Vec3;

/// Value of [`super::Materials::texture`] for no texture.
pub const NO_TEXTURE: u32 = u32::MAX;

/// Maximum width and height of a texture, in texels.
pub const MAX_TEXTURE_SIDE: u32 = 16_384;

/// Continuation of a texture beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// Repetition of the texture.
    #[default]
    Repeat,
    /// Repetition of its outermost texels.
    Clamp,
    /// Repetition of the texture, with every other one mirrored.
    Mirror,
}

/// A picture in bytes, decoded when it is sampled: from sRGB, if it is a colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Texels in a row, 1 to [`MAX_TEXTURE_SIDE`].
    pub width: u32,
    /// Rows, 1 to [`MAX_TEXTURE_SIDE`].
    pub height: u32,
    /// Continuation beyond the left and right edges, and beyond the upper and lower ones.
    pub wrap: [Wrap; 2],
    /// True to show each texel as a square of one colour, not blended with its neighbours.
    pub nearest: bool,
    /// `width` × `height` texels, the uppermost row first.
    pub texels: Column<[u8; 3]>,
    /// Opacity of each texel, in 255ths; empty if all are opaque.
    pub alpha: Column<u8>,
}

impl Texture {
    /// Colour at a position, decoded from sRGB first: bilinear between the centres of texels, or
    /// that of the nearest. (0, 0) is the upper left corner, (1, 1) the lower right one.
    pub fn color_at(&self, u: f32, v: f32) -> Vec3 {
        self.decoded_at(u, v, linear_of_srgb())
    }

    /// Value at a position of a picture that is data: shares of 255, bilinear between the centres
    /// of texels.
    pub fn value_at(&self, u: f32, v: f32) -> Vec3 {
        self.decoded_at(u, v, share_of_byte())
    }

    fn decoded_at(&self, u: f32, v: f32, value: &[f32; 256]) -> Vec3 {
        let texel = |k: usize| Vec3::from_array(self.texels[k].map(|c| value[usize::from(c)]));
        self.between(u, v, texel, |a, b, t| a + (b - a) * t)
    }

    /// Opacity at a position, 0 to 1: bilinear between the centres of texels.
    pub fn alpha_at(&self, u: f32, v: f32) -> f32 {
        if self.alpha.is_empty() {
            return 1.0;
        }
        let texel = |k: usize| f32::from(self.alpha[k]) / 255.0;
        self.between(u, v, texel, |a, b, t| a + (b - a) * t)
    }

    /// Interpolates between the four texels around a position: along the rows, then between them.
    fn between<T>(
        &self,
        u: f32,
        v: f32,
        texel: impl Fn(usize) -> T,
        mix: impl Fn(T, T, f32) -> T,
    ) -> T {
        let (left, right, tx) = texel_pair(u, self.wrap[0], self.width);
        let (above, below, ty) = texel_pair(v, self.wrap[1], self.height);
        let texel_at =
            |column: u32, row: u32| texel(row as usize * self.width as usize + column as usize);
        if self.nearest {
            let column = if tx < 0.5 { left } else { right };
            return texel_at(column, if ty < 0.5 { above } else { below });
        }
        let along = |row: u32| mix(texel_at(left, row), texel_at(right, row), tx);
        mix(along(above), along(below), ty)
    }
}

/// The two texels around a position, and the fraction of the distance from the first to the second.
fn texel_pair(place: f32, wrap: Wrap, size: u32) -> (u32, u32, f32) {
    let folded = match wrap {
        Wrap::Repeat => fraction(place),
        // A NaN counts as 0.
        Wrap::Clamp if place > 0.0 => place.min(1.0),
        Wrap::Clamp => 0.0,
        Wrap::Mirror => {
            let phase = fraction(place * 0.5) * 2.0;
            if phase > 1.0 { 2.0 - phase } else { phase }
        }
    };
    let x = folded * size as f32 + 0.5;
    let k = x.floor() as u32;
    let (before, after) = match wrap {
        Wrap::Repeat => (size - 1, 0),
        Wrap::Clamp | Wrap::Mirror => (0, size - 1),
    };
    let lower = if k == 0 { before } else { k.min(size) - 1 };
    let upper = if k >= size { after } else { k };
    (lower, upper, x - x.floor())
}

/// The fractional part. Numbers from 2²² on count as integers, and so does a NaN.
fn fraction(x: f32) -> f32 {
    if x.abs() < 4_194_304.0 { x - x.floor() } else { 0.0 }
}
