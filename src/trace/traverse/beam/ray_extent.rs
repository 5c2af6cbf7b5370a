//! Projections of rays, and the rectangle around all of them.

use super::projection::{BeamSpace, BoxView, MAX_RECT};
use crate::intersect::shear::Shear;
use crate::packet::RayPacket;
use crate::simd::{LaneMask, Lanes, Native};

/// Smallest depth of a direction along the beam, as a share of its length. Smaller ones have no
/// projection: 2⁻⁵⁰.
pub(super) const MIN_DEPTH_PER_T: f32 = 1.0 / ((1u64 << 50) as f32);

/// Boxes that overlap a rectangle.
#[inline(always)]
pub(super) fn meets(seen: &BoxView, around: &[[f32; 2]; 2]) -> u32 {
    let [p, q] = around.map(|range| range.map(Native::splat));
    let p = seen.low_p.le(p[1]) & seen.high_p.ge(p[0]);
    let q = seen.low_q.le(q[1]) & seen.high_q.ge(q[0]);
    (seen.ahead & p & q).bits()
}

/// Bounds of all rays of a beam, lane by lane, in a near frame.
pub(super) struct Extent<L> {
    low: [L; 2],
    high: [L; 2],
    /// Smallest depth of any ray per unit of distance.
    depth_per_t: L,
}

impl<L: Lanes> Extent<L> {
    pub(super) fn none() -> Extent<L> {
        let far = L::splat(f32::INFINITY);
        Extent {
            low: [far; 2],
            high: [-far; 2],
            depth_per_t: far,
        }
    }

    /// Adds the active lanes of a packet.
    #[inline(always)]
    pub(super) fn add(&mut self, [depth_per_t, p, q]: [L; 3], active: L::Mask) {
        for (axis, x) in [p, q].into_iter().enumerate() {
            // A NaN is lost here; such a ray hits nothing anyway.
            let (low, high) = (self.low[axis], self.high[axis]);
            self.low[axis] = active.select(low.min(x), low);
            self.high[axis] = active.select(high.max(x), high);
        }
        self.depth_per_t = active.select(self.depth_per_t.min(depth_per_t), self.depth_per_t);
    }

    /// Returns true if certainly no ray hits any of the given boxes.
    #[inline(always)]
    pub(super) fn misses(&self, space: &BeamSpace, seen: &BoxView) -> bool {
        let end = L::splat(MAX_RECT);
        let within = |axis: usize| self.low[axis].gt(-end) & self.high[axis].lt(end);
        let usual = within(0) & within(1) & self.depth_per_t.ge(L::splat(MIN_DEPTH_PER_T));
        // The extremes over all lanes are computed before widening, because those of lanes without
        // a ray are infinite.
        let [wider, share] = space.rect_epsilon;
        let around = [0, 1].map(|axis| {
            let (low, high) = (self.low[axis].min_element(), self.high[axis].max_element());
            let more = wider + low.abs().max(high.abs()) * share;
            [low - more, high + more]
        });
        !(!usual).any() && meets(seen, &around) == 0
    }
}

/// Projections of rays. Near: the direction along the beam's dominant axis, and over that the
/// directions along p and q. Rays that end at the apex are followed backward. Local: the depth at
/// which rays start, and their positions.
#[inline(always)]
pub(super) fn directions<L: Lanes>(space: &BeamSpace, rays: &RayPacket<L>) -> [L; 3] {
    if !space.near {
        return space.starts(rays);
    }
    let [forward, p, q] = rays.dir.from_axis(space.axes[0]);
    let along = L::splat(space.sign);
    // Going backward changes the sign of both parts of a quotient.
    let factor = along / forward;
    [
        forward * L::splat(space.depth_per_t()),
        p * factor,
        q * factor,
    ]
}

/// Projections of rays as by [`directions`], from the known frame of the rays. Its slopes are p and
/// q, if its axis is the beam's.
#[inline(always)]
pub(super) fn directions_by<L: Lanes>(
    space: &BeamSpace,
    rays: &RayPacket<L>,
    shear: &Shear<L>,
) -> [L; 3] {
    let axis = space.axes[0] % 3;
    if !space.near || shear.axis != axis {
        return directions(space, rays);
    }
    let [forward, _, _] = rays.dir.from_axis(axis);
    let [p, q, ..] = shear.slopes();
    let along = L::splat(space.sign);
    [
        forward * L::splat(space.depth_per_t()),
        p * along,
        q * along,
    ]
}
