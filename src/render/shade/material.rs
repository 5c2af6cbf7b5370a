//! The material of eight hits: its row, or what textures and vertex colours make of it.

use super::texture::{map_value, tint};
use super::wide;
use crate::wavefront::HitGroups;
use glam::Vec3;
use phalanx_scene::{LobeWeights, METALLIC_ROUGHNESS, MapTarget, MetallicRoughness, Scene};
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
        MaterialRow::of(scene, index).widened()
    }

    /// A row of the columns as textures and vertex colours vary it at eight hits on triangles.
    pub fn at(scene: &Scene, index: u32, hits: &HitPacket) -> ShadeMaterial {
        let (m, i) = (&scene.materials, index as usize);
        let tint = tint(scene, index, hits);
        let mut ambient = wide(m.ka.get(i)).mul_elementwise(tint);
        let mut kd = wide(m.kd.get(i)).mul_elementwise(tint);
        let (mut ke, mut ks) = (wide(m.ke.get(i)), wide(m.ks.get(i)));
        let [mut shininess, mut metallic, mut roughness] =
            [&m.shininess, &m.metallic, &m.roughness].map(|column| F32x8::splat(column[i]));
        for map in scene.maps.of(m.maps[i]) {
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
                MapTarget::Emission => ke = colored(ke),
                MapTarget::Specular => ks = colored(ks),
                MapTarget::Shininess => shininess = scaled(shininess),
                MapTarget::Metallic => metallic = scaled(metallic),
                MapTarget::Roughness => roughness = scaled(roughness),
                MapTarget::Normal => {}
            }
        }
        if m.flags[i] & METALLIC_ROUGHNESS != 0 {
            let lobes = LobeWeights::of(metallic.to_array(), roughness.to_array());
            let [metal, dielectric] = [lobes.metal, lobes.dielectric].map(F32x8::new);
            ks = ks.scale(dielectric) + kd.scale(metal);
            ambient = ambient.scale(F32x8::ONE - metal);
            kd = kd.scale(F32x8::ONE - metal);
            shininess = F32x8::new(lobes.shininess);
        }
        ShadeMaterial {
            own: ambient + ke,
            kd,
            ks,
            kt: m.kt.get(i),
            shininess,
            ior: m.ior[i],
            shines: is_not_zero(ks),
        }
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

/// One row of the material columns.
#[derive(Clone, Copy)]
struct MaterialRow {
    own: Vec3,
    kd: Vec3,
    ks: Vec3,
    kt: Vec3,
    shininess: f32,
    ior: f32,
}

impl MaterialRow {
    #[inline(always)]
    fn of(scene: &Scene, index: u32) -> MaterialRow {
        let (m, i) = (&scene.materials, index as usize);
        let row = MaterialRow {
            own: m.ka.get(i) + m.ke.get(i),
            kd: m.kd.get(i),
            ks: m.ks.get(i),
            kt: m.kt.get(i),
            shininess: m.shininess[i],
            ior: m.ior[i],
        };
        match m.metallic_roughness(i) {
            None => row,
            Some(lobes) => row.converted(m.ka.get(i), m.ke.get(i), lobes),
        }
    }

    /// The row with Kd, Ks and exponent that follow from metallic and roughness.
    #[cold]
    fn converted(self, ka: Vec3, ke: Vec3, lobes: MetallicRoughness) -> MaterialRow {
        let lobes = LobeWeights::of([lobes.metallic], [lobes.roughness]);
        let [metal] = lobes.metal;
        MaterialRow {
            own: ka * (1.0 - metal) + ke,
            kd: self.kd * (1.0 - metal),
            ks: self.ks * lobes.dielectric[0] + self.kd * metal,
            shininess: lobes.shininess[0],
            ..self
        }
    }

    /// The row in every lane. Callers use a few of the fields, and the rest is not made where this
    /// is inlined.
    #[inline(always)]
    fn widened(&self) -> ShadeMaterial {
        ShadeMaterial {
            own: wide(self.own),
            kd: wide(self.kd),
            ks: wide(self.ks),
            kt: self.kt,
            shininess: F32x8::splat(self.shininess),
            ior: self.ior,
            shines: match self.ks == Vec3::ZERO {
                true => Mask8::none(),
                false => !Mask8::none(),
            },
        }
    }
}

/// The materials of one surface after another; a row is read only when it changes.
pub(crate) struct CurrentMaterial<'g> {
    scene: &'g Scene,
    groups: &'g HitGroups<'g>,
    current: Option<(u32, MaterialRow)>,
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
    pub(crate) fn of(&mut self, k: usize) -> ShadeMaterial {
        if let Some(material) = self.groups.materials.get(k) {
            return *material;
        }
        let index = self.groups.surfaces[k].material;
        let row = match self.current {
            Some((current, row)) if current == index => row,
            _ => MaterialRow::of(self.scene, index),
        };
        self.current = Some((index, row));
        row.widened()
    }
}
