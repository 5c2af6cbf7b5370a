//! Division of objects into chunks, on all threads: a grid of cells, and a binned surface area
//! heuristic over the cells (Wald, "On Fast Construction of SAH-based Bounding Volume Hierarchies",
//! 2007) until the objects of several cells fit a chunk.
//!
//! | file | contents |
//! |---|---|
//! | `grid` | the cell of an object |
//! | `cells` | the box and the count of the objects in each cell |
//! | `bins` | division of cells by the surface area heuristic |
//! | `sorted` | objects sorted by cells, from which chunks are gathered |
//!
//! Unlike Wald, it divides cells instead of objects: each object is moved once rather than once per
//! level. A cell with far more objects than fit a chunk gets its own grid.
//!
//! Objects are processed in segments, one for each thread. Neither the boxes and counts of cells
//! nor the order of their objects depends on the segments, so the chunks do not depend on threads.

mod bins;
mod cells;
mod grid;
mod sorted;

use super::prim_ref::PrimRef;
use bins::{DivisionStep, divide_cells};
use cells::GridCells;
use rayon::prelude::*;
use sorted::SortedPrims;
use std::ops::Range;

/// Depth of nested grids from which objects are halved by count, which bounds the recursion for any
/// distribution of sizes.
const MAX_GRIDS: usize = 16;
/// Chunks that a single cell may fill before it gets its own grid, which takes a copy of its
/// objects.
const CHUNKS_PER_CELL: usize = 2;

/// Chunks of objects, and the tree of their divisions.
#[derive(Default)]
pub(super) struct Division {
    sources: Vec<ChunkSource>,
    /// Neighbourhoods, from left to right.
    chunks: Vec<Chunk>,
    /// The tree of the divisions in preorder: true for a chunk, false for two parts that follow.
    is_chunk: Vec<bool>,
}

/// Objects of several chunks.
enum ChunkSource {
    /// A chunk is a set of cells.
    Sorted(SortedPrims),
    /// A chunk is a range.
    Plain(Vec<PrimRef>),
}

/// Objects of a source.
struct Chunk {
    source: usize,
    part: Range<usize>,
}

impl Division {
    /// Divides objects so that each chunk of at most `chunk_prims`, or twice as many of a single
    /// cell, is a neighbourhood.
    pub(super) fn of(all: Vec<PrimRef>, chunk_prims: usize) -> Division {
        divide(all, chunk_prims, 0)
    }

    /// Number of chunks.
    pub(super) fn len(&self) -> usize {
        self.chunks.len()
    }

    /// The tree of the divisions in preorder: true for a chunk, false for two parts that follow.
    /// The objects are dropped.
    pub(super) fn into_tree(self) -> Vec<bool> {
        self.is_chunk
    }

    /// Replaces the contents of `objects` by the objects of a chunk.
    pub(super) fn gather(&self, chunk: usize, objects: &mut Vec<PrimRef>) {
        objects.clear();
        let Chunk { source, part } = &self.chunks[chunk];
        match &self.sources[*source] {
            ChunkSource::Sorted(sorted) => sorted.gather(part.clone(), objects),
            ChunkSource::Plain(all) => objects.extend_from_slice(&all[part.clone()]),
        }
    }

    /// Adds a chunk of the first source.
    fn add(&mut self, part: Range<usize>) {
        self.is_chunk.push(true);
        self.chunks.push(Chunk { source: 0, part });
    }

    /// Adds the chunks of another division in place of one.
    fn append(&mut self, other: Division) {
        let first = self.sources.len();
        self.chunks
            .extend(other.chunks.into_iter().map(|chunk| Chunk {
                source: first + chunk.source,
                ..chunk
            }));
        self.sources.extend(other.sources);
        self.is_chunk.extend(other.is_chunk);
    }
}

