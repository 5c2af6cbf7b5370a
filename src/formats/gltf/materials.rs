//! Converts metallic-roughness materials to the document's Ka, Kd, Ks, Kt and shininess. The table
//! is in the parent module.

use super::coverage::Cover;
use super::document::{GltfDocument, GltfMaterial, Primitive, SpecularGlossiness, TextureInfo};
use super::source::{GltfSource, file_name, parse_data_uri};
use super::unsupported::UnsupportedParts;
use crate::diagnostics::{DiagnosticSink, Span};
use crate::folder::Folder;
use crate::mesh::defaults::{GREY, WHITE};
use crate::metallic_roughness::{DIELECTRIC, PbrSurface};
use crate::options::ReadOptions;
use crate::texture::{Embedded, TextureLibrary, TextureSampler};
use glam::{Vec2, Vec3};
use phalanx_scene::{
    MapTarget, Material, MaterialTable, MetallicRoughness, NO_TEXTURE, Scene, TextureMap, Wrap,
};
use std::borrow::Cow;
use std::collections::HashMap;

/// The result of a primitive's material.
#[derive(Clone, Default)]
pub(super) struct PrimitiveMaterial {
    /// Row of the scene's materials.
    pub(super) material: u32,
    /// Layers of its UVs.
    pub(super) uvs: Vec<UvLayer>,
    /// True if the file's tangents are those of its normal map.
    pub(super) tangents: bool,
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

/// Texture coordinates of one or more textures of a material.
#[derive(Clone, PartialEq)]
pub(super) struct UvLayer {
    /// The attribute.
    pub(super) set: String,
    pub(super) map: UvMap,
}

/// KHR_texture_transform: u' = x · (u, v, 1), v' = y · (u, v, 1).
#[derive(Clone, Copy, PartialEq)]
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

    /// Returns true if u and v keep their directions.
    fn is_upright(&self) -> bool {
        let ([a, b, _], [c, d, _]) = (self.x, self.y);
        a > 0.0 && d > 0.0 && b == 0.0 && c == 0.0
    }

    #[inline]
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
    pub(super) fn convert(
        &mut self,
        row: Option<usize>,
        vertices: VertexPaint,
        options: &ReadOptions,
        scene: &mut Scene,
        report: &mut DiagnosticSink,
    ) -> Result<PrimitiveMaterial, String> {
        if let Some(converted) = self.cache.get(&(row, vertices)) {
            return Ok(converted.clone());
        }
        let converted = match row {
            None => {
                let colored = vertices != VertexPaint::Absent;
                let bare = Material {
                    single_sided: true,
                    ..if colored { WHITE } else { GREY }
                };
                let material = options.material.unwrap_or(bare);
                PrimitiveMaterial {
                    material: self.table.intern(&material, &mut scene.materials),
                    ..PrimitiveMaterial::default()
                }
            }
            Some(row) => self.converted(row, vertices, scene, report)?,
        };
        self.cache.insert((row, vertices), converted.clone());
        Ok(converted)
    }

    fn converted(
        &mut self,
        row: usize,
        vertices: VertexPaint,
        scene: &mut Scene,
        report: &mut DiagnosticSink,
    ) -> Result<PrimitiveMaterial, String> {
        let document: &'a GltfDocument = &self.source.document;
        let material = document.materials.get(row);
        let material = material.ok_or_else(|| format!("there is no materials[{row}]"))?;
        self.unsupported.add_material(material);
        let paint = PbrMaterial::of(material);
        let mut maps = MaterialMaps::default();
        let mut texture = NO_TEXTURE;
        if let Some((picture, info)) = self.map(paint.texture, row, report)? {
            texture = picture;
            maps.layer(info);
        }
        let alpha_texture = || self.library.alpha_of(texture);
        let in_vertices = vertices == VertexPaint::WithAlpha;
        let cover = Cover::of(material, paint.alpha, alpha_texture, in_vertices);
        let mut emitted = emitted(material);
        let glow = material.emissive_texture.as_ref();
        if let Some(info) = glow.filter(|_| emitted != Vec3::ZERO) {
            match self.map(Some(info), row, report)? {
                Some(glow) => maps.add(glow, MapTarget::Emission, 0),
                // Without its texture the whole surface would glow, so it does not glow at all.
                None => emitted = Vec3::ZERO,
            }
        }
        let mut varied = false;
        if material.extensions.unlit.is_none() {
            if let Some(normal) = self.map(material.normal_texture.as_ref(), row, report)? {
                maps.add(normal, MapTarget::Normal, 0);
            }
            let colored = texture != NO_TEXTURE || vertices != VertexPaint::Absent;
            varied = colored && paint.surface(0.0).has_colored_mirror();
            if let Some(lobes) = self.map(paint.lobes, row, report)? {
                maps.add(lobes, MapTarget::Roughness, 1);
                maps.add(lobes, MapTarget::Metallic, 2);
                varied = true;
            }
        }
        let converted = Material {
            ke: emitted,
            texture,
            opacity: cover.opacity,
            opacity_texture: cover.texture,
            alpha_cutoff: cover.cutoff,
            maps: scene.maps.push_all(&maps.rows),
            ..material_from(material, &paint, varied)
        };
        Ok(PrimitiveMaterial {
            material: self.table.intern(&converted, &mut scene.materials),
            tangents: maps.keeps_tangents(),
            uvs: maps.layers,
            vertex_opacity: cover.vertices,
        })
    }

