//! Objects sorted by cells, segment by segment: building a chunk gathers its cells' runs from all
//! segments.

use super::cells::{GridCells, OccupiedCell};
use crate::bvh::prim_ref::PrimRef;
use rayon::prelude::*;
use std::ops::Range;

/// Objects of a grid.
pub(super) struct SortedPrims {
    prims: Vec<PrimRef>,
    /// Indices of a segment's objects, sorted by cells, by segment. The objects themselves are not
    /// moved, because new memory for them costs more than it gains.
    order: Vec<u32>,
    segment_len: usize,
    /// End of each cell's run in a segment, by segment.
    ends: Vec<Vec<u32>>,
    /// Object counts of each cell, by segment.
    counts: Vec<Vec<u32>>,
    /// Cells with objects, in the order of their division.
    divided: Vec<OccupiedCell>,
}

impl SortedPrims {
    pub(super) fn new(
        prims: Vec<PrimRef>,
        cells: GridCells,
        divided: Vec<OccupiedCell>,
    ) -> SortedPrims {
        let len = cells.segment_len;
        let mut order = vec![0; prims.len()];
        let segments = prims.par_chunks(len).zip(order.par_chunks_mut(len));
        let ends = segments
            .zip(&cells.counts)
            .map(|((segment, order), counts)| sort_segment(segment, order, counts, &cells));
        SortedPrims {
            ends: ends.collect(),
            prims,
            order,
            segment_len: len,
            counts: cells.counts,
            divided,
        }
    }

    /// Appends the objects of the given cells, by their positions in the order of the division.
    pub(super) fn gather(&self, cells: Range<usize>, objects: &mut Vec<PrimRef>) {
        for cell in &self.divided[cells] {
            let index = cell.index as usize;
            let segments = self.prims.chunks(self.segment_len);
            let segments = segments.zip(self.order.chunks(self.segment_len));
            let runs = self.ends.iter().zip(&self.counts);
            for ((segment, order), (ends, counts)) in segments.zip(runs) {
                let end = ends[index] as usize;
                let run = &order[end - counts[index] as usize..end];
                objects.extend(run.iter().map(|&k| segment[k as usize]));
            }
        }
    }
}

/// Sorts the indices of a segment's objects by cells; returns the end of each cell's run.
fn sort_segment(
    segment: &[PrimRef],
    order: &mut [u32],
    counts: &[u32],
    cells: &GridCells,
) -> Vec<u32> {
    let mut ends = vec![0; counts.len()];
    let mut end = 0;
    for cell in &cells.occupied {
        let index = cell.index as usize;
        ends[index] = end;
        end += counts[index];
    }
    for (k, item) in segment.iter().enumerate() {
        let end = &mut ends[cells.grid.cell(item)];
        order[*end as usize] = k as u32;
        *end += 1;
    }
    ends
}
