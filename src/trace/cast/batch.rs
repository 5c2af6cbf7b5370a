//! Columns in, columns out: worker threads trace chunks of rays.

use super::columns::same_length;
use super::hit_lists::HitLists;
use super::rows::TransposedRays;
use super::scan_order::ScanOrder;
use super::small_batch::{self, FEW};
use super::worker::{RowNumbers, Worker};
use super::{BatchError, Hit, HitColumns, RayBatch, RayColumns};
use crate::bvh::Bvh;
use crate::traverse::Kernel;
use std::sync::{Mutex, PoisonError};

/// Rays that a worker takes at once: several beams, and few enough that rays and hits stay in the
/// second-level cache.
const CHUNK: usize = 2048;

/// Weight of rays of earlier batches in the decision to build the wide tree: a tree that is queried
/// again will be queried more. Incoherent rays pay for it with half a ray per primitive.
const EARLIER_RAYS: u64 = 8;

/// Maximum number of rays for which kernels are not compared: trials would take longer than they
/// save.
const SMALL: usize = 512;

impl Bvh {
    /// Finds the closest hit of every ray; [`HitColumns`] describes a miss. The bits are those of
    /// [`Bvh::intersect`] for each ray, for any order, batch size and number of threads.
    ///
    /// `threads` is the number of threads, 0 for one per CPU; a batch of up to 2048 rays stays on
    /// the caller's thread. A batch of up to 512 rays costs no more per ray than
    /// [`Bvh::intersect`]. For larger ones, kernels are chosen for 512 rays at a time
    /// ([`Kernel::Auto`]): beams, packets or single rays; each call then allocates a few hundred
    /// KiB of working memory per thread, which pays off for 10 000 rays or more. Small batches,
    /// large ones and many in a row build [`Bvh::wide`], if there is none; [`Bvh::build_wide`] does
    /// so ahead of time.
    ///
    /// # Errors
    /// [`BatchError`] if columns differ in length; nothing is written then.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, HitBuffer, Ray, RayBuffer, Scene};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// let bvh = Bvh::build(&scene);
    /// let rays: RayBuffer = [[0.0, 0.0, -3.0], [5.0, 0.0, -3.0]]
    ///     .map(|origin| Ray::new(origin, [0.0, 0.0, 1.0]))
    ///     .into_iter()
    ///     .collect();
    /// let mut hits = HitBuffer::new(rays.len());
    /// bvh.intersect_batch(&rays.columns(), &mut hits.columns(), 0)?;
    /// assert_eq!(hits.get(0).map(|hit| hit.t), Some(2.0));
    /// assert_eq!(hits.get(1), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn intersect_batch<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        hits: &mut HitColumns,
        threads: usize,
    ) -> Result<(), BatchError> {
        self.closest_of(rays.into(), hits, threads)
    }

    fn closest_of(
        &self,
        rays: RayBatch,
        hits: &mut HitColumns,
        threads: usize,
    ) -> Result<(), BatchError> {
        rays.check()?;
        hits.check(rays.len())?;
        if is_small(self, &rays) {
            small_batch::closest(self, &rays, |k, hit| hits.put(k, hit));
            return Ok(());
        }
        let order = scan_order(&rays);
        let chunk = chunk_of(&order);
        let work =
            |worker: &mut Worker, rays: &RayColumns, hits: &mut HitColumns, places: RowNumbers| {
                worker.closest(rays, hits, places);
            };
        run(self, (rays, &order), threads, hits.chunks(chunk), work);
        Ok(())
    }

    /// As [`Bvh::intersect_batch`], for hits that do not go to columns: `put` gets the number of
    /// each ray and its hit, once, on the thread that traced it and in any order.
    ///
    /// # Errors
    /// [`BatchError`] if columns differ in length; `put` is not called then.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Ray, RayBuffer, Scene};
    /// use std::sync::atomic::{AtomicUsize, Ordering};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// let rays: RayBuffer =
    ///     (0..1000).map(|x| Ray::new([x as f32 * 0.011, 0.0, -3.0], [0.0, 0.0, 1.0])).collect();
    /// let met = AtomicUsize::new(0);
    /// Bvh::build(&scene).intersect_batch_each(&rays.columns(), 0, |_, hit| {
    ///     met.fetch_add(usize::from(hit.is_some()), Ordering::Relaxed);
    /// })?;
    /// assert_eq!(met.into_inner(), 91);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn intersect_batch_each<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        threads: usize,
        put: impl Fn(usize, Option<Hit>) + Sync,
    ) -> Result<(), BatchError> {
        let rays = rays.into();
        rays.check()?;
        if is_small(self, &rays) {
            small_batch::closest(self, &rays, &put);
            return Ok(());
        }
        let order = scan_order(&rays);
        let firsts = (0..rays.len()).step_by(chunk_of(&order));
        let work =
            |worker: &mut Worker, rays: &RayColumns, first: &mut usize, places: RowNumbers| {
                worker.closest_each(rays, |k, hit| {
                    put(*first + places.map_or(k, |places| places[k] as usize), hit);
                });
            };
        run(self, (rays, &order), threads, firsts, work);
        Ok(())
    }

    /// Determines for every ray if it hits anything before its `tmax`. Threads, kernels and cost
    /// are as for [`Bvh::intersect_batch`]; the search ends at the first hit, so it is faster.
    ///
    /// # Errors
    /// [`BatchError`] if columns differ in length; nothing is written then.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, RayColumns, Scene, TMax};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// let bvh = Bvh::build(&scene);
    /// let (x, y, z) = ([0.0, 5.0, 0.0], [0.0; 3], [-3.0; 3]);
    /// let (level, ahead) = ([0.0; 3], [1.0; 3]);
    /// let rays = RayColumns {
    ///     origin: [&x, &y, &z],
    ///     direction: [&level, &level, &ahead],
    ///     tmax: TMax::Each(&[9.0, 9.0, 1.0]),
    /// };
    /// let mut blocked = [false; 3];
    /// bvh.occluded_batch(&rays, &mut blocked, 1)?;
    /// assert_eq!(blocked, [true, false, false]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn occluded_batch<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        blocked: &mut [bool],
        threads: usize,
    ) -> Result<(), BatchError> {
        self.occluded_of(rays.into(), blocked, threads)
    }

    fn occluded_of(
        &self,
        rays: RayBatch,
        blocked: &mut [bool],
        threads: usize,
    ) -> Result<(), BatchError> {
        rays.check()?;
        same_length("blocked", blocked.len(), rays.len())?;
        if is_small(self, &rays) {
            small_batch::occluded(self, &rays, blocked);
            return Ok(());
        }
        let order = scan_order(&rays);
        let chunk = chunk_of(&order);
        let work =
            |worker: &mut Worker, rays: &RayColumns, out: &mut &mut [bool], places: RowNumbers| {
                worker.occluded(rays, out, places);
            };
        run(
            self,
            (rays, &order),
            threads,
            blocked.chunks_mut(chunk),
            work,
        );
        Ok(())
    }

    /// Finds all hits of each ray before its `tmax`, not only the closest: see [`HitLists`].
    /// Threads are as for [`Bvh::intersect_batch`]. A list costs as much as an unobstructed ray,
    /// plus sorting.
    ///
    /// # Errors
    /// [`BatchError`] if columns differ in length.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Ray, RayBuffer, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    /// for z in [1.0, 2.0, 3.0] {
    ///     scene.add_mesh(&corners.map(|[x, y, _]| [x, y, z]), &[[0, 1, 2]])?;
    /// }
    /// let bvh = Bvh::build(&scene);
    /// let rays: RayBuffer = [[1.0, 1.0, 0.0], [9.0, 9.0, 0.0], [1.0, 1.0, 2.5]]
    ///     .map(|origin| Ray::new(origin, [0.0, 0.0, 1.0]))
    ///     .into_iter()
    ///     .collect();
    /// let lists = bvh.all_hits_batch(&rays.columns(), 0)?;
    /// assert_eq!(lists.starts, [0, 3, 3, 4]);
    /// assert_eq!(lists.t, [1.0, 2.0, 3.0, 0.5]);
    /// assert_eq!(lists.prim_id, [0, 1, 2, 2]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn all_hits_batch<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        threads: usize,
    ) -> Result<HitLists, BatchError> {
        self.all_hits_of(rays.into(), threads)
    }

    fn all_hits_of(&self, rays: RayBatch, threads: usize) -> Result<HitLists, BatchError> {
        rays.check()?;
        let mut parts = vec![HitLists::empty(); rays.len().div_ceil(CHUNK)];
        let work =
            |worker: &mut Worker, rays: &RayColumns, part: &mut &mut HitLists, _: RowNumbers| {
                for list in worker.hit_lists(rays) {
                    part.push(
                        list.iter()
                            .map(|hit| self.hit_of([hit.t, hit.u, hit.v], hit.prim_id)),
                    );
                }
            };
        run(self, (rays, &None), threads, parts.iter_mut(), work);
        Ok(HitLists::joined(&parts))
    }

    /// Counts the hits of each ray before its `tmax`: the lengths of [`Bvh::all_hits_batch`]'s
    /// lists, without the lists.
    ///
    /// # Errors
    /// [`BatchError`] if columns differ in length; nothing is written then.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Ray, RayBuffer, Scene};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3], [0.0, 0.0, 5.0]], &[1.0, 1.0])?;
    /// let bvh = Bvh::build(&scene);
    /// let rays: RayBuffer = [-3.0, 3.0]
    ///     .map(|z| Ray::new([0.0, 0.0, z], [0.0, 0.0, 1.0]))
    ///     .into_iter()
    ///     .collect();
    /// let mut counts = [0; 2];
    /// bvh.count_batch(&rays.columns(), &mut counts, 0)?;
    /// // A sphere counts once, though a line may cross it twice.
    /// assert_eq!(counts, [2, 1]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn count_batch<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        counts: &mut [u32],
        threads: usize,
    ) -> Result<(), BatchError> {
        self.count_of(rays.into(), counts, threads)
    }

    fn count_of(
        &self,
        rays: RayBatch,
        counts: &mut [u32],
        threads: usize,
    ) -> Result<(), BatchError> {
        rays.check()?;
        same_length("counts", counts.len(), rays.len())?;
        let work =
            |worker: &mut Worker, rays: &RayColumns, counts: &mut &mut [u32], _: RowNumbers| {
                counts.fill(0);
                for hit in worker.find_every_hit(rays) {
                    counts[hit.ray as usize] += 1;
                }
            };
        run(self, (rays, &None), threads, counts.chunks_mut(CHUNK), work);
        Ok(())
    }
}

