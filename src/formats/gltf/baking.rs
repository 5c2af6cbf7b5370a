//! Primitives of one mesh or several, baked on several threads: large ones one after another, each
//! by all threads, and small ones side by side.

use super::bake::BadAttributes;
use super::geometry::PrimitiveGeometry;
use super::skins::JointMaps;
use crate::origin::Origin;
use crate::text::workers;
use glam::DAffine3;
use phalanx_scene::Mesh;
use std::sync::Arc;

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
