//! The share of a surface that is there: the alpha of colours, textures and vertices, and its mode.

use super::document::GltfMaterial;
use phalanx_scene::NO_TEXTURE;

/// Columns of [`phalanx_scene::Materials`] about coverage.
pub(super) struct Cover {
    pub(super) opacity: f32,
    /// The texture with an alpha, or [`NO_TEXTURE`].
    pub(super) texture: u32,
    pub(super) cutoff: f32,
    /// True if the alpha of vertices counts.
    pub(super) vertices: bool,
}

/// Cutoff of a mask that names none.
const HALF: f64 = 0.5;

impl Cover {
    /// The same coverage everywhere.
    const fn even(opacity: f32) -> Cover {
        Cover {
            opacity,
            texture: NO_TEXTURE,
            cutoff: 0.0,
            vertices: false,
        }
    }

    /// The coverage of a material with a factor, which multiplies the alphas of a texture and of
    /// vertices. A mode that does not exist is that of a material without one: all of the surface
    /// is there. A mask of one alpha is decided here, since opaque surfaces are cheaper.
    pub(super) fn of(
        material: &GltfMaterial,
        factor: f32,
        texture: impl FnOnce() -> u32,
        vertices: bool,
    ) -> Cover {
        let mask = match material.alpha_mode.as_deref() {
            Some("MASK") => true,
            Some("BLEND") => false,
            _ => return Cover::even(1.0),
        };
        let varied = Cover {
            opacity: factor,
            texture: texture(),
            cutoff: 0.0,
            vertices,
        };
        let cutoff = material.alpha_cutoff.unwrap_or(HALF) as f32;
        if !mask {
            varied
        } else if cutoff <= 0.0 {
            Cover::even(1.0)
        } else if factor < cutoff {
            // No alpha reaches a cutoff that not even the factor does.
            Cover::even(0.0)
        } else if varied.texture == NO_TEXTURE && !vertices {
            Cover::even(1.0)
        } else {
            Cover { cutoff, ..varied }
        }
    }
}
