//! The build, on all threads: objects are divided into chunks from the top, each chunk is clustered
//! from below, and the upper levels are optimised as one tree.
//!
//! A tree whose upper levels are divided from the top costs less than one that is merged from below
//! throughout, and clusters cost less than divisions further down. `perf/notes/builder.md` has the
//! figures, and the builders that were tried.
//!
//! Nothing depends on the number of threads: the same scene gives the same tree on every machine.

use super::build_input::BuildInput;
use super::geometry_starts::GeometryStarts;
use super::settings::BuildSettings;
use super::subtree::{Subtree, build_subtree, cost};
use super::tree_parts::TreeParts;
use super::{Bvh, WideBvh};
use phalanx_scene::huge_pages::move_to_huge_pages;
use phalanx_scene::{NO_PRIM, Scene, on_pool, thread_count};
use rayon::prelude::*;
use std::panic::resume_unwind;

/// Minimum number of rows for which a thread is made: it takes as long as building a tree of some
/// hundred.
const ROWS_PER_THREAD: usize = 1 << 9;

impl Bvh {
    /// Builds the tree of a scene: [`Quality::Medium`](super::Quality::Medium), one thread per CPU.
    ///
    /// The scene may be empty, and is not needed afterwards. The tree follows later changes of the
    /// scene by [`Bvh::update`]. The same scene gives the same tree on every machine. Meshes and
    /// spheres that came as slices were checked; columns that were filled by hand go through
    /// [`Scene::validate`] first.
    ///
    /// # Panics
    /// If columns that were filled by hand show more primitives than 32 bits can number.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Ray, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let ray = Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]);
    /// assert!(Bvh::build(&scene).intersect(&ray).is_none());
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// assert!(Bvh::build(&scene).intersect(&ray).is_some());
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn build(scene: &Scene) -> Bvh {
        Bvh::build_with(scene, &BuildSettings::default())
    }

    /// Builds the tree of a scene as [`Bvh::build`] does, with another quality or on fewer threads.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{BuildSettings, Bvh, Quality, Scene};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3], [3.0, 0.0, 0.0]], &[1.0, 1.0])?;
    /// let settings = BuildSettings { quality: Quality::Best, threads: 1 };
    /// let bvh = Bvh::build_with(&scene, &settings);
    /// assert_eq!(bvh.leaf_prims().spheres.len(), 2);
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn build_with(scene: &Scene, settings: &BuildSettings) -> Bvh {
        run_on_threads(settings.threads, scene.prims.len(), || {
            on_pool(|| build(scene, settings))
        })
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
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Scene};
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
            let threads = thread_count(threads);
            let nodes = self.nodes.len();
            let widen = || Box::new(WideBvh::of(self, self.parts.as_deref()));
            let make = || run_on_threads(threads, nodes, || on_pool(widen));
            std::thread::scope(|scope| {
                match std::thread::Builder::new().spawn_scoped(scope, make) {
                    Ok(maker) => maker.join().unwrap_or_else(|panic| resume_unwind(panic)),
                    Err(_) => make(),
                }
            })
        })
    }
}

/// Does the work of `rows` primitives or nodes on threads of its own; 0 for one per CPU.
pub(super) fn run_on_threads<T>(threads: usize, rows: usize, work: impl FnOnce() -> T + Send) -> T
where
    T: Send,
{
    if threads == 0 {
        return work();
    }
    let threads = threads.min(1 + rows / ROWS_PER_THREAD);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    match pool.build() {
        Ok(pool) => pool.install(work),
        // If no thread pool can be made, the existing threads do the work.
        Err(_) => work(),
    }
}

fn build(scene: &Scene, settings: &BuildSettings) -> Bvh {
    let ids = scene.id_count();
    assert!(ids < u64::from(NO_PRIM), "{ids} primitives have no numbers");
    let quality = settings.quality;
    let input = BuildInput::new(scene, Vec::new());
    let meshes = (0..scene.meshes.len()).into_par_iter();
    let meshes: Vec<Subtree> = meshes
        .map(|mesh| build_subtree(&input, input.mesh(mesh), quality).unwrap_or_default())
        .collect();
    let bounds = meshes.iter().map(|mesh| mesh.tree.bounds).collect();
    let input = BuildInput::new(scene, bounds);
    let world = build_subtree(&input, input.world(), quality);
    let world = world.unwrap_or_else(Subtree::of_nothing);
    let mut parts = TreeParts::of(scene, settings, &world);
    let mut bvh = Bvh {
        depth: world.tree.depth,
        sah: cost(world.tree.weighted_cost, world.tree.bounds),
        nodes: world.tree.nodes.into(),
        slots: world.slots,
        geometries: GeometryStarts::of(scene),
        ..Bvh::default()
    };
    append_meshes(&mut bvh, meshes, &mut parts);
    bvh.parts = Some(Box::new(parts));
    bvh
}

/// Appends the trees of meshes, and leads the instances to them.
fn append_meshes(bvh: &mut Bvh, meshes: Vec<Subtree>, parts: &mut TreeParts) {
    if meshes.is_empty() {
        return;
    }
    let mut deepest = 0;
    for mesh in meshes {
        deepest = deepest.max(mesh.tree.depth);
        let part = parts.place((&mut bvh.nodes, &mut bvh.slots), mesh);
        parts.prototypes.push(part);
    }
    parts.lead_to_prototypes(&mut bvh.slots.instances);
    bvh.depth += deepest;
    move_to_huge_pages(bvh.nodes.make_mut());
    move_to_huge_pages(bvh.slots.triangles.make_mut());
    move_to_huge_pages(bvh.slots.spheres.make_mut());
}
