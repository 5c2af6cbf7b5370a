//! The order of a chunk's objects along the Morton curve.

use crate::bvh::prim_ref::{PrimRef, center_extent};
use glam::Vec3;

/// Bits per coordinate. Three coordinates and an object's index within its chunk fill a key.
const BITS: u32 = 16;
const CELLS: f32 = 65_535.0;

/// Reusable memory for keys and sorted objects.
#[derive(Default)]
pub(super) struct MortonOrder {
    keys: Vec<u64>,
    sorted: Vec<PrimRef>,
}

impl MortonOrder {
    /// The objects of a chunk along the curve through its extent.
    pub(super) fn sort(&mut self, chunk: &[PrimRef]) -> &[PrimRef] {
        let extent = center_extent(chunk);
        let scale = |size: f32| if size > 0.0 { CELLS / size } else { 0.0 };
        let scale = (extent.hi - extent.lo).map(scale);
        self.keys.clear();
        self.keys.extend(chunk.iter().enumerate().map(|(k, item)| {
            let cell = (item.center() - extent.lo) * scale;
            interleave(cell) << BITS | k as u64
        }));
        self.keys.sort_unstable();
        self.sorted.clear();
        let objects = self.keys.iter().map(|key| chunk[(key & 0xffff) as usize]);
        self.sorted.extend(objects);
        &self.sorted
    }
}

/// The interleaved bits of three coordinates. The conversion saturates, also for NaN.
#[inline(always)]
fn interleave(cell: Vec3) -> u64 {
    let x = spread(cell.x as u16);
    let y = spread(cell.y as u16);
    let z = spread(cell.z as u16);
    x | y << 1 | z << 2
}

/// The bits of a number, each preceded by two zeros.
#[inline(always)]
fn spread(number: u16) -> u64 {
    let mut x = u64::from(number);
    x = (x | x << 16) & 0x0000_0000_ff00_00ff;
    x = (x | x << 8) & 0x0000_00f0_0f00_f00f;
    x = (x | x << 4) & 0x0000_0c30_c30c_30c3;
    (x | x << 2) & 0x0000_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread() {
        for number in [0u16, 1, 2, 3, 0x8000, 0xffff, 0x1234, 0xbeef] {
            let want = (0..16).fold(0, |all, bit| {
                all | u64::from(number >> bit & 1) << (3 * bit)
            });
            assert_eq!(spread(number), want, "{number:x}");
        }
    }
}
