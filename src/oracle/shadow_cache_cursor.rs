//! Visibility of the lights for a sample that halves a cell: known results from the samples around
//! it, and its own results.

use glam::Vec3;
use phalanx_scene::sampling::{Cells, LightVisibility, MAX_HITS, path_id};

/// The visibility of the lights at the hits of a sample, stored for other samples.
pub(super) struct SampleVisibility<'c> {
    cells: &'c Cells,
    request: usize,
    pub(super) visibility: [LightVisibility; MAX_HITS],
}

impl<'c> SampleVisibility<'c> {
    /// An empty record for a requested sample.
    pub(super) fn of(cells: &'c Cells, ask: usize) -> SampleVisibility<'c> {
        SampleVisibility {
            cells,
            request: ask,
            visibility: Default::default(),
        }
    }

    /// A cursor at the camera ray's hit.
    pub(super) fn cursor(&mut self) -> ShadowCacheCursor<'_, 'c> {
        ShadowCacheCursor {
            sample: self,
            hit: 0,
            path_id: 0,
            known: (0, 0),
        }
    }
}

/// A cursor at one hit of a sample.
pub(super) struct ShadowCacheCursor<'s, 'c> {
    sample: &'s mut SampleVisibility<'c>,
    hit: usize,
    /// Path to the hit before, and from [`ShadowCacheCursor::begin_hit`] on to this one.
    path_id: u32,
    known: (u32, u32),
}

impl<'c> ShadowCacheCursor<'_, 'c> {
    /// Sets the primitive of the hit.
    pub(super) fn begin_hit(&mut self, prim_id: u32) {
        self.path_id = path_id(self.path_id, self.hit, prim_id);
        let SampleVisibility {
            cells,
            request: ask,
            visibility: all,
        } = &mut *self.sample;
        self.known = cells.known_lights(*ask, self.hit, self.path_id);
        all[self.hit].path_id = self.path_id;
    }

    /// Returns whether a light that would contribute `radiance` is visible from the hit, if that is
    /// known.
    pub(super) fn known_visibility(&self, light: usize, radiance: Vec3) -> Option<bool> {
        let (known, seen) = self.known;
        let bit = LightVisibility::bit(light);
        let SampleVisibility {
            cells,
            request: ask,
            ..
        } = &*self.sample;
        let known = known & bit != 0 && cells.may_reuse(*ask, radiance.to_array());
        known.then_some(seen & bit != 0)
    }

    /// Stores whether a queried light is visible.
    pub(super) fn record_visible(&mut self, light: usize, seen: bool) {
        let hit_index = &mut self.sample.visibility[self.hit];
        hit_index.queried |= LightVisibility::bit(light);
        hit_index.visible |= if seen { LightVisibility::bit(light) } else { 0 };
    }

    /// A cursor at the hit of the mirror ray, or else of the refracted ray, that a camera ray's hit
    /// sends on.
    pub(super) fn child(&mut self, mirror: bool) -> Option<ShadowCacheCursor<'_, 'c>> {
        let onward = ShadowCacheCursor {
            sample: self.sample,
            hit: if mirror { 1 } else { 2 },
            path_id: self.path_id,
            known: (0, 0),
        };
        (self.hit == 0).then_some(onward)
    }
}
