//! Rays and hits as columns: plain slices, one per component, of any length and alignment.

use super::{Hit, Ray};
use crate::packet::NO_PRIM;
use phalanx_scene::NO_GEOM;

/// A number for all rays of a batch, or one for each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PerRay<'a, T> {
    /// The same for all rays.
    All(T),
    /// One for each ray.
    Each(&'a [T]),
}

/// Farthest distances of a batch, in units of each ray's direction. Hits count below them; infinity
/// if rays have no end.
///
/// One for all is the fast case in batches of more than 512 rays: all kernels are available, except
/// for closest hits below a finite distance, which only packets find. If neighbours differ, only
/// packets are available, so coherent rays are slower; this does not apply if all rays end at 1
/// (see [`Ray::segment`]).
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{RayColumns, TMax};
///
/// let (zeros, ones, ends) = ([0.0; 8], [1.0; 8], [2.5; 8]);
/// let endless = RayColumns {
///     origin: [&zeros; 3].map(|column| &column[..]),
///     direction: [&ones; 3].map(|column| &column[..]),
///     tmax: TMax::All(f32::INFINITY),
/// };
/// let short = RayColumns { tmax: TMax::Each(&ends), ..endless };
/// assert!(endless.check().is_ok() && short.check().is_ok());
/// ```
pub type TMax<'a> = PerRay<'a, f32>;

impl<T: Copy + PartialEq> PerRay<'_, T> {
    /// The number of ray `k`.
    #[inline(always)]
    pub(super) fn get(&self, k: usize) -> T {
        match self {
            PerRay::All(one) => *one,
            PerRay::Each(each) => each[k],
        }
    }

    /// The number of all rays, if they have the same.
    pub(super) fn common(&self) -> Option<T> {
        match self {
            PerRay::All(one) => Some(*one),
            PerRay::Each(each) => {
                let first = *each.first()?;
                each.iter().all(|&one| one == first).then_some(first)
            }
        }
    }

    /// Checks that each of `rays` rays has a number.
    pub(super) fn check(&self, column: &'static str, rays: usize) -> Result<(), BatchError> {
        match self {
            PerRay::All(_) => Ok(()),
            PerRay::Each(each) => same_length(column, each.len(), rays),
        }
    }

    /// The numbers of a range of rays.
    pub(super) fn slice(&self, from: usize, to: usize) -> Self {
        match self {
            PerRay::Each(each) => PerRay::Each(&each[from..to]),
            PerRay::All(one) => PerRay::All(*one),
        }
    }
}

/// Rays of a batch: x, y and z of origins and directions in separate slices.
///
/// Origins are in scene units; directions may have lengths from 10⁻¹² to 10¹² (see
/// [`Ray::direction`](crate::Ray::direction)), and distances are in units of it. A ray with an
/// origin or direction that is not finite, a zero direction, or a `tmax` that is NaN, zero or
/// negative misses everything. For speed, adjacent rays in the slices should be coherent, like the
/// rays of one square of a picture; answers do not depend on it.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{RayColumns, TMax};
///
/// let (zeros, ones) = ([0.0; 100], [1.0; 100]);
/// let along_z = RayColumns {
///     origin: [&zeros, &zeros, &zeros],
///     direction: [&zeros, &zeros, &ones],
///     tmax: TMax::All(f32::INFINITY),
/// };
/// assert_eq!(along_z.len(), 100);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RayColumns<'a> {
    /// x, y and z of the origins.
    pub origin: [&'a [f32]; 3],
    /// x, y and z of the directions.
    pub direction: [&'a [f32]; 3],
    /// Distances at which rays end; hits beyond do not count.
    pub tmax: TMax<'a>,
}

/// Output columns for the hits of a batch, one row per ray. A call overwrites every row.
///
/// A miss has `t` = infinity, `u` = `v` = 0, `prim_id` = [`NO_PRIM`] and `geom_id` = [`NO_GEOM`],
/// which are both 2³² − 1. [`Hit`] documents the columns of a hit.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{Bvh, HitColumns, NO_GEOM, NO_PRIM, Ray, RayBuffer, Scene};
///
/// let bvh = Bvh::build(&Scene::new());
/// let rays: RayBuffer = [Ray::new([0.0; 3], [0.0, 0.0, 1.0])].into_iter().collect();
/// let (mut t, mut u, mut v) = ([7.0], [7.0], [7.0]);
/// let (mut prim_id, mut geom_id) = ([7], [7]);
/// let mut hits = HitColumns {
///     t: &mut t,
///     u: &mut u,
///     v: &mut v,
///     prim_id: &mut prim_id,
///     geom_id: &mut geom_id,
/// };
/// bvh.intersect_batch(&rays.columns(), &mut hits, 0)?;
/// assert_eq!((t, u, v), ([f32::INFINITY], [0.0], [0.0]));
/// assert_eq!((prim_id, geom_id), ([NO_PRIM], [NO_GEOM]));
/// # Ok::<(), phalanx::BatchError>(())
/// ```
#[derive(Debug)]
pub struct HitColumns<'a> {
    /// Distances in units of the rays' directions.
    pub t: &'a mut [f32],
    /// Barycentric weights of triangles' second vertices.
    pub u: &'a mut [f32],
    /// Barycentric weights of triangles' third vertices.
    pub v: &'a mut [f32],
    /// Primitives.
    pub prim_id: &'a mut [u32],
    /// Geometries.
    pub geom_id: &'a mut [u32],
}

