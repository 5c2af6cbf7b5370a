//! Instances: rays are transformed into the space of a mesh, and their hits back into the world.
//!
//! Directions are transformed without being normalized again, so that distances along the ray are
//! the same inside and outside, except for rounding. The distance of a hit in the world is that t
//! *inside*, clamped to the ray's interval in the instance's own box, and hits are ordered by that
//! and prim_id. A ray that misses that box hits nothing of the instance. With the clamp, every box
//! around the instance's own is entered no later than the hit (see [`crate::traverse`]): no tree of
//! the world can lose it.
//!
//! The closest hit is searched by t inside, without a clamp for each candidate. That finds the same
//! hit unless it is clamped itself: then all others that are clamped to that end of the interval
//! tie with it, and the instance is searched again.
//!
//! No tree of the mesh can lose it either, if pruning inside accounts for the clamp. Let `best` be
//! the closest distance so far in the world. A hit inside at t beyond `best` is clamped to max(t,
//! `tnear`) or, beyond the interval, to `tfar`. So it cannot matter if `best` < `tfar`. Otherwise
//! everything inside may still matter.

use super::aabb::TInterval;
use super::hit::inactive_t;
use crate::bvh::leaf::LeafInstance;
use crate::packet::RayPacket;
use crate::simd::{LaneMask, Lanes, Vec3Lanes};

/// The rays in the space of the instance's mesh: (x·v.x + y·v.y) + z·v.z, plus the translation for
/// the origins.
#[inline(always)]
pub(crate) fn to_object<L: Lanes>(rays: &RayPacket<L>, slot: &LeafInstance) -> RayPacket<L> {
    let [x, y, z, shift] = slot.to_object.map(|c| Vec3Lanes::splat(c[0], c[1], c[2]));
    let turn = |v: Vec3Lanes<L>| (x.scale(v.x) + y.scale(v.y)) + z.scale(v.z);
    RayPacket {
        org: turn(rays.org) + shift,
        dir: turn(rays.dir),
        tmax: rays.tmax,
    }
}

/// Lanes whose ray crosses the instance's own box ahead of its origin.
#[inline(always)]
fn crosses<L: Lanes>(interval: &TInterval<L>) -> L::Mask {
    interval.tnear.le(interval.tfar) & interval.tfar.gt(L::ZERO)
}

/// Limit up to which hits inside may matter; −∞ in lanes in which none can. If hits count up to any
/// distance, the limit is finite, because a hit at the limit itself counts.
#[inline(always)]
pub(crate) fn closest_limit<L: Lanes>(best: L, interval: &TInterval<L>) -> L {
    let limit = best.lt(interval.tfar).select(best, L::splat(f32::MAX));
    let reaches = crosses(interval) & interval.tnear.le(best);
    reaches.select(limit, L::splat(f32::NEG_INFINITY))
}

/// Limit inside for a query whose distances are those in the world and are clamped hit by hit: up
/// to the end of the interval any may count.
#[inline(always)]
pub(crate) fn unclamped_limit<L: Lanes>(limit: L, interval: &TInterval<L>) -> L {
    let open = limit.lt(interval.tfar);
    let live = limit.gt(inactive_t());
    live.select(open.select(limit, L::splat(f32::MAX)), inactive_t())
}

/// The distance outside of a hit inside, and the lanes in which it counts.
#[inline(always)]
pub(crate) fn to_world<L: Lanes>(t: L, interval: &TInterval<L>) -> (L::Mask, L) {
    let clamped = t.max(interval.tnear).min(interval.tfar);
    (crosses(interval) & clamped.gt(L::ZERO), clamped)
}

/// The limit inside for "any hit before `tmax`": a hit that is clamped to `tfar` or `tnear` may
/// count at any t.
#[inline(always)]
pub(crate) fn any_hit_limit<L: Lanes>(tmax: L, interval: &TInterval<L>) -> L {
    let nowhere = L::splat(f32::NEG_INFINITY);
    let everywhere = L::splat(f32::INFINITY);
    let some = interval.tnear.lt(tmax).select(tmax, nowhere);
    let limit = interval.tfar.lt(tmax).select(everywhere, some);
    crosses(interval).select(limit, nowhere)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::F32x8;

    const INF: f32 = f32::INFINITY;

    fn interval(enter: f32, leave: f32) -> TInterval<F32x8> {
        TInterval {
            tnear: F32x8::splat(enter),
            tfar: F32x8::splat(leave),
        }
    }

    fn first(lanes: F32x8) -> f32 {
        lanes.to_array()[0]
    }

    #[test]
    fn hits_come_out_within_the_interval() {
        for (t, enter, leave, want) in [
            (3.0, 2.0, 4.0, Some(3.0)),
            (1.0, 2.0, 4.0, Some(2.0)),
            (9.0, 2.0, 4.0, Some(4.0)),
            // Interval behind the origin, or beside the box.
            (1.0, 0.0, -1.0, None),
            (1.0, 0.0, 0.0, None),
            (3.0, 4.0, 2.0, None),
        ] {
            let (counts, out) = to_world(F32x8::splat(t), &interval(enter, leave));
            let got = (counts.bits() == 0xff).then(|| first(out));
            assert_eq!(got, want, "{t} in {enter} to {leave}");
        }
    }

    /// Checks that a hit beyond the limit inside cannot win outside, and that a hit that can win
    /// does not lie beyond it.
    #[test]
    fn limits_are_those_of_what_comes_out() {
        let distances = [0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, INF];
        for (enter, leave) in [
            (0.0, 1.0),
            (1.0, 3.0),
            (2.0, 2.0),
            (2.0, INF),
            (3.0, 1.0),
            (0.0, -2.0),
        ] {
            let interval = interval(enter, leave);
            for best in distances {
                let closest = first(closest_limit(F32x8::splat(best), &interval));
                let any = first(any_hit_limit(F32x8::splat(best), &interval));
                for t in [0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0] {
                    let (counts, out) = to_world(F32x8::splat(t), &interval);
                    let (counts, out) = (counts.any(), first(out));
                    // At the same distance the smaller number wins, on either side.
                    let may_win = counts && out <= best;
                    assert!(
                        !may_win || t <= closest,
                        "{t} of {enter}..{leave}, best {best}"
                    );
                    assert_eq!(
                        counts && out < best,
                        t < any,
                        "{t} of {enter}..{leave}, before {best}"
                    );
                }
                if enter > leave || leave <= 0.0 {
                    assert_eq!((closest, any), (-INF, -INF));
                }
            }
        }
    }
}
