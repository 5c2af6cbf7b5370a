//! Primitives: accessors to triangles, in their mesh's own space or baked into the world.

use super::accessor::Accessor;
use super::document::Primitive;
use super::materials::{PrimitiveMaterial, UvMap};
use super::source::GltfSource;
use crate::formats::origin::{self, Origin};
use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use phalanx_scene::{Bounds, Mesh, MeshMaterial, NO_NORMALS, NO_UVS};
use std::collections::HashMap;

/// Triangles of one material, in the form of the file's accessors.
pub(super) struct PrimitiveGeometry<'a> {
    positions: Accessor<'a>,
    normals: Option<Accessor<'a>>,
    uvs: Option<(Accessor<'a>, UvMap)>,
    corners: Vec<[u32; 3]>,
    material: u32,
}

/// Vertices of a mesh whose normal or UV in the file is unusable.
#[derive(Clone, Copy, Default)]
pub(super) struct BadAttributes {
    pub(super) normals: usize,
    pub(super) uvs: usize,
    /// True if positions that are single precision in the file were rounded.
    pub(super) inexact: bool,
}

/// Topologies of triangles, by their numbers in the file.
const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// Returns true if a mode means triangles; 0 to 3 are points and lines.
pub(super) fn is_surface(mode: u32) -> bool {
    (TRIANGLES..=FAN).contains(&mode)
}

impl<'a> PrimitiveGeometry<'a> {
    /// Opens a primitive's accessors and reads its indices: no more than `most` triangles, and only
    /// if `room` grants memory for them and for the columns that are made of them.
    pub(super) fn open(
        source: &'a GltfSource,
        primitive: &Primitive,
        material: &PrimitiveMaterial,
        most: u64,
        room: impl FnOnce(u64, u64) -> Result<(), String>,
    ) -> Result<PrimitiveGeometry<'a>, String> {
        let attribute = |name: &str, width: usize| {
            let row = primitive.attributes.get(name);
            let opened = row.map(|&row| Accessor::open(source, row, width));
            opened
                .transpose()
                .map_err(|reason| match primitive.extensions.draco {
                    Some(_) => {
                        "compressed by Draco (KHR_draco_mesh_compression), not read here".into()
                    }
                    None => reason,
                })
        };
        let positions = attribute("POSITION", 3)?.ok_or("it has no POSITION")?;
        let normals = attribute("NORMAL", 3)?;
        let uvs = match &material.uvs {
            Some((name, map)) => attribute(name, 2)?.map(|uvs| (uvs, *map)),
            None => None,
        };
        let short = |other: &Accessor| other.count < positions.count;
        if normals.as_ref().is_some_and(short) || uvs.as_ref().is_some_and(|(uvs, _)| short(uvs)) {
            return Err("an attribute has fewer rows than POSITION".into());
        }
        let mut shape = PrimitiveGeometry {
            positions,
            normals,
            uvs,
            corners: Vec::new(),
            material: material.material,
        };
        let corners = TriangleIndices::of(source, primitive, positions.count, most)?;
        room(corners.count as u64, shape.bytes_of(corners.count as u64))?;
        shape.corners = corners.collect()?;
        Ok(shape)
    }

    /// Number of triangles.
    pub(super) fn len(&self) -> usize {
        self.corners.len()
    }

    /// Upper bound on the bytes of its columns.
    pub(super) fn mesh_bytes(&self) -> u64 {
        self.bytes_of(self.len() as u64)
    }

    /// Upper bound on the bytes of the columns of `triangles` of its triangles: they grow by
    /// doubling.
    fn bytes_of(&self, triangles: u64) -> u64 {
        let per = |column: bool, bytes: u64| if column { bytes } else { 0 };
        let (normals, uvs) = (self.normals.is_some(), self.uvs.is_some());
        let triangle = 32 + per(normals, 12) + per(uvs, 12);
        let vertex = 12 + per(normals, 12) + per(uvs, 8);
        let vertices = (self.positions.count as u64).min(3 * triangles);
        2 * (triangles * triangle + vertices * vertex)
    }

    /// Bounds of the corners, in the mesh's own space.
    pub(super) fn bounds(&self) -> Bounds {
        let corners = self.corners.iter().flatten();
        corners.fold(Bounds::EMPTY, |all, &corner| {
            let position = Vec3::from_array(self.positions.get(corner as usize));
            all.union(Bounds::new(position, position))
        })
    }

    /// The triangles under a map, with only the vertices that they use. A map that mirrors reverses
    /// their order of corners, so that front faces stay front faces.
    ///
    /// If the map does nothing but subtract the scene's origin, positions must still be single
    /// precision after it.
    pub(super) fn mesh(
        &self,
        map: &DAffine3,
        origin: Origin,
    ) -> Result<(Mesh, BadAttributes), String> {
        let mut out = Placing::new(self, map);
        let taken = DAffine3::from_translation(-origin.position());
        let as_it_stands = origin.offset().is_some() && *map == taken;
        let mut corners = Vec::with_capacity(self.corners.len());
        for &[a, b, c] in &self.corners {
            let row = match out.mirrored {
                true => [a, c, b],
                false => [a, b, c],
            };
            let [a, b, c] = row.map(|corner| out.number(corner));
            corners.push([a?, b?, c?]);
        }
        let bad = BadAttributes {
            normals: out.nothing_said,
            uvs: out.bad_uvs.len(),
            inexact: as_it_stands && !self.is_exact_at(origin.position()),
        };
        Ok((out.finish(corners), bad))
    }
}

