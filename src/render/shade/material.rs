//! The material of eight hits: its row, or what textures and vertex colours make of it.

use super::texture::{map_value, tint};
use super::wide;
use glam::Vec3;
use phalanx_scene::{
    LobeWeights, METALLIC_ROUGHNESS, MapTarget, MetallicRoughness, PrimKind, Scene,
};
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::{F32x8, LaneMask, Lanes, Mask8, Vec3x8};

/// The material of eight hits.
#[derive(Clone, Copy, Debug)]
pub struct ShadeMaterial<'m> {
    /// Its row of the columns.
    pub row: &'m MaterialRow,
    /// Values in place of the row's, where textures or vertex colours vary them.
    pub varied: Option<&'m VariedMaterial>,
}

/// One row of the material columns.
#[derive(Clone, Copy, Debug)]
pub struct MaterialRow {
    own: Vec3,
    kd: Vec3,
    ks: Vec3,
    /// [`Material::highlight`](phalanx_scene::Material::highlight) times (s + 2)/8.
    highlight: Vec3,
    kt: Vec3,
    shininess: f32,
    ior: f32,
}

/// Parameters of a material as textures and vertex colours vary them at eight hits.
#[derive(Clone, Copy, Debug)]
pub struct VariedMaterial {
    own: Vec3x8,
    kd: Vec3x8,
    ks: Vec3x8,
    highlight: Vec3x8,
    shininess: F32x8,
}

impl ShadeMaterial<'_> {
    /// Ka + Ke, light that does not come from lamps.
    #[inline(always)]
    pub fn own(&self) -> Vec3x8 {
        self.varied.map_or_else(|| wide(self.row.own), |v| v.own)
    }

    /// Diffuse colour.
    #[inline(always)]
    pub fn kd(&self) -> Vec3x8 {
        self.varied.map_or_else(|| wide(self.row.kd), |v| v.kd)
    }

    /// Specular colour.
    #[inline(always)]
    pub fn ks(&self) -> Vec3x8 {
        self.varied.map_or_else(|| wide(self.row.ks), |v| v.ks)
    }

    /// Blinn exponent.
    #[inline(always)]
    pub fn shininess(&self) -> F32x8 {
        let even = || F32x8::splat(self.row.shininess);
        self.varied.map_or_else(even, |v| v.shininess)
    }

    /// Weight of the highlight without a mirror, and the lanes that have one; `None` if none has.
    #[inline(always)]
    pub fn highlight(&self) -> Option<(Vec3x8, Mask8)> {
        let highlight = match self.varied {
            Some(varied) => varied.highlight,
            None if self.row.highlight == Vec3::ZERO => return None,
            None => wide(self.row.highlight),
        };
        let lanes = is_not_zero(highlight);
        lanes.any().then_some((highlight, lanes))
    }

    /// Lanes in which Ks is not zero.
    #[inline(always)]
    pub fn shines(&self) -> Mask8 {
        match self.varied {
            Some(varied) => is_not_zero(varied.ks),
            None if self.row.ks == Vec3::ZERO => Mask8::none(),
            None => !Mask8::none(),
        }
    }

    /// Transmission colour.
    #[inline(always)]
    pub fn kt(&self) -> Vec3 {
        self.row.kt
    }

    /// Index of refraction.
    #[inline(always)]
    pub fn ior(&self) -> f32 {
        self.row.ior
    }

    /// Divisor that turns Ks and Kt into shares: Ks + Kt, but no less than 1. A share is the part
    /// of its camera ray that a bounce carries. After this division, the weights of all rays from a
    /// hit add up to 1 at most, and so do the shares of a camera ray's bounces at every depth,
    /// regardless of the materials. So no more than 1/w of them in each component are w or more.
    pub fn secondary_weight(&self) -> Vec3x8 {
        let both = self.ks().abs() + wide(self.kt().abs());
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

impl MaterialRow {
    /// Reads one row of the columns.
    #[inline(always)]
    pub fn of(scene: &Scene, index: u32) -> MaterialRow {
        let (m, i) = (&scene.materials, index as usize);
        let row = MaterialRow {
            own: m.ka.get(i) + m.ke.get(i),
            kd: m.kd.get(i),
            ks: m.ks.get(i),
            highlight: m.highlight.get(i) * ((m.shininess[i] + 2.0) * 0.125),
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
        let ([metal], [shininess]) = (lobes.metal, lobes.shininess);
        MaterialRow {
            own: ka * (1.0 - metal) + ke,
            kd: self.kd * (1.0 - metal),
            ks: self.ks * lobes.dielectric[0] + self.kd * metal,
            highlight: (self.ks * lobes.highlight[0]) * ((shininess + 2.0) * 0.125),
            shininess,
            ..self
        }
    }
}

impl VariedMaterial {
    /// The material of eight hits on primitives of one kind. Only that of triangles varies.
    pub fn of(scene: &Scene, index: u32, hits: &HitPacket) -> VariedMaterial {
        let first = scene.resolve(hits.prim_id.lane(0)).prim;
        match scene.prims[first as usize].kind() {
            PrimKind::Triangle => VariedMaterial::on_triangles(scene, index, hits),
            _ => VariedMaterial::even(scene, index),
        }
    }

    fn on_triangles(scene: &Scene, index: u32, hits: &HitPacket) -> VariedMaterial {
        let (m, i) = (&scene.materials, index as usize);
        let tint = tint(scene, index, hits);
        let mut ambient = wide(m.ka.get(i)).mul_elementwise(tint);
        let mut kd = wide(m.kd.get(i)).mul_elementwise(tint);
        let [mut ke, mut ks, mut highlight] =
            [&m.ke, &m.ks, &m.highlight].map(|column| wide(column.get(i)));
        let [mut shininess, mut metallic, mut roughness] =
            [&m.shininess, &m.metallic, &m.roughness].map(|column| F32x8::splat(column[i]));
        for map in scene.maps.range(m.maps[i]) {
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
                MapTarget::Specular => (ks, highlight) = (colored(ks), colored(highlight)),
                MapTarget::Shininess => shininess = scaled(shininess),
                MapTarget::Metallic => metallic = scaled(metallic),
                MapTarget::Roughness => roughness = scaled(roughness),
                MapTarget::Normal => {}
            }
        }
        if m.flags[i] & METALLIC_ROUGHNESS != 0 {
            let lobes = LobeWeights::of(metallic.to_array(), roughness.to_array());
            let [metal, dielectric] = [lobes.metal, lobes.dielectric].map(F32x8::new);
            highlight = ks.scale(F32x8::new(lobes.highlight));
            ks = ks.scale(dielectric) + kd.scale(metal);
            ambient = ambient.scale(F32x8::ONE - metal);
            kd = kd.scale(F32x8::ONE - metal);
            shininess = F32x8::new(lobes.shininess);
        }
        let height = (shininess + F32x8::splat(2.0)) * F32x8::splat(0.125);
        VariedMaterial {
            own: ambient + ke,
            kd,
            ks,
            highlight: highlight.scale(height),
            shininess,
        }
    }

    fn even(scene: &Scene, index: u32) -> VariedMaterial {
        let row = MaterialRow::of(scene, index);
        VariedMaterial {
            own: wide(row.own),
            kd: wide(row.kd),
            ks: wide(row.ks),
            highlight: wide(row.highlight),
            shininess: F32x8::splat(row.shininess),
        }
    }
}
