//! phalanx for programs that are compiled once and run on any x86-64 CPU: all of [`phalanx`], with
//! a [`Bvh`] whose rays use the instructions of the machine. In `Cargo.toml`, in place of phalanx:
//!
//! ```toml
//! phalanx = { package = "phalanx-levels", version = "0.1" }
//! ```
//!
//! ```
//! # use phalanx_levels as phalanx;
//! use phalanx::{Bvh, Ray, Scene};
//!
//! let mut scene = Scene::new();
//! scene.add_spheres(&[[0.0; 3]], &[1.0])?;
//! let bvh = Bvh::build(&scene);
//! let hit = bvh.intersect(&Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]));
//! assert_eq!(hit.map(|hit| hit.t), Some(2.0));
//! println!("rays run on {}", phalanx::isa());
//! # Ok::<(), phalanx::GeometryError>(())
//! ```
//!
//! The tracer chooses its instructions when it is compiled, so the build script compiles it twice
//! more, for x86-64-v3 (AVX2) and x86-64-v4 (AVX-512), and the program has both libraries in it.
//! The first tree loads the better of those that the CPU can run. Answers are the same bits.
//!
//! | where | rays run on |
//! |---|---|
//! | Linux with glibc on x86-64, compiled for less than AVX2, with optimization | the CPU's level |
//! | there, without a level that could not be compiled (`cargo build -vv` says why) | the next one |
//! | elsewhere | the build's level |
//!
//! The script takes sources and versions that the program itself is compiled from, and downloads
//! nothing. `PHALANX_LEVELS` names the levels to compile, if not both: `PHALANX_LEVELS=` for none,
//! as tools that only check sources may want. `PHALANX_LEVEL` names one for a run.
//!
//! A level's library has threads, an allocator and a pool of its own. So builds use that, and not
//! the pool that they are called on. Pictures (`frame`, feature `render`) use the build's level.

mod load;
#[macro_use]
mod tree;

#[doc(inline)]
pub use phalanx::*;

use std::any::Any;
use std::fmt;
use std::mem::ManuallyDrop;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Mutex, PoisonError};
use tree::AnyBvh;

/// The instruction set that rays of a [`Bvh`] run on: `x86-64` to `x86-64-v4`, elsewhere the
/// architecture's name.
pub fn isa() -> &'static str {
    load::chosen().0
}

/// [`phalanx::Bvh`] of the machine's level: the same methods, and the same answers.
pub struct Bvh(ManuallyDrop<Box<dyn AnyBvh>>);

impl fmt::Debug for Bvh {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let mut bvh = f.debug_struct("Bvh");
        bvh.field("isa", &isa()).field("depth", &self.depth());
        bvh.finish_non_exhaustive()
    }
}

impl Clone for Bvh {
    fn clone(&self) -> Bvh {
        Bvh::of(self.0.copy())
    }
}

impl Drop for Bvh {
    #[allow(unsafe_code, reason = "memory goes back to the side that it came from")]
    fn drop(&mut self) {
        // SAFETY: the tree is not used again.
        unsafe { ManuallyDrop::take(&mut self.0) }.free();
    }
}

impl Default for Bvh {
    fn default() -> Bvh {
        Bvh::build(&Scene::default())
    }
}

macro_rules! define_methods {
    ($(fn $name:ident(&$me:ident $(, $arg:ident: $type:ty)*) $(-> $out:ty)?;)*) => {
        /// Methods of one ray, and what a tree says of itself.
        impl Bvh {
            $(
                #[doc = concat!("[`phalanx::Bvh::", stringify!($name), "`].")]
                pub fn $name(&$me $(, $arg: $type)*) $(-> $out)? {
                    $me.0.$name($($arg),*)
                }
            )*
        }
    };
}

plain_methods!(define_methods);

impl Bvh {
    fn of(tree: Box<dyn AnyBvh>) -> Bvh {
        Bvh(ManuallyDrop::new(tree))
    }

    /// [`phalanx::Bvh::build`].
    pub fn build(scene: &Scene) -> Bvh {
        Bvh::build_with(scene, &BuildSettings::default())
    }

    /// [`phalanx::Bvh::build_with`].
    pub fn build_with(scene: &Scene, settings: &BuildSettings) -> Bvh {
        Bvh::of((load::chosen().1.build)(scene, settings))
    }

    /// [`phalanx::Bvh::update`].
    pub fn update(&mut self, scene: &Scene) -> UpdateReport {
        let report = self.update_with(scene, UpdateMode::Auto);
        report.unwrap_or_default()
    }

    /// [`phalanx::Bvh::update_with`].
    ///
    /// # Errors
    /// [`UpdateError`].
    pub fn update_with(
        &mut self,
        scene: &Scene,
        mode: UpdateMode,
    ) -> Result<UpdateReport, UpdateError> {
        let mut report = Ok(UpdateReport::default());
        self.0.update(scene, mode, &mut |done| {
            report = done.cloned().map_err(Clone::clone);
        });
        report
    }