impl PrimitiveGeometry<'_> {
    /// Returns true if subtracting an origin rounds no corner.
    fn is_exact_at(&self, position: DVec3) -> bool {
        let exact = |&corner: &u32| {
            let at = self.positions.get::<3>(corner as usize);
            (0..3).all(|axis| origin::is_exact(at[axis], position[axis]))
        };
        self.corners.iter().flatten().all(exact)
    }
}

/// Bytes of a triangle of a shape.
pub(super) const CORNERS_BYTES: u64 = 12;

/// Triangles of indices below `vertices`, counted before they are collected.
struct TriangleIndices<'a> {
    indices: Option<Accessor<'a>>,
    mode: u32,
    vertices: usize,
    count: usize,
}

impl<'a> TriangleIndices<'a> {
    /// The triangles of a primitive: no more than `most`.
    fn of(
        source: &'a GltfSource,
        primitive: &Primitive,
        vertices: usize,
        most: u64,
    ) -> Result<TriangleIndices<'a>, String> {
        let indices = primitive.indices;
        let indices = indices
            .map(|row| Accessor::open(source, row, 1))
            .transpose()?;
        if indices.is_some_and(|indices| !indices.holds_indices()) {
            return Err("its indices are not unsigned integers".into());
        }
        let steps = indices.map_or(vertices, |indices| indices.count);
        let count = match primitive.mode {
            TRIANGLES => steps / 3,
            _ => steps.saturating_sub(2),
        };
        if count as u64 > most || vertices as u64 > u64::from(u32::MAX) {
            return Err(format!(
                "{count} more triangles are too many for a file of this size"
            ));
        }
        Ok(TriangleIndices {
            indices,
            mode: primitive.mode,
            vertices,
            count,
        })
    }

    fn collect(&self) -> Result<Vec<[u32; 3]>, String> {
        let corner = |step: usize| match self.indices {
            Some(indices) => indices.index(step),
            None => step as u32,
        };
        let mut corners = Vec::with_capacity(self.count);
        for k in 0..self.count {
            let steps = match self.mode {
                TRIANGLES => [3 * k, 3 * k + 1, 3 * k + 2],
                // Every other triangle of a strip runs the other way round.
                STRIP => [k, k + 1 + k % 2, k + 2 - k % 2],
                _ => [k + 1, k + 2, 0],
            };
            corners.push(steps.map(corner));
        }
        let outside = |&&corner: &&u32| corner as usize >= self.vertices;
        match corners.iter().flatten().find(outside) {
            Some(corner) => Err(format!(
                "its index {corner} is not below its {} vertices",
                self.vertices
            )),
            None => Ok(corners),
        }
    }
}

/// A mesh while its vertices are renumbered in the order in which triangles use them.
struct Placing<'s> {
    shape: &'s PrimitiveGeometry<'s>,
    map: &'s DAffine3,
    /// Map of normals: the inverse transpose, up to a positive factor.
    turn: DMat3,
    mirrored: bool,
    numbers: VertexRenumbering,
    mesh: Mesh,
    /// Number of normals that are unusable in the file already; the map may spoil more of them.
    nothing_said: usize,
    /// Vertices without a usable normal; `bad_uvs` are those without a usable UV.
    bad_normals: Vec<u32>,
    bad_uvs: Vec<u32>,
}