/// The division of objects; `grids` is the number of grids around them.
fn divide(all: Vec<PrimRef>, chunk_prims: usize, grids: usize) -> Division {
    if all.len() <= chunk_prims || grids == MAX_GRIDS {
        return halve(all, chunk_prims);
    }
    let cells = GridCells::of(&all);
    if cells.occupied.len() < 2 {
        return halve(all, chunk_prims);
    }
    let mut divided = cells.occupied.clone();
    let steps = divide_cells(&mut divided, chunk_prims);
    let sorted = SortedPrims::new(all, cells, divided);
    // Single cells with more objects than a chunk may have.
    let divided_again = steps.par_iter().map(|step| match step {
        DivisionStep::Whole { cells, prims } if *prims > CHUNKS_PER_CELL * chunk_prims => {
            let mut objects = Vec::with_capacity(*prims);
            sorted.gather(cells.clone(), &mut objects);
            Some(divide(objects, chunk_prims, grids + 1))
        }
        _ => None,
    });
    let divided_again: Vec<Option<Division>> = divided_again.collect();
    let mut division = Division::default();
    division.sources.push(ChunkSource::Sorted(sorted));
    for (step, again) in steps.into_iter().zip(divided_again) {
        match (step, again) {
            (_, Some(again)) => division.append(again),
            (DivisionStep::Divided, _) => division.is_chunk.push(false),
            (DivisionStep::Whole { cells, .. }, _) => division.add(cells),
        }
    }
    division
}

/// The division of objects that no grid separates, halved until they fit.
fn halve(all: Vec<PrimRef>, chunk_prims: usize) -> Division {
    let mut division = Division::default();
    let mut waiting: Vec<Range<usize>> = std::iter::once(0..all.len()).collect();
    while let Some(part) = waiting.pop() {
        if part.len() <= chunk_prims {
            division.add(part);
            continue;
        }
        division.is_chunk.push(false);
        let middle = part.start + part.len() / 2;
        waiting.extend([middle..part.end, part.start..middle]);
    }
    division.sources.push(ChunkSource::Plain(all));
    division
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::LeafKind;
    use glam::Vec3;
    use phalanx_scene::Bounds;

    const CHUNK_PRIMS: usize = 1 << 13;

    fn items(count: usize, position: impl Fn(usize) -> Vec3) -> Vec<PrimRef> {
        let item = |k: usize| {
            let bounds = Bounds::new(position(k), position(k) + Vec3::ONE);
            PrimRef::new(k as u32, LeafKind::TRIANGLE, bounds)
        };
        (0..count).map(item).collect()
    }

    /// The objects of all chunks, after checks that each is in one of them, that the chunks are
    /// small enough and that the tree of the divisions has as many.
    fn chunks(all: Vec<PrimRef>) -> Vec<Vec<PrimRef>> {
        let count = all.len();
        let division = Division::of(all, CHUNK_PRIMS);
        let chunk = |k| {
            let mut objects = Vec::new();
            division.gather(k, &mut objects);
            objects
        };
        let chunks: Vec<Vec<PrimRef>> = (0..division.len()).map(chunk).collect();
        let mut seen: Vec<u32> = chunks.iter().flatten().map(|item| item.object).collect();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..count as u32));
        let most = CHUNKS_PER_CELL * CHUNK_PRIMS;
        let fits = |chunk: &Vec<PrimRef>| (1..=most).contains(&chunk.len());
        assert!(chunks.iter().all(fits));
        let tree = division.into_tree();
        let leaves = tree.iter().filter(|is_chunk| **is_chunk);
        assert_eq!(leaves.count(), chunks.len());
        assert_eq!(tree.len(), 2 * chunks.len() - 1);
        chunks
    }

    #[test]
    fn chunks_are_neighbourhoods() {
        let spread = |k: usize| {
            let town = if k.is_multiple_of(3) { 1e6 } else { 0.0 };
            Vec3::new(
                town + (k * 7919 % 1000) as f32,
                (k * 104_729 % 1000) as f32,
                0.0,
            )
        };
        let chunks = chunks(items(200_000, spread));
        assert!(chunks.len() >= 24);
        for chunk in chunks {
            let first = chunk[0].center().x > 1e6;
            assert!(chunk.iter().all(|i| (i.center().x > 1e6) == first));
        }
    }

    /// Checks that neither equal positions nor sizes that shrink forever make the recursion
    /// endless.
    #[test]
    fn what_cannot_be_parted_is_halved() {
        let count = 4 * CHUNK_PRIMS;
        assert_eq!(chunks(items(count, |_| Vec3::ONE)).len(), 4);
        let shrinking = |k: usize| Vec3::X * libm::pow(0.5, k as f64 / 900.0) as f32 * 1e30;
        assert!(chunks(items(count, shrinking)).len() >= 4);
        let far = |k: usize| Vec3::splat(if k == 0 { f32::MAX } else { -f32::MAX });
        assert!(chunks(items(count, far)).len() >= 4);
    }
}
