//! The material of eight hits: its row, or what textures and vertex colours make of it.

use super::texture::{map_value, tint};
use super::wide;
use crate::wavefront::HitGroups;
use glam::Vec3;
use phalanx_scene::{LobeWeights, METALLIC_ROUGHNESS, MapTarget, Scene};
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::{F32x8, LaneMask, Lanes, Mask8, Vec3x8};

/// The material of eight hits.
#[derive(Clone, Copy, Debug)]
pub struct ShadeMaterial {
    /// Ka + Ke, light that does not come from lamps.
    pub own: Vec3x8,
    /// Diffuse colour.
    pub kd: Vec3x8,
    /// Specular colour.
    pub ks: Vec3x8,
    /// Transmission colour.
    pub kt: Vec3,
    /// Blinn exponent.
    pub shininess: F32x8,
    /// Index of refraction.
    pub ior: f32,
    /// Lanes in which Ks is not zero.
    pub shines: Mask8,
}

impl ShadeMaterial {
    /// A row of the columns, the same for all hits.
    #[inline(always)]
    pub fn of(scene: &Scene, index: u32) -> ShadeMaterial {
        Varied::row(scene, index).into_material(scene, index)
    }

    /// A row of the columns as textures and vertex colours vary it at eight hits on triangles.
    pub fn at(scene: &Scene, index: u32, hits: &HitPacket) -> ShadeMaterial {
        let mut varied = Varied::row(scene, index);
        varied.apply_textures(scene, index, hits);
        varied.into_material(scene, index)
    }

    /// Divisor that turns Ks and Kt into shares: Ks + Kt, but no less than 1. A share is the part
    /// of its camera ray that a bounce carries. After this division, the weights of all rays from a
    /// hit add up to 1 at most, and so do the shares of a camera ray's bounces at every depth,
    /// regardless of the materials. So no more than 1/w of them in each component are w or more.
    pub fn secondary_weight(&self) -> Vec3x8 {
        let both = self.ks.abs() + wide(self.kt.abs());
        Vec3x8::new(
            both.x.max(F32x8::ONE),
            both.y.max(F32x8::ONE),
            both.z.max(F32x8::ONE),
        )
    }
}

/// Lanes in which a vector is not zero.
pub(super) fn is_not_zero(v: Vec3x8) -> Mask8 {
    let zero = F32x8::ZERO;
    !(v.x.eq(zero) & v.y.eq(zero) & v.z.eq(zero))
}

/// Parameters that may vary over a surface.
struct Varied {
    ambient: Vec3x8,
    ke: Vec3x8,
    kd: Vec3x8,
    ks: Vec3x8,
    shininess: F32x8,
    metallic: F32x8,
    roughness: F32x8,
}

impl Varied {
    #[inline(always)]
    fn row(scene: &Scene, index: u32) -> Varied {
        let (m, i) = (&scene.materials, index as usize);
        Varied {
            ambient: wide(m.ka.get(i)),
            ke: wide(m.ke.get(i)),
            kd: wide(m.kd.get(i)),
            ks: wide(m.ks.get(i)),
            shininess: F32x8::splat(m.shininess[i]),
            metallic: F32x8::splat(m.metallic[i]),
            roughness: F32x8::splat(m.roughness[i]),
        }
    }

    fn apply_textures(&mut self, scene: &Scene, index: u32, hits: &HitPacket) {
        let tint = tint(scene, index, hits);
        self.ambient = self.ambient.mul_elementwise(tint);
        self.kd = self.kd.mul_elementwise(tint);
        for map in scene.maps.of(scene.materials.maps[index as usize]) {
            if map.target == MapTarget::Normal {
                continue;
            }
            let Some((given, value)) = map_value(scene, &map, hits) else {
                continue;
            };
            let colored = |c: Vec3x8| Vec3x8::select(given, c.mul_elementwise(value), c);
            let channel = [value.x, value.y, value.z][map.channel as usize];
            let scaled = |c: F32x8| given.select(c * channel, c);
            match map.target {
                MapTarget::Emission => self.ke = colored(self.ke),
                MapTarget::Specular => self.ks = colored(self.ks),
                MapTarget::Shininess => self.shininess = scaled(self.shininess),
                MapTarget::Metallic => self.metallic = scaled(self.metallic),
                MapTarget::Roughness => self.roughness = scaled(self.roughness),
                MapTarget::Normal => {}
            }
        }
    }

    /// Converts metallic and roughness, where the material has them.
    #[inline(always)]
    fn into_material(mut self, scene: &Scene, index: u32) -> ShadeMaterial {
        let (m, i) = (&scene.materials, index as usize);
        if m.flags[i] & METALLIC_ROUGHNESS != 0 {
            let lobes = LobeWeights::of(self.metallic.to_array(), self.roughness.to_array());
            let [metal, dielectric] = [lobes.metal, lobes.dielectric].map(F32x8::new);
            self.ks = self.ks.scale(dielectric) + self.kd.scale(metal);
            self.ambient = self.ambient.scale(F32x8::ONE - metal);
            self.kd = self.kd.scale(F32x8::ONE - metal);
            self.shininess = F32x8::new(lobes.shininess);
        }
        ShadeMaterial {
            own: self.ambient + self.ke,
            kd: self.kd,
            ks: self.ks,
            kt: m.kt.get(i),
            shininess: self.shininess,
            ior: m.ior[i],
            shines: is_not_zero(self.ks),
        }
    }
}

/// The materials of one surface after another; a row is read only when it changes.
pub(crate) struct CurrentMaterial<'g> {
    scene: &'g Scene,
    groups: &'g HitGroups<'g>,
    current: Option<(u32, ShadeMaterial)>,
}

impl<'g> CurrentMaterial<'g> {
    /// Materials of the surfaces of a wave.
    pub(crate) fn new(scene: &'g Scene, groups: &'g HitGroups<'g>) -> CurrentMaterial<'g> {
        CurrentMaterial {
            scene,
            groups,
            current: None,
        }
    }

    /// The material of the surface `k`.
    #[inline(always)]
    pub(crate) fn of(&mut self, k: usize) -> &ShadeMaterial {
        if let Some(material) = self.groups.materials.get(k) {
            return material;
        }
        let index = self.groups.surfaces[k].material;
        if self.current.is_none_or(|(current, _)| current != index) {
            self.current = None;
        }
        let read = || (index, ShadeMaterial::of(self.scene, index));
        &self.current.get_or_insert_with(read).1
    }
}
