//! Division of cells by the surface area heuristic, over bins along the three axes.

use super::cells::OccupiedCell;
use crate::bvh::prim_ref::LaneBounds;
use glam::Vec3;
use phalanx_scene::Bounds;
use std::ops::Range;

/// Bins per axis.
const BINS: usize = 32;
/// Minimum number of cells for dividing both parts in parallel.
const PARALLEL_GRAIN: usize = 1 << 10;
/// Depth from which cells are halved by count, which bounds the recursion for any distribution of
/// sizes.
const MAX_SAH_DEPTH: usize = 40;

/// A step of a division, in preorder.
pub(super) enum DivisionStep {
    /// Two parts, which follow in preorder.
    Divided,
    /// Consecutive cells, which are not divided further here, and the number of their objects.
    Whole { cells: Range<usize>, prims: usize },
}

/// Reorders cells so that those of each part follow one another.
pub(super) fn divide_cells(cells: &mut [OccupiedCell], chunk_prims: usize) -> Vec<DivisionStep> {
    divide(cells, 0, chunk_prims, 0)
}

/// Divides cells, of which the first has the index `first`.
fn divide(
    cells: &mut [OccupiedCell],
    first: usize,
    chunk_prims: usize,
    depth: usize,
) -> Vec<DivisionStep> {
    let prims = cells.iter().map(|cell| cell.count as usize).sum();
    if cells.len() == 1 || prims <= chunk_prims {
        let cells = first..first + cells.len();
        return vec![DivisionStep::Whole { cells, prims }];
    }
    let border = match best_split(cells) {
        Some(split) if depth < MAX_SAH_DEPTH => partition(cells, &split),
        _ => cells.len() / 2,
    };
    let (left, right) = cells.split_at_mut(border);
    let parallel = left.len().min(right.len()) >= PARALLEL_GRAIN;
    let mut left = || divide(left, first, chunk_prims, depth + 1);
    let mut right = || divide(right, first + border, chunk_prims, depth + 1);
    let (left, right) = if parallel { rayon::join(left, right) } else { (left(), right()) };
    let mut steps = vec![DivisionStep::Divided];
    steps.extend(left);
    steps.extend(right);
    steps
}

/// A border between bins of one axis.
struct Split {
    grid: BinGrid,
    axis: usize,
    bin: usize,
}

/// Moves the cells below the border to the front; returns their number.
fn partition(cells: &mut [OccupiedCell], split: &Split) -> usize {
    let mut below = 0;
    for k in 0..cells.len() {
        let position = split.grid.position(&cells[k]);
        if bin(position[split.axis]) < split.bin {
            cells.swap(k, below);
            below += 1;
        }
    }
    below
}

/// Positions of cells in units of bins.
#[derive(Clone, Copy)]
struct BinGrid {
    lo: Vec3,
    scale: Vec3,
}

impl BinGrid {
    fn over(cells: &[OccupiedCell]) -> BinGrid {
        let mut extent = Bounds::EMPTY;
        for cell in cells {
            let center = center(cell);
            extent = extent.union(Bounds::new(center, center));
        }
        let scale = |size: f32| if size > 0.0 { BINS as f32 / size } else { 0.0 };
        BinGrid {
            lo: extent.lo,
            scale: (extent.hi - extent.lo).map(scale),
        }
    }

    fn position(&self, cell: &OccupiedCell) -> Vec3 {
        (center(cell) - self.lo) * self.scale
    }
}

/// Twice the centre of a cell's box.
fn center(cell: &OccupiedCell) -> Vec3 {
    let bounds = cell.bounds.bounds();
    bounds.lo + bounds.hi
}

/// The bin at a position. The conversion saturates, also for a NaN that comes from overflow.
fn bin(position: f32) -> usize {
    (position as usize).min(BINS - 1)
}

/// Box and number of objects.
type BoxCount = (LaneBounds, u32);

fn unite(a: BoxCount, b: BoxCount) -> BoxCount {
    (a.0.union(b.0), a.1 + b.1)
}

/// The border with the smallest sum of both sides' areas times counts; `None` if no border
/// separates anything.
#[inline(never)]
fn best_split(cells: &[OccupiedCell]) -> Option<Split> {
    let grid = BinGrid::over(cells);
    let mut bins = [[(LaneBounds::EMPTY, 0); BINS]; 3];
    for cell in cells {
        let position = grid.position(cell);
        for (axis, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[bin(position[axis])];
            *bin = unite(*bin, (cell.bounds, cell.count));
        }
    }
    let mut best: Option<(f64, Split)> = None;
    for (axis, bins) in bins.iter().enumerate() {
        for (bin, cost) in borders(bins) {
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, Split { grid, axis, bin }));
            }
        }
    }
    best.map(|(_, split)| split)
}

/// The cost of each border of an axis that has objects on both sides.
fn borders(bins: &[BoxCount; BINS]) -> impl Iterator<Item = (usize, f64)> {
    let cost = |side: BoxCount| f64::from(side.0.bounds().half_area()) * f64::from(side.1);
    let mut right = [(LaneBounds::EMPTY, 0); BINS + 1];
    for bin in (0..BINS).rev() {
        right[bin] = unite(right[bin + 1], bins[bin]);
    }
    let mut left = (LaneBounds::EMPTY, 0);
    (1..BINS).filter_map(move |border| {
        left = unite(left, bins[border - 1]);
        let parts = left.1 > 0 && right[border].1 > 0;
        parts.then(|| (border, cost(left) + cost(right[border])))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::LeafKind;
    use crate::bvh::prim_ref::PrimRef;

    #[test]
    fn each_cell_is_in_one_part() {
        let cell = |k: u32| {
            let center = Vec3::X * libm::exp2f((k % 250) as f32 - 125.0);
            let bounds = Bounds::new(center - 1.0, center + 1.0);
            let prim = PrimRef::new(k, LeafKind::TRIANGLE, bounds);
            OccupiedCell {
                bounds: LaneBounds(prim.lanes()),
                count: 1 + k % 3,
                index: k,
            }
        };
        let mut cells: Vec<OccupiedCell> = (0..5000).map(cell).collect();
        let steps = divide_cells(&mut cells, 4);
        let mut end = 0;
        for step in steps {
            if let DivisionStep::Whole { cells: part, prims } = step {
                assert_eq!(std::mem::replace(&mut end, part.end), part.start);
                let count: u32 = cells[part.clone()].iter().map(|cell| cell.count).sum();
                assert!(count as usize == prims && (prims <= 4 || part.len() == 1));
            }
        }
        assert_eq!(end, cells.len());
        let mut indices: Vec<u32> = cells.iter().map(|cell| cell.index).collect();
        indices.sort_unstable();
        assert!(indices.into_iter().eq(0..5000));
    }
}
