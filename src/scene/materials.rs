//! Columns of the surface parameters, and a table that gives equal materials one row.

use super::{Column, MetallicRoughness, NO_TEXTURE, Vec3s};
use crate::column::{AnyColumn, Attribute};
use crate::prims::{ColumnInfo, RowCheck, column_infos, column_list};
use glam::Vec3;
use std::collections::HashMap;

/// Declares [`Material`], [`Materials`] and what copies one to the other. A parameter is one row:
/// its type and that of its column, the value of [`Material::DEFAULT`], the section of scene caches
/// and the name in messages, and the condition on its values.
macro_rules! material_parameters {
    (|$textures:ident| $(
        $(#[$doc:meta])+
        $name:ident: $row:ty, $column:ty = $default:expr, $names:tt, $check:expr;
    )+) => {
        /// One row of [`Materials`] (design document, "Recursive shading model"): RGB linear and
        /// finite.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Material {
            $($(#[$doc])+ pub $name: $row,)+
            /// True for a sheet without a volume: it transmits light straight through, weighted by
            /// Kt, also in its shadow. Other transmissive materials refract, and block the light of
            /// lamps.
            pub thin: bool,
            /// True for a material whose triangles are invisible from behind: see
            /// [`Scene::is_unseen_back`](crate::Scene::is_unseen_back).
            pub single_sided: bool,
            /// Rows of [`Scene::maps`](crate::Scene::maps) that vary the material: the first one,
            /// and their number.
            pub maps: [u32; 2],
            /// Present if Kd, Ks and s follow from these at each hit: see
            /// [`LobeWeights`](crate::LobeWeights). Kd is then the base colour, Ks the reflectance
            /// of the non-metal part, and `highlight` follows from it.
            pub metallic_roughness: Option<MetallicRoughness>,
        }

        impl Material {
            /// The initial material of a `.test` file: a faint ambient grey.
            pub const DEFAULT: Material = Material {
                $($name: $default,)+
                thin: false,
                single_sided: false,
                maps: [0; 2],
                metallic_roughness: None,
            };

            /// The bits of every parameter. Equal materials have equal bits; bits, unlike floats,
            /// can be hashed.
            fn bits(&self) -> MaterialBits {
                let [metallic, roughness] = self.metallic_roughness_parts();
                let [first_map, maps] = self.maps;
                [
                    $(self.$name.bits(),)+
                    [self.flags().into(), first_map, maps],
                    Vec3::new(metallic, roughness, 0.0).bits(),
                ]
            }
        }

        /// Bits of the parameters of a material, and of the columns that are no parameters.
        type MaterialBits = [[u32; 3]; [$(stringify!($name)),+].len() + 2];

        /// Surface parameters, one [`Material`] each.
        #[derive(Clone, Debug, Default)]
        pub struct Materials {
            $(
                #[doc = concat!("[`Material::", stringify!($name), "`] of each material.")]
                pub $name: $column,
            )+
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
            /// Appends a row and returns its number.
            pub fn push(&mut self, surface: &Material) -> u32 {
                let row = self.len() as u32;
                $(self.$name.push(surface.$name);)+
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
                    $($name: self.$name.row(i),)+
                    thin: self.flags[i] & THIN != 0,
                    single_sided: self.flags[i] & SINGLE_SIDED != 0,
                    maps: self.maps[i],
                    metallic_roughness: self.metallic_roughness(i),
                }
            }

            column_list! {
                /// The columns, with the conditions on them. Rows refer to `textures` textures.
                pub(crate) fn columns(materials, $textures), columns_mut;
                "material", materials.len() => {
                    $($name: $names, $check;)+
                    flags: ["material flags", "flag"], RowCheck::Any;
                    maps: ["material maps", "maps"], RowCheck::Any;
                    metallic: ["material lobes", "metallic"], RowCheck::UnitInterval;
                    roughness: ["material lobes", "roughness"], RowCheck::UnitInterval;
                }
            }
        }
    };
}

material_parameters! {
    |textures|
    /// Ambient Ka.
    ka: Vec3, Vec3s = Vec3::splat(0.2), ["materials", "ka"], RowCheck::Finite;
    /// Emission Ke.
    ke: Vec3, Vec3s = Vec3::ZERO, ["materials", "ke"], RowCheck::Finite;
    /// Diffuse Kd.
    kd: Vec3, Vec3s = Vec3::ZERO, ["materials", "kd"], RowCheck::Finite;
    /// Specular Ks, also the weight of the mirror ray.
    ks: Vec3, Vec3s = Vec3::ZERO, ["materials", "ks"], RowCheck::Finite;
    /// Reflectance of lamps alone, beside Ks: a highlight that no mirror image goes with. Each lamp
    /// adds highlight · (s + 2)/8 · max(h·n, 0)^s · max(l·n, 0), a lobe that reflects this share of
    /// its light or less at any exponent (Walter et al., "Microfacet Models for Refraction through
    /// Rough Surfaces", 2007: D/4 of Blinn-Phong).
    highlight: Vec3, Vec3s = Vec3::ZERO, ["materials", "highlight"], RowCheck::Finite;
    /// Transmission Kt, the weight of the refracted ray.
    kt: Vec3, Vec3s = Vec3::ZERO, ["materials", "kt"], RowCheck::Finite;
    /// Blinn exponent s, at least 0.
    shininess: f32, Column<f32> = 1.0, ["materials", "shininess"], RowCheck::Color;
    /// Index of refraction, positive.
    ior: f32, Column<f32> = 1.0, ["materials", "ior"], RowCheck::Positive;
    /// Index of the texture that Ka and Kd are multiplied with, or [`NO_TEXTURE`].
    texture: u32, Column<u32> = NO_TEXTURE, ["materials", "texture"], RowCheck::Texture(textures);
    /// Exponent n of the lobe cosⁿ, about the mirror direction, over which mirror rays are spread;
    /// 0 for a perfect mirror, which reflects all rays in one direction.
    ///
    /// Each ray has weight Ks, regardless of its direction. A ray that the lobe would send through
    /// the surface is reflected back by it.
    gloss: f32, Column<f32> = 0.0, ["material gloss", "gloss"], RowCheck::Color;
    /// Opacity of the surface, 0 to 1. The rest of rays and light passes straight through: see
    /// [`Scene::coverage`](crate::Scene::coverage).
    opacity: f32, Column<f32> = 1.0, ["material opacity", "opacity"], RowCheck::UnitInterval;
    /// Index of the texture whose alpha the opacity is multiplied with, or [`NO_TEXTURE`].
    opacity_texture: u32, Column<u32> = NO_TEXTURE,
        ["material opacity", "opacity texture"], RowCheck::Texture(textures);
    /// Opacity from which the surface counts as opaque; below, it counts as transparent. 0 to use
    /// opacity unchanged.
    alpha_cutoff: f32, Column<f32> = 0.0, ["material opacity", "cutoff"], RowCheck::UnitInterval;
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
}

/// A parameter's bits, for any width.
trait ParameterBits {
    fn bits(self) -> [u32; 3];
}

impl ParameterBits for Vec3 {
    fn bits(self) -> [u32; 3] {
        self.to_array().map(f32::to_bits)
    }
}

impl ParameterBits for f32 {
    fn bits(self) -> [u32; 3] {
        [self.to_bits(), 0, 0]
    }
}

impl ParameterBits for u32 {
    fn bits(self) -> [u32; 3] {
        [self, 0, 0]
    }
}

/// Gives each distinct material one row.
#[derive(Clone, Debug, Default)]
pub struct MaterialTable {
    rows: HashMap<MaterialBits, u32>,
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
