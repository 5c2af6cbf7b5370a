//! What a sample that halves a cell knows of the lights from the samples around it, and what it
//! sees of them.

use glam::Vec3;
use phalanx_scene::sampling::{Cells, LightVisibility, MAX_HITS, path_id};

/// The hits of a sample that others ask about.
pub(super) struct SampleVisibility<'c> {
    cells: &'c Cells,
    request: usize,
    pub(super) visibility: [LightVisibility; MAX_HITS],
}

impl<'c> SampleVisibility<'c> {
    /// Of a sample that is asked for.
    pub(super) fn of(cells: &'c Cells, ask: usize) -> SampleVisibility<'c> {
        SampleVisibility {
            cells,
            request: ask,
            visibility: Default::default(),
        }
    }

    /// Where its camera ray will hit.
    pub(super) fn cursor(&mut self) -> ShadowCacheCursor<'_, 'c> {
        ShadowCacheCursor {
            sample: self,
            hit: 0,
            path_id: 0,
            known: (0, 0),
        }
    }
}

/// One of them.
pub(super) struct ShadowCacheCursor<'s, 'c> {
    sample: &'s mut SampleVisibility<'c>,
    hit: usize,
    /// To the hit before, and from [`ShadowCacheCursor::begin_hit`] on to this one.
    path_id: u32,
    known: (u32, u32),
}

impl<'c> ShadowCacheCursor<'_, 'c> {
    /// Tells what was hit.
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

    /// Whether a light that would add `radiance` is seen from there, if that is known.
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

    /// Tells whether a light that was asked for is seen.
    pub(super) fn record_visible(&mut self, light: usize, seen: bool) {
        let hit_index = &mut self.sample.visibility[self.hit];
        hit_index.queried |= LightVisibility::bit(light);
        hit_index.visible |= if seen { LightVisibility::bit(light) } else { 0 };
    }

    /// Where the mirror ray, or else the refracted ray, of a camera ray's hit will hit.
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
