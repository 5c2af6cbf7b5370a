//! The sub-beams of a beam: rays of one packet, or some of them, within a small rectangle of the
//! beam's projective coordinates.

use super::projection::{BeamSpace, BoxView, MAX_RECT, TriangleView};
use super::ray_extent::{MIN_DEPTH_PER_T, meets};
use super::shadow_cull::ShadowCull;
use crate::intersect::aabb::REACH;
use crate::simd::{COLUMN_LANES, F32x8, LANES, LaneMask, Lanes, NATIVE, Native, NativeMask};

/// Maximum number of sub-beams in a beam: one bit each.
pub(super) const MAX_SUB_BEAMS: usize = COLUMN_LANES;

/// Maximum width of a sub-beam, in units of the median width. A wider one is split between its
/// rays: its rays straddle a silhouette, and the rectangle would be tested against everything in
/// between.
const MAX_WIDTH_RATIO: f32 = 4.0;

/// Maximum width of any sub-beam, in units of the apex's distance.
const MIN_SPLIT_WIDTH: f32 = 0.02;

/// Maximum number of parts into which a packet is split.
const MAX_SPLITS: usize = 4;

type SubBeamColumn = [f32; MAX_SUB_BEAMS];

/// Result of adding a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Added {
    /// All of its rays are in sub-beams.
    All,
    /// Its rays diverge too much for a beam, and none is in a sub-beam.
    TooWide,
    /// None of its rays is in a sub-beam, because too few are left. A beam without other packets
    /// has room for any packet.
    NoRoom,
}

/// The sub-beams, in columns.
#[repr(C, align(64))]
pub(super) struct SubBeams {
    /// Lower ends of the rectangles along p and along q; and upper ends.
    low: [SubBeamColumn; 2],
    high: [SubBeamColumn; 2],
    /// Middles and half widths of the rectangles, for triangles.
    mid: [SubBeamColumn; 2],
    half: [SubBeamColumn; 2],
    /// Largest depth to which any ray of each sub-beam still searches.
    far: SubBeamColumn,
    /// Largest depth per unit of distance of any ray of each sub-beam.
    depth_per_t: SubBeamColumn,
    /// Lanes of the packet in each sub-beam.
    lanes: [u32; MAX_SUB_BEAMS],
    group: [u8; MAX_SUB_BEAMS],
    count: usize,
    /// Rectangles of whole packets, along p and along q.
    ranges: [[[f32; 2]; 2]; MAX_SUB_BEAMS],
    /// Rectangle around all sub-beams: along p and along q, lower and upper end.
    around: [[f32; 2]; 2],
    /// Bounds on the width of sub-beams, and on |p| and |q|.
    widest: f32,
    end: f32,
}

impl SubBeams {
    pub(super) fn new() -> SubBeams {
        const ZERO: SubBeamColumn = [0.0; MAX_SUB_BEAMS];
        SubBeams {
            low: [ZERO; 2],
            high: [ZERO; 2],
            mid: [ZERO; 2],
            half: [ZERO; 2],
            far: ZERO,
            depth_per_t: ZERO,
            lanes: [0; MAX_SUB_BEAMS],
            group: [0; MAX_SUB_BEAMS],
            count: 0,
            ranges: [[[0.0; 2]; 2]; MAX_SUB_BEAMS],
            around: [[0.0; 2]; 2],
            widest: MIN_SPLIT_WIDTH,
            end: MAX_RECT,
        }
    }

    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    /// All sub-beams, as bits.
    pub(super) fn all(&self) -> u64 {
        match self.count {
            0 => 0,
            count => u64::MAX >> (MAX_SUB_BEAMS - count),
        }
    }

    /// Index of the packet of a sub-beam.
    #[inline(always)]
    pub(super) fn group(&self, sub_beam: usize) -> usize {
        self.group[sub_beam % MAX_SUB_BEAMS] as usize % MAX_SUB_BEAMS
    }

    /// Adds the active lanes of a packet, which search as far as `limit`. [`SubBeams::finish`] must
    /// follow the last call.
    #[inline(always)]
    pub(super) fn add<L: Lanes>(
        &mut self,
        near: bool,
        [depth_per_t, p, q]: [L; 3],
        limit: L,
        active: L::Mask,
        group: usize,
    ) -> Added {
        let live = active.bits();
        if near && depth_per_t.ge(L::splat(MIN_DEPTH_PER_T)).bits() & live != live {
            return Added::TooWide;
        }
        if self.count == MAX_SUB_BEAMS {
            return Added::NoRoom;
        }
        if live == L::Mask::splat(true).bits() {
            let ranges = self.ranges[group % MAX_SUB_BEAMS];
            if self.is_narrow(ranges) {
                self.put(
                    ranges,
                    [depth_per_t, limit].map(L::max_element),
                    live,
                    group,
                );
                return Added::All;
            }
        }
        self.add_parts([depth_per_t, p, q], limit, live, group)
    }

