//! Vertices of a primitive as its accessors have them, moved by its morph targets.

use super::accessor::Accessor;
use super::document::Primitive;
use super::materials::{PrimitiveMaterial, UvLayer, UvMap};
use super::morph::{self, MorphTarget};
use super::skins::Influences;
use super::source::GltfSource;
use glam::{DVec3, Vec2, Vec3};

/// Attributes of the vertices of a primitive.
pub(super) struct PrimitiveVertices<'a> {
    /// Number of vertices.
    pub(super) count: usize,
    positions: Accessor<'a>,
    normals: Option<Accessor<'a>>,
    /// Layers of texture coordinates; all or none of them.
    uvs: Vec<(Accessor<'a>, UvMap)>,
    tangents: Option<Accessor<'a>>,
    colors: Option<Accessor<'a>>,
    /// True if the alpha of colours counts.
    has_opacity: bool,
    targets: Vec<MorphTarget<'a>>,
    influences: Option<Influences<'a>>,
    /// Attributes that are omitted, since they have fewer rows than POSITION.
    pub(super) too_short: Vec<String>,
}

/// Attributes of a vertex in addition to its position.
#[derive(Clone, Copy)]
pub(super) struct Attributes {
    pub(super) normals: bool,
    /// Number of layers.
    pub(super) uvs: usize,
    pub(super) tangents: bool,
    pub(super) colors: bool,
    pub(super) opacity: bool,
}

