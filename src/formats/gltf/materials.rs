//! Converts metallic-roughness materials to the document's Ka, Kd, Ks, Kt and shininess. The table
//! is in the parent module.

use super::coverage::Cover;
use super::document::{GltfDocument, GltfMaterial, Primitive, SpecularGlossiness, TextureInfo};
use super::source::{GltfSource, file_name, parse_data_uri};
use super::unsupported::UnsupportedParts;
use crate::diagnostics::{DiagnosticSink, Span};
use crate::folder::Folder;
use crate::mesh_defaults::{GREY, WHITE};
use crate::options::Options;
use crate::texture::{Embedded, TextureLibrary};
use glam::{Vec2, Vec3};
use phalanx_scene::{Material, MaterialTable, Materials, NO_TEXTURE, Wrap};
use std::borrow::Cow;
use std::collections::HashMap;

/// The result of a primitive's material.
#[derive(Clone)]
pub(super) struct PrimitiveMaterial {
    /// Row of the scene's materials.
    pub(super) material: u32,
    /// The attribute with its UVs, and the map applied to them.
    pub(super) uvs: Option<(String, UvMap)>,
    /// True if the alpha of vertex colours counts.
    pub(super) vertex_opacity: bool,
}

/// Colours of the vertices of a primitive. They multiply the base colour.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum VertexPaint {
    Absent,
    Opaque,
    WithAlpha,
}

impl VertexPaint {
    /// Finds out by the accessors whether a primitive has colours. Those of some of its vertices
    /// do not count.
    pub(super) fn of(primitive: &Primitive, document: &GltfDocument) -> VertexPaint {
        let accessor = |name: &str| {
            let row = primitive.attributes.get(name);
            row.map(|&row| document.accessors.get(row))
        };
        let vertices = accessor("POSITION").flatten().map_or(0, |row| row.count);
        match accessor("COLOR_0") {
            None => VertexPaint::Absent,
            Some(Some(colors)) if colors.count < vertices => VertexPaint::Absent,
            Some(Some(colors)) if colors.kind == "VEC4" => VertexPaint::WithAlpha,
            Some(_) => VertexPaint::Opaque,
        }
    }
}

/// KHR_texture_transform: u' = x · (u, v, 1), v' = y · (u, v, 1).
#[derive(Clone, Copy)]
pub(super) struct UvMap {
    x: [f64; 3],
    y: [f64; 3],
}

impl UvMap {
    fn of(info: &TextureInfo) -> UvMap {
        let Some(t) = &info.extensions.transform else {
            return UvMap {
                x: [1.0, 0.0, 0.0],
                y: [0.0, 1.0, 0.0],
            };
        };
        // Scaled, then turned counter-clockwise as seen on the picture, whose v points down.
        let (sin, cos) = (libm::sin(t.rotation), libm::cos(t.rotation));
        let ([sx, sy], [ox, oy]) = (t.scale, t.offset);
        UvMap {
            x: [cos * sx, sin * sy, ox],
            y: [-sin * sx, cos * sy, oy],
        }
    }

    pub(super) fn apply(&self, [u, v]: [f32; 2]) -> Vec2 {
        let (u, v) = (f64::from(u), f64::from(v));
        let row = |[a, b, c]: [f64; 3]| (a * u + b * v + c) as f32;
        Vec2::new(row(self.x), row(self.y))
    }
}

/// The scene's materials while it is read.
pub(super) struct GltfMaterials<'a> {
    source: &'a GltfSource<'a>,
    asset_dir: &'a Folder,
    library: TextureLibrary<'a>,
    table: MaterialTable,
    /// Extensions without whose pictures textures are left out, as a warning has said.
    unread: Vec<&'static str>,
    cache: HashMap<(Option<usize>, VertexPaint), PrimitiveMaterial>,
    /// Features that the file has and the picture does not show.
    pub(super) unsupported: UnsupportedParts,
}