    /// A texture and its description, if there is one and it can be read.
    fn map<'i>(
        &mut self,
        info: Option<&'i TextureInfo>,
        material: usize,
        report: &mut DiagnosticSink,
    ) -> Result<Option<(u32, &'i TextureInfo)>, String> {
        let Some(info) = info else {
            return Ok(None);
        };
        let texture = self.texture(info, material, report)?;
        Ok((texture != NO_TEXTURE).then_some((texture, info)))
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
        let sampler = TextureSampler {
            wrap: wrap.map(wrap_of),
            nearest: sampler.is_some_and(|s| s.mag_filter == Some(NEAREST)),
        };
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
            let Some(data) = parse_data_uri(uri) else {
                let name = file_name(uri, self.asset_dir);
                return Ok(self.library.named(&name, sampler, span, report));
            };
            let bytes = || Ok(Cow::Owned(data.bytes()?));
            let picture = Embedded::Text(row);
            return Ok(self.library.embedded(picture, bytes, sampler, span, report));
        }
        let Some(view) = image.buffer_view else {
            let message = format!("images[{row}] has neither uri nor bufferView");
            report.warning(span(), message);
            return Ok(NO_TEXTURE);
        };
        let bytes = || source.view(view).map(Cow::Borrowed);
        let picture = Embedded::View(view);
        Ok(self.library.embedded(picture, bytes, sampler, span, report))
    }

    /// Warns of a texture without a picture of a kind that is read here, once for each kind.
    fn warn_no_picture(&mut self, index: usize, span: Span, report: &mut DiagnosticSink) {
        let others = &self.source.document.textures[index].extensions;
        let kinds = [
            (others.basisu.is_some(), "KTX2", "KHR_texture_basisu"),
            (others.avif.is_some(), "AVIF", "EXT_texture_avif"),
            (others.dds.is_some(), "DDS", "MSFT_texture_dds"),
        ];
        let kind = kinds.into_iter().find(|(is_present, ..)| *is_present);
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

/// Maps of a material, and the texture coordinates of all its textures.
#[derive(Default)]
struct MaterialMaps {
    layers: Vec<UvLayer>,
    rows: Vec<TextureMap>,
}

impl MaterialMaps {
    /// The number of a texture's layer.
    fn layer(&mut self, info: &TextureInfo) -> u32 {
        let transform = info.extensions.transform.as_ref();
        let set = transform.and_then(|t| t.tex_coord);
        let layer = UvLayer {
            set: format!("TEXCOORD_{}", set.unwrap_or(info.tex_coord)),
            map: UvMap::of(info),
        };
        let known = self.layers.iter().position(|known| *known == layer);
        known.unwrap_or_else(|| {
            self.layers.push(layer);
            self.layers.len() - 1
        }) as u32
    }

    fn add(&mut self, (texture, info): (u32, &TextureInfo), target: MapTarget, channel: u32) {
        let scale = info.scale as f32;
        let uv_layer = self.layer(info);
        self.rows.push(TextureMap {
            target,
            texture,
            channel,
            uv_layer,
            scale: if scale.is_finite() { scale } else { 1.0 },
        });
    }

    /// Returns true if the tangents of the file, if it has any, are those of the normal map: they
    /// follow texture coordinates that are not turned.
    fn keeps_tangents(&self) -> bool {
        let is_upright = |map: &TextureMap| self.layers[map.uv_layer as usize].map.is_upright();
        let mut maps = self.rows.iter();
        maps.any(|map| map.target == MapTarget::Normal && is_upright(map))
    }
}

/// The filter of a texture whose texels are not blended. Only `magFilter` counts: rays sample a
/// point, and never the mean of many texels.
const NEAREST: u32 = 9728;

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
    /// Texture of metallic and roughness.
    lobes: Option<&'a TextureInfo>,
}