impl<'a> PrimitiveVertices<'a> {
    /// Opens the accessors of a primitive that has positions, in a pose of these weights.
    pub(super) fn open(
        source: &'a GltfSource,
        primitive: &Primitive,
        material: &PrimitiveMaterial,
        weights: &[f64],
        skinned: bool,
    ) -> Result<PrimitiveVertices<'a>, String> {
        if is_only_compressed(source, primitive) {
            return Err("compressed by Draco (KHR_draco_mesh_compression), not read here".into());
        }
        let vectors = |name: &str, width: usize| {
            Accessor::of_attribute(source, &primitive.attributes, name, width)
        };
        let positions = vectors("POSITION", 3)?.ok_or("it has no POSITION")?;
        let mut too_short = Vec::new();
        let mut complete = |name: &str, opened: Option<Accessor<'a>>| match opened {
            Some(accessor) if accessor.count < positions.count => {
                too_short.push(name.to_owned());
                None
            }
            opened => opened,
        };
        let mut uvs = Vec::new();
        for UvLayer { set, map } in &material.uvs {
            let given = complete(set, vectors(set, 2)?);
            // The first layer stands in for others that are missing.
            let Some(layer) = given.or(uvs.first().map(|&(first, _)| first)) else {
                break;
            };
            uvs.push((layer, *map));
        }
        let colors = primitive.attributes.get("COLOR_0");
        let colors = colors.map(|&row| Accessor::open_colors(source, row));
        let colors = complete("COLOR_0", colors.transpose()?);
        let normals = complete("NORMAL", vectors("NORMAL", 3)?);
        // Without normals, tangents do not count (glTF 2.0, 3.7.2.1).
        let tangents = if material.tangents && normals.is_some() {
            complete("TANGENT", vectors("TANGENT", 4)?)
        } else {
            None
        };
        let first_set = material.uvs.first().map(|layer| &layer.set[..]);
        let opened = PrimitiveVertices {
            count: positions.count,
            positions,
            normals,
            uvs,
            tangents,
            colors,
            has_opacity: material.vertex_opacity,
            targets: MorphTarget::all(source, primitive, weights, first_set)?,
            influences: if skinned { Influences::open(source, primitive)? } else { None },
            too_short,
        };
        if opened.rows() < opened.count {
            Err("an attribute has fewer rows than POSITION".into())
        } else {
            Ok(opened)
        }
    }

    /// Number of rows that all morph targets and joints have.
    fn rows(&self) -> usize {
        let targets = self.targets.iter().map(MorphTarget::rows);
        let influences = self.influences.iter().map(Influences::rows);
        targets.chain(influences).min().unwrap_or(self.count)
    }

    pub(super) fn attributes(&self) -> Attributes {
        Attributes {
            normals: self.normals.is_some(),
            uvs: self.uvs.len(),
            tangents: self.tangents.is_some(),
            colors: self.colors.is_some(),
            opacity: self.colors.is_some() && self.has_opacity,
        }
    }

    /// Number of morph targets that move each vertex.
    pub(super) fn target_count(&self) -> usize {
        self.targets.len()
    }

    /// Returns true if positions are those of the accessor itself.
    pub(super) fn is_unmoved(&self) -> bool {
        self.targets.is_empty() && self.influences.is_none()
    }

    /// The joints that move each vertex, if the pose has a skin and the primitive is made for one.
    pub(super) fn influences(&self) -> Option<&Influences<'a>> {
        self.influences.as_ref()
    }

    /// A position in the accessor itself.
    #[inline]
    pub(super) fn stored_position(&self, row: usize) -> [f32; 3] {
        self.positions.get(row)
    }

    /// Calls `put` with the position of each of the rows, and its index among them.
    #[inline]
    pub(super) fn each_position(&self, rows: &[u32], put: impl FnMut(usize, DVec3)) {
        self.each_vector(&self.positions, |target| target.position, rows, put);
    }

    /// The same for normals of any length, if there are any.
    #[inline]
    pub(super) fn each_normal(&self, rows: &[u32], put: impl FnMut(usize, DVec3)) {
        if let Some(normals) = &self.normals {
            self.each_vector(normals, |target| target.normal, rows, put);
        }
    }

    #[inline]
    fn each_vector(
        &self,
        vectors: &Accessor,
        attribute: impl Fn(&MorphTarget<'a>) -> Option<Accessor<'a>>,
        rows: &[u32],
        mut put: impl FnMut(usize, DVec3),
    ) {
        vectors.each(rows, |k, own| {
            let own = Vec3::from_array(own).as_dvec3();
            put(
                k,
                morph::vector(&self.targets, &attribute, rows[k] as usize, own),
            );
        });
    }

    /// The same for tangents of any length and the signs of their bitangents, if there are any.
    /// Morph targets leave them unchanged: they are made perpendicular to the normal at each hit.
    #[inline]
    pub(super) fn each_tangent(&self, rows: &[u32], mut put: impl FnMut(usize, DVec3, f32)) {
        if let Some(tangents) = &self.tangents {
            tangents.each(rows, |k, [x, y, z, sign]| {
                put(k, Vec3::new(x, y, z).as_dvec3(), sign);
            });
        }
    }

    /// The same for the texture coordinates of a layer. Morph targets move those of the first.
    #[inline]
    pub(super) fn each_uv(&self, layer: usize, rows: &[u32], mut put: impl FnMut(usize, Vec2)) {
        let (uvs, map) = &self.uvs[layer];
        let targets = if layer == 0 { &self.targets[..] } else { &[] };
        uvs.each(rows, |k, own| {
            put(k, map.apply(morph::uv(targets, rows[k] as usize, own)));
        });
    }

    /// The same for colours and their opacity, all within 0 to 1, or NaN, if there are any.
    #[inline]
    pub(super) fn each_color(&self, rows: &[u32], mut put: impl FnMut(usize, [f32; 4])) {
        let Some(colors) = &self.colors else {
            return;
        };
        for (k, &row) in rows.iter().enumerate() {
            let row = row as usize;
            let color = morph::color(&self.targets, row, colors.color(row, 1.0));
            put(k, color.map(|share| share.clamp(0.0, 1.0)));
        }
    }
}

/// Returns true if a primitive has only compressed data: its accessors are empty.
fn is_only_compressed(source: &GltfSource, primitive: &Primitive) -> bool {
    let positions = primitive.attributes.get("POSITION").copied();
    let rows = [positions, primitive.indices].into_iter().flatten();
    let mut accessors = rows.filter_map(|row| source.document.accessors.get(row));
    primitive.extensions.draco.is_some()
        && accessors.any(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none())
}
