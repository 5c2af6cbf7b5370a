//! Metallic-roughness materials of glTF and MTL, converted to the document's: the table is that of
//! glTF's module.

use glam::Vec3;
use phalanx_scene::{LobeWeights, Material, MetallicRoughness};

/// Ambient share of the diffuse colour, as of every mesh.
pub(super) const AMBIENT: f32 = 0.1;
/// Reflectance of glass, paint and plastic seen straight on.
pub(super) const DIELECTRIC: f32 = 0.04;

/// A surface that reflects in part like a metal.
#[derive(Clone, Copy)]
pub(super) struct PbrSurface {
    /// Base colour.
    pub(super) color: Vec3,
    pub(super) lobes: MetallicRoughness,
    /// Reflectance of the non-metal part, straight on.
    pub(super) specular: Vec3,
    /// Share that is transmitted.
    pub(super) through: f32,
}

impl PbrSurface {
    fn weights(&self) -> LobeWeights<1> {
        LobeWeights::of([self.lobes.metallic], [self.lobes.roughness])
    }

    /// Returns true if the base colour is a factor of Ks.
    pub(super) fn has_colored_mirror(&self) -> bool {
        self.weights().metal != [0.0]
    }

    /// A material of this surface: its Ka, Kd, Ks, highlight and exponent. If it is `varied`,
    /// metallic and roughness are left to the hits.
    pub(super) fn to_material(self, varied: bool) -> Material {
        let weights = self.weights();
        let ([metal], [dielectric]) = (weights.metal, weights.dielectric);
        let (kd, ks) = if varied {
            (self.color * (1.0 - self.through), self.specular)
        } else {
            (
                self.color * ((1.0 - metal) * (1.0 - self.through)),
                self.specular * dielectric + self.color * metal,
            )
        };
        Material {
            ka: kd * AMBIENT,
            kd,
            ks,
            highlight: self.specular * weights.highlight[0],
            shininess: weights.shininess[0],
            metallic_roughness: varied.then_some(self.lobes),
            ..Material::DEFAULT
        }
    }
}
