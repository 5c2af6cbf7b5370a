//! Steps of rays from hit to hit, in the order of (t, prim_id).
//!
//! Most rays take few steps, and each of these is a traversal for the next hit. Rays that take more
//! find some hits ahead in one traversal, and each time more of them: n surfaces in one place,
//! which every traversal meets, cost O(n log n) and not O(n²).

use super::next_hit::HitsByLane;
use super::traversal::Traversal;
use crate::packet::{HitPacket, RayPacket};
use crate::simd::{LaneMask, Mask8};
use std::cmp::Reverse;

/// Steps that find one hit each.
const SINGLE_STEPS: u32 = 12;

/// Hits that the first traversal looks ahead, growth of that from one to the next, and the most:
/// lists of eight rays then take up to 10 MiB.
const FIRST_AHEAD: usize = 16;
const GROWTH: usize = 8;
const MOST_AHEAD: usize = 1 << 15;

/// The way of eight rays from hit to hit.
#[derive(Default)]
pub struct HitWalk {
    steps: u32,
    /// Hits to look ahead for next.
    most: usize,
    /// The hits after the last step, the farthest first.
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
