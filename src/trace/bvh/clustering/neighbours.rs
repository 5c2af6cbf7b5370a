//! The cheapest neighbour of each cluster, in lanes: the one that gives the smallest union.
//!
//! Each cost is computed once, by the first of the two clusters, and read by the second. Among
//! equal costs, a cluster at an even position prefers the next one and one at an odd position the
//! previous one, so that equal boxes merge in pairs at once.

use super::clusters::{Clusters, PADDING};
use crate::simd::{LaneMask, LaneU32, Lanes, NATIVE, Native, NativeMask};

/// Maximum number of neighbours on each side.
pub(super) const MAX_REACH: usize = 16;

/// Clusters whose costs are kept at a time; a multiple of the lanes.
const TILE: usize = 128;

/// Size of a window that contains all neighbours of a run of lanes.
const WINDOW: usize = NATIVE + MAX_REACH;
const _: () = assert!(WINDOW <= PADDING && TILE.is_multiple_of(NATIVE));

type NativeU32 = <Native as Lanes>::U32;

/// The neighbour that each cluster has chosen.
#[derive(Default)]
pub(super) struct Neighbours {
    /// Offset of the neighbour, plus [`MAX_REACH`].
    offsets: Vec<u32>,
    /// Costs with the neighbour at each distance: those of [`MAX_REACH`] clusters before the tile,
    /// then those of the tile.
    costs: Vec<[f32; MAX_REACH + TILE]>,
}

impl Neighbours {
    /// The position of the neighbour that a cluster has chosen. It may be invalid: outside the
    /// clusters, or the cluster's own.
    #[inline(always)]
    pub(super) fn chosen_by(&self, k: usize) -> usize {
        (k + self.offsets[k] as usize).wrapping_sub(MAX_REACH)
    }

    /// Pairs each cluster with the next, at any cost. If their number is odd, the last one remains.
    pub(super) fn pair_up(&mut self, count: usize) {
        self.offsets.clear();
        let offset = |k: usize| MAX_REACH as u32 + 1 - 2 * (k & 1) as u32;
        self.offsets.extend((0..count).map(offset));
    }
}

/// Chooses the cheapest of up to `REACH` neighbours on each side.
#[inline(never)]
pub(super) fn choose<const REACH: usize>(clusters: &Clusters, neighbours: &mut Neighbours) {
    const { assert!(REACH <= MAX_REACH) };
    let count = clusters.len();
    neighbours.offsets.resize(count + NATIVE, MAX_REACH as u32);
    let costs = &mut neighbours.costs;
    costs.resize(REACH, [f32::INFINITY; MAX_REACH + TILE]);
    for row in costs.iter_mut() {
        row[..MAX_REACH].fill(f32::INFINITY);
    }
    for tile in (0..count).step_by(TILE) {
        for start in (tile..count.min(tile + TILE)).step_by(NATIVE) {
            let nearest = choose_run::<REACH>(clusters, start, start - tile, costs);
            neighbours.offsets[start..start + NATIVE].copy_from_slice(&nearest);
        }
        for row in costs.iter_mut() {
            row.copy_within(TILE.., 0);
        }
    }
}

/// Chooses for one cluster per lane, `first` positions after the tile's first.
#[inline(always)]
fn choose_run<const REACH: usize>(
    clusters: &Clusters,
    start: usize,
    first: usize,
    costs: &mut [[f32; MAX_REACH + TILE]],
) -> [u32; NATIVE] {
    let columns = clusters.columns_from(start);
    let [x0, y0, z0, x1, y1, z1] = columns.map(window);
    let load = |column: &[f32; WINDOW], distance: usize| lanes(&column[distance..]);
    let own = [load(x0, 0), load(y0, 0), load(z0, 0)];
    let own_hi = [load(x1, 0), load(y1, 0), load(z1, 0)];
    let mut best = Native::splat(f32::INFINITY);
    let mut nearest = NativeU32::splat(MAX_REACH as u32);
    for distance in 1..=REACH {
        let dx = own_hi[0].max(load(x1, distance)) - own[0].min(load(x0, distance));
        let dy = own_hi[1].max(load(y1, distance)) - own[1].min(load(y0, distance));
        let dz = own_hi[2].max(load(z1, distance)) - own[2].min(load(z0, distance));
        let cost = dx * (dy + dz) + dy * dz;
        costs[distance - 1][MAX_REACH + first..][..NATIVE].copy_from_slice(&cost.to_array());
        let better = cost.lt(best);
        best = better.select(cost, best);
        let offset = NativeU32::splat((MAX_REACH + distance) as u32);
        nearest = better.select_u32(offset, nearest);
    }
    let odd = NativeMask::from_bits(0xaaaa_aaaa);
    for distance in 1..=REACH {
        let cost = lanes(&costs[distance - 1][MAX_REACH + first - distance..]);
        let better = match distance {
            1 => cost.lt(best) | (cost.le(best) & odd),
            _ => cost.lt(best),
        };
        best = better.select(cost, best);
        let offset = NativeU32::splat((MAX_REACH - distance) as u32);
        nearest = better.select_u32(offset, nearest);
    }
    nearest.to_array()
}

#[inline(always)]
fn window(column: &[f32]) -> &[f32; WINDOW] {
    match column.first_chunk() {
        Some(window) => window,
        // Columns are padded by more than a window.
        None => unreachable!("a column ends within the window"),
    }
}

#[inline(always)]
fn lanes(values: &[f32]) -> Native {
    match values.first_chunk::<NATIVE>() {
        Some(values) => Native::new(*values),
        None => unreachable!("a row ends within the lanes"),
    }
}