/// Ambient share of the diffuse colour, as of every mesh.
const AMBIENT: f32 = 0.1;
/// Reflectance of glass, paint and plastic seen straight on.
const DIELECTRIC: f32 = 0.04;
/// Roughness from which on nothing is mirrored.
const MATT: f32 = 0.5;
/// Largest Blinn exponent.
const SHARPEST: f32 = 10_000.0;

impl<'a> GltfMaterials<'a> {
    pub(super) fn new(source: &'a GltfSource<'a>, asset_dir: &'a Folder) -> Self {
        GltfMaterials {
            source,
            asset_dir,
            library: TextureLibrary::new(asset_dir),
            table: MaterialTable::default(),
            unread: Vec::new(),
            cache: HashMap::new(),
            unsupported: UnsupportedParts::default(),
        }
    }

    /// The textures of all materials.
    pub(super) fn into_textures(self) -> Vec<phalanx_scene::Texture> {
        self.library.into_textures()
    }

    /// The material of a row for a primitive of such vertices. Without a row it is the one of the
    /// options, or a matt grey; vertices with colours are white without them.
    pub(super) fn of(
        &mut self,
        row: Option<usize>,
        vertices: VertexPaint,
        options: &Options,
        materials: &mut Materials,
        report: &mut DiagnosticSink,
    ) -> Result<PrimitiveMaterial, String> {
        if let Some(found) = self.cache.get(&(row, vertices)) {
            return Ok(found.clone());
        }
        let found = match row {
            None => {
                let bare = Material {
                    single_sided: true,
                    ..match vertices {
                        VertexPaint::Absent => GREY,
                        _ => WHITE,
                    }
                };
                PrimitiveMaterial {
                    material: self
                        .table
                        .intern(&options.material.unwrap_or(bare), materials),
                    uvs: None,
                    vertex_opacity: false,
                }
            }
            Some(row) => self.converted(row, vertices, materials, report)?,
        };
        self.cache.insert((row, vertices), found.clone());
        Ok(found)
    }

    fn converted(
        &mut self,
        row: usize,
        vertices: VertexPaint,
        materials: &mut Materials,
        report: &mut DiagnosticSink,
    ) -> Result<PrimitiveMaterial, String> {
        let document: &'a GltfDocument = &self.source.document;
        let material = document.materials.get(row);
        let material = material.ok_or_else(|| format!("there is no materials[{row}]"))?;
        self.unsupported.add_material(material);
        let paint = PbrMaterial::of(material, vertices != VertexPaint::Absent);
        let texture = match paint.texture {
            Some(info) => self.texture(info, row, report)?,
            None => NO_TEXTURE,
        };
        let alpha_texture = || self.library.alpha_of(texture);
        let in_vertices = vertices == VertexPaint::WithAlpha;
        let cover = Cover::of(material, paint.alpha, alpha_texture, in_vertices);
        let converted = Material {
            texture,
            opacity: cover.opacity,
            opacity_texture: cover.texture,
            alpha_cutoff: cover.cutoff,
            ..material_from(material, &paint)
        };
        let uvs = paint.texture.filter(|_| texture != NO_TEXTURE);
        Ok(PrimitiveMaterial {
            material: self.table.intern(&converted, materials),
            uvs: uvs.map(|info| (set_of(info), UvMap::of(info))),
            vertex_opacity: cover.vertices,
        })
    }

