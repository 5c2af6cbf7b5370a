//! From the number of a primitive to that of the geometry it was added with.

use phalanx_scene::{GeomId, NO_GEOM, Scene};

/// Geometries of a tree by the first `prim_id` of each, ascending; the last entry begins beyond all
/// primitives.
#[derive(Clone, Debug, Default)]
pub(crate) struct GeometryStarts(Vec<(u32, GeomId)>);

impl GeometryStarts {
    pub(crate) fn of(scene: &Scene) -> GeometryStarts {
        GeometryStarts(scene.geometry_starts())
    }

    /// The first primitive of a geometry.
    pub(super) fn first_prim(&self, geometry: GeomId) -> Option<u32> {
        let known = |&&(_, id): &&(u32, GeomId)| id == geometry && id != NO_GEOM;
        self.0.iter().find(known).map(|&(first, _)| first)
    }

    /// The geometry of a primitive, or [`NO_GEOM`]; `near` is where to look first, the entry that
    /// was found last.
    #[inline]
    pub(super) fn find(&self, prim_id: u32, near: &mut usize) -> GeomId {
        let from = |k: usize| self.0.get(k).map_or(u32::MAX, |&(first, _)| first);
        let here = from(*near) <= prim_id && prim_id < from(*near + 1);
        if !here {
            let after = self.0.partition_point(|&(first, _)| first <= prim_id);
            *near = after.saturating_sub(1);
        }
        self.0.get(*near).map_or(NO_GEOM, |&(_, id)| id)
    }
}
