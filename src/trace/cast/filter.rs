//! Rays that choose what they hit: from a distance on, geometries by mask, not one primitive, or
//! whatever a closure accepts. All are single rays: see [`crate::traverse::single_ray`].

use super::batch::{share, thread_count};
use super::columns::same_length;
use super::rows::{RayBatch, TransposedRays};
use super::worker::{PacketStorage, is_able};
use super::{BatchError, Hit, HitColumns, HitLists, PerRay, Ray};
use crate::bvh::Bvh;
use crate::packet::NO_PRIM;
use crate::traverse::HitFilter;
use crate::traverse::every_hit::FoundHit;
use crate::traverse::single_ray::{FilteredRays, OneRay};
use std::cell::RefCell;

/// Rays that a thread takes at once.
const CHUNK: usize = 512;

/// Filter of a ray's hits, besides its `tmax`. The default accepts all.
///
/// A sphere, an ellipsoid or a cone is hit where the ray first crosses it, or if the filter refuses
/// that, where it crosses it again.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{Bvh, Ray, RayFilter, Scene};
///
/// let mut scene = Scene::new();
/// let near = scene.add_spheres(&[[0.0; 3]], &[1.0])?;
/// let far = scene.add_spheres(&[[0.0, 0.0, 5.0]], &[1.0])?;
/// scene.set_mask(near, 0b01)?;
/// scene.set_mask(far, 0b10)?;
/// let bvh = Bvh::build(&scene);
/// let ray = Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]);
/// let hit = |filter: RayFilter| bvh.intersect_filtered(&ray, &filter).map(|hit| hit.geom_id);
///
/// assert_eq!(hit(RayFilter::default()), Some(near));
/// assert_eq!(hit(RayFilter { mask: 0b10, ..RayFilter::default() }), Some(far));
/// // From within the near sphere its far side is hit, at t = 4.
/// assert_eq!(hit(RayFilter { tnear: 2.5, ..RayFilter::default() }), Some(near));
/// assert_eq!(hit(RayFilter { tnear: 4.0, ..RayFilter::default() }), Some(far));
/// // A primitive that is ignored is hit on neither side.
/// assert_eq!(hit(RayFilter { ignore: 0, ..RayFilter::default() }), Some(far));
/// let is_odd = |hit: &phalanx::Hit| hit.prim_id % 2 == 1;
/// assert_eq!(hit(RayFilter { accept: &is_odd, ..RayFilter::default() }), Some(far));
/// # Ok::<(), phalanx::GeometryError>(())
/// ```
#[derive(Clone, Copy)]
pub struct RayFilter<'f> {
    /// Hits count if `tnear` < t, and 0 < t: the ray passes through what is nearer. A ray with a
    /// NaN here misses everything. A ray that starts on a sphere and goes inward hits its far side
    /// if this is a little more than the rounding of its origin.
    pub tnear: f32,
    /// Only geometries whose mask shares a bit with this one count: see
    /// [`set_mask`](phalanx_scene::Scene::set_mask). Primitives without a geometry have all bits.
    pub mask: u32,
    /// `prim_id` of a primitive that does not count; [`NO_PRIM`] for none.
    /// For rays that leave a triangle. A ray within a sphere has to hit that sphere's far side, and
    /// this refuses both: use `tnear`.
    pub ignore: u32,
    /// Decides whether a hit counts. A curved primitive may be offered twice, and counts where it
    /// is accepted first. The closure must answer by the hit alone: nothing is promised about the
    /// order and number of its calls. It may cast rays itself.
    pub accept: &'f dyn Fn(&Hit) -> bool,
}

impl Default for RayFilter<'_> {
    fn default() -> Self {
        RayFilter {
            tnear: 0.0,
            mask: u32::MAX,
            ignore: NO_PRIM,
            accept: &|_| true,
        }
    }
}