/// New numbers of vertices by their old ones: a table if most are used, a map if few are.
enum VertexRenumbering {
    Table(Vec<u32>),
    Map(HashMap<u32, u32>),
}

impl VertexRenumbering {
    fn slot(&mut self, old: u32) -> &mut u32 {
        match self {
            VertexRenumbering::Table(table) => &mut table[old as usize],
            VertexRenumbering::Map(map) => map.entry(old).or_insert(u32::MAX),
        }
    }
}

impl<'s> Placing<'s> {
    fn new(shape: &'s PrimitiveGeometry<'s>, map: &'s DAffine3) -> Self {
        let m = map.matrix3;
        let mirrored = m.determinant() < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        let cofactors = DMat3::from_cols(
            m.y_axis.cross(m.z_axis),
            m.z_axis.cross(m.x_axis),
            m.x_axis.cross(m.y_axis),
        );
        let (vertices, corners) = (shape.positions.count, 3 * shape.corners.len());
        Placing {
            shape,
            map,
            turn: cofactors * sign,
            mirrored,
            // The table's size is at most a few times what is read anyway.
            numbers: match vertices <= 4 * corners {
                true => VertexRenumbering::Table(vec![u32::MAX; vertices]),
                false => VertexRenumbering::Map(HashMap::new()),
            },
            mesh: Mesh::default(),
            nothing_said: 0,
            bad_normals: Vec::new(),
            bad_uvs: Vec::new(),
        }
    }

    /// The new number of a vertex, which is appended at its first use.
    fn number(&mut self, old: u32) -> Result<u32, String> {
        let new = self.mesh.vertices.len() as u32;
        let slot = self.numbers.slot(old);
        if *slot != u32::MAX {
            return Ok(*slot);
        }
        *slot = new;
        let row = old as usize;
        let position = Vec3::from_array(self.shape.positions.get(row));
        let placed = self.map.transform_point3(position.as_dvec3()).as_vec3();
        if !placed.is_finite() {
            return Err(match position.is_finite() {
                true => format!("vertex {old} is beyond single precision where its nodes put it"),
                false => format!("vertex {old} is not finite, and a triangle uses it"),
            });
        }
        self.mesh.vertices.push(placed);
        if let Some(normals) = &self.shape.normals {
            let normal = unit(Vec3::from_array(normals.get(row)).as_dvec3());
            self.nothing_said += usize::from(normal == DVec3::ZERO);
            let turned = unit(self.turn * normal);
            if turned == DVec3::ZERO {
                self.bad_normals.push(new);
            }
            self.mesh.vertex_normals.push(turned.as_vec3());
        }
        if let Some((uvs, map)) = &self.shape.uvs {
            let mut uv = map.apply(uvs.get(row));
            if !uv.is_finite() {
                self.bad_uvs.push(new);
                uv = Vec2::ZERO;
            }
            self.mesh.vertex_uvs.push(uv);
        }
        Ok(new)
    }

    fn finish(self, corners: Vec<[u32; 3]>) -> Mesh {
        let without = |bad: &[u32], none: u32| -> Vec<[u32; 3]> {
            let rows = corners.iter();
            // New numbers were given in ascending order.
            let is_bad = |corner: &u32| bad.binary_search(corner).is_ok();
            rows.map(|row| {
                if row.iter().any(is_bad) {
                    [none; 3]
                } else {
                    *row
                }
            })
            .collect()
        };
        let mut mesh = self.mesh;
        if self.shape.normals.is_some() {
            mesh.normals = without(&self.bad_normals, NO_NORMALS).into();
        }
        if self.shape.uvs.is_some() {
            mesh.uvs = without(&self.bad_uvs, NO_UVS).into();
        }
        mesh.material = MeshMaterial::One(self.shape.material);
        mesh.corners = corners.into();
        mesh
    }
}

/// v/|v|, or zero for a vector without a direction.
fn unit(v: DVec3) -> DVec3 {
    let length = v.length();
    match length > 0.0 && length.is_finite() {
        true => v * (1.0 / length),
        false => DVec3::ZERO,
    }
}
