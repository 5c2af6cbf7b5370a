//! Primitives under a map, or moved by joints: columns of a mesh, with only the vertices that its
//! triangles use.

use super::geometry::PrimitiveGeometry;
use super::skins::Influences;
use crate::chunk_remarks::counted;
use crate::mesh::is_in_reach;
use crate::origin::Origin;
use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use phalanx_scene::{Mesh, MeshMaterial, NO_COLORS, NO_NORMALS, NO_TANGENTS, NO_UVS};
use std::collections::HashMap;

/// Vertices of a mesh that cannot be used as the file has them.
#[derive(Clone, Copy, Default)]
pub(super) struct BadAttributes {
    pub(super) normals: usize,
    /// Triangles with a vertex that is not finite, or out of reach.
    pub(super) triangles: usize,
    pub(super) uvs: usize,
    pub(super) colors: usize,
    /// Vertices that follow a joint which the skin does not have.
    pub(super) joints: usize,
    /// True if positions that are single precision in the file were rounded.
    pub(super) inexact: bool,
}

impl BadAttributes {
    /// Adds those of another primitive.
    pub(super) fn add(&mut self, other: BadAttributes) {
        self.normals += other.normals;
        self.triangles += other.triangles;
        self.uvs += other.uvs;
        self.colors += other.colors;
        self.joints += other.joints;
        self.inexact |= other.inexact;
    }

    /// Warnings of them.
    pub(super) fn messages(&self) -> Vec<String> {
        let kinds = [
            (
                self.triangles,
                "one triangle is left out: a vertex is not finite or beyond 1e20",
                "triangles are left out: vertices are not finite or beyond 1e20",
            ),
            (
                self.normals,
                "one normal is zero or not finite: faces that use it are shaded flat",
                "normals are zero or not finite: faces that use them are shaded flat",
            ),
            (
                self.uvs,
                "one texture place is not finite: faces that use it have no texture",
                "texture places are not finite: faces that use them have no texture",
            ),
            (
                self.colors,
                "one vertex colour is no number: faces that use it have the material's",
                "vertex colours are no numbers: faces that use them have the material's",
            ),
            (
                self.joints,
                "one vertex follows a joint that its skin does not have",
                "vertices follow joints that their skin does not have",
            ),
        ];
        let there = kinds.iter().filter(|(count, ..)| *count > 0);
        let messages = there.map(|&(count, one, several)| counted(count, one, several));
        messages.collect()
    }
}

impl PrimitiveGeometry<'_> {
    /// The triangles under a map, with only the vertices that they use. A map that mirrors reverses
    /// their order of corners, so that front faces stay front faces. Vertices that follow joints do
    /// so instead of the map.
    ///
    /// If the map does nothing but subtract the scene's origin, positions must still be single
    /// precision after it.
    pub(super) fn mesh(
        &self,
        map: &DAffine3,
        joints: Option<&[DAffine3]>,
        origin: Origin,
    ) -> (Mesh, BadAttributes) {
        let mut out = Baking::new(self, map, joints);
        let taken = DAffine3::from_translation(-origin.position());
        let as_it_stands = origin.offset().is_some() && *map == taken && self.vertices.is_unmoved();
        let mut corners = Vec::with_capacity(self.corners.len());
        for &[a, b, c] in &self.corners {
            let row = match out.mirrored {
                true => [a, c, b],
                false => [a, b, c],
            };
            match row.map(|corner| out.number(corner)) {
                [Some(a), Some(b), Some(c)] => corners.push([a, b, c]),
                _ => out.bad.triangles += 1,
            }
        }
        let bad = BadAttributes {
            inexact: as_it_stands && !self.is_exact_at(origin.position()),
            uvs: out.bad_uvs.len(),
            colors: out.bad_colors.len(),
            ..out.bad
        };
        (out.finish(corners), bad)
    }
}

/// A map of vertices and the one of their normals.
#[derive(Clone, Copy)]
struct VertexMap {
    position: DAffine3,
    /// The inverse transpose, up to a positive factor.
    normal: DMat3,
    mirrored: bool,
}

impl VertexMap {
    fn of(position: DAffine3) -> VertexMap {
        let m = position.matrix3;
        let mirrored = m.determinant() < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        let cofactors = DMat3::from_cols(
            m.y_axis.cross(m.z_axis),
            m.z_axis.cross(m.x_axis),
            m.x_axis.cross(m.y_axis),
        );
        VertexMap {
            position,
            normal: cofactors * sign,
            mirrored,
        }
    }
}

