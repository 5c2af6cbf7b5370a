//! Primitives under a map, or moved by joints: columns of a mesh, with only the vertices that its
//! triangles use; on several threads, large ones one after another, each by all threads, and small
//! ones side by side.

use super::geometry::{PrimitiveGeometry, Renumbered};
use super::skins::JointMaps;
use super::vertex_columns::{BadVertices, MovedVertices, VertexMap};
use crate::diagnostics::counted;
use crate::origin::Origin;
use crate::text::workers;
use glam::DAffine3;
use phalanx_scene::{Mesh, MeshMaterial, NO_INDEX};
use std::sync::Arc;

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
                "one normal is zero or not finite: faces that use it have none",
                "normals are zero or not finite: faces that use them have none",
            ),
            (
                self.uvs,
                "one texture coordinate is not finite: faces that use it have no texture",
                "texture coordinates are not finite: faces that use them have no texture",
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
        let present = kinds.iter().filter(|(count, ..)| *count > 0);
        let messages = present.map(|&(count, one, several)| counted(count, one, several));
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
        threads: usize,
    ) -> (Mesh, BadAttributes) {
        let moved = self.moved(map, joints);
        let taken = DAffine3::from_translation(-origin.position());
        let as_it_stands = origin.offset().is_some() && *map == taken && self.vertices.is_unmoved();
        let mirrored = self.is_mirrored(&moved);
        let mut numbered = self.renumbered(mirrored, &[]);
        let (mut mesh, mut bad) = moved.columns(&numbered.rows, threads);
        if !bad.lost.is_empty() {
            let lost = bad
                .lost
                .iter()
                .map(|&number| numbered.rows[number as usize]);
            numbered = self.renumbered(mirrored, &lost.collect::<Vec<u32>>());
            (mesh, bad) = moved.columns(&numbered.rows, threads);
        }
        let faults = BadAttributes {
            normals: bad.normals_of_file,
            triangles: self.len() - numbered.corners.len(),
            uvs: bad.uvs.len(),
            colors: bad.colors.len(),
            joints: bad.joints,
            inexact: as_it_stands && !self.is_exact_at(origin.position()),
        };
        self.add_triangles(&mut mesh, numbered.corners, &bad, threads);
        (mesh, faults)
    }

    fn moved<'s>(&'s self, map: &DAffine3, joints: Option<&'s [DAffine3]>) -> MovedVertices<'s> {
        MovedVertices {
            vertices: &self.vertices,
            map: VertexMap::of(*map),
            skin: self.vertices.influences().zip(joints),
        }
    }

    /// Returns true if triangles are turned inside out. A skeleton mirrors all of a mesh, or none
    /// of it.
    fn is_mirrored(&self, moved: &MovedVertices) -> bool {
        match (moved.skin, self.corners.first()) {
            (Some((influences, joints)), Some(&[first, ..])) => {
                let (map, _) = influences.map(first as usize, joints);
                VertexMap::of(map).mirrored
            }
            _ => moved.map.mirrored,
        }
    }

    /// Its triangles by the numbers of the vertices that they use, without those of `lost` rows.
    pub(super) fn renumbered(&self, mirrored: bool, lost: &[u32]) -> Renumbered {
        let triangles = self
            .corners
            .iter()
            .map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] });
        Renumbered::of(triangles, self.vertices.count, lost)
    }

    fn add_triangles(
        &self,
        mesh: &mut Mesh,
        corners: Vec<[u32; 3]>,
        bad: &BadVertices,
        threads: usize,
    ) {
        let has = self.vertices.attributes();
        let white = is_white(mesh);
        if white {
            mesh.vertex_colors = Default::default();
            mesh.vertex_opacity = Default::default();
        }
        let columns = vec![
            (has.normals, &bad.normals, 1),
            (has.uvs > 0, &bad.uvs, has.uvs as u32),
            (has.tangents, &bad.tangents, 1),
            (has.colors && !white, &bad.colors, 1),
        ];
        let rows = workers::map(threads, columns, |(is_present, bad, layers)| {
            if is_present { without(&corners, bad, layers) } else { Vec::new() }
        });
        let mut rows = rows.into_iter().map(Into::into);
        let mut next = || rows.next().unwrap_or_default();
        mesh.normals = next();
        mesh.uvs = next();
        mesh.tangents = next();
        mesh.colors = next();
        mesh.material = MeshMaterial::One(self.material);
        mesh.corners = corners.into();
    }
}

/// Rows of an attribute for triangles of these corners: [`NO_INDEX`] for those with a vertex whose
/// attribute is bad. A vertex has `layers` of the attribute, one after another.
fn without(corners: &[[u32; 3]], bad: &[u32], layers: u32) -> Vec<[u32; 3]> {
    if bad.is_empty() && layers == 1 {
        return corners.to_vec();
    }
    let is_bad = |corner: &u32| bad.binary_search(corner).is_ok();
    let rows = corners.iter().map(|row| {
        if row.iter().any(is_bad) {
            [NO_INDEX; 3]
        } else {
            row.map(|vertex| vertex * layers)
        }
    });
    rows.collect()
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

/// Shapes of a mesh that one node shows.
pub(super) struct BakedMesh<'a> {
    pub(super) mesh: usize,
    pub(super) shapes: Arc<[PrimitiveGeometry<'a>]>,
    /// Number of the object's name.
    pub(super) name: u32,
    pub(super) map: DAffine3,
    pub(super) joints: Option<JointMaps>,
}

/// Number of triangles from which on several threads bake a primitive, and of those that a thread
/// bakes before the results are taken.
const SHARE: usize = 1 << 16;

/// Bakes the primitives of meshes, and calls `take` in their order: with the index of the mesh, the
/// primitive, and its columns.
pub(super) fn bake_all(
    meshes: &[BakedMesh],
    origin: Origin,
    threads: usize,
    mut take: impl FnMut(usize, &PrimitiveGeometry, Mesh, BadAttributes),
) {
    let each = meshes.iter().enumerate();
    let jobs = each.flat_map(|(k, mesh)| mesh.shapes.iter().map(move |shape| (k, shape)));
    let jobs: Vec<(usize, &PrimitiveGeometry)> = jobs.collect();
    let mut rest = &jobs[..];
    while !rest.is_empty() {
        let (group, later) = rest.split_at(group_length(rest, threads));
        let inner = if group.len() > 1 { 1 } else { threads };
        let baked = workers::map(threads, group.to_vec(), |(k, shape)| {
            let BakedMesh { map, joints, .. } = &meshes[k];
            shape.mesh(map, joints.as_deref(), origin, inner)
        });
        for (&(k, shape), (mesh, bad)) in group.iter().zip(baked) {
            take(k, shape, mesh, bad);
        }
        rest = later;
    }
}

/// Number of primitives that are baked at once.
fn group_length(jobs: &[(usize, &PrimitiveGeometry)], threads: usize) -> usize {
    let mut triangles = 0;
    let is_small = |(_, shape): &&(usize, &PrimitiveGeometry)| {
        triangles += shape.len();
        shape.len() <= SHARE && triangles <= threads * SHARE
    };
    jobs.iter().take_while(is_small).count().max(1)
}
