//! Pictures that colour surfaces.

use super::Column;

/// Stands for "no texture" in [`super::Materials::texture`].
pub const NO_TEXTURE: u32 = u32::MAX;

/// Most texels in a row, and most rows.
pub const MAX_TEXTURE_SIDE: u32 = 16_384;

/// What lies beyond the edges of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// Its outermost texels.
    Clamp,
    /// The texture again, every other one mirrored.
    Mirror,
}

/// A picture in sRGB bytes, decoded when it is sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Texels in a row, 1 to [`MAX_TEXTURE_SIDE`].
    pub width: u32,
    /// Rows, 1 to [`MAX_TEXTURE_SIDE`].
    pub height: u32,
    /// Beyond the left and right edges, and beyond the upper and lower ones.
    pub wrap: [Wrap; 2],
    /// `width` × `height` texels in sRGB, the uppermost row first.
    pub texels: Column<[u8; 3]>,
}