    /// Adds the lanes of a packet, in as many parts as they need.
    #[inline(never)]
    fn add_parts<L: Lanes>(
        &mut self,
        [depth_per_t, p, q]: [L; 3],
        limit: L,
        live: u32,
        group: usize,
    ) -> Added {
        let mut waiting = [live; MAX_SPLITS];
        let (mut top, mut parts, first) = (1, 0, self.count);
        while top > 0 {
            top -= 1;
            let lanes = waiting[top % MAX_SPLITS];
            let mask = L::Mask::from_bits(lanes);
            let nowhere = L::splat(f32::NEG_INFINITY);
            let ranges = [p, q].map(|x| {
                let low = mask.select(x, L::splat(f32::INFINITY)).min_element();
                [low, mask.select(x, nowhere).max_element()]
            });
            if self.is_narrow(ranges) {
                let most = [depth_per_t, limit].map(|x| mask.select(x, nowhere).max_element());
                self.put(ranges, most, lanes, group);
                parts += 1;
                continue;
            }
            let width = ranges.map(|[low, high]| high - low);
            let axis = usize::from(width[1] > width[0]);
            let middle = 0.5 * (ranges[axis][0] + ranges[axis][1]);
            let lower = [p, q][axis].lt(L::splat(middle)).bits() & lanes;
            let too_many = parts + top + 2 > MAX_SPLITS;
            if too_many || lower == 0 || lower == lanes {
                self.count = first;
                return Added::TooWide;
            }
            if self.count + top + 2 > MAX_SUB_BEAMS {
                self.count = first;
                return Added::NoRoom;
            }
            (waiting[top % MAX_SPLITS], waiting[(top + 1) % MAX_SPLITS]) = (lower, lanes & !lower);
            top += 2;
        }
        Added::All
    }

    #[inline(always)]
    fn put(
        &mut self,
        [p, q]: [[f32; 2]; 2],
        [depth_per_t, limit]: [f32; 2],
        lanes: u32,
        group: usize,
    ) {
        let k = self.count % MAX_SUB_BEAMS;
        for (axis, [low, high]) in [p, q].into_iter().enumerate() {
            (self.low[axis][k], self.high[axis][k]) = (low, high);
        }
        (self.depth_per_t[k], self.far[k]) = (depth_per_t, limit);
        (self.lanes[k], self.group[k]) = (lanes, group as u8);
        self.count += 1;
    }

    /// Measures all packets of a beam to find the bound on the width of sub-beams, for rays to a
    /// light; camera rays have a fixed bound.
    #[inline(always)]
    pub(super) fn look_at<L: Lanes>(&mut self, space: &BeamSpace, all: &[[L; 3]]) {
        if !space.ahead {
            for (ranges, [_, p, q]) in self.ranges.iter_mut().zip(all) {
                *ranges = [range(*p), range(*q)];
            }
            (self.widest, self.end) = (MIN_SPLIT_WIDTH, MAX_RECT);
            return;
        }
        let mut widths = [0.0; MAX_SUB_BEAMS];
        for ((width, ranges), [_, p, q]) in widths.iter_mut().zip(&mut self.ranges).zip(all) {
            *ranges = [range(*p), range(*q)];
            let [p, q] = ranges.map(|[low, high]| high - low);
            *width = if p > q { p } else { q };
        }
        let count = all.len().min(MAX_SUB_BEAMS);
        let (_, usual, _) = widths[..count].select_nth_unstable_by(count / 2, f32::total_cmp);
        let widest = MAX_WIDTH_RATIO * *usual;
        let wide = MIN_SPLIT_WIDTH * space.distance;
        self.widest = if widest < wide { widest } else { wide };
        self.end = if space.near { MAX_RECT } else { f32::INFINITY };
    }

    /// Returns true if rays of this range may be one sub-beam. A range with a NaN may not.
    #[inline(always)]
    fn is_narrow(&self, ranges: [[f32; 2]; 2]) -> bool {
        let fits =
            |[low, high]: [f32; 2]| high - low <= self.widest && low > -self.end && high < self.end;
        fits(ranges[0]) && fits(ranges[1])
    }

