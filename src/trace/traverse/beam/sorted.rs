//! The rays of a beam in the order of their projections, so that those of one sub-beam are close to
//! each other.
//!
//! Shadow rays come in pixel order. Neighbours may be far apart as seen from the light, wherever a
//! surface ends or slants away. Results do not depend on which ray is in which packet.

use super::batch::SIZE;
use super::projection::BeamSpace;
use super::ray_extent::directions;
use crate::packet::{RayPacket, RayQueue};
use crate::simd::{COLUMN_LANES, LANES, LaneMask, Lanes, NATIVE, Native, Vec3Lanes};
use std::ops::Range;

/// Maximum number of rays in a beam.
const RAYS: usize = SIZE * LANES;

/// Squares along each side of the grid by which rays are sorted.
const GRID: usize = 16;
const SQUARES: usize = GRID * GRID;

/// Keys of the squares in the order of Hilbert's curve, which visits neighbours and never jumps.
static HILBERT: [u8; SQUARES] = {
    let mut squares = [0; SQUARES];
    let mut k = 0;
    while k < SQUARES {
        let (mut x, mut y, mut rest, mut side) = (0, 0, k, 1);
        while side < GRID {
            let (right, up) = ((rest / 2) & 1, (rest ^ (rest / 2)) & 1);
            if up == 0 {
                if right == 1 {
                    (x, y) = (side - 1 - x, side - 1 - y);
                }
                (x, y) = (y, x);
            }
            (x, y) = (x + side * right, y + side * up);
            (rest, side) = (rest / 4, side * 2);
        }
        squares[k] = (x * GRID + y) as u8;
        k += 1;
    }
    squares
};

type RayColumn = [[f32; COLUMN_LANES]; RAYS / COLUMN_LANES];

/// Up to [`RAYS`] rays as columns.
pub(super) struct Sorted {
    org: [RayColumn; 3],
    dir: [RayColumn; 3],
    /// Numbers of the rays, counted from the beam's first.
    number: [u16; RAYS],
    count: usize,
}

impl Default for Sorted {
    fn default() -> Sorted {
        const ZERO: RayColumn = [[0.0; COLUMN_LANES]; RAYS / COLUMN_LANES];
        Sorted {
            org: [ZERO; 3],
            dir: [ZERO; 3],
            number: [0; RAYS],
            count: 0,
        }
    }
}

impl Sorted {
    /// Sorts the rays of the given packets into the columns.
    #[inline(never)]
    pub(super) fn take(&mut self, space: &BeamSpace, rays: &RayQueue, packets: Range<usize>) {
        let first = packets.start * LANES;
        self.count = rays.len().min(packets.end * LANES) - first;
        let keys = keys(space, rays, packets.clone());
        let mut next = [0u16; SQUARES];
        for &key in &keys[..self.count] {
            next[usize::from(key)] += 1;
        }
        let mut before = 0;
        for square in HILBERT {
            let here = &mut next[usize::from(square)];
            (*here, before) = (before, before + *here);
        }
        let (keys, _) = keys[..self.count.next_multiple_of(LANES)].as_chunks::<LANES>();
        let mut left = self.count;
        for (number, (keys, slot)) in keys.iter().zip(&rays.slots()[packets.start..]).enumerate() {
            for lane in 0..LANES.min(left) {
                let place = &mut next[usize::from(keys[lane])];
                let k = usize::from(*place) % RAYS;
                *place += 1;
                for axis in 0..3 {
                    self.org[axis].as_flattened_mut()[k] = slot.org[axis][lane];
                    self.dir[axis].as_flattened_mut()[k] = slot.dir[axis][lane];
                }
                self.number[k] = (number * LANES + lane) as u16;
            }
            left -= LANES.min(left);
        }
    }

    pub(super) fn groups<L: Lanes>(&self) -> usize {
        self.count.div_ceil(L::PACKETS * LANES)
    }

