//! What a sample that halves a cell knows of the lights from the samples around it, and what it sees of them.

use glam::Vec3;
use phalanx_scene::sampling::{Cells, SIGHTS, Sight, trail};

/// The hits of a sample that others ask about.
pub(super) struct Sights<'c> {
    cells: &'c Cells,
    ask: usize,
    pub(super) all: [Sight; SIGHTS],
}

impl<'c> Sights<'c> {
    /// Of a sample that is asked for.
    pub(super) fn of(cells: &'c Cells, ask: usize) -> Sights<'c> {
        Sights {
            cells,
            ask,
            all: Default::default(),
        }
    }

    /// Where its camera ray will hit.
    pub(super) fn watch(&mut self) -> Watch<'_, 'c> {
        Watch {
            sights: self,
            sight: 0,
            trail: 0,
            known: (0, 0),
        }
    }
}

/// One of them.
pub(super) struct Watch<'s, 'c> {
    sights: &'s mut Sights<'c>,
    sight: usize,
    /// To the hit before, and from [`Watch::met`] on to this one.
    trail: u32,
    known: (u32, u32),
}

impl<'c> Watch<'_, 'c> {
    /// Tells what was hit.
    pub(super) fn met(&mut self, prim_id: u32) {
        self.trail = trail(self.trail, self.sight, prim_id);
        let Sights { cells, ask, all } = &mut *self.sights;
        self.known = cells.known(*ask, self.sight, self.trail);
        all[self.sight].trail = self.trail;
    }

    /// Whether a light that would add `radiance` is seen from there, if that is known.
    pub(super) fn knows(&self, light: usize, radiance: Vec3) -> Option<bool> {
        let (known, seen) = self.known;
        let bit = Sight::bit(light);
        let Sights { cells, ask, .. } = &*self.sights;
        let known = known & bit != 0 && cells.may_believe(*ask, radiance.to_array());
        known.then_some(seen & bit != 0)
    }

    /// Tells whether a light that was asked for is seen.
    pub(super) fn saw(&mut self, light: usize, seen: bool) {
        let sight = &mut self.sights.all[self.sight];
        sight.asked |= Sight::bit(light);
        sight.seen |= if seen { Sight::bit(light) } else { 0 };
    }

    /// Where the mirror ray, or else the refracted ray, of a camera ray's hit will hit.
    pub(super) fn onward(&mut self, mirror: bool) -> Option<Watch<'_, 'c>> {
        let onward = Watch {
            sights: self.sights,
            sight: if mirror { 1 } else { 2 },
            trail: self.trail,
            known: (0, 0),
        };
        (self.sight == 0).then_some(onward)
    }
}