    fn texture(
        &mut self,
        info: &TextureInfo,
        material: usize,
        report: &mut DiagnosticSink,
    ) -> Result<u32, String> {
        let document: &'a GltfDocument = &self.source.document;
        let Some(index) = info.index else {
            return Ok(NO_TEXTURE);
        };
        let texture = document.textures.get(index);
        let texture = texture.ok_or_else(|| format!("there is no textures[{index}]"))?;
        let sampler = texture.sampler.and_then(|row| document.samplers.get(row));
        let wrap = sampler.map_or([None; 2], |s| [s.wrap_s, s.wrap_t]);
        let wrap = wrap.map(wrap_of);
        let source = self.source;
        let span = || source.span_of("materials", material);
        let other = texture.extensions.webp.as_ref();
        let Some(row) = texture.source.or(other.and_then(|webp| webp.source)) else {
            self.warn_no_picture(index, span(), report);
            return Ok(NO_TEXTURE);
        };
        let image = document.images.get(row);
        let image = image.ok_or_else(|| format!("there is no images[{row}]"))?;
        if let Some(uri) = &image.uri {
            return Ok(match parse_data_uri(uri) {
                None => {
                    let name = file_name(uri, self.asset_dir);
                    self.library.named(&name, wrap, span, report)
                }
                Some(data) => {
                    let bytes = || Ok(Cow::Owned(data.bytes()?));
                    let picture = Embedded::Text(row);
                    self.library.embedded(picture, bytes, wrap, span, report)
                }
            });
        }
        let Some(view) = image.buffer_view else {
            let message = format!("images[{row}] has neither uri nor bufferView");
            report.warning(span(), message);
            return Ok(NO_TEXTURE);
        };
        let bytes = || source.view(view).map(Cow::Borrowed);
        let picture = Embedded::View(view);
        Ok(self.library.embedded(picture, bytes, wrap, span, report))
    }

    /// Warns of a texture without a picture of a kind that is read here, once for each kind.
    fn warn_no_picture(&mut self, index: usize, span: Span, report: &mut DiagnosticSink) {
        let others = &self.source.document.textures[index].extensions;
        let kinds = [
            (others.basisu.is_some(), "KTX2", "KHR_texture_basisu"),
            (others.avif.is_some(), "AVIF", "EXT_texture_avif"),
            (others.dds.is_some(), "DDS", "MSFT_texture_dds"),
        ];
        let kind = kinds.into_iter().find(|(there, ..)| *there);
        let (_, kind, extension) = kind.unwrap_or_default();
        if self.unread.contains(&extension) {
            return;
        }
        self.unread.push(extension);
        let start = format!("textures[{index}], and others like it, are left out:");
        let message = match extension {
            "" => format!("{start} without a picture"),
            _ => format!(
                "{start} pictures of the kind {kind} ({extension}) are not read here, PNG, JPEG \
                 and WebP are"
            ),
        };
        report.warning(span, message);
    }
}

fn set_of(info: &TextureInfo) -> String {
    let transform = info.extensions.transform.as_ref();
    let set = transform
        .and_then(|t| t.tex_coord)
        .unwrap_or(info.tex_coord);
    format!("TEXCOORD_{set}")
}

fn wrap_of(number: Option<u32>) -> Wrap {
    match number {
        Some(33_071) => Wrap::Clamp,
        Some(33_648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

/// Common form of both ways of describing a material.
struct PbrMaterial<'a> {
    color: Vec3,
    alpha: f32,
    /// Share that reflects like a metal, in its colour.
    metallic: f32,
    roughness: f32,
    /// Reflectance of the non-metal part, straight on.
    specular: Vec3,
    texture: Option<&'a TextureInfo>,
}

impl PbrMaterial<'_> {
    /// The material of a primitive whose vertices have colours or not.
    fn of(material: &GltfMaterial, colored: bool) -> PbrMaterial<'_> {
        match &material.extensions.specular_glossiness {
            Some(glossiness) => PbrMaterial::of_glossiness(glossiness),
            None => PbrMaterial::of_metallic(material, colored),
        }
    }

    fn of_metallic(material: &GltfMaterial, colored: bool) -> PbrMaterial<'_> {
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, alpha] = pbr.base_color_factor.map(share);
        let ior = ior(material);
        let reflectance = (ior - 1.0) / (ior + 1.0);
        // One number cannot stand for a texture of roughness, and one colour cannot stand for a
        // mirror that a texture or vertices colour. Both are shown as matt paint.
        let varied = pbr.metallic_roughness_texture.is_some();
        let metallic = share(pbr.metallic_factor);
        let texture = pbr
            .base_color_texture
            .as_ref()
            .filter(|t| t.index.is_some());
        let even = texture.is_none() && !colored;
        let plain = !varied && (even || metallic == 0.0);
        PbrMaterial {
            color: Vec3::new(r, g, b),
            alpha,
            metallic: if plain { metallic } else { 0.0 },
            roughness: if varied {
                1.0
            } else {
                share(pbr.roughness_factor)
            },
            specular: match material.extensions.ior {
                Some(_) => Vec3::splat(reflectance * reflectance),
                None => Vec3::splat(DIELECTRIC),
            },
            texture,
        }
    }

    fn of_glossiness(glossiness: &SpecularGlossiness) -> PbrMaterial<'_> {
        let [r, g, b, alpha] = glossiness.diffuse_factor.map(share);
        let varied = glossiness.specular_glossiness_texture.is_some();
        let gloss = share(glossiness.glossiness_factor);
        PbrMaterial {
            color: Vec3::new(r, g, b),
            alpha,
            metallic: 0.0,
            roughness: if varied { 1.0 } else { 1.0 - gloss },
            specular: Vec3::from_array(glossiness.specular_factor.map(share)),
            texture: glossiness.diffuse_texture.as_ref(),
        }
    }
}

