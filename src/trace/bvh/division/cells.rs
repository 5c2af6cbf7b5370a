//! Boxes and counts of the objects in each cell, segment by segment.

use super::grid::CellGrid;
use crate::bvh::prim_ref::{LaneBounds, PrimRef};
use rayon::prelude::*;

/// Most segments, of which each has a box for every cell. Additional threads stay idle during the
/// few passes that use segments.
const MAX_SEGMENTS: usize = 32;
/// Minimum number of objects in a segment.
const MIN_SEGMENT: usize = 1 << 14;

/// A cell that is not empty.
#[derive(Clone, Copy)]
pub(super) struct OccupiedCell {
    pub(super) bounds: LaneBounds,
    pub(super) count: u32,
    pub(super) index: u32,
}

/// The objects of all cells.
pub(super) struct GridCells {
    pub(super) grid: CellGrid,
    /// Objects per segment; the last one may be shorter.
    pub(super) segment_len: usize,
    /// Object counts of each cell, by segment.
    pub(super) counts: Vec<Vec<u32>>,
    /// Cells with objects, by index.
    pub(super) occupied: Vec<OccupiedCell>,
}

impl GridCells {
    pub(super) fn of(all: &[PrimRef]) -> GridCells {
        let segments = rayon::current_num_threads().min(MAX_SEGMENTS);
        let segment_len = all.len().div_ceil(segments).max(MIN_SEGMENT);
        let segments: Vec<&[PrimRef]> = all.chunks(segment_len).collect();
        let grid = CellGrid::over(&segments);
        let filled = segments.par_iter().map(|segment| fill(segment, &grid));
        let filled: Vec<(Vec<LaneBounds>, Vec<u32>)> = filled.collect();
        let cell = |index: usize| {
            let start = (LaneBounds::EMPTY, 0);
            let (bounds, count) = filled.iter().fold(start, |all, (bounds, counts)| {
                (all.0.union(bounds[index]), all.1 + counts[index])
            });
            let index = index as u32;
            (count > 0).then_some(OccupiedCell {
                bounds,
                count,
                index,
            })
        };
        let occupied = (0..grid.len()).into_par_iter().with_min_len(4096);
        let occupied = occupied.filter_map(cell).collect();
        GridCells {
            grid,
            segment_len,
            counts: filled.into_iter().map(|(_, counts)| counts).collect(),
            occupied,
        }
    }
}

/// Boxes and counts of a segment's objects, by cell.
fn fill(segment: &[PrimRef], grid: &CellGrid) -> (Vec<LaneBounds>, Vec<u32>) {
    let mut bounds = vec![LaneBounds::EMPTY; grid.len()];
    let mut counts = vec![0; grid.len()];
    for item in segment {
        let cell = grid.cell(item);
        bounds[cell] = bounds[cell].union(LaneBounds(item.lanes()));
        counts[cell] += 1;
    }
    (bounds, counts)
}