/// A mesh that is baked. Its vertices are renumbered in the order in which triangles use them.
struct Baking<'s> {
    shape: &'s PrimitiveGeometry<'s>,
    map: VertexMap,
    /// Joints that move each vertex instead of the map.
    skin: Option<(&'s Influences<'s>, &'s [DAffine3])>,
    mirrored: bool,
    numbers: VertexRenumbering,
    mesh: Mesh,
    /// Normals that are unusable in the file already, as the map may spoil more of them, and
    /// vertices of absent joints.
    bad: BadAttributes,
    /// Vertices without a usable normal, UV or colour.
    bad_normals: Vec<u32>,
    bad_uvs: Vec<u32>,
    bad_tangents: Vec<u32>,
    bad_colors: Vec<u32>,
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

impl<'s> Baking<'s> {
    fn new(
        shape: &'s PrimitiveGeometry<'s>,
        map: &DAffine3,
        joints: Option<&'s [DAffine3]>,
    ) -> Self {
        let skin = shape.vertices.influences().zip(joints);
        let map = VertexMap::of(*map);
        // A skeleton mirrors all of a mesh, or none of it.
        let mirrored = match (skin, shape.corners.first()) {
            (Some((influences, joints)), Some(&[first, ..])) => {
                let (map, _) = influences.map(first as usize, joints);
                VertexMap::of(map).mirrored
            }
            _ => map.mirrored,
        };
        let (vertices, corners) = (shape.vertices.count, 3 * shape.corners.len());
        Baking {
            shape,
            map,
            skin,
            mirrored,
            // The table's size is at most a few times what is read anyway.
            numbers: match vertices <= 4 * corners {
                true => VertexRenumbering::Table(vec![u32::MAX; vertices]),
                false => VertexRenumbering::Map(HashMap::new()),
            },
            mesh: Mesh::default(),
            bad: BadAttributes::default(),
            bad_normals: Vec::new(),
            bad_uvs: Vec::new(),
            bad_tangents: Vec::new(),
            bad_colors: Vec::new(),
        }
    }

    /// The new number of a vertex, which is appended at its first use. `None` if it is not finite
    /// or out of reach.
    fn number(&mut self, old: u32) -> Option<u32> {
        let new = self.mesh.vertices.len() as u32;
        let slot = self.numbers.slot(old);
        if *slot != u32::MAX {
            return Some(*slot);
        }
        let row = old as usize;
        let map = match self.skin {
            Some((influences, joints)) => {
                let (map, complete) = influences.map(row, joints);
                self.bad.joints += usize::from(!complete);
                VertexMap::of(map)
            }
            None => self.map,
        };
        let position = self.shape.vertices.position(row);
        let placed = map.position.transform_point3(position).as_vec3();
        if !is_in_reach(placed.to_array()) {
            return None;
        }
        *self.numbers.slot(old) = new;
        self.mesh.vertices.push(placed);
        self.add_attributes(row, new, &map);
        Some(new)
    }

    fn add_attributes(&mut self, row: usize, new: u32, map: &VertexMap) {
        let vertices = &self.shape.vertices;
        if let Some(normal) = vertices.normal(row) {
            let normal = unit(normal);
            self.bad.normals += usize::from(normal == DVec3::ZERO);
            let turned = unit(map.normal * normal);
            if turned == DVec3::ZERO {
                self.bad_normals.push(new);
            }
            self.mesh.vertex_normals.push(turned.as_vec3());
        }
        for mut uv in vertices.uvs(row) {
            if !uv.is_finite() {
                if self.bad_uvs.last() != Some(&new) {
                    self.bad_uvs.push(new);
                }
                uv = Vec2::ZERO;
            }
            self.mesh.vertex_uvs.push(uv);
        }
        if let Some((tangent, sign)) = vertices.tangent(row) {
            let turned = unit(map.position.matrix3 * unit(tangent));
            if turned == DVec3::ZERO || !sign.is_finite() {
                self.bad_tangents.push(new);
            }
            self.mesh.vertex_tangents.push(turned.as_vec3());
            let upright = (sign >= 0.0) != map.mirrored;
            self.mesh
                .bitangent_signs
                .push(if upright { 1.0 } else { -1.0 });
        }
        if let Some(mut color) = vertices.color(row) {
            if color.iter().any(|share| share.is_nan()) {
                self.bad_colors.push(new);
                color = [1.0; 4];
            }
            let [r, g, b, opacity] = color;
            self.mesh.vertex_colors.push(Vec3::new(r, g, b));
            if vertices.attributes().opacity {
                self.mesh.vertex_opacity.push(opacity);
            }
        }
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
        let has = self.shape.vertices.attributes();
        if has.normals {
            mesh.normals = without(&self.bad_normals, NO_NORMALS).into();
        }
        if has.uvs > 0 {
            let first_of_layers = |row: [u32; 3]| match row {
                [NO_UVS, ..] => row,
                row => row.map(|vertex| vertex * has.uvs as u32),
            };
            let rows = without(&self.bad_uvs, NO_UVS).into_iter();
            mesh.uvs = rows.map(first_of_layers).collect();
        }
        if has.tangents {
            mesh.tangents = without(&self.bad_tangents, NO_TANGENTS).into();
        }
        if is_white(&mesh) {
            mesh.vertex_colors = Default::default();
            mesh.vertex_opacity = Default::default();
        } else if has.colors {
            mesh.colors = without(&self.bad_colors, NO_COLORS).into();
        }
        mesh.material = MeshMaterial::One(self.shape.material);
        mesh.corners = corners.into();
        mesh
    }
}

/// Returns true if colours have no effect: some exporters write white for every mesh.
fn is_white(mesh: &Mesh) -> bool {
    let [r, g, b] = mesh.vertex_colors.parts();
    let columns = [r, g, b, &mesh.vertex_opacity];
    columns
        .into_iter()
        .flat_map(|column| column.iter())
        .all(|&share| share == 1.0)
}

/// v/|v|, or zero for a vector without a direction.
fn unit(v: DVec3) -> DVec3 {
    let length = v.length();
    match length > 0.0 && length.is_finite() {
        true => v * (1.0 / length),
        false => DVec3::ZERO,
    }
}
