//! The tracer's public interface: [`Bvh::intersect`] and [`Bvh::occluded`] for one ray,
//! [`Bvh::intersect_batch`] and [`Bvh::occluded_batch`] for many, [`Bvh::all_hits_batch`] and
//! [`Bvh::count_batch`] for all hits of each ray.
//!
//! | file | content |
//! |---|---|
//! | `columns` | rays and hits of a batch: borrowed slices, and buffers |
//! | `rows` | rays with interleaved components |
//! | `scan_order` | pictures in scan order, traced in blocks |
//! | `hit_lists` | all hits of each ray |
//! | `batch` | chunks and threads |
//! | `small_batch` | single rays, from and to the caller's memory |
//! | `worker` | packets of a thread |
//! | `filter` | rays that choose what they hit |
//! | `refine` | a hit in double precision |
//!
//! Lengths are in scene units, distances in units of a ray's direction. Directions need not be
//! normalized: see [`Ray::direction`] for the lengths that they may have.
//! Hits count if 0 < t < `tmax`; ties go to the smaller `prim_id`. All calls give the same bits as
//! the scalar oracle, ray by ray. They hit every surface, whatever its material's opacity: opacity
//! only affects pictures (`phalanx_scene::Scene::coverage` is that of a hit).

mod batch;
mod columns;
mod filter;
mod hit_lists;
mod refine;
mod rows;
mod scan_order;
mod small_batch;
mod worker;

pub use filter::{AcceptHit, BatchFilter, RayFilter};
pub use hit_lists::HitLists;
pub use refine::{RefinedHit, refine, world_corners};
pub use rows::{RayBatch, RayRows};

pub use columns::{BatchError, HitBuffer, HitColumns, PerRay, RayBuffer, RayColumns, TMax};

use crate::bvh::Bvh;
use crate::packet::NO_PRIM;
use crate::traverse::single_ray::OneRay;
use phalanx_scene::{GeomId, NO_GEOM};

/// A ray: hits at `origin` + t · `direction` count if 0 < t < `tmax`.
///
/// A ray with an origin or direction that is not finite, a zero direction, or a `tmax` that is NaN,
/// zero or negative misses everything; that is not an error.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::Ray;
///
/// let ray = Ray { tmax: 10.0, ..Ray::new([0.0; 3], [0.0, 0.0, 1.0]) };
/// assert!(ray.can_hit());
/// assert!(!Ray { tmax: f32::NAN, ..ray }.can_hit());
/// assert!(!Ray { direction: [0.0; 3], ..ray }.can_hit());
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Starting point, in scene units. A ray that starts on a surface may hit that surface again;
    /// move the point off by a small part of the scene's extent.
    pub origin: [f32; 3],
    /// Direction, of a length from 10⁻¹² to 10¹², for surfaces of 10⁻⁶ to 10⁶ units. Squares of
    /// shorter and longer ones leave the range of single precision, and such rays may miss.
    pub direction: [f32; 3],
    /// Distance at which the ray ends, in units of `direction`.
    pub tmax: f32,
}

impl Ray {
    /// Creates a ray with infinite `tmax`. Accepts arrays and glam's vectors.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::Ray;
    ///
    /// let ray = Ray::new([0.0, 0.0, 5.0], [0.0, 0.0, -2.0]);
    /// assert_eq!(ray.at(1.5), [0.0, 0.0, 2.0]);
    /// ```
    #[inline]
    pub fn new(origin: impl Into<[f32; 3]>, direction: impl Into<[f32; 3]>) -> Ray {
        Ray {
            origin: origin.into(),
            direction: direction.into(),
            tmax: f32::INFINITY,
        }
    }

