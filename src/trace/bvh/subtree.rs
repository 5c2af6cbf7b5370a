//! The tree over some objects of a scene: the world's, or those of a mesh.

use super::build_input::BuildInput;
use super::clustering::{ChunkTree, Clustering};
use super::division::Division;
use super::prim_ref::PrimRef;
use super::settings::Quality;
use super::upper::{WholeTree, upper_tree};
use super::{LeafPrims, best};
use phalanx_scene::Bounds;
use rayon::prelude::*;

/// Cost of a tree by the surface area heuristic, without its root.
pub(super) fn relative_cost(weighted_cost: f64, bounds: Bounds) -> f64 {
    let area = f64::from(bounds.half_area());
    if area > 0.0 {
        weighted_cost / area
    } else {
        0.0
    }
}

/// A tree whose root is its node 0; no nodes by default.
#[derive(Default)]
pub(super) struct Subtree {
    pub(super) tree: WholeTree,
    pub(super) slots: LeafPrims,
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
    let chunks = (0..division.len()).into_par_iter().with_max_len(1);
    let chunks: Vec<ChunkTree> = chunks
        .map_init(ChunkBuilder::default, |builder, k| {
            division.gather(k, &mut builder.objects);
            builder.run(quality)
        })
        .collect();
    let divisions = division.into_tree();
    // The upper levels, which are optimised node by node, are few.
    let (upper, slots) = rayon::join(
        || upper_tree(&divisions, &chunks),
        || LeafPrims::of_chunks(input, &chunks),
    );
    let tree = WholeTree::new(&upper, &chunks);
    Some(Subtree { tree, slots })
}

/// Memory that a thread uses for one chunk after another.
#[derive(Default)]
struct ChunkBuilder {
    objects: Vec<PrimRef>,
    clustering: Clustering,
}

impl ChunkBuilder {
    fn run(&mut self, quality: Quality) -> ChunkTree {
        let chunk = &self.objects[..];
        match quality {
            Quality::Fast => self.clustering.run::<4>(chunk),
            Quality::Medium => self.clustering.run::<8>(chunk),
            Quality::Best => best::chunk_tree(chunk),
        }
    }
}