/// Test of a ray, by its number, and a hit of it: whether that counts.
pub type AcceptHit<'a> = dyn Fn(usize, &Hit) -> bool + Sync + 'a;

/// Filters of a batch's rays, each a [`RayFilter`]. The default accepts all.
#[derive(Clone, Copy)]
pub struct BatchFilter<'a> {
    /// As [`RayFilter::tnear`].
    pub tnear: PerRay<'a, f32>,
    /// As [`RayFilter::mask`].
    pub mask: PerRay<'a, u32>,
    /// As [`RayFilter::ignore`].
    pub ignore: PerRay<'a, u32>,
    /// As [`RayFilter::accept`], with the number of the ray, on several threads at once; `None`
    /// accepts all.
    pub accept: Option<&'a AcceptHit<'a>>,
}

impl Default for BatchFilter<'_> {
    fn default() -> Self {
        let any = RayFilter::default();
        BatchFilter {
            tnear: PerRay::All(any.tnear),
            mask: PerRay::All(any.mask),
            ignore: PerRay::All(any.ignore),
            accept: None,
        }
    }
}

impl BatchFilter<'_> {
    fn check(&self, rays: usize) -> Result<(), BatchError> {
        self.tnear.check("tnear", rays)?;
        self.mask.check("mask", rays)?;
        self.ignore.check("ignore", rays)
    }

    /// Filter of a ray, without the closure.
    fn get(&self, k: usize) -> RayFilter<'static> {
        RayFilter {
            tnear: self.tnear.get(k),
            mask: self.mask.get(k),
            ignore: self.ignore.get(k),
            ..RayFilter::default()
        }
    }
}

impl Bvh {
    /// Finds the closest hit that a filter accepts, the smallest by (t, `prim_id`); `None` is a
    /// miss. [`RayFilter`] has an example, `perf/notes/calls.md` the cost.
    pub fn intersect_filtered(&self, ray: &Ray, filter: &RayFilter) -> Option<Hit> {
        self.filtered(ray, filter, false)
    }

    /// Returns true if a ray hits anything that a filter accepts.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Ray, RayFilter, Scene};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// let (bvh, ray) = (Bvh::build(&scene), Ray::segment([0.0, 0.0, -3.0], [0.0; 3]));
    /// assert!(bvh.occluded_filtered(&ray, &RayFilter::default()));
    /// let beyond = RayFilter { tnear: 0.9, ..RayFilter::default() };
    /// assert!(!bvh.occluded_filtered(&ray, &beyond));
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn occluded_filtered(&self, ray: &Ray, filter: &RayFilter) -> bool {
        self.filtered(ray, filter, true).is_some()
    }