    /// Creates a ray from one point to another, with `tmax` 1, so that hits beyond `to` do not
    /// count. For shadow rays.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::Ray;
    ///
    /// let ray = Ray::segment([1.0, 0.0, 0.0], [4.0, 0.0, 0.0]);
    /// assert_eq!((ray.direction, ray.tmax), ([3.0, 0.0, 0.0], 1.0));
    /// ```
    #[inline]
    pub fn segment(from: impl Into<[f32; 3]>, to: impl Into<[f32; 3]>) -> Ray {
        let (origin, to) = (from.into(), to.into());
        Ray {
            origin,
            direction: std::array::from_fn(|axis| to[axis] - origin[axis]),
            tmax: 1.0,
        }
    }

    /// The point at distance `t`, in units of the direction. At a hit's t it lies on the surface up
    /// to rounding in single precision.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::Ray;
    ///
    /// assert_eq!(Ray::segment([1.0, 0.0, 0.0], [5.0, 2.0, 0.0]).at(0.5), [3.0, 1.0, 0.0]);
    /// ```
    #[inline]
    pub fn at(&self, t: f32) -> [f32; 3] {
        std::array::from_fn(|axis| self.origin[axis] + t * self.direction[axis])
    }

    /// Returns true if the ray can hit anything at all: see [`Ray`], which has an example.
    #[inline]
    pub fn can_hit(&self) -> bool {
        // Without branches between the numbers, which single rays would feel.
        let finite = |v: &[f32; 3]| v.iter().fold(true, |all, x| all & x.is_finite());
        let is_zero = self.direction.iter().fold(true, |all, &x| all & (x == 0.0));
        finite(&self.origin) & finite(&self.direction) & !is_zero & (self.tmax > 0.0)
    }
}

/// The closest hit of a ray. A miss is `None` instead.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{Bvh, Hit, Ray, Scene};
///
/// let mut scene = Scene::new();
/// let ball = scene.add_spheres(&[[0.0; 3]], &[1.0])?;
/// let ray = Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 0.5]);
/// // Two units away, of which the direction is half a one.
/// let expected = Hit { t: 4.0, u: 0.0, v: 0.0, prim_id: 0, geom_id: ball };
/// assert_eq!(Bvh::build(&scene).intersect(&ray), Some(expected));
/// # Ok::<(), phalanx::GeometryError>(())
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance, 0 < t < `tmax`, in units of the ray's direction.
    pub t: f32,
    /// Barycentric weight of a triangle's second vertex, in \[0, 1\]; 0 on anything else. The first
    /// vertex has the weight 1 − u − v.
    pub u: f32,
    /// Barycentric weight of a triangle's third vertex, in \[0, 1\]; 0 on anything else.
    pub v: f32,
    /// Primitive, counted over the whole scene; see [`Bvh::first_prim`] for its number within its
    /// geometry.
    pub prim_id: u32,
    /// Geometry, as returned by [`add_mesh`](phalanx_scene::Scene::add_mesh) and related methods;
    /// for an instance, that of the instance. [`NO_GEOM`] for primitives that were added one by
    /// one, such as those of files. Caches keep it.
    pub geom_id: GeomId,
}

impl Hit {
    /// A miss, as columns of hits have it.
    const MISS: Hit = Hit {
        t: f32::INFINITY,
        u: 0.0,
        v: 0.0,
        prim_id: NO_PRIM,
        geom_id: NO_GEOM,
    };
}

