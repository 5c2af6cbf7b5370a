//! Primitives of one mesh or several, baked on several threads: large ones one after another, each
//! by all threads, and small ones side by side.

use super::bake::BadAttributes;
use super::geometry::PrimitiveGeometry;
use super::skins::JointMaps;
use crate::origin::Origin;
use crate::workers;
use glam::DAffine3;
use phalanx_scene::Mesh;

/// Shapes of a mesh that one node shows.
pub(super) struct BakedMesh<'a> {
    pub(super) mesh: usize,
    pub(super) shapes: Vec<PrimitiveGeometry<'a>>,
    /// Number of the object's name.
    pub(super) name: u32,
    pub(super) map: DAffine3,
    pub(super) joints: Option<JointMaps>,
}

/// A primitive to be baked.
pub(super) struct BakeJob<'s> {
    pub(super) shape: &'s PrimitiveGeometry<'s>,
    pub(super) map: &'s DAffine3,
    pub(super) joints: Option<&'s [DAffine3]>,
}

/// Number of triangles from which on several threads bake a primitive, and of those that a thread
/// bakes before the results are taken.
const SHARE: usize = 1 << 16;

/// Bakes primitives, and calls `take` with the index of each and its columns, in their order.
pub(super) fn bake_all(
    jobs: &[BakeJob],
    origin: Origin,
    threads: usize,
    mut take: impl FnMut(usize, Mesh, BadAttributes),
) {
    let mut first = 0;
    while first < jobs.len() {
        let group = &jobs[first..first + group_length(&jobs[first..], threads)];
        let inner = if group.len() > 1 { 1 } else { threads };
        let bake = |job: &BakeJob| job.shape.mesh(job.map, job.joints, origin, inner);
        let baked = workers::map(threads, group.iter().collect(), bake);
        for (index, (mesh, bad)) in (first..).zip(baked) {
            take(index, mesh, bad);
        }
        first += group.len();
    }
}

/// Number of primitives that are baked at once.
fn group_length(jobs: &[BakeJob], threads: usize) -> usize {
    let mut triangles = 0;
    let is_small = |job: &&BakeJob| {
        triangles += job.shape.len();
        job.shape.len() <= SHARE && triangles <= threads * SHARE
    };
    jobs.iter().take_while(is_small).count().max(1)
}
