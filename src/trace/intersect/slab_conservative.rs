//! Slab test for boxes of nodes: that of [`super::aabb`] with half the arithmetic and a little
//! slack.
//!
//! The result for a primitive's own box must be the same bits everywhere. The results for enclosing
//! boxes need only be conservative. So the distance of a plane at c is c·r − o·r here, with o·r
//! computed once for a ray. This is a product and a difference that are fused if the build has an
//! instruction for it. Fused or not, the hits are the same; only the number of visited boxes may
//! differ between builds, by very few.
//!
//! # Why nothing is lost
//!
//! | symbol | meaning |
//! |---|---|
//! | u | 2⁻²⁴ |
//! | o | the origin moved by the padding, as in [`super::aabb`] |
//! | p | the padding, 32u·\|o\| |
//! | r | the reciprocal of the direction, here positive |
//! | c | the coordinate of a plane |
//! | e | c − o |
//!
//! There a ray enters at the larger of 0 and fl((c − o)·r): with e > 0 that is e·r within 2u of it.
//! Here:
//!
//! - The origin is moved by 2p, which takes p·r off.
//! - r is smaller by 8u, which takes at least 7u of e·r off.
//! - Rounding of c·r, of the moved origin times r and of their difference adds at most u(|c| + 2|o|
//!   + e)·r. That is below (3u|o| + 2ue)·r, less than both together.
//!
//! So the ray enters here no later. With e ≤ 0 the same holds, and both are 0 then. It leaves no
//! earlier: the same with the other sign, and r larger by 8u. For r < 0 lower and upper planes
//! change places, and the factor that is smaller by a share of |r| is again the one for entering.
//! [`ABS_SLACK`] covers losses below the smallest numbers.

use super::aabb::{RaySlabs, SlabTest, TInterval};
use crate::packet::RayPacket;
use crate::simd::{LaneMask, Lanes, Vec3Lanes};

/// Relative amount by which a reciprocal is decreased and increased: 8u.
const REL_SLACK: f32 = 8.0 / 16_777_216.0;

/// Amount subtracted from entry distances and added to exit distances: 2⁻¹⁰⁰.
const ABS_SLACK: f32 = f32::from_bits((127 - 100) << 23);

/// Data of the planes on one side of boxes: their distance is their coordinate times `by`, less
/// `less`.
#[derive(Clone, Copy)]
struct SlabSide<L> {
    by: Vec3Lanes<L>,
    less: Vec3Lanes<L>,
}

/// A packet's rays, prepared for the boxes of nodes. The sides are the planes that the rays cross
/// first and last if their directions agree in sign, else the lower and upper planes.
#[derive(Clone, Copy)]
pub(crate) struct ConservativeSlabs<L> {
    sides: [SlabSide<L>; 2],
}

impl<L: Lanes> ConservativeSlabs<L> {
    /// Prepares rays, given with their slabs.
    #[inline(always)]
    pub(crate) fn new(rays: &RayPacket<L>, slabs: &RaySlabs<L>) -> ConservativeSlabs<L> {
        let (rdir, tiny) = (slabs.rdir, L::splat(ABS_SLACK));
        let tiny = Vec3Lanes::new(tiny, tiny, tiny);
        // For entering sooner, a reciprocal loses a share of itself. If signs differ, the one for
        // lower planes loses a share of its size: a ray that goes down leaves by the lower planes,
        // and then leaves later.
        let (share, tiny) = match slabs.octant {
            Some(_) => (rdir, tiny),
            None => (rdir.abs(), signed(tiny, rdir)),
        };
        let share = share.scale(L::splat(REL_SLACK));
        // The slabs' origins are moved by the padding; here it is twice that.
        let [first, last] = slabs.org.map(|moved| moved + (moved - rays.org));
        let side = |by: Vec3Lanes<L>, org: Vec3Lanes<L>, tiny: Vec3Lanes<L>| SlabSide {
            by,
            less: org.mul_elementwise(by) + tiny,
        };
        ConservativeSlabs {
            sides: [
                side(rdir - share, first, tiny),
                side(rdir + share, last, -tiny),
            ],
        }
    }