impl Bvh {
    /// Finds the closest hit of one ray; `None` is a miss. In this and all other queries, triangles
    /// are hit from both sides, regardless of their material: only pictures treat any as
    /// single-sided.
    ///
    /// The first call makes the wide tree: see [`Bvh::build_wide`]. For many rays,
    /// [`Bvh::intersect_batch`] is faster and gives the same bits.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Ray, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    /// let wall = scene.add_mesh(&corners, &[[0, 1, 2]])?;
    /// let bvh = Bvh::build(&scene);
    ///
    /// let hit = bvh.intersect(&Ray::new([1.0, 2.0, 5.0], [0.0, 0.0, -1.0])).expect("a hit");
    /// assert_eq!((hit.t, hit.u, hit.v), (5.0, 0.25, 0.5));
    /// assert_eq!((hit.prim_id, hit.geom_id), (0, wall));
    /// assert_eq!(bvh.intersect(&Ray::new([1.0, 2.0, 5.0], [0.0, 0.0, 1.0])), None);
    /// assert_eq!(bvh.intersect(&Ray::new([1.0, 2.0, 5.0], [f32::NAN; 3])), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.closest_by(&mut OneRay::new(self), ray)
    }

    /// As [`Bvh::intersect`], to memory of the caller's, which a miss leaves as it is. Returns true
    /// if there is a hit. Where hits are kept, this saves some five nanoseconds a ray: an `Option`
    /// is written by numbers and copied by wider words, which wait for the numbers.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Hit, Ray, Scene};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// let bvh = Bvh::build(&scene);
    /// let mut hit = Hit { t: 7.0, u: 0.0, v: 0.0, prim_id: 9, geom_id: 9 };
    /// assert!(!bvh.intersect_into(&Ray::new([5.0, 0.0, -3.0], [0.0, 0.0, 1.0]), &mut hit));
    /// assert_eq!(hit.prim_id, 9);
    /// assert!(bvh.intersect_into(&Ray::new([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]), &mut hit));
    /// assert_eq!((hit.t, hit.prim_id), (2.0, 0));
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn intersect_into(&self, ray: &Ray, hit: &mut Hit) -> bool {
        let closest = self.closest_by(&mut OneRay::new(self), ray);
        closest.map(|closest| *hit = closest).is_some()
    }

    /// Returns true if a ray hits anything before its `tmax`. Cost as for [`Bvh::intersect`].
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Ray, Scene};
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// let bvh = Bvh::build(&scene);
    /// let light = [0.0, 9.0, 0.0];
    /// assert!(bvh.occluded(&Ray::segment([0.0, -9.0, 0.0], light)));
    /// assert!(!bvh.occluded(&Ray::segment([0.0, 2.0, 0.0], light)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.occluded_by(&mut OneRay::new(self), ray)
    }

    #[inline(always)]
    fn occluded_by(&self, kernel: &mut OneRay, ray: &Ray) -> bool {
        ray.can_hit() && kernel.occluded([&ray.origin, &ray.direction], ray.tmax)
    }

    #[inline(always)]
    fn closest_by(&self, kernel: &mut OneRay, ray: &Ray) -> Option<Hit> {
        if !ray.can_hit() {
            return None;
        }
        let hit = kernel.closest([&ray.origin, &ray.direction], ray.tmax);
        let (weights, prim_id) = hit.found()?;
        Some(self.hit_of(weights, prim_id))
    }

    /// A hit from its distance, its weights and its primitive.
    #[inline(always)]
    fn hit_of(&self, [t, u, v]: [f32; 3], prim_id: u32) -> Hit {
        Hit {
            t,
            u,
            v,
            prim_id,
            geom_id: self.geometries().find(prim_id),
        }
    }

    /// The `prim_id` of a geometry's first primitive: `hit.prim_id` minus this is the row of the
    /// triangle or sphere in the slices that it was added from. `None` for geometries without
    /// primitives, for [`NO_GEOM`], and in trees from a cache.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Ray, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let near = scene.add_spheres(&[[0.0; 3], [9.0, 0.0, 0.0]], &[1.0, 1.0])?;
    /// let far = scene.add_spheres(&[[0.0, 9.0, 0.0], [9.0, 9.0, 0.0]], &[1.0, 1.0])?;
    /// let bvh = Bvh::build(&scene);
    /// let hit = bvh.intersect(&Ray::new([9.0, 9.0, -5.0], [0.0, 0.0, 1.0])).expect("a hit");
    /// assert_eq!((hit.geom_id, hit.prim_id), (far, 3));
    /// assert_eq!(bvh.first_prim(far).map(|first| hit.prim_id - first), Some(1));
    /// assert_eq!(bvh.first_prim(near), Some(0));
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn first_prim(&self, geometry: GeomId) -> Option<u32> {
        self.geometries().first_prim(geometry)
    }
}
