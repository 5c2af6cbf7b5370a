//! Steps of rays from hit to hit, in the order of (t, prim_id).
//!
//! Most rays take few steps, each of which is a traversal for the next hit. Rays that take more
//! find several hits ahead in one traversal, a growing number each time: n surfaces in one place,
//! which every traversal meets, cost O(n log n) instead of O(n²).

use super::next_hit::HitsByLane;
use super::traversal::Traversal;
use crate::packet::{HitPacket, RayPacket};
use crate::simd::{LaneMask, Mask8};
use std::cmp::Reverse;

/// Number of steps that find one hit each.
const SINGLE_STEPS: u32 = 12;

/// Number of hits that the first traversal looks ahead, its growth per traversal, and its maximum:
/// lists of eight rays then take up to 10 MiB.
const FIRST_AHEAD: usize = 16;
const GROWTH: usize = 8;
const MOST_AHEAD: usize = 1 << 15;

/// State of eight rays on their way from hit to hit.
#[derive(Default)]
pub struct HitWalk {
    steps: u32,
    /// Number of hits to look ahead for next.
    most: usize,
    /// The hits after the last step, farthest first.
    ahead: HitsByLane,
    /// Lanes without further hits than those.
    ended: u32,
}

impl HitWalk {
    /// The next hits of eight rays after `after`, by (t, prim_id), before their `tmax`. Lanes that
    /// are not active are returned as a miss. From the second step on, `after` holds what the step
    /// before returned for these lanes.
    pub fn next(
        &mut self,
        traversal: &mut Traversal,
        rays: &RayPacket,
        active: Mask8,
        after: &HitPacket,
    ) -> HitPacket {
        if self.steps < SINGLE_STEPS {
            self.steps += 1;
            return traversal.next(rays, active, after);
        }
        self.look_ahead(traversal, rays, active, after);
        let mut hits = HitPacket {
            t: rays.tmax,
            ..HitPacket::miss()
        };
        for lane in active.lanes() {
            if let Some(hit) = self.ahead[lane].pop() {
                hits.set(lane, [hit.t, hit.u, hit.v], hit.prim_id);
            }
        }
        hits
    }

    /// Finds hits for those lanes that have none left.
    fn look_ahead(
        &mut self,
        traversal: &mut Traversal,
        rays: &RayPacket,
        active: Mask8,
        after: &HitPacket,
    ) {
        let dry = (active.lanes()).filter(|&lane| self.ahead[lane].is_empty());
        let dry = dry.fold(0, |bits, lane| bits | 1 << lane) & !self.ended;
        if dry == 0 {
            return;
        }
        self.most = (self.most * GROWTH).clamp(FIRST_AHEAD, MOST_AHEAD);
        let dry = Mask8::from_bits(dry);
        traversal.next_hits(rays, dry, after, self.most, &mut self.ahead);
        for lane in dry.lanes() {
            let list = &mut self.ahead[lane];
            list.sort_unstable_by_key(|hit| Reverse(hit.key()));
            self.ended |= u32::from(list.len() < self.most) << lane;
        }
    }
}
