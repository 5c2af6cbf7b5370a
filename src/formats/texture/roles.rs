//! The roles of a texture beside its colours: alpha, mask and normal map.

use super::TextureLibrary;
use super::relief::{is_normal_map, normals_of_heights};
use crate::diagnostics::{DiagnosticSink, Span};
use phalanx_scene::{NO_TEXTURE, Texture};

impl TextureLibrary<'_> {
    /// The same texture for its alpha: an index for [`phalanx_scene::Material::opacity_texture`].
    /// It is [`NO_TEXTURE`] for a missing texture and for one whose texels are all opaque.
    pub(crate) fn alpha_of(&mut self, texture: u32) -> u32 {
        let stored = self.textures.get(texture as usize);
        if stored.is_none_or(|texture| texture.alpha.is_empty()) {
            return NO_TEXTURE;
        }
        self.read_for_alpha.insert(texture);
        texture
    }

    /// The same texture as a mask: a picture without alpha has its luminance as alpha, of the bytes
    /// as they are stored. Otherwise as [`TextureLibrary::alpha_of`], with an error at `span` if
    /// there is no memory for it.
    pub(crate) fn mask_of(
        &mut self,
        texture: u32,
        span: impl FnOnce() -> Span,
        report: &mut DiagnosticSink,
    ) -> u32 {
        if let Some(&row) = self.masks.get(&texture) {
            return row;
        }
        if let Some(stored) = self.textures.get_mut(texture as usize)
            && stored.alpha.is_empty()
        {
            let bytes = stored.texels.len() as u64;
            let memory = self.asset_dir.memory();
            match memory.take(bytes, "for the texture of an opacity") {
                Ok(()) => stored.alpha = luminance(&stored.texels).into(),
                Err(reason) => report.error(span(), reason),
            }
        }
        let row = self.alpha_of(texture);
        self.masks.insert(texture, row);
        row
    }

    /// The same texture as a normal map: a picture that is none already is taken as heights. An
    /// error at `span` if there is no memory for it.
    pub(crate) fn normals_of(
        &mut self,
        texture: u32,
        span: impl FnOnce() -> Span,
        report: &mut DiagnosticSink,
    ) -> u32 {
        let Some(stored) = self.textures.get(texture as usize) else {
            return NO_TEXTURE;
        };
        if let Some(&row) = self.normals.get(&texture) {
            return row;
        }
        let row = if is_normal_map(stored) {
            texture
        } else {
            let bytes = 3 * stored.texels.len() as u64;
            let memory = self.asset_dir.memory();
            if let Err(reason) = memory.take(bytes, "for the normals of a relief") {
                report.error(span(), reason);
                return NO_TEXTURE;
            }
            let normals = Texture {
                texels: normals_of_heights(stored).into(),
                alpha: Default::default(),
                ..*stored
            };
            self.push(normals)
        };
        self.normals.insert(texture, row);
        row
    }
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
