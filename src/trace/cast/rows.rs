//! Rays of a batch in rows, as numpy and most programs have them: x, y and z side by side.

use super::columns::same_length;
use super::{BatchError, Ray, RayBuffer, RayColumns, TMax};

/// Rays of a batch whose x, y and z lie side by side, row after row. What a ray may be and what
/// makes it fast is told at [`RayColumns`]; answers are the same. A batch turns the rows into
/// columns as it goes, which costs about a nanosecond a ray.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{Bvh, HitBuffer, RayRows, Scene, TMax};
///
/// let mut scene = Scene::new();
/// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
/// let bvh = Bvh::build(&scene);
/// // An origin and a direction, as Open3D has them: six numbers a ray.
/// let rays = [[0.0, 0.0, -3.0, 0.0, 0.0, 1.0], [5.0, 0.0, -3.0, 0.0, 0.0, 1.0]];
/// let numbers = rays.as_flattened();
/// let rows = RayRows {
///     origin: numbers,
///     direction: &numbers[3..],
///     stride: 6,
///     tmax: TMax::All(f32::INFINITY),
/// };
/// assert_eq!(rows.len(), 2);
/// let mut hits = HitBuffer::new(2);
/// bvh.intersect_batch(&rows, &mut hits.columns(), 1)?;
/// assert_eq!(hits.get(0).map(|hit| hit.t), Some(2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RayRows<'a> {
    /// Origins: three numbers at each multiple of `stride`.
    pub origin: &'a [f32],
    /// Directions, in the same way.
    pub direction: &'a [f32],
    /// Numbers from one ray to the next, 3 or more: 3 where rows touch.
    pub stride: usize,
    /// Distances from which on hits do not count.
    pub tmax: TMax<'a>,
}

/// Greatest distance of two numbers in memory.
const MAX_STRIDE: usize = isize::MAX as usize / size_of::<f32>();

impl<'a> RayRows<'a> {
    /// Rows that touch: one array of origins, and one of directions.
    pub fn new(origin: &'a [[f32; 3]], direction: &'a [[f32; 3]], tmax: TMax<'a>) -> RayRows<'a> {
        RayRows {
            origin: origin.as_flattened(),
            direction: direction.as_flattened(),
            stride: 3,
            tmax,
        }
    }

    /// Number of rays.
    #[inline]
    pub fn len(&self) -> usize {
        self.rows(self.origin)
    }

    /// Tells if there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Rows of three numbers that a slice holds.
    fn rows(&self, numbers: &[f32]) -> usize {
        let behind_first = numbers.len().checked_sub(3);
        behind_first.map_or(0, |more| more / self.stride.max(3) + 1)
    }

    /// Compares the lengths of all slices, as every batch does first.
    ///
    /// # Errors
    /// [`BatchError`] with what differs from the origins, or a stride below 3 or beyond any memory.
    pub fn check(&self) -> Result<(), BatchError> {
        let rays = self.len();
        same_length("direction", self.rows(self.direction), rays)?;
        if !(3..=MAX_STRIDE).contains(&self.stride) {
            return Err(BatchError {
                column: "stride",
                len: self.stride,
                rays,
            });
        }
        self.tmax.check("tmax", rays)
    }

    fn slice(&self, from: usize, to: usize) -> Self {
        let numbers =
            |all: &'a [f32]| &all[from * self.stride..][..(to - from - 1) * self.stride + 3];
        RayRows {
            origin: numbers(self.origin),
            direction: numbers(self.direction),
            tmax: self.tmax.slice(from, to),
            ..*self
        }
    }
}

/// Rays as any batch takes them: [`RayColumns`] or [`RayRows`].
#[derive(Clone, Copy, Debug)]
pub enum RayBatch<'a> {
    /// A slice for each number.
    InColumns(RayColumns<'a>),
    /// Numbers of a ray side by side.
    InRows(RayRows<'a>),
}

impl<'a> From<&RayColumns<'a>> for RayBatch<'a> {
    fn from(columns: &RayColumns<'a>) -> RayBatch<'a> {
        RayBatch::InColumns(*columns)
    }
}

impl<'a> From<&RayRows<'a>> for RayBatch<'a> {
    fn from(rows: &RayRows<'a>) -> RayBatch<'a> {
        RayBatch::InRows(*rows)
    }
}

impl<'a> RayBatch<'a> {
    pub(super) fn len(&self) -> usize {
        match self {
            RayBatch::InColumns(columns) => columns.len(),
            RayBatch::InRows(rows) => rows.len(),
        }
    }

    pub(super) fn tmax(&self) -> TMax<'a> {
        match self {
            RayBatch::InColumns(columns) => columns.tmax,
            RayBatch::InRows(rows) => rows.tmax,
        }
    }

    pub(super) fn check(&self) -> Result<(), BatchError> {
        match self {
            RayBatch::InColumns(columns) => columns.check(),
            RayBatch::InRows(rows) => rows.check(),
        }
    }

    /// A ray, by its number.
    ///
    /// # Panics
    /// If there are fewer.
    #[inline(always)]
    pub fn ray(&self, k: usize) -> Ray {
        let (origin, direction) = match self {
            RayBatch::InColumns(columns) => (
                columns.origin.map(|column| column[k]),
                columns.direction.map(|column| column[k]),
            ),
            RayBatch::InRows(rows) => {
                let row =
                    |numbers: &[f32]| std::array::from_fn(|axis| numbers[k * rows.stride + axis]);
                (row(rows.origin), row(rows.direction))
            }
        };
        Ray {
            origin,
            direction,
            tmax: self.tmax().get(k),
        }
    }

    /// Some of the rays, one at least.
    pub(super) fn slice(&self, from: usize, to: usize) -> RayBatch<'a> {
        match self {
            RayBatch::InColumns(columns) => RayBatch::InColumns(columns.slice(from, to)),
            RayBatch::InRows(rows) => RayBatch::InRows(rows.slice(from, to)),
        }
    }
}

