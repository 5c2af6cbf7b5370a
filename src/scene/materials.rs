//! Columns of the surface parameters, and a table that gives equal materials one row.

use super::{Column, MetallicRoughness, NO_TEXTURE, Vec3s};
use glam::Vec3;
use std::collections::HashMap;

/// One row of [`Materials`] (design document, "Recursive shading model"): RGB linear and finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Ambient Ka.
    pub ka: Vec3,
    /// Emission Ke.
    pub ke: Vec3,
    /// Diffuse Kd.
    pub kd: Vec3,
    /// Specular Ks, also the weight of the mirror ray.
    pub ks: Vec3,
    /// Reflectance of lamps alone, beside Ks: a highlight that no mirror image goes with. Each lamp
    /// adds highlight · (s + 2)/8 · max(h·n, 0)^s · max(l·n, 0), a lobe that reflects this share of
    /// its light or less at any exponent (Walter et al., "Microfacet Models for Refraction through
    /// Rough Surfaces", 2007: D/4 of Blinn-Phong).
    pub highlight: Vec3,
    /// Transmission Kt, the weight of the refracted ray.
    pub kt: Vec3,
    /// Blinn exponent s, at least 0.
    pub shininess: f32,
    /// Index of refraction, positive.
    pub ior: f32,
    /// Index of the texture that Ka and Kd are multiplied with, or [`NO_TEXTURE`].
    pub texture: u32,
    /// Exponent n of the lobe cosⁿ, about the mirror direction, over which mirror rays are spread;
    /// 0 for a perfect mirror, which reflects all rays in one direction.
    ///
    /// Each ray has weight Ks, regardless of its direction. A ray that the lobe would send through
    /// the surface is reflected back by it.
    pub gloss: f32,
    /// Opacity of the surface, 0 to 1. The rest of rays and light passes straight through: see
    /// [`Scene::coverage`](crate::Scene::coverage).
    pub opacity: f32,
    /// Index of the texture whose alpha the opacity is multiplied with, or [`NO_TEXTURE`].
    pub opacity_texture: u32,
    /// Opacity from which the surface counts as opaque; below, it counts as transparent. 0 to use
    /// opacity unchanged.
    pub alpha_cutoff: f32,
    /// True for a sheet without a volume: it transmits light straight through, weighted by Kt, also
    /// in its shadow. Other transmissive materials refract, and block the light of lamps.
    pub thin: bool,
    /// True for a material whose triangles are invisible from behind: see
    /// [`Scene::is_unseen_back`](crate::Scene::is_unseen_back).
    pub single_sided: bool,
    /// Rows of [`Scene::maps`](crate::Scene::maps) that vary the material: the first one, and their
    /// number.
    pub maps: [u32; 2],
    /// Present if Kd, Ks and s follow from these at each hit: see
    /// [`LobeWeights`](crate::LobeWeights). Kd is then the base colour, Ks the reflectance of the
    /// non-metal part, and `highlight` follows from it.
    pub metallic_roughness: Option<MetallicRoughness>,
}

impl Material {
    /// The initial material of a `.test` file: a faint ambient grey.
    pub const DEFAULT: Material = Material {
        ka: Vec3::splat(0.2),
        ke: Vec3::ZERO,
        kd: Vec3::ZERO,
        ks: Vec3::ZERO,
        highlight: Vec3::ZERO,
        kt: Vec3::ZERO,
        shininess: 1.0,
        ior: 1.0,
        texture: NO_TEXTURE,
        gloss: 0.0,
        opacity: 1.0,
        opacity_texture: NO_TEXTURE,
        alpha_cutoff: 0.0,
        thin: false,
        single_sided: false,
        maps: [0; 2],
        metallic_roughness: None,
    };
}

impl Default for Material {
    /// [`Material::DEFAULT`].
    fn default() -> Self {
        Material::DEFAULT
    }
}

/// Bit of [`Materials::flags`] for a sheet without a volume.
pub const THIN: u8 = 1;
/// Bit of [`Materials::flags`] for a material that is invisible from behind.
pub const SINGLE_SIDED: u8 = 2;
/// Bit of [`Materials::flags`] for a material with [`Material::metallic_roughness`].
pub const METALLIC_ROUGHNESS: u8 = 4;

/// Surface parameters, one [`Material`] each.
#[derive(Clone, Debug, Default)]
pub struct Materials {
    /// Ambient Ka.
    pub ka: Vec3s,
    /// Emission Ke.
    pub ke: Vec3s,
    /// Diffuse Kd.
    pub kd: Vec3s,
    /// Specular Ks.
    pub ks: Vec3s,
    /// Reflectance of lamps alone.
    pub highlight: Vec3s,
    /// Transmission Kt.
    pub kt: Vec3s,
    /// Blinn exponent s.
    pub shininess: Column<f32>,
    /// Index of refraction.
    pub ior: Column<f32>,
    /// Index of a texture, or [`NO_TEXTURE`].
    pub texture: Column<u32>,
    /// Exponent of the mirror lobe, or 0.
    pub gloss: Column<f32>,
    /// Share of the surface that is there.
    pub opacity: Column<f32>,
    /// Index of the texture of opacity, or [`NO_TEXTURE`].
    pub opacity_texture: Column<u32>,
    /// Least opacity that counts as all, or 0.
    pub alpha_cutoff: Column<f32>,
    /// [`THIN`], [`SINGLE_SIDED`] and [`METALLIC_ROUGHNESS`].
    pub flags: Column<u8>,
    /// First map and number of maps.
    pub maps: Column<[u32; 2]>,
    /// [`MetallicRoughness::metallic`], or 0.
    pub metallic: Column<f32>,
    /// [`MetallicRoughness::roughness`], or 0.
    pub roughness: Column<f32>,
}

