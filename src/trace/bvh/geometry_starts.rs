//! Mapping from a primitive to the geometry that it was added with.

use crate::simd::{LaneMask, LaneU32, U32x8};
use phalanx_scene::{GeomId, NO_GEOM, NO_PRIM, Scene};

/// A tree's geometries by their first `prim_id`, ascending; the last entry begins beyond all
/// primitives.
#[derive(Clone, Debug, Default)]
pub(crate) struct GeometryStarts {
    starts: Vec<(u32, GeomId)>,
    /// Masks by the geometries' numbers.
    masks: Vec<u32>,
    /// First primitives in the same way; [`NO_PRIM`] without any.
    firsts: Vec<u32>,
}

impl GeometryStarts {
    pub(super) fn of(scene: &Scene) -> GeometryStarts {
        let (starts, masks) = (scene.geometry_starts(), scene.geometries.mask.to_vec());
        let mut firsts = vec![NO_PRIM; masks.len()];
        for &(first, id) in &starts {
            if let Some(place) = firsts.get_mut(id as usize) {
                *place = first;
            }
        }
        GeometryStarts {
            starts,
            masks,
            firsts,
        }
    }

    /// The mask of a geometry; all bits for [`NO_GEOM`].
    #[inline]
    pub(crate) fn mask(&self, geometry: GeomId) -> u32 {
        self.masks
            .get(geometry as usize)
            .copied()
            .unwrap_or(u32::MAX)
    }

    /// The first primitive of a geometry.
    pub(crate) fn first_prim(&self, geometry: GeomId) -> Option<u32> {
        let first = self.firsts.get(geometry as usize).copied();
        first.filter(|&first| first != NO_PRIM)
    }

    /// The geometry of a primitive, or [`NO_GEOM`].
    #[inline(always)]
    pub(crate) fn find(&self, prim_id: u32) -> GeomId {
        self.run_of(prim_id).geometry
    }

    /// The geometries of eight primitives, some of which may be [`NO_PRIM`]; `run` is the run found
    /// last, which is tried first.
    #[inline(always)]
    pub(crate) fn find_eight(&self, prim_id: U32x8, run: &mut GeometryRun) -> U32x8 {
        let none = prim_id.eq(U32x8::splat(NO_PRIM));
        let within = !prim_id.lt(U32x8::splat(run.first)) & prim_id.lt(U32x8::splat(run.end));
        if (none | within).bits() == 0xff {
            return none.select_u32(U32x8::splat(NO_GEOM), U32x8::splat(run.geometry));
        }
        self.find_each(prim_id, run)
    }

    #[inline(never)]
    fn find_each(&self, prim_id: U32x8, run: &mut GeometryRun) -> U32x8 {
        U32x8::new(prim_id.to_array().map(|prim_id| {
            if prim_id == NO_PRIM {
                return NO_GEOM;
            }
            if prim_id < run.first || prim_id >= run.end {
                *run = self.run_of(prim_id);
            }
            run.geometry
        }))
    }

    /// The run that contains a primitive.
    pub(crate) fn run_of(&self, prim_id: u32) -> GeometryRun {
        let after = self.starts.partition_point(|&(first, _)| first <= prim_id);
        let end = self.starts.get(after).map_or(u32::MAX, |&(first, _)| first);
        let (first, geometry) = match after {
            0 => (0, NO_GEOM),
            _ => self.starts[after - 1],
        };
        GeometryRun {
            first,
            end,
            geometry,
        }
    }
}

/// Primitives from `first` up to, but not including, `end`, which were added together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GeometryRun {
    first: u32,
    end: u32,
    geometry: GeomId,
}