    /// Finds all hits that a filter accepts, ordered by (t, `prim_id`): see [`HitLists`].
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Ray, RayFilter, Scene};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[0.0, 4.0, 8.0].map(|z| [0.0, 0.0, z]), &[1.0; 3])?;
    /// let (bvh, ray) = (Bvh::build(&scene), Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]));
    /// let hits = bvh.all_hits_filtered(&ray, &RayFilter { ignore: 1, ..RayFilter::default() });
    /// assert_eq!(hits.iter().map(|hit| hit.t).collect::<Vec<f32>>(), [2.0, 10.0]);
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn all_hits_filtered(&self, ray: &Ray, filter: &RayFilter) -> Vec<Hit> {
        let all = RefCell::new(Vec::new());
        // A refused hit does not end the search, so the filter sees every hit, on both sides of a
        // primitive.
        let refuse = |hit: &Hit| {
            if (filter.accept)(hit) {
                all.borrow_mut().push(*hit);
            }
            false
        };
        let recorder = RayFilter {
            accept: &refuse,
            ..*filter
        };
        self.filtered(ray, &recorder, false);
        let mut all = all.into_inner();
        let key = |hit: &Hit| FoundHit::key_of(hit.t, hit.prim_id);
        // A primitive's two sides are brought together, the nearer first, and only that one stays.
        all.sort_unstable_by_key(|hit| key(hit).rotate_left(32));
        all.dedup_by_key(|hit| hit.prim_id);
        all.sort_unstable_by_key(key);
        all
    }

    /// As [`Bvh::intersect_batch`], for the closest hits that a filter accepts. All kernels but
    /// that for single rays are left out, so coherent rays are slower.
    ///
    /// # Errors
    /// [`BatchError`] if columns differ in length; nothing is written then.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{BatchFilter, Bvh, HitBuffer, NO_PRIM, PerRay, Ray, RayBuffer, Scene};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3], [0.0, 0.0, 5.0]], &[1.0, 1.0])?;
    /// let rays: RayBuffer = [Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]); 2].into_iter().collect();
    /// let mut hits = HitBuffer::new(2);
    /// let filter = BatchFilter { ignore: PerRay::Each(&[NO_PRIM, 0]), ..BatchFilter::default() };
    /// let bvh = Bvh::build(&scene);
    /// bvh.intersect_batch_filtered(&rays.columns(), &filter, &mut hits.columns(), 0)?;
    /// assert_eq!(hits.iter().flatten().map(|hit| hit.t).collect::<Vec<f32>>(), [2.0, 7.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn intersect_batch_filtered<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        filter: &BatchFilter,
        hits: &mut HitColumns,
        threads: usize,
    ) -> Result<(), BatchError> {
        let rays = rays.into();
        rays.check()?;
        hits.check(rays.len())?;
        let chunks = hits.chunks(CHUNK);
        self.each(&rays, filter, threads, (chunks, false), |hits, k, hit| {
            hits.put(k, hit)
        })
    }

    /// As [`Bvh::intersect_batch_each`], for the closest hits that a filter accepts.
    ///
    /// # Errors
    /// [`BatchError`] if columns differ in length; `put` is not called then.
    pub fn intersect_batch_filtered_each<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        filter: &BatchFilter,
        threads: usize,
        put: impl Fn(usize, Option<Hit>) + Sync,
    ) -> Result<(), BatchError> {
        let rays = rays.into();
        rays.check()?;
        let firsts = (0..rays.len()).step_by(CHUNK);
        self.each(&rays, filter, threads, (firsts, false), |first, k, hit| {
            put(*first + k, hit)
        })
    }

    /// As [`Bvh::occluded_batch`], for the hits that a filter accepts.
    ///
    /// # Errors
    /// [`BatchError`] if columns differ in length; nothing is written then.
    pub fn occluded_batch_filtered<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        filter: &BatchFilter,
        blocked: &mut [bool],
        threads: usize,
    ) -> Result<(), BatchError> {
        let rays = rays.into();
        rays.check()?;
        same_length("blocked", blocked.len(), rays.len())?;
        let chunks = blocked.chunks_mut(CHUNK);
        self.each(&rays, filter, threads, (chunks, true), |blocked, k, hit| {
            blocked[k] = hit.is_some();
        })
    }

    /// As [`Bvh::all_hits_batch`], for the hits that a filter accepts. Where `tnear` may lie within
    /// a curved primitive, only single rays are traced, and coherent ones are slower.
    ///
    /// # Errors
    /// [`BatchError`] if columns differ in length.
    pub fn all_hits_batch_filtered<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        filter: &BatchFilter,
        threads: usize,
    ) -> Result<HitLists, BatchError> {
        let rays = rays.into();
        rays.check()?;
        filter.check(rays.len())?;
        let prims = self.leaf_prims();
        let is_flat = prims.spheres.is_empty() && prims.ellipsoids.is_empty();
        // Masks and numbers refuse both sides of a primitive.
        let from_start = filter.tnear.common().is_some_and(|tnear| tnear <= 0.0);
        if from_start && filter.accept.is_none() || is_flat && prims.cones.is_empty() {
            let mut lists = self.all_hits_batch(rays, threads)?;
            lists.retain(|ray, hit| self.accepts_of(filter, ray, hit));
            return Ok(lists);
        }
        let count = rays.len();
        let mut parts = vec![HitLists::empty(); count.div_ceil(CHUNK)];
        let threads = thread_count(threads, parts.len());
        self.build_wide(threads);
        let jobs = (0..count).step_by(CHUNK).zip(&mut parts);
        share(jobs, threads, |next| {
            while let Some((first, part)) = next() {
                for k in first..(first + CHUNK).min(count) {
                    let accept = |hit: &Hit| self.accepts_of(filter, k, hit);
                    let accept = RayFilter {
                        accept: &accept,
                        ..RayFilter::default()
                    };
                    part.push(self.all_hits_filtered(&rays.ray(k), &accept));
                }
            }
        });
        Ok(HitLists::joined(&parts))
    }

    /// Finds a hit for each ray of a batch, the closest one or any, and stores it by its row in the
    /// ray's chunk.
    fn each<O: Send>(
        &self,
        rays: &RayBatch,
        filters: &BatchFilter,
        threads: usize,
        (outputs, any): (impl Iterator<Item = O> + Send, bool),
        put: impl Fn(&mut O, usize, Option<Hit>) + Sync,
    ) -> Result<(), BatchError> {
        let count = rays.len();
        filters.check(count)?;
        let threads = thread_count(threads, count.div_ceil(CHUNK));
        self.build_wide(threads);
        let jobs = (0..count).step_by(CHUNK).zip(outputs);
        share(jobs, threads, |next| {
            let mut kernel = FilteredRays::new(self);
            let mut packets = PacketStorage::default();
            let mut transposed = TransposedRays::default();
            while let Some((first, mut output)) = next() {
                let part = rays.slice(first, (first + CHUNK).min(count));
                let part = transposed.columns(&part);
                let (tmax, len) = (part.tmax, part.len());
                packets.fill(&part, false);
                let accept = |k: usize, weights, prim_id| {
                    let hit = self.hit_of(weights, prim_id);
                    hit.t < tmax.get(k) && self.accepts_of(filters, first + k, &hit)
                };
                let filter = HitFilter {
                    accept: &accept,
                    any,
                };
                let limit = tmax.common().unwrap_or(f32::INFINITY);
                kernel.trace(&packets.queue.queue(), limit, &filter, &mut |k, hit| {
                    let hit = hit.filter(|_| k < len && is_able(&packets.able, k));
                    put(
                        &mut output,
                        k,
                        hit.map(|(t, prim_id)| self.hit_of(t, prim_id)),
                    );
                });
            }
        });
        Ok(())
    }

    /// Returns true if a filter accepts a hit.
    fn accepts(&self, hit: &Hit, filter: &RayFilter) -> bool {
        hit.t > filter.tnear
            && hit.prim_id != filter.ignore
            && self.geometries().mask(hit.geom_id) & filter.mask != 0
            && (filter.accept)(hit)
    }

    /// Returns true if the filter of a batch's ray accepts a hit.
    fn accepts_of(&self, filters: &BatchFilter, ray: usize, hit: &Hit) -> bool {
        self.accepts(hit, &filters.get(ray)) && filters.accept.is_none_or(|accept| accept(ray, hit))
    }

    fn filtered(&self, ray: &Ray, filter: &RayFilter, any: bool) -> Option<Hit> {
        if !ray.can_hit() {
            return None;
        }
        let accept = |_: usize, weights: [f32; 3], prim_id: u32| {
            let hit = self.hit_of(weights, prim_id);
            hit.t < ray.tmax && self.accepts(&hit, filter)
        };
        let filter = HitFilter {
            accept: &accept,
            any,
        };
        let ends = [&ray.origin, &ray.direction];
        let (weights, prim_id) = OneRay::new(self)
            .filtered(ends, ray.tmax, &filter)
            .found()?;
        Some(self.hit_of(weights, prim_id))
    }
}
