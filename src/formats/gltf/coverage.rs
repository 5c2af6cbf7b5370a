//! The share of a surface that is there: the alpha of colours, textures and vertices, and its mode.

use super::document::GltfMaterial;
use phalanx_scene::NO_TEXTURE;

/// Meaning of a material's alpha.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum AlphaMode {
    /// All of the surface is there, whatever its alpha.
    Opaque,
    /// The surface is there where its alpha reaches a cutoff.
    Mask,
    /// Alpha is the share that is there.
    Blend,
}

/// The mode of a material. Modes that do not exist are that of a material without one.
pub(super) fn mode_of(material: &GltfMaterial) -> AlphaMode {
    match material.alpha_mode.as_deref() {
        Some("MASK") => AlphaMode::Mask,
        Some("BLEND") => AlphaMode::Blend,
        _ => AlphaMode::Opaque,
    }
}

/// Sources of alpha, which are multiplied.
#[derive(Clone, Copy)]
pub(super) struct Alphas {
    pub(super) factor: f32,
    /// The texture with an alpha, or [`NO_TEXTURE`].
    pub(super) texture: u32,
    /// True if vertices have one.
    pub(super) in_vertices: bool,
}

/// Columns of [`phalanx_scene::Materials`] about coverage.
pub(super) struct Cover {
    pub(super) opacity: f32,
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

    /// The coverage of a material with these alphas. A mask of one alpha is decided here, since
    /// surfaces that are whole cost less.
    pub(super) fn of(material: &GltfMaterial, alphas: Alphas) -> Cover {
        let varied = Cover {
            opacity: alphas.factor,
            texture: alphas.texture,
            cutoff: 0.0,
            vertices: alphas.in_vertices,
        };
        let cutoff = material.alpha_cutoff.unwrap_or(HALF) as f32;
        match mode_of(material) {
            AlphaMode::Opaque => Cover::even(1.0),
            AlphaMode::Blend => varied,
            AlphaMode::Mask if cutoff <= 0.0 => Cover::even(1.0),
            // No alpha reaches a cutoff that not even the factor does.
            AlphaMode::Mask if alphas.factor < cutoff => Cover::even(0.0),
            AlphaMode::Mask if alphas.texture == NO_TEXTURE && !alphas.in_vertices => {
                Cover::even(1.0)
            }
            AlphaMode::Mask => Cover { cutoff, ..varied },
        }
    }
}
