//! The cell of an object: a grid of nearly cubic cells over the extent of all centres.

use crate::bvh::prim_ref::{PrimRef, center_extent};
use glam::Vec3;
use phalanx_scene::Bounds;
use rayon::prelude::*;

/// Average number of objects per cell of a grid. If objects form surfaces, most cells are empty.
const PRIMS_PER_CELL: usize = 32;
/// Average number in large scenes, whose cells would take too much memory.
const MOST_PRIMS_PER_CELL: usize = 48;
const CELLS: [usize; 2] = [1 << 9, 1 << 17];

/// A grid of cells.
#[derive(Clone, Copy)]
pub(super) struct CellGrid {
    lo: Vec3,
    /// Cells per unit.
    scale: Vec3,
    /// Cells along each axis.
    side: [u32; 3],
}

impl CellGrid {
    /// A grid over objects, which threads process in the given segments.
    pub(super) fn over(segments: &[&[PrimRef]]) -> CellGrid {
        let extents = segments.par_iter().map(|segment| center_extent(segment));
        let extent = extents.reduce(|| Bounds::EMPTY, Bounds::union);
        let count: usize = segments.iter().map(|segment| segment.len()).sum();
        let most = CELLS[1].max(count / MOST_PRIMS_PER_CELL);
        let cells = (count / PRIMS_PER_CELL).clamp(CELLS[0], most);
        let size = extent.hi - extent.lo;
        let side = sides(size.to_array(), cells as f32);
        let scale = |k: usize| {
            if size[k] > 0.0 { side[k] as f32 / size[k] } else { 0.0 }
        };
        CellGrid {
            lo: extent.lo,
            scale: Vec3::new(scale(0), scale(1), scale(2)),
            side,
        }
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.side.iter().map(|&side| side as usize).product()
    }

    /// The cell of an object. The conversions saturate, also for NaN that comes from overflow.
    #[inline(always)]
    pub(super) fn cell(&self, item: &PrimRef) -> usize {
        let position = (item.center() - self.lo) * self.scale;
        let [x, y, z] = self.side;
        let along = |position: f32, side: u32| (position as u32).min(side - 1);
        let row = along(position.z, z) * y + along(position.y, y);
        (row * x + along(position.x, x)) as usize
    }
}

/// Cells along each axis of an extent, close to the wanted total. Axes shorter than a cell have
/// one, and the others share the rest.
fn sides(size: [f32; 3], cells: f32) -> [u32; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| size[a].total_cmp(&size[b]));
    let mut side = [1; 3];
    let mut left = cells;
    for (k, &axis) in order.iter().enumerate() {
        let longer = &order[k..];
        // The edge of a cell, if `left` cubes fill the remaining axes.
        let mean: f32 = longer.iter().map(|&a| libm::log2f(size[a])).sum::<f32>();
        let edge = (mean - libm::log2f(left)) / longer.len() as f32;
        let cells = libm::exp2f(libm::log2f(size[axis]) - edge);
        // An extent of zero or infinity gets one cell.
        side[axis] = (cells as u32).clamp(1, left as u32);
        left /= side[axis] as f32;
    }
    side
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_cubes_where_the_extent_allows() {
        for (size, want) in [
            ([1.0; 3], [16, 16, 16]),
            ([4.0, 1.0, 1.0], [40, 10, 10]),
            ([1e-3, 7.0, 7.0], [1, 64, 64]),
            ([0.0, 0.0, 5.0], [1, 1, 4096]),
            ([0.0; 3], [1, 1, 1]),
            ([f32::INFINITY, 1.0, 1.0], [1, 1, 1]),
        ] {
            let got = sides(size, 4096.0);
            let close = got.iter().zip(want).all(|(a, b)| a.abs_diff(b) <= 1);
            assert!(close || want == [1; 3], "{size:?}: {got:?}");
            assert!(got.iter().product::<u32>() <= 4096, "{size:?}: {got:?}");
        }
    }
}