impl PbrMaterial<'_> {
    fn of(material: &GltfMaterial) -> PbrMaterial<'_> {
        match &material.extensions.specular_glossiness {
            Some(glossiness) => PbrMaterial::of_glossiness(glossiness),
            None => PbrMaterial::of_metallic(material),
        }
    }

    /// The surface with a share that is transmitted.
    fn surface(&self, through: f32) -> PbrSurface {
        PbrSurface {
            color: self.color,
            lobes: MetallicRoughness {
                metallic: self.metallic,
                roughness: self.roughness,
            },
            specular: self.specular,
            through,
        }
    }

    fn of_metallic(material: &GltfMaterial) -> PbrMaterial<'_> {
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, alpha] = pbr.base_color_factor.unwrap_or([1.0; 4]).map(share);
        let ior = ior(material);
        let reflectance = (ior - 1.0) / (ior + 1.0);
        let texture = pbr.base_color_texture.as_ref();
        PbrMaterial {
            color: Vec3::new(r, g, b),
            alpha,
            metallic: share(pbr.metallic_factor.unwrap_or(1.0)),
            roughness: share(pbr.roughness_factor.unwrap_or(1.0)),
            specular: match material.extensions.ior {
                Some(_) => Vec3::splat(reflectance * reflectance),
                None => Vec3::splat(DIELECTRIC),
            },
            texture: texture.filter(|t| t.index.is_some()),
            lobes: pbr.metallic_roughness_texture.as_ref(),
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
            lobes: None,
        }
    }
}

/// Light that the whole surface emits, without its texture.
fn emitted(material: &GltfMaterial) -> Vec3 {
    let strength = material.extensions.emissive_strength.as_ref();
    let strength = strength.map_or(1.0, |s| s.emissive_strength);
    // KHR_materials_unlit shows the base colour alone.
    let strength = material.extensions.unlit.map_or(strength, |_| 0.0);
    let bounded = |c: f64| (c * strength).clamp(0.0, 1e30) as f32;
    Vec3::from_array(material.emissive_factor.map(bounded))
}

/// The material without its textures and its emission. If it is `varied`, metallic and roughness
/// are left to the hits.
fn material_from(material: &GltfMaterial, paint: &PbrMaterial, varied: bool) -> Material {
    let extensions = &material.extensions;
    if extensions.unlit.is_some() {
        return Material {
            ka: paint.color,
            single_sided: !material.double_sided,
            ..Material::default()
        };
    }
    let transmission = extensions.transmission.as_ref();
    // A texture that is not read may say anything, so nothing is transmitted.
    let transmission = transmission.filter(|t| t.transmission_texture.is_none());
    let transmission = transmission.map_or(0.0, |t| share(t.transmission_factor));
    let volume = extensions.volume.as_ref();
    let solid = volume.is_some_and(|v| v.thickness_factor > 0.0);
    // The share that is not metal may transmit light in its colour; a texture may say that nothing
    // is metal.
    let metallic = paint.lobes.map_or(paint.metallic, |_| 0.0);
    let through = transmission * (1.0 - metallic);
    Material {
        kt: paint.color * through,
        // A thin sheet does not bend the light it transmits. All materials but those with a volume
        // are thin.
        ior: if solid { ior(material) } else { 1.0 },
        thin: !solid && through > 0.0,
        // Light that has entered leaves through backs, and is seen there.
        single_sided: !material.double_sided && through == 0.0,
        ..paint.surface(through).to_material(varied)
    }
}

/// The index of refraction; 1.5 if the file gives none, or an impossible one.
fn ior(material: &GltfMaterial) -> f32 {
    let ior = material.extensions.ior.as_ref().and_then(|given| given.ior);
    let ior = ior.filter(|ior| (1.0..=100.0).contains(ior));
    ior.unwrap_or(1.5) as f32
}

fn share(number: f64) -> f32 {
    number.clamp(0.0, 1.0) as f32
}