fn material_from(material: &GltfMaterial, paint: &PbrMaterial) -> Material {
    let extensions = &material.extensions;
    let emitted = match (&material.emissive_texture, &extensions.emissive_strength) {
        // Without its texture the whole surface would glow, so it does not glow at all.
        (Some(_), _) => Vec3::ZERO,
        (None, strength) => {
            let strength = strength.as_ref().map_or(1.0, |s| s.emissive_strength);
            let bounded = |c: f64| (c * strength).clamp(0.0, 1e6) as f32;
            Vec3::from_array(material.emissive_factor.map(bounded))
        }
    };
    if extensions.unlit.is_some() {
        return Material {
            ka: paint.color,
            ke: emitted,
            single_sided: !material.double_sided,
            ..Material::default()
        };
    }
    let mirror = gloss(paint.roughness);
    let transmission = extensions.transmission.as_ref();
    // A texture that is not read may say anything, so nothing is transmitted.
    let transmission = transmission.filter(|t| t.transmission_texture.is_none());
    let transmission = transmission.map_or(0.0, |t| share(t.transmission_factor));
    let volume = extensions.volume.as_ref();
    let solid = volume.is_some_and(|v| v.thickness_factor > 0.0);
    // The share that is not metal may transmit light in its colour.
    let through = transmission * (1.0 - paint.metallic);
    let metal = paint.metallic * mirror;
    let kd = paint.color * ((1.0 - metal) * (1.0 - through));
    Material {
        ka: kd * AMBIENT,
        ke: emitted,
        kd,
        ks: paint.specular * ((1.0 - paint.metallic) * mirror) + paint.color * metal,
        kt: paint.color * through,
        shininess: exponent(paint.roughness),
        // A thin sheet does not bend the light it transmits. All materials but those with a volume
        // are thin.
        ior: if solid { ior(material) } else { 1.0 },
        thin: !solid && through > 0.0,
        // Light that has entered leaves through backs, and is seen there.
        single_sided: !material.double_sided && through == 0.0,
        ..Material::DEFAULT
    }
}

/// Weight of the mirror image: 1 for a polished surface, 0 from [`MATT`] on.
fn gloss(roughness: f32) -> f32 {
    let left = (1.0 - roughness / MATT).max(0.0);
    left * left
}

/// The Blinn exponent of a roughness r, 2/r⁴ − 2: its lobe is as wide as that of α = r² (Karis,
/// "Specular BRDF Reference", 2013).
fn exponent(roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    (2.0 / (alpha * alpha) - 2.0).clamp(0.0, SHARPEST)
}

/// The index of refraction; 1.5 if the file gives none, or an impossible one.
fn ior(material: &GltfMaterial) -> f32 {
    let ior = material.extensions.ior.as_ref().map_or(1.5, |i| i.ior);
    match (1.0..=100.0).contains(&ior) {
        true => ior as f32,
        false => 1.5,
    }
}

fn share(number: f64) -> f32 {
    number.clamp(0.0, 1.0) as f32
}
