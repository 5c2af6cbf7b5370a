//! Building on all threads: objects are parted into chunks from the top, the chunks become trees of
//! obvhs's side by side, and a small tree over the chunks makes one of them.
//!
//! obvhs's own parallel build gains 15 % on two threads (its reinsertion is serial), and holds 220
//! bytes an object while it works. Built in chunks the tree costs less, too, by the surface area
//! heuristic: its upper levels are better parted from the top than gathered from below.
//! `perf/notes/parallel-build.md` has the figures.
//!
//! Nothing depends on the number of threads: the same scene gives the same tree on every machine.

use super::build_input::{BuildInput, PrimIndex};
use super::chunks::{chunks, prim_refs};
use super::huge_pages::move_to_huge_pages;
use super::merge::merge;
use super::subtree::{ObvhsTree, Offsets, Subtree, weighted_cost};
use super::{Bvh, Child, Node, WideBvh, ploc};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use phalanx_scene::{Bounds, Scene};
use rayon::prelude::*;
use std::panic::resume_unwind;
use std::sync::OnceLock;

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
    /// Two to three times the build for 2 to 9 % of rate: for a cache that is rendered often, and
    /// what `bench` measures.
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

    /// As on the command line.
    pub fn name(self) -> &'static str {
        let known = Quality::ALL.iter().find(|(_, quality)| *quality == self);
        known.map_or("", |(name, _)| name)
    }

    pub(super) fn preset(self) -> BvhBuildParams {
        match self {
            Quality::Fastest => BvhBuildParams::very_fast_build(),
            Quality::Fast => BvhBuildParams::fast_build(),
            // Neighbours are looked for from the second round on, not from the fourth: trees 3 to 5
            // % cheaper for next to nothing (perf/notes/tree-preset.md).
            Quality::Medium => BvhBuildParams {
                search_depth_threshold: 1,
                ..BvhBuildParams::medium_build()
            },
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

impl Bvh {
    /// Builds the tree of a scene with the default settings.
    pub fn build(scene: &Scene) -> Bvh {
        Bvh::build_with(scene, &BuildSettings::default())
    }

    /// Builds the tree of a scene.
    pub fn build_with(scene: &Scene, settings: &BuildSettings) -> Bvh {
        run_on_threads(settings.threads, || build(scene, settings.quality))
    }

    /// The world's tree with as many children a node as there are lanes; made when it is first
    /// asked for, on one thread per CPU.
    pub fn wide(&self) -> &WideBvh {
        self.wide_on(0)
    }

    /// Makes [`Bvh::wide`], if it has not been made, on so many threads; 0 for one per CPU. They
    /// change the time alone.
    pub fn build_wide(&self, threads: usize) {
        self.wide_on(threads);
    }

    /// Whoever asks while it is made waits, and may be a thread of rayon's: one that waited for
    /// work of its own pool would take up other work meanwhile, which may ask for the tree, too. So
    /// it is made in threads of its own.
    fn wide_on(&self, threads: usize) -> &WideBvh {
        self.wide.get_or_init(|| {
            let threads = match threads {
                0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
                some => some,
            };
            let make = || run_on_threads(threads, || Box::new(WideBvh::of(self)));
            std::thread::scope(|scope| {
                match std::thread::Builder::new().spawn_scoped(scope, make) {
                    Ok(maker) => maker.join().unwrap_or_else(|panic| resume_unwind(panic)),
                    Err(_) => make(),
                }
            })
        })
    }
}

fn run_on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    if threads == 0 {
        return work();
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    match pool.build() {
        Ok(pool) => pool.install(work),
        // Without threads of its own the work goes on in those that there are.
        Err(_) => work(),
    }
}

fn build(scene: &Scene, quality: Quality) -> Bvh {
    let objects = BuildInput::new(scene);
    let Some(world) = build_subtree(&objects, objects.world(), quality) else {
        return Bvh::empty();
    };
    let sah = 1.0 + relative_cost(&world);
    let mut bvh = Bvh {
        depth: world.depth,
        nodes: world.nodes.into(),
        slots: world.slots,
        sah,
        wide: OnceLock::new(),
    };
    let meshes = (0..scene.meshes.len()).into_par_iter();
    let meshes: Vec<Option<Subtree>> = meshes
        .map(|mesh| build_subtree(&objects, objects.mesh(mesh), quality))
        .collect();
    let mut deepest = 0;
    let roots: Vec<u32> = meshes
        .into_iter()
        .flatten()
        .map(|mut mesh| {
            let offsets = Offsets::after(bvh.nodes.len(), &bvh.slots);
            offsets.rebase_nodes(&mut mesh.nodes);
            bvh.nodes.extend(mesh.nodes);
            bvh.slots.append(mesh.slots);
            deepest = deepest.max(mesh.depth);
            offsets.node
        })
        .collect();
    for slot in bvh.slots.instances.iter_mut() {
        slot.root = roots[slot.root as usize];
    }
    bvh.depth += deepest;
    move_to_huge_pages(bvh.nodes.make_mut());
    move_to_huge_pages(bvh.slots.triangles.make_mut());
    move_to_huge_pages(bvh.slots.spheres.make_mut());
    bvh
}

fn relative_cost(subtree: &Subtree) -> f64 {
    let area = f64::from(subtree.bounds.half_area());
    if area > 0.0 {
        subtree.weighted_cost / area
    } else {
        0.0
    }
}

/// A tree whose root is its node 0; none over nothing.
fn build_subtree(objects: &BuildInput, all: Vec<PrimIndex>, quality: Quality) -> Option<Subtree> {
    let mut all = prim_refs(objects, all);
    let chunks = chunks(&mut all);
    let subtrees = chunks.into_par_iter().filter_map(|chunk| {
        let boxes: Vec<Aabb> = chunk.iter().map(|item| aabb(item.bounds)).collect();
        let theirs = ObvhsTree {
            tree: &ploc::build(&boxes, &quality.preset())?,
            chunk,
            objects,
        };
        Some(theirs.subtree())
    });
    let mut subtrees: Vec<Subtree> = subtrees.collect();
    drop(all);
    let whole = match subtrees.len() {
        0 | 1 => subtrees.pop()?,
        _ => {
            let boxes: Vec<Aabb> = subtrees.iter().map(|p| aabb(p.bounds)).collect();
            let preset = BvhBuildParams {
                max_prims_per_leaf: 1,
                ..quality.preset()
            };
            merge(subtrees, &ploc::build(&boxes, &preset)?)
        }
    };
    Some(rooted(whole))
}

/// The piece with a node at its root, even if all it has is one leaf.
fn rooted(mut subtree: Subtree) -> Subtree {
    if let leaf @ Child::Leaf { .. } = subtree.root {
        subtree.weighted_cost += weighted_cost(leaf, subtree.bounds);
        subtree.nodes.push(Node::new([
            (leaf, subtree.bounds),
            (Child::EMPTY, Bounds::EMPTY),
        ]));
        subtree.root = Child::Node(0);
        subtree.depth = 1;
    }
    subtree
}

/// A box as obvhs has it.
fn aabb(b: Bounds) -> Aabb {
    Aabb::new(b.lo.into(), b.hi.into())
}
