//! Building on all threads: chunks of neighbouring objects become trees of obvhs's side by side, and a tree over the
//! upper nodes of all of them makes one of them.
//!
//! obvhs's own parallel build gains 15 % on two threads (its reinsertion is serial), and holds 220 bytes an object while
//! it works. Chunks are cut where the Morton order of the centres splits (Lauterbach et al., "Fast BVH Construction on
//! GPUs", 2009), which says nothing about cost; so the largest nodes of every chunk are taken apart again, and what
//! hangs below them is gathered by one more build over all chunks. `perf/notes/parallel-build.md` has the figures.
//!
//! Nothing depends on the number of threads: the same scene gives the same tree on every machine.

use super::join::join;
use super::objects::{Object, Objects};
use super::piece::{Base, Piece, Theirs, weighted_cost};
use super::{Bvh, Child, Node};
use crate::scene::{Bounds, Scene};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use rayon::prelude::*;
use std::time::Duration;

/// How much time a tree is worth. Figures stand in `perf/notes/tree-preset.md`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Soonest there, slowest to trace: for one small picture of a huge scene.
    Fastest,
    /// Less search and less reinsertion than the default.
    Fast,
    /// What pays for a picture of the usual size.
    #[default]
    Medium,
    /// Several times the build for a few percent of rate: for a cache that is rendered often.
    Best,
}

impl Quality {
    /// Every quality by name.
    pub const ALL: [(&'static str, Quality); 4] = [
        ("fastest", Quality::Fastest),
        ("fast", Quality::Fast),
        ("medium", Quality::Medium),
        ("best", Quality::Best),
    ];

    fn preset(self) -> BvhBuildParams {
        match self {
            Quality::Fastest => BvhBuildParams::very_fast_build(),
            Quality::Fast => BvhBuildParams::fast_build(),
            Quality::Medium => BvhBuildParams::medium_build(),
            Quality::Best => BvhBuildParams::very_slow_build(),
        }
    }
}

/// How to build.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildSettings {
    /// What the tree is worth.
    pub quality: Quality,
    /// Threads to build with; 0 for one per CPU. They change the time alone.
    pub threads: usize,
}

/// Most objects of a chunk: large enough that its border matters little, small enough for many threads.
const CHUNK: usize = 1 << 15;
/// Subtrees that a chunk is taken apart into.
const SUBTREES: usize = 64;

impl Bvh {
    /// Builds the tree of a scene with the default settings.
    pub fn build(scene: &Scene) -> Bvh {
        Bvh::build_with(scene, &BuildSettings::default())
    }

    /// Builds the tree of a scene.
    pub fn build_with(scene: &Scene, settings: &BuildSettings) -> Bvh {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads);
        match pool.build() {
            Ok(pool) if settings.threads > 0 => pool.install(|| build(scene, settings.quality)),
            // Without threads of its own the build goes on in those that there are.
            _ => build(scene, settings.quality),
        }
    }
}

fn build(scene: &Scene, quality: Quality) -> Bvh {
    let objects = Objects::new(scene);
    let Some(world) = grow(&objects, objects.world(), quality) else {
        return Bvh::empty();
    };
    let sah = 1.0 + weight_ratio(&world);
    let mut bvh = Bvh {
        depth: world.depth,
        nodes: world.nodes.into(),
        slots: world.slots,
        sah,
    };
    let meshes = (0..scene.meshes.len()).into_par_iter();
    let meshes: Vec<Option<Piece>> = meshes
        .map(|mesh| grow(&objects, objects.mesh(mesh), quality))
        .collect();
    let mut deepest = 0;
    let roots: Vec<u32> = meshes
        .into_iter()
        .flatten()
        .map(|mut mesh| {
            let base = Base::behind(bvh.nodes.len(), &bvh.slots);
            base.move_nodes(&mut mesh.nodes);
            bvh.nodes.extend(mesh.nodes);
            bvh.slots.append(mesh.slots);
            deepest = deepest.max(mesh.depth);
            base.node
        })
        .collect();
    for slot in bvh.slots.instances.iter_mut() {
        slot.root = roots[slot.root as usize];
    }
    bvh.depth += deepest;
    bvh
}

fn weight_ratio(piece: &Piece) -> f64 {
    let area = f64::from(piece.bounds.half_area());
    if area > 0.0 {
        piece.weighted_cost / area
    } else {
        0.0
    }
}