/// Rows turned into columns. Each number is read once, and nothing is decided by what the caller's
/// memory holds afterwards.
#[derive(Default)]
pub(super) struct TransposedRays(RayBuffer);

impl TransposedRays {
    /// The rays in columns.
    pub(super) fn columns<'b>(&'b mut self, rays: &RayBatch<'b>) -> RayColumns<'b> {
        let rows = match rays {
            RayBatch::InColumns(columns) => return *columns,
            RayBatch::InRows(rows) => rows,
        };
        turn(rows.origin, rows.stride, &mut self.0.origin);
        turn(rows.direction, rows.stride, &mut self.0.direction);
        if let TMax::Each(each) = rows.tmax {
            self.0.tmax.clear();
            self.0.tmax.extend_from_slice(each);
        }
        self.with_limits(rows.tmax)
    }

    /// The rays in columns, with limits of their own unless all have one.
    fn with_limits<'b>(&'b self, tmax: TMax<'b>) -> RayColumns<'b> {
        let columns = self.0.columns();
        match tmax {
            TMax::All(_) => RayColumns { tmax, ..columns },
            TMax::Each(_) => columns,
        }
    }

    /// The rays at some places, in columns.
    pub(super) fn picked<'b>(&'b mut self, rays: &RayBatch<'b>, places: &[u32]) -> RayColumns<'b> {
        let RayBuffer {
            origin,
            direction,
            tmax,
        } = &mut self.0;
        match rays {
            RayBatch::InColumns(columns) => {
                for axis in 0..3 {
                    pick(columns.origin[axis], places, &mut origin[axis]);
                    pick(columns.direction[axis], places, &mut direction[axis]);
                }
            }
            RayBatch::InRows(rows) => {
                pick_rows(rows.origin, rows.stride, places, origin);
                pick_rows(rows.direction, rows.stride, places, direction);
            }
        }
        if let TMax::Each(each) = rays.tmax() {
            pick(each, places, tmax);
        }
        self.with_limits(rays.tmax())
    }
}

/// Numbers at some places.
fn pick(numbers: &[f32], places: &[u32], column: &mut Vec<f32>) {
    column.clear();
    column.extend(places.iter().map(|&place| numbers[place as usize]));
}

/// Rows at some places, in columns. A picture's places come in runs of four side by side, which are
/// read as one.
fn pick_rows(numbers: &[f32], stride: usize, places: &[u32], columns: &mut [Vec<f32>; 3]) {
    match stride {
        3 => pick_strided(numbers, 3, places, columns),
        6 => pick_strided(numbers, 6, places, columns),
        _ => pick_strided(numbers, stride, places, columns),
    }
}

/// As [`pick_rows`]: compiled once for each stride that is common.
#[inline(always)]
fn pick_strided(numbers: &[f32], stride: usize, places: &[u32], columns: &mut [Vec<f32>; 3]) {
    for column in columns.iter_mut() {
        column.resize(places.len(), 0.0);
    }
    let [xs, ys, zs] = columns.each_mut().map(|column| column.as_chunks_mut::<4>());
    let (fours, rest) = places.as_chunks::<4>();
    let (x4, y4, z4) = (xs.0.iter_mut(), ys.0.iter_mut(), zs.0.iter_mut());
    for (four, ((x, y), z)) in fours.iter().zip(x4.zip(y4).zip(z4)) {
        match run_of_four(four) {
            Some(first) => {
                let rows = &numbers[first * stride..][..3 * stride + 3];
                let axis = |axis| std::array::from_fn(|row| rows[row * stride + axis]);
                (*x, *y, *z) = (axis(0), axis(1), axis(2));
            }
            None => pick_singly(numbers, stride, four, [x, y, z]),
        }
    }
    pick_singly(numbers, stride, rest, [xs.1, ys.1, zs.1]);
}

/// Rows at places that are no run.
fn pick_singly(numbers: &[f32], stride: usize, places: &[u32], columns: [&mut [f32]; 3]) {
    for (axis, column) in columns.into_iter().enumerate() {
        for (number, &place) in column.iter_mut().zip(places) {
            *number = numbers[place as usize * stride + axis];
        }
    }
}

/// The first of four places that lie side by side.
#[inline(always)]
pub(super) fn run_of_four(four: &[u32; 4]) -> Option<usize> {
    let first = four[0];
    let run = [first, first + 1, first + 2, first + 3];
    (*four == run).then_some(first as usize)
}

/// Three columns of numbers that lie side by side.
fn turn(numbers: &[f32], stride: usize, columns: &mut [Vec<f32>; 3]) {
    for (axis, column) in columns.iter_mut().enumerate() {
        column.clear();
        column.extend(numbers[axis..].iter().step_by(stride));
    }
}