/// The order in which a picture's rays are traced; `None` for small batches, where sorting does not
/// pay.
fn scan_order(rays: &RayBatch) -> Option<ScanOrder> {
    (rays.len() > SMALL).then(|| ScanOrder::of(rays))?
}

/// Rays in a chunk.
fn chunk_of(order: &Option<ScanOrder>) -> usize {
    order.as_ref().map_or(CHUNK, ScanOrder::band)
}

/// Returns true if rays are traced singly: if their batch is small, and not within instances, where
/// single rays are packets of one; a few rays are in any case.
fn is_small(bvh: &Bvh, rays: &RayBatch) -> bool {
    rays.len() <= FEW || (rays.len() <= SMALL && bvh.leaf_prims().instances.is_empty())
}

/// Kernel for a batch of `count` rays. For small batches single rays are the fastest, but for
/// coherent rays in simple scenes, and never much slower than calls for one ray; within instances
/// they would be packets of one.
fn kernel_of(bvh: &Bvh, count: usize) -> Kernel {
    if count > SMALL {
        Kernel::Auto.for_frame(bvh, count as u64 + EARLIER_RAYS * bvh.count_rays(count))
    } else if bvh.leaf_prims().instances.is_empty() {
        Kernel::Single
    } else {
        Kernel::packets()
    }
}