    /// [`phalanx::Bvh::all_hits_filtered`].
    pub fn all_hits_filtered(&self, ray: &Ray, filter: &RayFilter) -> Vec<Hit> {
        let mut all = Vec::new();
        self.0
            .all_hits(ray, filter, &mut |hits| all = hits.to_vec());
        all
    }
}

/// Batches. Their errors are those of [`phalanx::Bvh`].
#[allow(clippy::missing_errors_doc, reason = "said once for all of them")]
impl Bvh {
    /// [`phalanx::Bvh::intersect_batch`].
    pub fn intersect_batch<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        hits: &mut HitColumns,
        threads: usize,
    ) -> Result<(), BatchError> {
        self.0.closest(rays.into(), None, hits, threads)
    }

    /// [`phalanx::Bvh::intersect_batch_filtered`].
    pub fn intersect_batch_filtered<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        filter: &BatchFilter,
        hits: &mut HitColumns,
        threads: usize,
    ) -> Result<(), BatchError> {
        relay_filter(filter, |filter| {
            self.0.closest(rays.into(), Some(filter), hits, threads)
        })
    }

    /// [`phalanx::Bvh::intersect_batch_each`].
    pub fn intersect_batch_each<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        threads: usize,
        put: impl Fn(usize, Option<Hit>) + Sync,
    ) -> Result<(), BatchError> {
        let panic = Panic::default();
        let put = |k: usize, hit| panic.held(|| put(k, hit));
        let done = self.0.closest_each(rays.into(), None, threads, &put);
        panic.released(done)
    }

    /// [`phalanx::Bvh::intersect_batch_filtered_each`].
    pub fn intersect_batch_filtered_each<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        filter: &BatchFilter,
        threads: usize,
        put: impl Fn(usize, Option<Hit>) + Sync,
    ) -> Result<(), BatchError> {
        let panic = Panic::default();
        let put = |k: usize, hit| panic.held(|| put(k, hit));
        let done = relay_filter(filter, |filter| {
            self.0
                .closest_each(rays.into(), Some(filter), threads, &put)
        });
        panic.released(done)
    }

    /// [`phalanx::Bvh::occluded_batch`].
    pub fn occluded_batch<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        blocked: &mut [bool],
        threads: usize,
    ) -> Result<(), BatchError> {
        self.0.blocked(rays.into(), None, blocked, threads)
    }

    /// [`phalanx::Bvh::occluded_batch_filtered`].
    pub fn occluded_batch_filtered<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        filter: &BatchFilter,
        blocked: &mut [bool],
        threads: usize,
    ) -> Result<(), BatchError> {
        relay_filter(filter, |filter| {
            self.0.blocked(rays.into(), Some(filter), blocked, threads)
        })
    }

    /// [`phalanx::Bvh::count_batch`].
    pub fn count_batch<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        counts: &mut [u32],
        threads: usize,
    ) -> Result<(), BatchError> {
        self.0.counts(rays.into(), counts, threads)
    }

    /// [`phalanx::Bvh::all_hits_batch`].
    pub fn all_hits_batch<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        threads: usize,
    ) -> Result<HitLists, BatchError> {
        self.lists(rays.into(), None, threads)
    }

    /// [`phalanx::Bvh::all_hits_batch_filtered`].
    pub fn all_hits_batch_filtered<'r>(
        &self,
        rays: impl Into<RayBatch<'r>>,
        filter: &BatchFilter,
        threads: usize,
    ) -> Result<HitLists, BatchError> {
        relay_filter(filter, |filter| {
            self.lists(rays.into(), Some(filter), threads)
        })
    }

    fn lists(
        &self,
        rays: RayBatch,
        filter: Option<&BatchFilter>,
        threads: usize,
    ) -> Result<HitLists, BatchError> {
        let mut all = HitLists::empty();
        let take = &mut |lists: &HitLists| all = lists.clone();
        self.0.lists(rays, filter, threads, take)?;
        Ok(all)
    }
}

/// A panic in a user's closure, held while a batch ends: the threads of a level's library cannot
/// pass it on.
#[derive(Default)]
struct Panic(Mutex<Option<Box<dyn Any + Send>>>);

impl Panic {
    fn held<T: Default>(&self, closure: impl FnOnce() -> T) -> T {
        catch_unwind(AssertUnwindSafe(closure)).unwrap_or_else(|panic| {
            let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert(panic);
            T::default()
        })
    }

    fn released<T>(self, result: T) -> T {
        match self.0.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(panic) => resume_unwind(panic),
            None => result,
        }
    }
}

/// Passes on a filter whose closure's panics are held.
fn relay_filter<T>(filter: &BatchFilter, batch: impl FnOnce(&BatchFilter) -> T) -> T {
    let Some(accept) = filter.accept else {
        return batch(filter);
    };
    let panic = Panic::default();
    let accept = |k: usize, hit: &Hit| panic.held(|| accept(k, hit));
    let held = BatchFilter {
        accept: Some(&accept),
        ..*filter
    };
    let result = batch(&held);
    panic.released(result)
}
