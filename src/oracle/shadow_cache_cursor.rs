//! Visibility of the lights for a sample that splits a cell: known results from the samples around
//! it, and its own results.

use glam::Vec3;
use phalanx_scene::sampling::{BounceKind, Cells, LightVisibility, MAX_HITS, path_id};

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
            sample: Some(self),
            ..ShadowCacheCursor::NONE
        }
    }
}

/// A cursor at one hit of a sample.
pub(super) struct ShadowCacheCursor<'s, 'c> {
    /// The sample; `None` if nothing is reused or stored.
    sample: Option<&'s mut SampleVisibility<'c>>,
    hit: usize,
    /// Path to the hit before, and from [`ShadowCacheCursor::begin_hit`] on to this one.
    path_id: u32,
    /// As bits: the lights whose visibility is known at the hit, and those of them that are
    /// visible.
    known: (u32, u32),
}

impl<'s, 'c> ShadowCacheCursor<'s, 'c> {
    /// The cursor of a hit where every shadow ray is traced.
    pub(super) const NONE: ShadowCacheCursor<'s, 'c> = ShadowCacheCursor {
        sample: None,
        hit: 0,
        path_id: 0,
        known: (0, 0),
    };

    /// Sets the primitive of the hit.
    pub(super) fn begin_hit(&mut self, prim_id: u32) {
        let Some(sample) = &mut self.sample else {
            return;
        };
        self.path_id = path_id(self.path_id, self.hit, prim_id);
        self.known = (sample.cells).known_lights(sample.request, self.hit, self.path_id);
        sample.visibility[self.hit].path_id = self.path_id;
    }

    /// Returns true if a light that would contribute `radiance` is visible from the hit: from the
    /// cache if it may be reused, otherwise from `trace`. Stores the result.
    pub(super) fn is_visible(
        &mut self,
        light: usize,
        radiance: Vec3,
        trace: impl FnOnce() -> bool,
    ) -> bool {
        let Some(sample) = &mut self.sample else {
            return trace();
        };
        let bit = LightVisibility::bit(light);
        let (known, seen) = self.known;
        let reused =
            known & bit != 0 && (sample.cells).may_reuse(sample.request, radiance.to_array());
        let visible = if reused { seen & bit != 0 } else { trace() };
        let at_hit = &mut sample.visibility[self.hit];
        at_hit.queried |= bit;
        at_hit.visible |= if visible { bit } else { 0 };
        visible
    }

    /// A cursor at the hit of a bounce from a camera ray's hit. Later hits share nothing.
    pub(super) fn child(&mut self, bounce: BounceKind) -> ShadowCacheCursor<'_, 'c> {
        let hit = match bounce {
            BounceKind::Mirror => 1,
            BounceKind::Refracted => 2,
            // Nothing is stored behind a partly transparent surface.
            BounceKind::Passed => return ShadowCacheCursor::NONE,
        };
        ShadowCacheCursor {
            sample: self.sample.as_deref_mut().filter(|_| self.hit == 0),
            hit,
            path_id: self.path_id,
            known: (0, 0),
        }
    }
}