    /// Computes the final rectangles, which are a little wider, their middles, and the rectangle
    /// around all.
    #[inline(always)]
    pub(super) fn finish(&mut self, space: &BeamSpace) {
        let runs = self.count.div_ceil(LANES);
        // Unused columns repeat the first sub-beam, so that they do not change the rectangle around
        // all.
        for k in self.count..runs * LANES {
            for columns in [&mut self.low, &mut self.high] {
                columns.iter_mut().for_each(|column| column[k] = column[0]);
            }
        }
        for run in 0..runs {
            let column = |column: &SubBeamColumn| F32x8::load_run(column, run);
            let depth_per_t = column(&self.depth_per_t) * F32x8::splat(REACH);
            if space.near {
                let far = column(&self.far) * depth_per_t + F32x8::splat(space.min_depth);
                put(&mut self.depth_per_t, run, depth_per_t);
                put(&mut self.far, run, far);
            } else {
                // The ray that starts last determines the far end of the sub-beam.
                put(&mut self.far, run, column(&self.depth_per_t));
            }
        }
        for axis in 0..2 {
            let (mut least, mut most) =
                (F32x8::splat(f32::INFINITY), F32x8::splat(f32::NEG_INFINITY));
            for run in 0..runs {
                let low = F32x8::load_run(&self.low[axis], run);
                let high = F32x8::load_run(&self.high[axis], run);
                let [wider, share] = space.rect_epsilon.map(F32x8::splat);
                let more = wider + low.abs().max(high.abs()) * share;
                let (low, high) = (low - more, high + more);
                let half = F32x8::splat(0.5);
                put(&mut self.low[axis], run, low);
                put(&mut self.high[axis], run, high);
                put(&mut self.mid[axis], run, (low + high) * half);
                put(&mut self.half[axis], run, (high - low) * half);
                (least, most) = (least.min(low), most.max(high));
            }
            self.around[axis] = [least.min_element(), most.max_element()];
        }
    }

    /// Limits the search of a sub-beam's rays to `limit`, which is −∞ for rays that are done.
    #[inline(always)]
    pub(super) fn set_far<L: Lanes>(&mut self, space: &BeamSpace, sub_beam: usize, limit: L) {
        let k = sub_beam % MAX_SUB_BEAMS;
        let live = L::Mask::from_bits(self.lanes[k]);
        let most = live
            .select(limit, L::splat(f32::NEG_INFINITY))
            .max_element();
        if space.near {
            self.far[k] = most * self.depth_per_t[k] + space.min_depth;
        } else if most == f32::NEG_INFINITY {
            self.far[k] = most;
        }
    }

    /// The rectangle around all sub-beams: along p and along q, lower and upper end.
    #[inline(always)]
    pub(super) fn around(&self) -> &[[f32; 2]; 2] {
        &self.around
    }

    /// Boxes that any sub-beam may hit.
    #[inline(always)]
    pub(super) fn any_meets(&self, seen: &BoxView) -> u32 {
        meets(seen, &self.around)
    }

    /// Sub-beams, out of `candidates`, that may hit a box.
    #[inline(always)]
    pub(super) fn meeting<L: Lanes>(
        &self,
        candidates: u64,
        seen: &[[f32; NATIVE]; 5],
        lane: usize,
    ) -> u64 {
        let [low_p, high_p, low_q, high_q, near] =
            [0, 1, 2, 3, 4].map(|k| L::splat(seen[k][lane % NATIVE]));
        let mut met = 0;
        for run in 0..self.runs::<L>() {
            let column = |column: &SubBeamColumn| L::load_run(column, run);
            let p = low_p.le(column(&self.high[0])) & high_p.ge(column(&self.low[0]));
            let q = low_q.le(column(&self.high[1])) & high_q.ge(column(&self.low[1]));
            let depth = near.le(column(&self.far));
            met |= u64::from((p & q & depth).bits()) << (run * L::PACKETS * LANES);
        }
        met & candidates
    }

    /// Sub-beams, out of `candidates`, that still search as deep as `near`.
    #[inline(always)]
    pub(super) fn reaching<L: Lanes>(&self, candidates: u64, near: f32) -> u64 {
        let mut met = 0;
        for run in 0..self.runs::<L>() {
            let reach = L::splat(near).le(L::load_run(&self.far, run));
            met |= u64::from(reach.bits()) << (run * L::PACKETS * LANES);
        }
        met & candidates
    }

    /// Number of runs of lanes that hold all sub-beams. Lanes beyond the last sub-beam are stale,
    /// but in no mask.
    #[inline(always)]
    fn runs<L: Lanes>(&self) -> usize {
        self.count.div_ceil(L::PACKETS * LANES)
    }