impl Materials {
    /// Number of materials.
    #[inline]
    pub fn len(&self) -> usize {
        self.ior.len()
    }

    /// Returns true if there are no materials.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ior.is_empty()
    }

    /// Appends a row and returns its number.
    pub fn push(&mut self, surface: &Material) -> u32 {
        let row = self.len() as u32;
        self.ka.push(surface.ka);
        self.ke.push(surface.ke);
        self.kd.push(surface.kd);
        self.ks.push(surface.ks);
        self.highlight.push(surface.highlight);
        self.kt.push(surface.kt);
        self.shininess.push(surface.shininess);
        self.ior.push(surface.ior);
        self.texture.push(surface.texture);
        self.gloss.push(surface.gloss);
        self.opacity.push(surface.opacity);
        self.opacity_texture.push(surface.opacity_texture);
        self.alpha_cutoff.push(surface.alpha_cutoff);
        self.flags.push(surface.flags());
        self.maps.push(surface.maps);
        let [metallic, roughness] = surface.metallic_roughness_parts();
        self.metallic.push(metallic);
        self.roughness.push(roughness);
        row
    }

    /// The row `i`.
    pub fn get(&self, i: usize) -> Material {
        Material {
            ka: self.ka.get(i),
            ke: self.ke.get(i),
            kd: self.kd.get(i),
            ks: self.ks.get(i),
            highlight: self.highlight.get(i),
            kt: self.kt.get(i),
            shininess: self.shininess[i],
            ior: self.ior[i],
            texture: self.texture[i],
            gloss: self.gloss[i],
            opacity: self.opacity[i],
            opacity_texture: self.opacity_texture[i],
            alpha_cutoff: self.alpha_cutoff[i],
            thin: self.flags[i] & THIN != 0,
            single_sided: self.flags[i] & SINGLE_SIDED != 0,
            maps: self.maps[i],
            metallic_roughness: self.metallic_roughness(i),
        }
    }

    /// [`Material::metallic_roughness`] of the row `i`.
    #[inline]
    pub fn metallic_roughness(&self, i: usize) -> Option<MetallicRoughness> {
        let varies = self.flags[i] & METALLIC_ROUGHNESS != 0;
        varies.then(|| MetallicRoughness {
            metallic: self.metallic[i],
            roughness: self.roughness[i],
        })
    }

    /// Returns true if the material of the row `i` may send mirror rays: Ks is not zero, or may not
    /// be.
    #[inline]
    pub fn may_mirror(&self, i: usize) -> bool {
        self.ks.get(i) != Vec3::ZERO || self.flags[i] & METALLIC_ROUGHNESS != 0
    }

    /// Returns true if the material of the row `i` varies over its surface, apart from the factor
    /// of its colour.
    #[inline]
    pub fn is_mapped(&self, i: usize) -> bool {
        self.maps[i][1] > 0 || self.flags[i] & METALLIC_ROUGHNESS != 0
    }
}

/// Numbers in a material.
const MATERIAL_WORDS: usize = 30;

impl Material {
    fn flags(&self) -> u8 {
        (u8::from(self.thin) * THIN)
            | (u8::from(self.single_sided) * SINGLE_SIDED)
            | (u8::from(self.metallic_roughness.is_some()) * METALLIC_ROUGHNESS)
    }

    fn metallic_roughness_parts(&self) -> [f32; 2] {
        self.metallic_roughness
            .map_or([0.0; 2], |pbr| [pbr.metallic, pbr.roughness])
    }

    /// The material's bits. Equal materials have equal bits; bits, unlike floats, can be hashed.
    fn bits(&self) -> [u32; MATERIAL_WORDS] {
        let colors = [self.ka, self.ke, self.kd, self.ks, self.highlight, self.kt];
        let colors = colors.iter().flat_map(|color| color.to_array());
        let [metallic, roughness] = self.metallic_roughness_parts();
        let numbers = [
            self.shininess,
            self.ior,
            self.gloss,
            self.opacity,
            self.alpha_cutoff,
            metallic,
            roughness,
        ];
        let [first_map, maps] = self.maps;
        let textures = [self.texture, self.opacity_texture, first_map, maps];
        let words = textures.into_iter().chain([self.flags().into()]);
        let all = colors.chain(numbers).map(f32::to_bits).chain(words);
        let mut bits = [0; MATERIAL_WORDS];
        bits.iter_mut()
            .zip(all)
            .for_each(|(bits, word)| *bits = word);
        bits
    }
}

/// Gives each distinct material one row.
#[derive(Clone, Debug, Default)]
pub struct MaterialTable {
    rows: HashMap<[u32; MATERIAL_WORDS], u32>,
}

impl MaterialTable {
    /// The row of `surface`, which is appended if it is new.
    #[inline]
    pub fn intern(&mut self, surface: &Material, materials: &mut Materials) -> u32 {
        *self
            .rows
            .entry(surface.bits())
            .or_insert_with(|| materials.push(surface))
    }
}