    /// The interval in a box, by the slabs' `octant`.
    #[inline(always)]
    pub(crate) fn intersect_box(
        &self,
        corners: &[[f32; 3]; 2],
        octant: Option<[usize; 3]>,
    ) -> TInterval<L> {
        match octant {
            Some(near) => self.intersect_box_same_octant(corners, near),
            None => self.intersect_box_mixed(corners),
        }
    }
}

impl<L: Lanes> SlabTest<L> for ConservativeSlabs<L> {
    #[inline(always)]
    fn distances(&self, side: usize, [x, y, z]: [f32; 3]) -> [L; 3] {
        let SlabSide { by, less } = &self.sides[side];
        [
            L::splat(x).mul_sub_any_rounding(by.x, less.x),
            L::splat(y).mul_sub_any_rounding(by.y, less.y),
            L::splat(z).mul_sub_any_rounding(by.z, less.z),
        ]
    }
}

/// Magnitudes with the signs of other values.
#[inline(always)]
fn signed<L: Lanes>(size: Vec3Lanes<L>, like: Vec3Lanes<L>) -> Vec3Lanes<L> {
    let one = |size: L, like: L| like.lt(L::ZERO).select(-size, size);
    Vec3Lanes::new(
        one(size.x, like.x),
        one(size.y, like.y),
        one(size.z, like.z),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::full_or::full_or;
    use crate::intersect::random::RandomSource;
    use crate::simd::{F32x8, LANES, Mask8, Vec3x8};

    /// A random box, and rays of which most touch a corner of it, from near and far, some along an
    /// axis.
    fn box_and_rays(from: &mut RandomSource, together: bool) -> ([[f32; 3]; 2], RayPacket) {
        let mut next = || from.unit();
        let scale = (next() * 20.0).exp2();
        let size = (next() * 10.0).exp2() * scale;
        let lo = [0; 3].map(|_| next() * scale);
        let hi = lo.map(|x| x + (next() + 1.0) * size);
        let start = [0; 3].map(|_| next() * scale * (next() * 8.0).exp2());
        let corners = [lo, hi];
        let (mut org, mut dir) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for lane in 0..LANES {
            let length = if next() > 0.8 { (next() * 96.0).exp2() } else { 1.0 };
            for axis in 0..3 {
                let apart = if together { 1e-3 } else { 1.0 };
                org[axis][lane] = start[axis] + next() * scale * apart;
                let to = corners[usize::from(next() > 0.0)][axis];
                dir[axis][lane] = match next() {
                    x if x > 0.9 => 0.0,
                    x if x > 0.8 => -0.0,
                    _ => (to - org[axis][lane]) * length,
                };
            }
        }
        let [org, dir] = [org, dir].map(|[x, y, z]| {
            let [x, y, z] = [x, y, z].map(F32x8::new);
            Vec3x8::new(x, y, z)
        });
        let tmax = F32x8::splat(f32::INFINITY);
        (corners, RayPacket { org, dir, tmax })
    }

    #[test]
    fn what_passes_the_slab_test_is_visited_as_early_and_as_long() {
        let mut from = RandomSource(5);
        let everyone = Mask8::splat(true);
        let (mut passed, mut tight, mut ordered) = (0, 0, 0);
        let rounds = full_or(200_000, 20_000);
        for round in 0..rounds {
            let (corners, rays) = box_and_rays(&mut from, round % 2 == 0);
            let slabs = RaySlabs::new(rays.org, rays.dir, everyone);
            let (must, cull) = (
                slabs.intersect_box(&corners),
                ConservativeSlabs::new(&rays, &slabs),
            );
            let may = cull.intersect_box(&corners, slabs.octant);
            ordered += usize::from(slabs.octant.is_some());
            for lane in must.overlaps(rays.tmax).lanes() {
                let [enter, leave] = [must.tnear.lane(lane), must.tfar.lane(lane)];
                let interval = [may.tnear.lane(lane), may.tfar.lane(lane)];
                assert!(
                    interval[0] <= enter && interval[1] >= leave,
                    "{interval:?} for {enter} to {leave}: {corners:?} {rays:?} {lane}"
                );
                tight += usize::from(interval[0] >= enter * 0.999_9);
                passed += 1;
            }
        }
        assert!(2 * passed > rounds, "{passed} rays met their box");
        assert!(10 * ordered > rounds, "{ordered} packets with one sign");
        assert!(
            2 * tight > passed,
            "{tight} of {passed} were not much earlier"
        );
    }
}
