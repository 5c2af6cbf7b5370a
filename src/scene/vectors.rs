//! Vector attributes, one column per component.

use super::Column;
use crate::bounds::Bounds;
use crate::column::{AnyColumn, Attribute};
use crate::threads::{BLOCK_ROWS, map_on_pool};
use glam::{Vec2, Vec3};
use std::ops::Range;

/// Three float columns: a vector attribute stored as structure of arrays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vec3s {
    /// x components.
    pub x: Column<f32>,
    /// y components.
    pub y: Column<f32>,
    /// z components.
    pub z: Column<f32>,
}

impl Vec3s {
    /// Number of vectors.
    #[inline]
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Returns true if there are no vectors.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Appends one vector.
    #[inline]
    pub fn push(&mut self, v: Vec3) {
        self.x.push(v.x);
        self.y.push(v.y);
        self.z.push(v.z);
    }

    /// The vector at `i`.
    #[inline]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// [`Vec3s::get`], as a column calls it.
    #[inline]
    pub(crate) fn row(&self, i: usize) -> Vec3 {
        self.get(i)
    }

    /// Replaces the vector at `i`.
    #[inline]
    pub fn set(&mut self, i: usize, v: Vec3) {
        (self.x[i], self.y[i], self.z[i]) = (v.x, v.y, v.z);
    }

    /// The box of some rows, which are finite.
    pub(crate) fn bounds(&self, rows: Range<usize>) -> Bounds {
        let ends = self.parts().map(|part| least_and_most(&part[rows.clone()]));
        let [lo, hi] = [0, 1].map(|side| Vec3::from_array(ends.map(|end| end[side])));
        Bounds::new(lo, hi)
    }

    /// Appends the rows of another attribute, or takes it over if this one is empty.
    #[inline]
    pub fn append(&mut self, other: Vec3s) {
        self.x.append(other.x);
        self.y.append(other.y);
        self.z.append(other.z);
    }

    /// The three columns.
    #[inline]
    pub fn parts(&self) -> [&Column<f32>; 3] {
        [&self.x, &self.y, &self.z]
    }

    /// The three columns, to be changed.
    #[inline]
    pub fn parts_mut(&mut self) -> [&mut Column<f32>; 3] {
        [&mut self.x, &mut self.y, &mut self.z]
    }

    /// Largest absolute value of a component.
    pub(crate) fn largest_magnitude(&self) -> f32 {
        let of_part = |part: &[f32]| map_on_pool(part.chunks(BLOCK_ROWS), largest_magnitude);
        let blocks = self.parts().into_iter().flat_map(|part| of_part(part));
        blocks.fold(0.0, f32::max)
    }
}

impl Attribute for Vec3s {
    fn columns(&self) -> Vec<&dyn AnyColumn> {
        vec![&self.x, &self.y, &self.z]
    }

    fn columns_mut(&mut self) -> Vec<&mut dyn AnyColumn> {
        vec![&mut self.x, &mut self.y, &mut self.z]
    }
}

/// Largest absolute value of a column. It uses eight lanes, so that one comparison need not wait
/// for the one before.
fn largest_magnitude(column: &[f32]) -> f32 {
    let mut most = [0.0f32; 8];
    let (blocks, rest) = column.as_chunks::<8>();
    for block in blocks {
        for (most, c) in most.iter_mut().zip(block) {
            *most = most.max(c.abs());
        }
    }
    let all = most.into_iter().chain(rest.iter().map(|c| c.abs()));
    all.fold(0.0, f32::max)
}

/// The least and the largest of finite numbers, in lanes.
fn least_and_most(column: &[f32]) -> [f32; 2] {
    const LANES: usize = 8;
    let mut ends = [[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]];
    for row in column.chunks(LANES) {
        for (k, &x) in row.iter().enumerate() {
            ends[0][k] = if x < ends[0][k] { x } else { ends[0][k] };
            ends[1][k] = if x > ends[1][k] { x } else { ends[1][k] };
        }
    }
    let [least, most] = ends;
    [
        least.into_iter().fold(f32::INFINITY, f32::min),
        most.into_iter().fold(f32::NEG_INFINITY, f32::max),
    ]
}

/// Two float columns: texture coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vec2s {
    /// x components.
    pub x: Column<f32>,
    /// y components.
    pub y: Column<f32>,
}

impl Vec2s {
    /// Number of vectors.
    #[inline]
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Returns true if there are no vectors.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Appends one vector.
    #[inline]
    pub fn push(&mut self, v: Vec2) {
        self.x.push(v.x);
        self.y.push(v.y);
    }

    /// The vector at `i`.
    #[inline]
    pub fn get(&self, i: usize) -> Vec2 {
        Vec2::new(self.x[i], self.y[i])
    }

    /// Appends the rows of another attribute, or takes it over if this one is empty.
    #[inline]
    pub fn append(&mut self, other: Vec2s) {
        self.x.append(other.x);
        self.y.append(other.y);
    }
}

impl Attribute for Vec2s {
    fn columns(&self) -> Vec<&dyn AnyColumn> {
        vec![&self.x, &self.y]
    }

    fn columns_mut(&mut self) -> Vec<&mut dyn AnyColumn> {
        vec![&mut self.x, &mut self.y]
    }
}