/// Error for columns of one batch that differ in length. A call that returns it has written
/// nothing.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{Bvh, HitBuffer, Ray, RayBuffer, Scene};
///
/// let bvh = Bvh::build(&Scene::new());
/// let rays: RayBuffer = [Ray::new([0.0; 3], [0.0, 0.0, 1.0])].into_iter().collect();
/// let mut hits = HitBuffer::new(2);
/// let error = bvh.intersect_batch(&rays.columns(), &mut hits.columns(), 0).unwrap_err();
/// assert_eq!((error.column, error.len, error.rays), ("t", 2, 1));
/// assert_eq!(error.to_string(), "the column t has 2 rows, and there are 1 rays");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the column {column} has {len} rows, and there are {rays} rays")]
pub struct BatchError {
    /// Name of the column.
    pub column: &'static str,
    /// Its length.
    pub len: usize,
    /// Number of rays: the length of the origins' x.
    pub rays: usize,
}

impl RayColumns<'_> {
    /// Number of rays.
    #[inline]
    pub fn len(&self) -> usize {
        self.origin[0].len()
    }

    /// Returns true if there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Compares the lengths of all columns, as every batch does first.
    ///
    /// # Errors
    /// [`BatchError`] with the first column that differs from the origins' x.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{RayColumns, TMax};
    ///
    /// let (long, short) = ([0.0; 3], [0.0; 2]);
    /// let rays = RayColumns {
    ///     origin: [&long, &long, &long],
    ///     direction: [&long, &long, &short],
    ///     tmax: TMax::All(1.0),
    /// };
    /// assert_eq!(rays.check().unwrap_err().column, "direction");
    /// ```
    pub fn check(&self) -> Result<(), BatchError> {
        let rays = self.len();
        for (name, columns) in [("origin", self.origin), ("direction", self.direction)] {
            for column in columns {
                same_length(name, column.len(), rays)?;
            }
        }
        self.tmax.check("tmax", rays)
    }

    /// A range of the rays.
    pub(super) fn slice(&self, from: usize, to: usize) -> Self {
        RayColumns {
            origin: self.origin.map(|column| &column[from..to]),
            direction: self.direction.map(|column| &column[from..to]),
            tmax: self.tmax.slice(from, to),
        }
    }
}

impl HitColumns<'_> {
    /// Writes the answer of ray `k`.
    #[inline(always)]
    pub(super) fn put(&mut self, k: usize, hit: Option<Hit>) {
        let hit = hit.unwrap_or(Hit::MISS);
        self.t[k] = hit.t;
        self.u[k] = hit.u;
        self.v[k] = hit.v;
        self.prim_id[k] = hit.prim_id;
        self.geom_id[k] = hit.geom_id;
    }

    pub(super) fn check(&self, rays: usize) -> Result<(), BatchError> {
        same_length("t", self.t.len(), rays)?;
        same_length("u", self.u.len(), rays)?;
        same_length("v", self.v.len(), rays)?;
        same_length("prim_id", self.prim_id.len(), rays)?;
        same_length("geom_id", self.geom_id.len(), rays)
    }

    /// Pieces of `rows` rows, the last one shorter.
    pub(super) fn chunks(&mut self, rows: usize) -> impl Iterator<Item = HitColumns<'_>> + Send {
        let weights = self.u.chunks_mut(rows).zip(self.v.chunks_mut(rows));
        let numbers = self.prim_id.chunks_mut(rows);
        let numbers = numbers.zip(self.geom_id.chunks_mut(rows));
        let all = self.t.chunks_mut(rows).zip(weights).zip(numbers);
        all.map(|((t, (u, v)), (prim_id, geom_id))| HitColumns {
            t,
            u,
            v,
            prim_id,
            geom_id,
        })
    }
}

pub(super) fn same_length(column: &'static str, len: usize, rays: usize) -> Result<(), BatchError> {
    if len == rays { Ok(()) } else { Err(BatchError { column, len, rays }) }
}