    /// The k-th packet of as many lanes as `L` has.
    #[inline(always)]
    pub(super) fn group<L: Lanes>(&self, k: usize, tmax: f32) -> (RayPacket<L>, L::Mask) {
        let first = k * L::PACKETS * LANES;
        let vec = |columns: &[RayColumn; 3]| {
            let lanes = |column: &RayColumn| {
                let run = first % COLUMN_LANES / (L::PACKETS * LANES);
                L::load_run(&column[first / COLUMN_LANES % (RAYS / COLUMN_LANES)], run)
            };
            Vec3Lanes::new(lanes(&columns[0]), lanes(&columns[1]), lanes(&columns[2]))
        };
        let rays = RayPacket {
            org: vec(&self.org),
            dir: vec(&self.dir),
            tmax: L::splat(tmax),
        };
        let left = self.count - first;
        (rays, L::Mask::first(left.min(L::PACKETS * LANES)))
    }

    /// Adds the lanes (as bits) of the k-th sorted packet to those of the packets from which the
    /// rays came.
    #[inline(always)]
    pub(super) fn put_back<L: Lanes>(&self, k: usize, lanes: u32, packets: &mut [u8; SIZE]) {
        let first = k * L::PACKETS * LANES;
        let numbers = &self.number[first..self.count.min(first + L::PACKETS * LANES)];
        for (lane, &number) in numbers.iter().enumerate() {
            let (packet, bit) = (
                usize::from(number) / LANES % SIZE,
                usize::from(number) % LANES,
            );
            packets[packet] |= ((lanes >> lane & 1) as u8) << bit;
        }
    }
}

/// The key of each ray's square: sixteen times the index along p, plus the index along q.
#[inline(always)]
fn keys(space: &BeamSpace, rays: &RayQueue, packets: Range<usize>) -> [u8; RAYS] {
    const ZERO: Native = Native::ZERO;
    let mut points = [[ZERO; 2]; RAYS / NATIVE];
    let mut ends = [f32::INFINITY, f32::NEG_INFINITY].map(|end| [Native::splat(end); 2]);
    for (point, packet) in points.iter_mut().zip(packets.step_by(Native::PACKETS)) {
        let (rays, active) = rays.packet::<Native>(packet, 0.0);
        let [_, p, q] = directions(space, &rays);
        *point = [p, q];
        for (axis, x) in point.iter().enumerate() {
            ends[0][axis] = ends[0][axis].min(active.select(*x, ends[0][axis]));
            ends[1][axis] = ends[1][axis].max(active.select(*x, ends[1][axis]));
        }
    }
    let low = ends[0].map(Native::min_element);
    let high = ends[1].map(Native::max_element);
    let low_lanes = low.map(Native::splat);
    let scale: [Native; 2] =
        std::array::from_fn(|axis| Native::splat((GRID as f32 - 1.0) / (high[axis] - low[axis])));
    // Adding it rounds to an integer, which ends up in the last bits.
    let integer_limit = Native::splat((1 << 23) as f32);
    let mut keys = [0; RAYS];
    for (keys, point) in keys.as_chunks_mut::<NATIVE>().0.iter_mut().zip(&points) {
        let [p, q] = [0, 1].map(|axis| (point[axis] - low_lanes[axis]) * scale[axis]);
        let row = (p + integer_limit) - integer_limit;
        let square = (row * Native::splat(GRID as f32) + q) + integer_limit;
        *keys = square.to_array().map(|x| x.to_bits() as u8);
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_passes_every_square_and_never_jumps() {
        let keys: Vec<(u8, u8)> = (0..GRID * GRID)
            .map(|k| ((k % GRID) as u8, (k / GRID) as u8))
            .collect();
        let position = HILBERT.map(|square| {
            let is = |&&(x, y): &&(u8, u8)| x * GRID as u8 + y == square;
            *keys.iter().find(is).expect("every number is a square's")
        });
        for step in position.windows(2) {
            let far = step[0].0.abs_diff(step[1].0) + step[0].1.abs_diff(step[1].1);
            assert_eq!(far, 1, "{step:?}");
        }
        let mut squares = HILBERT;
        squares.sort_unstable();
        assert!(squares.is_sorted_by(|a, b| a < b));
    }
}
