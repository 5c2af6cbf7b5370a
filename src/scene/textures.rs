//! Pictures that colour surfaces.

use super::Column;

/// Stands for "no texture" in [`super::Materials::texture`].
pub const NO_TEXTURE: u32 = u32::MAX;

/// Greatest width and height of a texture, in texels.
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

/// A picture in sRGB bytes, decoded when it is sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Texels in a row, 1 to [`MAX_TEXTURE_SIDE`].
    pub width: u32,
    /// Rows, 1 to [`MAX_TEXTURE_SIDE`].
    pub height: u32,
    /// Continuation beyond the left and right edges, and beyond the upper and lower ones.
    pub wrap: [Wrap; 2],
    /// `width` × `height` texels in sRGB, the uppermost row first.
    pub texels: Column<[u8; 3]>,
    /// Share of each texel that is there, in 255ths: as many as there are texels, or none where all
    /// are whole.
    pub alpha: Column<u8>,
}