/// Buffer of rays in columns, filled one by one, for callers without columns of their own.
///
/// 28 bytes per ray.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{Ray, RayBuffer};
///
/// let ahead = |x| Ray::new([x, 0.0, 0.0], [0.0, 0.0, 1.0]);
/// let mut rays: RayBuffer = (0..10).map(|x| ahead(x as f32)).collect();
/// assert_eq!(rays.columns().origin[0][9], 9.0);
/// rays.clear();
/// rays.push(&ahead(5.0));
/// assert_eq!(rays.len(), 1);
/// ```
#[derive(Clone, Debug, Default)]
pub struct RayBuffer {
    pub(super) origin: [Vec<f32>; 3],
    pub(super) direction: [Vec<f32>; 3],
    pub(super) tmax: Vec<f32>,
}

impl RayBuffer {
    /// Creates an empty buffer with room for `rays` rays.
    pub fn with_capacity(rays: usize) -> RayBuffer {
        let column = || Vec::with_capacity(rays);
        RayBuffer {
            origin: [(); 3].map(|()| column()),
            direction: [(); 3].map(|()| column()),
            tmax: column(),
        }
    }

    /// Appends a ray.
    #[inline]
    pub fn push(&mut self, ray: &Ray) {
        for axis in 0..3 {
            self.origin[axis].push(ray.origin[axis]);
            self.direction[axis].push(ray.direction[axis]);
        }
        self.tmax.push(ray.tmax);
    }

    /// Removes all rays and keeps the memory.
    pub fn clear(&mut self) {
        let columns = self.origin.iter_mut().chain(&mut self.direction);
        columns.for_each(Vec::clear);
        self.tmax.clear();
    }

    /// Number of rays.
    #[inline]
    pub fn len(&self) -> usize {
        self.tmax.len()
    }

    /// Returns true if there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.tmax.is_empty()
    }

    /// Borrows the columns.
    #[inline]
    pub fn columns(&self) -> RayColumns<'_> {
        RayColumns {
            origin: self.origin.each_ref().map(Vec::as_slice),
            direction: self.direction.each_ref().map(Vec::as_slice),
            tmax: TMax::Each(&self.tmax),
        }
    }
}

impl FromIterator<Ray> for RayBuffer {
    fn from_iter<I: IntoIterator<Item = Ray>>(rays: I) -> RayBuffer {
        let mut buffer = RayBuffer::default();
        rays.into_iter().for_each(|ray| buffer.push(&ray));
        buffer
    }
}

/// Buffer of hits in columns, initially all misses.
///
/// 20 bytes per ray. A buffer can be reused for any number of batches of its length.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{Bvh, HitBuffer, Ray, RayBuffer, Scene};
///
/// let mut scene = Scene::new();
/// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
/// let bvh = Bvh::build(&scene);
/// let rays: RayBuffer =
///     (0..3).map(|x| Ray::new([2.0 * x as f32, 0.0, -3.0], [0.0, 0.0, 1.0])).collect();
/// let mut hits = HitBuffer::new(rays.len());
/// assert_eq!(hits.get(0), None);
/// bvh.intersect_batch(&rays.columns(), &mut hits.columns(), 0)?;
/// assert_eq!(hits.get(0).map(|hit| hit.t), Some(2.0));
/// assert_eq!(hits.iter().flatten().count(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct HitBuffer {
    t: Vec<f32>,
    u: Vec<f32>,
    v: Vec<f32>,
    prim_id: Vec<u32>,
    geom_id: Vec<u32>,
}

impl HitBuffer {
    /// Creates rows for the hits of `rays` rays.
    pub fn new(rays: usize) -> HitBuffer {
        HitBuffer {
            t: vec![f32::INFINITY; rays],
            u: vec![0.0; rays],
            v: vec![0.0; rays],
            prim_id: vec![NO_PRIM; rays],
            geom_id: vec![NO_GEOM; rays],
        }
    }

    /// Number of rays.
    #[inline]
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Returns true if there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Borrows the columns to be filled.
    #[inline]
    pub fn columns(&mut self) -> HitColumns<'_> {
        HitColumns {
            t: &mut self.t,
            u: &mut self.u,
            v: &mut self.v,
            prim_id: &mut self.prim_id,
            geom_id: &mut self.geom_id,
        }
    }

    /// The hit of ray `i`, or `None` if it missed.
    ///
    /// # Panics
    /// If there is no ray `i`.
    #[inline]
    pub fn get(&self, i: usize) -> Option<Hit> {
        let hit = Hit {
            t: self.t[i],
            u: self.u[i],
            v: self.v[i],
            prim_id: self.prim_id[i],
            geom_id: self.geom_id[i],
        };
        (hit.prim_id != NO_PRIM).then_some(hit)
    }

    /// Iterates over the hits, ray by ray.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Option<Hit>> + '_ {
        (0..self.len()).map(|i| self.get(i))
    }
}
