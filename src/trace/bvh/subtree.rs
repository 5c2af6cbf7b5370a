//! The tree over some objects of a scene: the world's, or those of a mesh.

use super::build_input::BuildInput;
use super::clustering::{ChunkTree, Clustering, LeafObjects};
use super::division::Division;
use super::prim_ref::PrimRef;
use super::settings::Quality;
use super::upper::{WholeTree, upper_tree};
use super::{LeafPrims, Node, best};
use bumpalo::Bump;
use phalanx_scene::Bounds;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Cost of a tree by the surface area heuristic, without its root.
pub(super) fn relative_cost(weighted_cost: f64, bounds: Bounds) -> f64 {
    let area = f64::from(bounds.half_area());
    if area > 0.0 { weighted_cost / area } else { 0.0 }
}

/// Cost of a tree by the surface area heuristic; 0 for nothing.
pub(super) fn cost(weighted_cost: f64, bounds: Bounds) -> f64 {
    match bounds.is_empty() {
        true => 0.0,
        false => 1.0 + relative_cost(weighted_cost, bounds),
    }
}

/// A tree whose root is its node 0; no nodes by default.
#[derive(Default)]
pub(super) struct Subtree {
    pub(super) tree: WholeTree,
    pub(super) slots: LeafPrims,
}

impl Subtree {
    /// A root with two empty leaves.
    pub(super) fn of_nothing() -> Subtree {
        let tree = WholeTree {
            nodes: vec![Node::EMPTY],
            depth: 1,
            ..WholeTree::default()
        };
        Subtree {
            tree,
            slots: LeafPrims::default(),
        }
    }
}

/// The tree over some objects; `None` for none.
pub(super) fn build_subtree(
    input: &BuildInput,
    all: Vec<PrimRef>,
    quality: Quality,
) -> Option<Subtree> {
    if all.is_empty() {
        return None;
    }
    let division = Division::of(all, quality.chunk_prims());
    let threads = rayon::current_num_threads().min(division.len());
    let mut arenas: Vec<Bump> = (0..threads).map(|_| Bump::new()).collect();
    let chunks = chunk_trees(&division, quality, &mut arenas);
    let divisions = division.into_tree();
    let upper = upper_tree(&divisions, &chunks);
    let tree = WholeTree::new(&upper, &chunks);
    let objects: Vec<LeafObjects> = chunks.into_iter().map(|chunk| chunk.leaves).collect();
    // The nodes are in the whole tree, and rows in leaf order need as much memory again.
    arenas.into_par_iter().for_each(drop);
    let slots = LeafPrims::of_chunks(input, &objects);
    Some(Subtree { tree, slots })
}

/// The trees over all chunks. Each thread takes one chunk after another, and has an arena for their
/// nodes.
fn chunk_trees<'a>(
    division: &Division,
    quality: Quality,
    arenas: &'a mut [Bump],
) -> Vec<ChunkTree<'a>> {
    let next = AtomicUsize::new(0);
    let take = |arena: &'a mut Bump| {
        let (arena, mut builder) = (&*arena, ChunkBuilder::default());
        let chunks = std::iter::from_fn(|| {
            let k = next.fetch_add(1, Relaxed);
            (k < division.len()).then(|| {
                division.gather(k, &mut builder.objects);
                (k, builder.run(quality, arena))
            })
        });
        chunks.collect::<Vec<_>>()
    };
    let taken = arenas.par_iter_mut().with_max_len(1).flat_map_iter(take);
    let mut chunks: Vec<(usize, ChunkTree)> = taken.collect();
    chunks.sort_unstable_by_key(|&(k, _)| k);
    chunks.into_iter().map(|(_, chunk)| chunk).collect()
}

/// Memory that a thread uses for one chunk after another.
#[derive(Default)]
struct ChunkBuilder {
    objects: Vec<PrimRef>,
    clustering: Clustering,
}

impl ChunkBuilder {
    fn run<'a>(&mut self, quality: Quality, arena: &'a Bump) -> ChunkTree<'a> {
        let chunk = &self.objects[..];
        match quality {
            Quality::Fast => self.clustering.run::<4>(chunk, arena),
            Quality::Medium => self.clustering.run::<8>(chunk, arena),
            Quality::Best => best::chunk_tree(chunk, arena),
        }
    }
}
