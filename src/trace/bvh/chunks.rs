//! Parallel division of objects into chunks: binned surface area heuristic from the top (Wald, "On
//! Fast Construction of SAH-based Bounding Volume Hierarchies", 2007), until a chunk is small
//! enough for a more thorough builder.
//!
//! The division unites boxes and counts objects. Neither depends on the order, so the chunks do not
//! depend on threads.

use super::build_input::PrimRef;
use phalanx_scene::Bounds;
use rayon::prelude::*;

/// Most objects of a chunk. Smaller and larger chunks gave trees 1 to 5 % worse: see
/// `perf/notes/parallel-build.md`.
const CHUNK_PRIMS: usize = 1 << 15;
/// Buckets per axis.
const BINS: usize = 32;
/// Depth from which objects are halved by count, so that no order of sizes makes the recursion
/// deep.
const MAX_SAH_DEPTH: usize = 40;
/// Objects that a thread processes at a time.
const BLOCK: usize = 1 << 14;

/// Reorders objects so that each of the chunks returned is a neighbourhood.
pub(super) fn chunks(all: &mut [PrimRef]) -> Vec<&mut [PrimRef]> {
    split(all, 0)
}

fn split(all: &mut [PrimRef], depth: usize) -> Vec<&mut [PrimRef]> {
    if all.len() <= CHUNK_PRIMS {
        return vec![all];
    }
    let at = match best_split(all) {
        Some(border) if depth < MAX_SAH_DEPTH => partition(all, &border),
        _ => all.len() / 2,
    };
    let (left, right) = all.split_at_mut(at);
    let (mut chunks, rest) = rayon::join(|| split(left, depth + 1), || split(right, depth + 1));
    chunks.extend(rest);
    chunks
}

/// A border between buckets of one axis.
struct Split {
    grid: BinGrid,
    axis: usize,
    bin: usize,
}

/// Grid that assigns centres to buckets.
#[derive(Clone, Copy)]
struct BinGrid {
    lo: glam::Vec3,
    scale: glam::Vec3,
}

impl BinGrid {
    fn over(all: &[PrimRef]) -> BinGrid {
        let centers = all.par_chunks(BLOCK).map(|block| {
            block.iter().fold(Bounds::EMPTY, |extent, item| {
                let center = item.center();
                extent.union(Bounds::new(center, center))
            })
        });
        let extent = centers.reduce(|| Bounds::EMPTY, Bounds::union);
        let scale = |size: f32| if size > 0.0 { BINS as f32 / size } else { 0.0 };
        BinGrid {
            lo: extent.lo,
            scale: (extent.hi - extent.lo).map(scale),
        }
    }

    /// The bucket of an object. The conversion saturates, also for a NaN that comes from overflow.
    fn bin(&self, item: &PrimRef, axis: usize) -> usize {
        let place = (item.center()[axis] - self.lo[axis]) * self.scale[axis];
        (place as usize).min(BINS - 1)
    }
}

/// Box and number of the objects in each bucket of each axis.
type Bins = [[(Bounds, usize); BINS]; 3];

const NO_BINS: Bins = [[(Bounds::EMPTY, 0); BINS]; 3];

fn unite(a: (Bounds, usize), b: (Bounds, usize)) -> (Bounds, usize) {
    (a.0.union(b.0), a.1 + b.1)
}

/// The border with the least sum of both sides' areas times counts; `None` if no border separates
/// anything.
fn best_split(all: &[PrimRef]) -> Option<Split> {
    let grid = BinGrid::over(all);
    let filled = all.par_chunks(BLOCK).map(|block| {
        let mut bins = Box::new(NO_BINS);
        for item in block {
            for (axis, bins) in bins.iter_mut().enumerate() {
                let bin = &mut bins[grid.bin(item, axis)];
                *bin = unite(*bin, (item.bounds, 1));
            }
        }
        bins
    });
    let bins = filled.reduce(
        || Box::new(NO_BINS),
        |mut a, b| {
            let both = a.iter_mut().flatten().zip(b.iter().flatten());
            both.for_each(|(a, b)| *a = unite(*a, *b));
            a
        },
    );
    let mut best: Option<(f64, Split)> = None;
    for axis in 0..3 {
        for (bin, cost) in splits(&bins[axis]) {
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, Split { grid, axis, bin }));
            }
        }
    }
    best.map(|(_, border)| border)
}

/// The cost of each border of an axis that has objects on both sides.
fn splits(bins: &[(Bounds, usize); BINS]) -> impl Iterator<Item = (usize, f64)> {
    let cost = |side: &(Bounds, usize)| f64::from(side.0.half_area()) * side.1 as f64;
    let mut right = [(Bounds::EMPTY, 0); BINS + 1];
    for k in (0..BINS).rev() {
        right[k] = unite(right[k + 1], bins[k]);
    }
    let mut left = (Bounds::EMPTY, 0);
    (1..BINS).filter_map(move |border| {
        left = unite(left, bins[border - 1]);
        let parts = left.1 > 0 && right[border].1 > 0;
        parts.then(|| (border, cost(&left) + cost(&right[border])))
    })
}

/// Moves the objects below the border to the front; returns their number.
fn partition(all: &mut [PrimRef], border: &Split) -> usize {
    let mut at = 0;
    for k in 0..all.len() {
        if border.grid.bin(&all[k], border.axis) < border.bin {
            all.swap(k, at);
            at += 1;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn items(count: usize, position: impl Fn(usize) -> Vec3) -> Vec<PrimRef> {
        let item = |k: usize| PrimRef {
            object: k as u32,
            bounds: Bounds::new(position(k), position(k) + Vec3::ONE),
        };
        (0..count).map(item).collect()
    }

    /// Checks that two distant groups are never in one chunk, and that all objects are in some
    /// chunk.
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
        let mut all = items(100_000, spread);
        let chunks = chunks(&mut all);
        assert!(chunks.len() >= 4);
        let mut seen: Vec<u32> = Vec::new();
        for chunk in chunks {
            assert!(chunk.len() <= CHUNK_PRIMS);
            let first = chunk[0].bounds.lo.x > 5e5;
            assert!(chunk.iter().all(|i| (i.bounds.lo.x > 5e5) == first));
            seen.extend(chunk.iter().map(|i| i.object));
        }
        seen.sort_unstable();
        assert!(seen.iter().enumerate().all(|(k, &o)| k as u32 == o) && seen.len() == 100_000);
    }

    /// Checks that neither equal positions nor sizes that shrink forever make the recursion
    /// endless.
    #[test]
    fn what_cannot_be_parted_is_halved() {
        let count = 4 * CHUNK_PRIMS;
        assert_eq!(chunks(&mut items(count, |_| Vec3::ONE)).len(), 4);
        let shrinking = |k: usize| Vec3::X * libm::pow(0.5, k as f64 / 900.0) as f32 * 1e30;
        let mut all = items(count, shrinking);
        assert!(
            chunks(&mut all)
                .iter()
                .all(|c| c.len() <= CHUNK_PRIMS && !c.is_empty())
        );
    }
}
