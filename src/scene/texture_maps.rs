//! Textures that vary a material over its surface, beside those of its colour and opacity.

use super::Column;
use std::ops::Range;

/// Parameter of the surface that a map varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum MapTarget {
    /// Factor of Ke, in sRGB.
    Emission,
    /// Factor of Ks, in sRGB.
    Specular,
    /// Factor of the Blinn exponent: one channel, linear.
    Shininess,
    /// Factor of [`MetallicRoughness::metallic`](crate::MetallicRoughness): one channel, linear.
    Metallic,
    /// Factor of [`MetallicRoughness::roughness`](crate::MetallicRoughness): one channel, linear.
    Roughness,
    /// The shading normal: 2·rgb − 1 along tangent, bitangent and normal, the bitangent pointing to
    /// the upper edge of the picture (glTF 2.0, 3.9.3).
    Normal,
}

impl MapTarget {
    /// Number of targets.
    pub const COUNT: usize = MapTarget::ALL.len();
    const ALL: [MapTarget; 6] = [
        MapTarget::Emission,
        MapTarget::Specular,
        MapTarget::Shininess,
        MapTarget::Metallic,
        MapTarget::Roughness,
        MapTarget::Normal,
    ];
}

/// One row of [`TextureMaps`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureMap {
    /// The varied parameter.
    pub target: MapTarget,
    /// Index of the texture.
    pub texture: u32,
    /// Channel of a target that has one: 0, 1 or 2 for red, green or blue.
    pub channel: u32,
    /// Layer of the texture coordinates: see [`Triangles::uvs`](crate::Triangles::uvs).
    pub uv_layer: u32,
    /// Factor of a normal's components along the surface; finite.
    pub scale: f32,
}

/// Maps of all materials, those of one material one after another: see
/// [`Materials::maps`](crate::Materials::maps).
#[derive(Clone, Debug, Default)]
pub struct TextureMaps {
    /// [`TextureMap::target`] as a number.
    pub target: Column<u32>,
    /// Index of the texture.
    pub texture: Column<u32>,
    /// Channel of the texture.
    pub channel: Column<u32>,
    /// Layer of the texture coordinates.
    pub uv_layer: Column<u32>,
    /// Factor of a normal's components along the surface.
    pub scale: Column<f32>,
}

impl TextureMaps {
    /// Number of maps.
    #[inline]
    pub fn len(&self) -> usize {
        self.target.len()
    }

    /// Returns true if no material has a map.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.target.is_empty()
    }

    /// Appends the maps of a material, and returns the first row and their number, for
    /// [`Material::maps`](crate::Material::maps).
    pub fn push_all(&mut self, maps: &[TextureMap]) -> [u32; 2] {
        if maps.is_empty() {
            return [0; 2];
        }
        let first = self.len() as u32;
        for map in maps {
            self.target.push(map.target as u32);
            self.texture.push(map.texture);
            self.channel.push(map.channel);
            self.uv_layer.push(map.uv_layer);
            self.scale.push(map.scale);
        }
        [first, maps.len() as u32]
    }

    /// The row `k`.
    pub fn get(&self, k: usize) -> TextureMap {
        TextureMap {
            target: MapTarget::ALL[self.target[k] as usize],
            texture: self.texture[k],
            channel: self.channel[k],
            uv_layer: self.uv_layer[k],
            scale: self.scale[k],
        }
    }

    /// The maps of a material, by its [`Material::maps`](crate::Material::maps).
    pub fn range(&self, [first, count]: [u32; 2]) -> impl Iterator<Item = TextureMap> {
        let rows: Range<usize> = first as usize..(first + count) as usize;
        rows.map(|k| self.get(k))
    }
}
