//! Dimensions shared by the parts of the street.

/// Seed of all random numbers.
pub(super) const SEED: u64 = 0x57ee_7000;
/// Half the width of the lane, from wall to wall.
pub(super) const HALF: f64 = 3.6;
/// The z coordinate where the first houses begin, toward the eye.
pub(super) const START: f64 = 7.0;

/// Height of the ground floor, then of the floors above.
pub(super) const GROUND: f64 = 3.4;
pub(super) const FLOOR: f64 = 3.05;
/// Depth of windows in the wall.
pub(super) const REVEAL: f64 = 0.2;

/// A rectangle of the facade: left, bottom, right, top.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub(super) x0: f64,
    pub(super) y0: f64,
    pub(super) x1: f64,
    pub(super) y1: f64,
}

impl Area {
    pub(super) const fn new(x0: f64, y0: f64, x1: f64, y1: f64) -> Area {
        Area { x0, y0, x1, y1 }
    }
}