/// A tree whose root is its node 0; none over nothing.
fn grow(objects: &Objects, mut all: Vec<Object>, quality: Quality) -> Option<Piece> {
    if all.is_empty() {
        return None;
    }
    let whole = if all.len() <= CHUNK {
        let tree = build_chunk(objects, &all, quality);
        theirs(&tree, &all, objects).piece(0)
    } else {
        sort_by_place(objects, &mut all);
        let chunks: Vec<Vec<Piece>> = all
            .par_chunks(CHUNK)
            .map(|chunk| {
                let tree = build_chunk(objects, chunk, quality);
                let theirs = theirs(&tree, chunk, objects);
                let cut = largest_subtrees(&tree);
                cut.into_iter().map(|at| theirs.piece(at)).collect()
            })
            .collect();
        drop(all);
        let pieces: Vec<Piece> = chunks.into_iter().flatten().collect();
        let boxes: Vec<PaddedBox> = pieces.iter().map(|p| PaddedBox::new(p.bounds)).collect();
        let preset = BvhBuildParams {
            max_prims_per_leaf: 1,
            ..quality.preset()
        };
        join(pieces, &build_theirs(&boxes, preset))
    };
    Some(rooted(whole))
}

fn theirs<'a>(tree: &'a Bvh2, order: &'a [Object], objects: &'a Objects<'a>) -> Theirs<'a> {
    Theirs {
        tree,
        order,
        objects,
    }
}

/// The piece with a node at its root, even if all it has is one leaf.
fn rooted(mut piece: Piece) -> Piece {
    if let leaf @ Child::Leaf { .. } = piece.root {
        piece.weighted_cost += weighted_cost(leaf, piece.bounds);
        piece.nodes.push(Node::new([
            (leaf, piece.bounds),
            (Child::EMPTY, Bounds::EMPTY),
        ]));
        piece.root = Child::Node(0);
        piece.depth = 1;
    }
    piece
}

struct PaddedBox(Aabb);

impl PaddedBox {
    fn new(b: Bounds) -> PaddedBox {
        PaddedBox(Aabb::new(b.lo.into(), b.hi.into()))
    }
}

impl Boundable for PaddedBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

fn build_chunk(objects: &Objects, chunk: &[Object], quality: Quality) -> Bvh2 {
    let boxes = chunk
        .iter()
        .map(|&object| PaddedBox::new(objects.bounds(object)));
    let boxes: Vec<PaddedBox> = boxes.collect();
    build_theirs(&boxes, quality.preset())
}

fn build_theirs(boxes: &[PaddedBox], preset: BvhBuildParams) -> Bvh2 {
    // obvhs measures its own build; we time the whole load path instead.
    let mut unused = Duration::ZERO;
    build_bvh2(boxes, preset, &mut unused)
}

/// Bits of a Morton code for each axis.
const AXIS_BITS: u32 = 21;

/// Brings objects into the Morton order of their boxes' centres, those of one cell by number.
fn sort_by_place(objects: &Objects, all: &mut [Object]) {
    let center = |object: Object| {
        let b = objects.bounds(object);
        b.lo + b.hi
    };
    let extent = all.par_iter().map(|&object| {
        let c = center(object);
        Bounds::new(c, c)
    });
    let extent = extent.reduce(|| Bounds::EMPTY, Bounds::union);
    let cells = (1u32 << AXIS_BITS) as f32;
    let scale = (extent.hi - extent.lo).map(|e| if e > 0.0 { cells / e } else { 0.0 });
    let mut keyed: Vec<(u64, Object)> = all
        .par_iter()
        .map(|&object| {
            let cell = (center(object) - extent.lo) * scale;
            // The conversion saturates; so does the upper end, which falls on the border of the last cell.
            let cell = cell
                .to_array()
                .map(|c| (c as u32).min((1 << AXIS_BITS) - 1));
            (morton(cell), object)
        })
        .collect();
    keyed.par_sort_unstable();
    all.par_iter_mut()
        .zip(keyed)
        .for_each(|(object, (_, sorted))| *object = sorted);
}

/// The bits of three numbers, one of each in turn.
fn morton([x, y, z]: [u32; 3]) -> u64 {
    // Each step halves the runs of bits and doubles the gaps between them, until two zeros follow every bit.
    let spread = |v: u32| {
        let v = u64::from(v);
        let v = (v | v << 32) & 0x001f_0000_0000_ffff;
        let v = (v | v << 16) & 0x001f_0000_ff00_00ff;
        let v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
        let v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
        (v | v << 2) & 0x1249_2492_4924_9249
    };
    spread(x) | spread(y) << 1 | spread(z) << 2
}

/// The roots of about [`SUBTREES`] subtrees that together hold all, found by opening the largest box again and again.
fn largest_subtrees(tree: &Bvh2) -> Vec<usize> {
    let mut open = vec![0];
    while open.len() < SUBTREES {
        let area = |at: usize| tree.nodes[at].aabb().half_area();
        let inner = (0..open.len()).filter(|&k| tree.nodes[open[k]].prim_count == 0);
        let Some(largest) = inner.max_by(|&a, &b| area(open[a]).total_cmp(&area(open[b]))) else {
            break;
        };
        let first = tree.nodes[open[largest]].first_index as usize;
        open[largest] = first;
        open.push(first + 1);
    }
    open
}
