//! The build, on all threads: objects are divided into chunks from the top, each chunk is clustered
//! from below, and the upper levels are optimised as one tree.
//!
//! A tree whose upper levels are divided from the top costs less than one that is merged from below
//! throughout, and clusters cost less than divisions further down. `perf/notes/builder.md` has the
//! figures, and the builders that were tried.
//!
//! Nothing depends on the number of threads: the same scene gives the same tree on every machine.

use super::build_input::BuildInput;
use super::clustering::{self, ChunkTree, Clustering};
use super::division::Division;
use super::geometry_starts::GeometryStarts;
use super::huge_pages::move_to_huge_pages;
use super::offsets::Offsets;
use super::prim_ref::PrimRef;
use super::upper::{WholeTree, whole_tree};
use super::wide::widen;
use super::{Bvh, LeafPrims, WideBvh, best};
use phalanx_scene::{NO_PRIM, Scene};
use rayon::prelude::*;
use std::panic::resume_unwind;
use std::sync::OnceLock;

/// Trade of build time for tracing speed. No hit depends on it.
///
/// On two threads of one machine a million triangles took 0.08 to 0.11 s at [`Quality::Medium`] and
/// 0.8 to 1.1 s at [`Quality::Best`]: see `perf/notes/builder.md`.
///
/// ```
/// use phalanx_trace::bvh::Quality;
///
/// assert_eq!(Quality::default(), Quality::Medium);
/// assert_eq!(Quality::Best.name(), "best");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Clusters are compared with four neighbours on each side.
    Fast,
    /// Eight neighbours on each side: best total time for a picture.
    #[default]
    Medium,
    /// obvhs's most thorough trees: ten times the build time, for a cache that is rendered often,
    /// and the quality that `bench` measures.
    Best,
}

impl Quality {
    /// Every quality by name; `fastest` is another name of `fast`.
    pub const ALL: [(&'static str, Quality); 4] = [
        ("fast", Quality::Fast),
        ("fastest", Quality::Fast),
        ("medium", Quality::Medium),
        ("best", Quality::Best),
    ];

    /// The quality's name on the command line.
    pub fn name(self) -> &'static str {
        let known = Quality::ALL.iter().find(|(_, quality)| *quality == self);
        known.map_or("", |(name, _)| name)
    }

    /// Most objects of a chunk.
    fn chunk_prims(self) -> usize {
        match self {
            Quality::Fast | Quality::Medium => clustering::CHUNK_PRIMS,
            Quality::Best => best::CHUNK_PRIMS,
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
    /// # Panics
    /// If columns that were filled by hand show more primitives than 32 bits can number.
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
    /// assert_eq!(bvh.leaf_prims().spheres.len(), 2);
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
    let ids = scene.id_count();
    assert!(ids < u64::from(NO_PRIM), "{ids} primitives have no numbers");
    let objects = BuildInput::new(scene);
    let Some(world) = build_subtree(&objects, objects.world(), quality) else {
        return Bvh::empty();
    };
    let mut bvh = Bvh {
        depth: world.tree.depth,
        sah: 1.0 + relative_cost(&world.tree),
        nodes: world.tree.nodes.into(),
        slots: world.slots,
        wide: OnceLock::new(),
        geometries: GeometryStarts::of(scene),
    };
    let meshes = (0..scene.meshes.len()).into_par_iter();
    let meshes: Vec<Option<Subtree>> = meshes
        .map(|mesh| build_subtree(&objects, objects.mesh(mesh), quality))
        .collect();
    append_meshes(&mut bvh, meshes.into_iter().flatten().collect());
    bvh
}

/// Appends the trees of meshes, and leads the instances to them.
fn append_meshes(bvh: &mut Bvh, meshes: Vec<Subtree>) {
    if meshes.is_empty() {
        return;
    }
    let mut deepest = 0;
    let append = |mesh: Subtree| {
        let offsets = Offsets::after(bvh.nodes.len(), &bvh.slots);
        let mut nodes = mesh.tree.nodes;
        offsets.rebase_nodes(&mut nodes);
        bvh.nodes.extend(nodes);
        bvh.slots.append(&mesh.slots);
        deepest = deepest.max(mesh.tree.depth);
        offsets.node
    };
    let roots: Vec<u32> = meshes.into_iter().map(append).collect();
    for slot in bvh.slots.instances.iter_mut() {
        slot.root = roots[slot.root as usize];
    }
    bvh.depth += deepest;
    move_to_huge_pages(bvh.nodes.make_mut());
    move_to_huge_pages(bvh.slots.triangles.make_mut());
    move_to_huge_pages(bvh.slots.spheres.make_mut());
}

fn relative_cost(tree: &WholeTree) -> f64 {
    let area = f64::from(tree.bounds.half_area());
    if area > 0.0 {
        tree.weighted_cost / area
    } else {
        0.0
    }
}

/// A tree whose root is its node 0.
struct Subtree {
    tree: WholeTree,
    slots: LeafPrims,
}

/// The tree over some objects; `None` for none.
fn build_subtree(input: &BuildInput, all: Vec<PrimRef>, quality: Quality) -> Option<Subtree> {
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
    let tree = whole_tree(&division.into_tree(), &chunks);
    let slots = LeafPrims::of_chunks(input, &chunks);
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
