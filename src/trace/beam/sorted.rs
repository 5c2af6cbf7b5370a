//! The rays of a beam in the order of where they are seen, so that those of one cell are close to each other.
//!
//! Shadow rays come in the order of the pixels, and neighbours there may lie far apart as the light sees them, wherever a
//! surface ends or slants away. Which ray is in which packet matters to no answer.

use super::SIZE;
use super::cells::directions;
use super::frame::Frame;
use crate::lanes::{F32x8, LANES, LaneMask, Lanes, Vec3Lanes};
use crate::packet::{RayPacket, RayQueue};
use std::ops::Range;

/// Rays of a beam.
const RAYS: usize = SIZE * LANES;

/// Squares along each side of the grid by which rays are sorted.
const GRID: usize = 16;

/// The squares in the order of Hilbert's curve, which goes from neighbour to neighbour and never jumps, by their keys.
static HILBERT: [u8; GRID * GRID] = {
    let mut squares = [0; GRID * GRID];
    let mut k = 0;
    while k < GRID * GRID {
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
        squares[k] = apart(x as u8) | apart(y as u8) << 1;
        k += 1;
    }
    squares
};

/// Up to [`RAYS`] rays as columns.
pub(super) struct Sorted {
    org: [[f32; RAYS]; 3],
    dir: [[f32; RAYS]; 3],
    /// Their numbers, counted from the beam's first.
    number: [u16; RAYS],
    count: usize,
}

impl Default for Sorted {
    fn default() -> Sorted {
        Sorted {
            org: [[0.0; RAYS]; 3],
            dir: [[0.0; RAYS]; 3],
            number: [0; RAYS],
            count: 0,
        }
    }
}

impl Sorted {
    /// Takes the rays of some packets.
    #[inline(never)]
    pub(super) fn take(&mut self, frame: &Frame, rays: &RayQueue, packets: Range<usize>) {
        let first = packets.start * LANES;
        self.count = rays.len().min(packets.end * LANES) - first;
        let keys = keys(frame, rays, packets);
        let mut place = [0u16; GRID * GRID];
        for &key in &keys[..self.count] {
            place[key as usize] += 1;
        }
        let mut before = 0;
        for square in HILBERT {
            let here = &mut place[usize::from(square)];
            (*here, before) = (before, before + *here);
        }
        for (number, &key) in keys[..self.count].iter().enumerate() {
            let at = &mut place[key as usize];
            let (org, dir) = rays.ray(first / LANES + number / LANES, number % LANES);
            let k = usize::from(*at) % RAYS;
            for axis in 0..3 {
                self.org[axis][k] = org[axis];
                self.dir[axis][k] = dir[axis];
            }
            self.number[k] = number as u16;
            *at += 1;
        }
    }

    pub(super) fn groups<L: Lanes>(&self) -> usize {
        self.count.div_ceil(L::PACKETS * LANES)
    }

    /// The k-th packet of as many lanes as `L` has.
    #[inline(always)]
    pub(super) fn group<L: Lanes>(&self, k: usize, tmax: f32) -> (RayPacket<L>, L::Mask) {
        let vec = |columns: &[[f32; RAYS]; 3]| {
            let lanes = |column: &[f32; RAYS]| {
                let eights = column.as_chunks::<LANES>().0;
                L::from_eights(|j| eights[(k * L::PACKETS + j) % SIZE])
            };
            Vec3Lanes::new(lanes(&columns[0]), lanes(&columns[1]), lanes(&columns[2]))
        };
        let rays = RayPacket {
            org: vec(&self.org),
            dir: vec(&self.dir),
            tmax: L::splat(tmax),
        };
        let left = self.count - k * L::PACKETS * LANES;
        (rays, L::Mask::first(left.min(L::PACKETS * LANES)))
    }

    /// Adds the lanes (as bits) of the k-th packet to those of the packets that rays came in.
    #[inline(always)]
    pub(super) fn put_back<L: Lanes>(&self, k: usize, lanes: u32, packets: &mut [u8; SIZE]) {
        let first = k * L::PACKETS * LANES;
        let numbers = &self.number[first..self.count.min(first + L::PACKETS * LANES)];
        for (lane, &number) in numbers.iter().enumerate() {
            let (packet, at) = (
                usize::from(number) / LANES % SIZE,
                usize::from(number) % LANES,
            );
            packets[packet] |= ((lanes >> lane & 1) as u8) << at;
        }
    }
}

/// Of each ray the square in which it is seen: the bits of its number along p and along q, by turns.
#[inline(always)]
fn keys(frame: &Frame, rays: &RayQueue, packets: Range<usize>) -> [u8; RAYS] {
    const ZERO: F32x8 = F32x8::ZERO;
    let mut places = [[ZERO; 2]; SIZE];
    let mut ends = [f32::INFINITY, f32::NEG_INFINITY].map(|end| [F32x8::splat(end); 2]);
    for (place, packet) in places.iter_mut().zip(packets) {
        let (rays, active) = rays.packet::<F32x8>(packet, 0.0);
        let [_, p, q] = directions(frame, &rays);
        *place = [p, q];
        for (axis, x) in place.iter().enumerate() {
            ends[0][axis] = ends[0][axis].min(active.select(*x, ends[0][axis]));
            ends[1][axis] = ends[1][axis].max(active.select(*x, ends[1][axis]));
        }
    }
    let low = ends[0].map(F32x8::least);
    let high = ends[1].map(F32x8::greatest);
    let scale: [f32; 2] =
        std::array::from_fn(|axis| (GRID as f32 - 0.01) / (high[axis] - low[axis]));
    let mut keys = [0; RAYS];
    for (keys, place) in keys.as_chunks_mut::<LANES>().0.iter_mut().zip(&places) {
        let square = |axis: usize| {
            let x = (place[axis] - F32x8::splat(low[axis])) * F32x8::splat(scale[axis]);
            x.to_array()
        };
        let (p, q) = (square(0), square(1));
        for lane in 0..LANES {
            keys[lane] = apart(p[lane] as u8) | apart(q[lane] as u8) << 1;
        }
    }
    keys
}

/// Four bits with a place between each two.
#[inline(always)]
const fn apart(bits: u8) -> u8 {
    let x = bits & 15;
    let x = (x | x << 2) & 0x33;
    (x | x << 1) & 0x55
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_passes_every_square_and_never_jumps() {
        let keys: Vec<(u8, u8)> = (0..GRID * GRID)
            .map(|k| ((k % GRID) as u8, (k / GRID) as u8))
            .collect();
        let place = HILBERT.map(|square| {
            let is = |&&(x, y): &&(u8, u8)| apart(x) | apart(y) << 1 == square;
            *keys.iter().find(is).expect("every number is a square's")
        });
        for step in place.windows(2) {
            let far = step[0].0.abs_diff(step[1].0) + step[0].1.abs_diff(step[1].1);
            assert_eq!(far, 1, "{step:?}");
        }
        let mut squares = HILBERT;
        squares.sort_unstable();
        assert!(squares.is_sorted_by(|a, b| a < b));
    }
}