/// Processes a batch, chunk by chunk, on at most `threads` threads, including the caller's.
/// `outputs` has a slot for the answers of each chunk.
fn run<'a, O: Send>(
    bvh: &'a Bvh,
    (rays, order): (RayBatch, &Option<ScanOrder>),
    threads: usize,
    outputs: impl Iterator<Item = O> + Send,
    work: impl Fn(&mut Worker<'a>, &RayColumns, &mut O, RowNumbers) + Sync,
) {
    let (count, chunk) = (rays.len(), chunk_of(order));
    if count == 0 {
        return;
    }
    let threads = thread_count(threads, count.div_ceil(chunk));
    let kernel = kernel_of(bvh, count);
    if kernel.is_wide() {
        bvh.build_wide(threads);
    }
    let starts = (0..count).step_by(chunk);
    let chunks = starts.map(|from| rays.slice(from, (from + chunk).min(count)));
    share(chunks.zip(outputs), threads, |next| {
        let mut worker = Worker::new(bvh, kernel);
        let mut transposed = TransposedRays::default();
        while let Some((rays, mut output)) = next() {
            let places = order.as_ref().and_then(|order| order.places(rays.len()));
            let Some(places) = places else {
                work(&mut worker, &transposed.columns(&rays), &mut output, None);
                continue;
            };
            for places in places.chunks(CHUNK) {
                let picked = transposed.picked(&rays, places);
                work(&mut worker, &picked, &mut output, Some(places));
            }
        }
    });
}

/// Number of threads to use: one per CPU for 0, and at most one per chunk.
pub(super) fn thread_count(threads: usize, chunks: usize) -> usize {
    match threads {
        // It asks the system, which takes as long as a hundred rays.
        0 if chunks > 1 => std::thread::available_parallelism().map_or(1, |n| n.get().min(chunks)),
        0 => 1,
        some => some.min(chunks),
    }
}

/// Lets some threads, including the caller's, each `drain` a common queue of jobs.
pub(super) fn share<J>(
    jobs: impl Iterator<Item = J> + Send,
    threads: usize,
    drain: impl Fn(&mut dyn FnMut() -> Option<J>) + Sync,
) {
    let jobs = Mutex::new(jobs);
    let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
    let drain = || drain(&mut || next());
    if threads <= 1 {
        return drain();
    }
    std::thread::scope(|scope| {
        for _ in 1..threads {
            // If a thread cannot be spawned, the others do its share.
            let _ = std::thread::Builder::new().spawn_scoped(scope, drain);
        }
        drain();
    });
}