    /// Triangles that a sub-beam's rays may hit.
    #[inline(always)]
    pub(super) fn hits(&self, sub_beam: usize, seen: &TriangleView) -> u32 {
        let k = sub_beam % MAX_SUB_BEAMS;
        let [p, q] = [0, 1].map(|axis| Native::splat(self.mid[axis][k]));
        let [half_p, half_q] = [0, 1].map(|axis| Native::splat(self.half[axis][k]));
        let range = |[constant, slope_p, slope_q]: [Native; 3]| {
            let middle = constant + (slope_p * p + slope_q * q);
            let more = seen.margin + (slope_p.abs() * half_p + slope_q.abs() * half_q);
            [middle - more, middle + more]
        };
        let [u, v, w] = seen.edges.map(range);
        let inside =
            u[1].min(v[1]).min(w[1]).ge(Native::ZERO) | u[0].max(v[0]).max(w[0]).le(Native::ZERO);
        (inside & self.reaches(k, &seen.own)).bits()
    }

    /// Triangles that any of a sub-beam's rays may hit, according to the culling data.
    #[inline(always)]
    pub(super) fn may_hit(&self, sub_beam: usize, cull: &ShadowCull, own: &BoxView) -> u32 {
        let k = sub_beam % MAX_SUB_BEAMS;
        let [p, q] = [0, 1].map(|axis| Native::splat(self.mid[axis][k]));
        let [half_p, half_q] = [0, 1].map(|axis| Native::splat(self.half[axis][k]));
        let inside = cull.within([p, q], [half_p, half_q]);
        (inside & self.reaches(k, own)).bits()
    }

    /// Boxes that the k-th sub-beam's rays reach, as far as they search.
    #[inline(always)]
    fn reaches(&self, k: usize, seen: &BoxView) -> NativeMask {
        let edge = |column: &[SubBeamColumn; 2], axis: usize| {
            Native::splat(column[axis][k % MAX_SUB_BEAMS])
        };
        let outside = seen.low_p.le(edge(&self.high, 0))
            & seen.high_p.ge(edge(&self.low, 0))
            & seen.low_q.le(edge(&self.high, 1))
            & seen.high_q.ge(edge(&self.low, 1));
        outside & seen.ahead & seen.near.le(Native::splat(self.far[k % MAX_SUB_BEAMS]))
    }
}

#[inline(always)]
fn put(column: &mut SubBeamColumn, run: usize, lanes: F32x8) {
    column.as_chunks_mut::<LANES>().0[run % (MAX_SUB_BEAMS / LANES)] = lanes.to_array();
}

#[inline(always)]
fn range<L: Lanes>(lanes: L) -> [f32; 2] {
    [lanes.min_element(), lanes.max_element()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Mask8;
    use Added::{All, NoRoom, TooWide};

    /// Adds a packet whose rays have these projections along p.
    fn add(sub_beams: &mut SubBeams, group: usize, p: F32x8) -> Added {
        sub_beams.ranges[group % MAX_SUB_BEAMS] = [range(p), range(F32x8::ZERO)];
        let packet = [F32x8::ONE, p, F32x8::ZERO];
        sub_beams.add(true, packet, F32x8::ONE, Mask8::splat(true), group)
    }

    #[test]
    fn what_finds_no_room_leaves_no_part_behind() {
        let narrow = F32x8::splat(0.5);
        let two_bunches = F32x8::new([0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
        let three_bunches = F32x8::new([0.0, 0.0, 0.3, 0.3, 1.0, 1.0, 1.0, 1.0]);
        let apart = F32x8::new([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]);
        let mut sub_beams = Box::new(SubBeams::new());
        let count = |sub_beams: &SubBeams| sub_beams.all().count_ones() as usize;
        for group in 0..MAX_SUB_BEAMS - 2 {
            assert_eq!(add(&mut sub_beams, group, narrow), All);
        }
        // One part of it is added before the others are found to be too many.
        assert_eq!(
            add(&mut sub_beams, MAX_SUB_BEAMS - 2, three_bunches),
            NoRoom
        );
        assert_eq!(count(&sub_beams), MAX_SUB_BEAMS - 2);
        assert_eq!(add(&mut sub_beams, MAX_SUB_BEAMS - 2, narrow), All);
        assert_eq!(add(&mut sub_beams, MAX_SUB_BEAMS - 1, two_bunches), NoRoom);
        assert_eq!(count(&sub_beams), MAX_SUB_BEAMS - 1);
        assert_eq!(add(&mut sub_beams, MAX_SUB_BEAMS - 1, narrow), All);
        assert_eq!(add(&mut sub_beams, MAX_SUB_BEAMS - 1, narrow), NoRoom);
        // A beam of its own has room for each packet but those that diverge too much.
        sub_beams.clear();
        assert_eq!(add(&mut sub_beams, 7, two_bunches), All);
        assert_eq!(count(&sub_beams), 2);
        assert_eq!((sub_beams.group(0), sub_beams.group(1)), (7, 7));
        assert_eq!(sub_beams.lanes[0] | sub_beams.lanes[1], 0xff);
        assert_eq!(add(&mut sub_beams, 8, apart), TooWide);
        assert_eq!(count(&sub_beams), 2);
    }
}
