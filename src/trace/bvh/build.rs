//! Parallel build. Objects are divided into chunks from the top, obvhs builds trees over the chunks
//! side by side, and a small tree over the chunks joins them to one.
//!
//! obvhs's own parallel build gains 15 % on two threads (its reinsertion is serial), and holds 220
//! bytes an object while it works. A tree built in chunks also costs less by the surface area
//! heuristic: its upper levels are divided better from the top than they are merged from below.
//! `perf/notes/parallel-build.md` has the figures.
//!
//! Nothing depends on the number of threads: the same scene gives the same tree on every machine.

use super::build_input::{BuildInput, PrimIndex};
use super::chunks::chunks;
use super::geometry_starts::GeometryStarts;
use super::huge_pages::move_to_huge_pages;
use super::merge::merge;
use super::subtree::{ObvhsTree, Offsets, Subtree, weighted_cost};
use super::wide::widen;
use super::{Bvh, Child, Node, WideBvh, ploc};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use phalanx_scene::{Bounds, Scene};
use rayon::prelude::*;
use std::panic::resume_unwind;
use std::sync::OnceLock;

/// Trade of build time for tracing speed. No hit depends on it.
///
/// On two threads of one machine a million triangles took 0.27 to 0.38 s at [`Quality::Medium`] and
/// 0.72 to 0.94 s at [`Quality::Best`]: see `perf/notes/tree-preset.md`.
///
/// ```
/// use phalanx_trace::bvh::Quality;
///
/// assert_eq!(Quality::default(), Quality::Medium);
/// assert_eq!(Quality::Best.name(), "best");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Fastest build, slowest to trace: for one small picture of a huge scene.
    Fastest,
    /// Less search and less reinsertion than the default.
    Fast,
    /// Best total time for a picture of the usual size.
    #[default]
    Medium,
    /// Two to three times the build time for 2 to 9 % of rate: for a cache that is rendered often,
    /// and the quality that `bench` measures.
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

    /// The quality's name on the command line.
    pub fn name(self) -> &'static str {
        let known = Quality::ALL.iter().find(|(_, quality)| *quality == self);
        known.map_or("", |(name, _)| name)
    }

    pub(super) fn preset(self) -> BvhBuildParams {
        match self {
            Quality::Fastest => BvhBuildParams::very_fast_build(),
            Quality::Fast => BvhBuildParams::fast_build(),
            // Neighbours are searched from the second round on, not from the fourth: trees 3 to 5 %
            // cheaper for next to nothing (perf/notes/tree-preset.md).
            Quality::Medium => BvhBuildParams {
                search_depth_threshold: 1,
                ..BvhBuildParams::medium_build()
            },
            Quality::Best => BvhBuildParams::very_slow_build(),
        }
    }
}

/// Settings of a build: see [`Bvh::build_with`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildSettings {
    /// Trade of build time for tracing speed.
    pub quality: Quality,
    /// Threads to build with; 0 for one per CPU. They change only the time.
    pub threads: usize,
}

impl Bvh {
    /// Builds the tree of a scene: [`Quality::Medium`], one thread per CPU.
    ///
    /// The scene may be empty, and is not needed afterwards. The tree does not follow later changes
    /// of the scene: build it anew. The same scene gives the same tree on every machine. Meshes and
    /// spheres that came as slices were checked; columns that were filled by hand go through
    /// [`Scene::validate`] first.
    ///
    /// ```
    /// use phalanx_scene::Scene;
    /// use phalanx_trace::{Ray, bvh::Bvh};
    ///
    /// let mut scene = Scene::new();
    /// let ray = Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]);
    /// assert!(Bvh::build(&scene).intersect(&ray).is_none());
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// assert!(Bvh::build(&scene).intersect(&ray).is_some());
    /// # Ok::<(), phalanx_scene::GeometryError>(())
    /// ```
    pub fn build(scene: &Scene) -> Bvh {
        Bvh::build_with(scene, &BuildSettings::default())
    }

    /// Builds the tree of a scene as [`Bvh::build`] does, with another quality or on fewer threads.
    ///
    /// ```
    /// use phalanx_scene::Scene;
    /// use phalanx_trace::bvh::{BuildSettings, Bvh, Quality};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3], [3.0, 0.0, 0.0]], &[1.0, 1.0])?;
    /// let settings = BuildSettings { quality: Quality::Best, threads: 1 };
    /// let bvh = Bvh::build_with(&scene, &settings);
    /// assert_eq!(bvh.spheres().len(), 2);
    /// # Ok::<(), phalanx_scene::GeometryError>(())
    /// ```
    pub fn build_with(scene: &Scene, settings: &BuildSettings) -> Bvh {
        run_on_threads(settings.threads, || build(scene, settings.quality))
    }

    /// The world's tree with as many children a node as there are lanes. It is made at the first
    /// call, on one thread per CPU.
    pub fn wide(&self) -> &WideBvh {
        self.wide_on(0)
    }

    /// Makes [`Bvh::wide`], if it has not been made, on the given number of threads; 0 for one per
    /// CPU. They change only the time. The first large batch does the same; call this before a
    /// clock is started, or where the first answer must not wait.
    ///
    /// ```
    /// use phalanx_scene::Scene;
    /// use phalanx_trace::bvh::Bvh;
    ///
    /// let bvh = Bvh::build(&Scene::new());
    /// assert!(!bvh.has_wide());
    /// bvh.build_wide(0);
    /// assert!(bvh.has_wide());
    /// ```
    pub fn build_wide(&self, threads: usize) {
        self.wide_on(threads);
    }

    /// Makes the wide tree on threads of its own, while other callers wait. A caller may be a rayon
    /// worker. If it waited for work of its own pool, it would take up other work meanwhile, which
    /// may call this, too, and deadlock.
    fn wide_on(&self, threads: usize) -> &WideBvh {
        self.wide.get_or_init(|| {
            let threads = match threads {
                0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
                some => some,
            };
            let make = || run_on_threads(threads, || Box::new(widen(self)));
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
        // If no thread pool can be made, the current threads do the work.
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
        geometries: GeometryStarts::of(scene),
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

/// A tree whose root is its node 0; `None` for no objects.
fn build_subtree(objects: &BuildInput, all: Vec<PrimIndex>, quality: Quality) -> Option<Subtree> {
    let mut all = objects.prim_refs(all);
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

/// The subtree with a node at its root, even if its only content is one leaf.
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

/// Converts a box to obvhs's type.
fn aabb(b: Bounds) -> Aabb {
    Aabb::new(b.lo.into(), b.hi.into())
}
