//! The interface between a program and a level's library: one trait, which both compile.
//!
//! The library is made by the build script of the crate that loads it: the same compiler, the same
//! sources and versions, other instructions. Layouts of types do not depend on those, and sizes and
//! a described scene are compared before anything else is used. What a side has allocated, it
//! frees.

use phalanx_scene::{GeomId, Scene};
use phalanx_trace::bvh::{BuildSettings, Bvh, UpdateError, UpdateMode, UpdateReport};
use phalanx_trace::{BatchError, BatchFilter, Hit, HitColumns, HitLists, Ray, RayBatch, RayFilter};

/// Takes a part of a text.
type TakeText<'a> = dyn FnMut(&str) + 'a;

/// Exports of a library, by the name `PHALANX_LEVEL`.
#[repr(C)]
pub struct LevelExports {
    /// Sizes and alignments of all types that cross.
    pub sizes: [usize; 2 * CROSSING],
    /// Passes on a scene as text, field by field.
    pub describe: fn(&Scene, &mut TakeText),
    /// [`Bvh::build_with`].
    pub build: fn(&Scene, &BuildSettings) -> Box<dyn AnyBvh>,
}

/// Number of types that cross.
const CROSSING: usize = 14;

macro_rules! sizes {
    ($($type:ty),*) => {
        [$(size_of::<$type>(), align_of::<$type>()),*]
    };
}

impl LevelExports {
    /// The level of the build that this is part of.
    pub const OWN: LevelExports = LevelExports {
        sizes: sizes![
            Scene, BuildSettings, Box<dyn AnyBvh>, Ray, RayBatch, RayFilter, BatchFilter,
            Option<Hit>, HitColumns, HitLists, Result<(), BatchError>, UpdateMode, UpdateReport,
            UpdateError
        ],
        describe: |scene, take| take(&format!("{scene:?}")),
        build: |scene, settings| Box::new(Bvh::build_with(scene, settings)),
    };
}

/// Calls `$with` with the methods that are the same for [`Bvh`], for [`AnyBvh`] and for users.
macro_rules! plain_methods {
    ($with:ident) => {
        $with! {
            fn build_wide(&self, threads: usize);
            fn is_current(&self, scene: &Scene) -> bool;
            fn first_prim(&self, geometry: GeomId) -> Option<u32>;
            fn depth(&self) -> usize;
            fn sah(&self) -> f64;
            fn cost_growth(&self) -> f64;
            fn has_wide(&self) -> bool;
            fn wide_bytes(&self) -> usize;
            fn node_bytes(&self) -> usize;
            fn prim_bytes(&self) -> usize;
            fn intersect(&self, ray: &Ray) -> Option<Hit>;
            fn intersect_into(&self, ray: &Ray, hit: &mut Hit) -> bool;
            fn occluded(&self, ray: &Ray) -> bool;
            fn intersect_filtered(&self, ray: &Ray, filter: &RayFilter) -> Option<Hit>;
            fn occluded_filtered(&self, ray: &Ray, filter: &RayFilter) -> bool;
        }
    };
}

/// Takes the hit of the ray with this number.
pub type PutHit<'a> = dyn Fn(usize, Option<Hit>) + Sync + 'a;

/// Takes what an update did, or why it was refused.
pub type TakeReport<'a> = dyn FnMut(Result<&UpdateReport, &UpdateError>) + 'a;

/// Result of a batch.
type Done = Result<(), BatchError>;

macro_rules! define_tree {
    ($(fn $name:ident(&$me:ident $(, $arg:ident: $type:ty)*) $(-> $out:ty)?;)*) => {
        /// A tree of either side. Methods are those of [`Bvh`]; what they allocate is passed to
        /// `take`, and batches with a filter are those without if it is `None`.
        #[rustfmt::skip]
        pub trait AnyBvh: Send + Sync {
            $(fn $name(&$me $(, $arg: $type)*) $(-> $out)?;)*
            /// A copy, made by the side of the tree.
            fn copy(&self) -> Box<dyn AnyBvh>;
            /// Frees the tree, on the side of the tree.
            fn free(self: Box<Self>);
            fn update(&mut self, scene: &Scene, mode: UpdateMode, take: &mut TakeReport);
            fn all_hits(&self, ray: &Ray, filter: &RayFilter, take: &mut dyn FnMut(&[Hit]));
            fn closest(
                &self, rays: RayBatch, filter: Option<&BatchFilter>, hits: &mut HitColumns, threads: usize,
            ) -> Done;
            fn closest_each(
                &self, rays: RayBatch, filter: Option<&BatchFilter>, threads: usize, put: &PutHit,
            ) -> Done;
            fn blocked(
                &self, rays: RayBatch, filter: Option<&BatchFilter>, blocked: &mut [bool], threads: usize,
            ) -> Done;
            fn counts(&self, rays: RayBatch, counts: &mut [u32], threads: usize) -> Done;
            fn lists(
                &self, rays: RayBatch, filter: Option<&BatchFilter>, threads: usize, take: &mut dyn FnMut(&HitLists),
            ) -> Done;
        }

        #[rustfmt::skip]
        impl AnyBvh for Bvh {
            $(fn $name(&$me $(, $arg: $type)*) $(-> $out)? {
                Bvh::$name($me $(, $arg)*)
            })*

            fn copy(&self) -> Box<dyn AnyBvh> {
                Box::new(self.clone())
            }

            fn free(self: Box<Self>) {}

            fn update(&mut self, scene: &Scene, mode: UpdateMode, take: &mut TakeReport) {
                take(self.update_with(scene, mode).as_ref());
            }

            fn all_hits(&self, ray: &Ray, filter: &RayFilter, take: &mut dyn FnMut(&[Hit])) {
                take(&self.all_hits_filtered(ray, filter));
            }

            fn closest(
                &self, rays: RayBatch, filter: Option<&BatchFilter>, hits: &mut HitColumns, threads: usize,
            ) -> Done {
                match filter {
                    Some(filter) => self.intersect_batch_filtered(rays, filter, hits, threads),
                    None => self.intersect_batch(rays, hits, threads),
                }
            }

            fn closest_each(
                &self, rays: RayBatch, filter: Option<&BatchFilter>, threads: usize, put: &PutHit,
            ) -> Done {
                match filter {
                    Some(filter) => self.intersect_batch_filtered_each(rays, filter, threads, put),
                    None => self.intersect_batch_each(rays, threads, put),
                }
            }

            fn blocked(
                &self, rays: RayBatch, filter: Option<&BatchFilter>, blocked: &mut [bool], threads: usize,
            ) -> Done {
                match filter {
                    Some(filter) => self.occluded_batch_filtered(rays, filter, blocked, threads),
                    None => self.occluded_batch(rays, blocked, threads),
                }
            }

            fn counts(&self, rays: RayBatch, counts: &mut [u32], threads: usize) -> Done {
                self.count_batch(rays, counts, threads)
            }

            fn lists(
                &self, rays: RayBatch, filter: Option<&BatchFilter>, threads: usize, take: &mut dyn FnMut(&HitLists),
            ) -> Done {
                let lists = match filter {
                    Some(filter) => self.all_hits_batch_filtered(rays, filter, threads),
                    None => self.all_hits_batch(rays, threads),
                };
                lists.map(|lists| take(&lists))
            }
        }
    };
}

plain_methods!(define_tree);
