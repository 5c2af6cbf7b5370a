//! Conditions that must hold for every row of a column, so that no engine meets a number it does
//! not expect.

use super::{Prim, PrimKind};
use crate::textures::NO_TEXTURE;
use crate::threads::{BLOCK_ROWS, map_on_pool};

/// Marks a triangle without an optional attribute: its row of [`Triangles::normals`],
/// [`Triangles::uvs`], [`Triangles::tangents`] or [`Triangles::colors`] is three times this.
///
/// [`Triangles::normals`]: crate::Triangles::normals
/// [`Triangles::uvs`]: crate::Triangles::uvs
/// [`Triangles::tangents`]: crate::Triangles::tangents
/// [`Triangles::colors`]: crate::Triangles::colors
pub const NO_INDEX: u32 = u32::MAX;

/// The condition on a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowCheck {
    /// No condition, or one that is checked elsewhere.
    Any,
    /// A finite f32.
    Finite,
    /// A finite f32 of at least zero.
    Color,
    /// An f32 from 0 to 1.
    UnitInterval,
    /// A finite f32 above zero.
    Positive,
    /// A u32 below this, or several of them.
    Below(usize),
    /// A u32 below this, or [`NO_TEXTURE`].
    Texture(usize),
    /// Three u32 below this, or three times [`NO_INDEX`].
    CornersOrNone(usize),
    /// A primitive whose row exists in the column of its kind.
    Prims([usize; PrimKind::COUNT]),
}

impl RowCheck {
    /// The fault of a row for which the condition does not hold.
    pub(crate) fn problem(self) -> &'static str {
        match self {
            RowCheck::Finite => "not finite",
            RowCheck::Color => "negative or not finite",
            RowCheck::UnitInterval => "not from 0 to 1",
            RowCheck::Positive => "not a positive number",
            _ => "out of range",
        }
    }

    /// Index of the first row of `row_size` bytes for which the condition does not hold.
    pub(crate) fn first_fault(self, bytes: &[u8], row_size: usize) -> Option<usize> {
        let blocks = map_on_pool(bytes.chunks(BLOCK_ROWS * row_size), |block| {
            self.holds(block)
        });
        let block = blocks.into_iter().position(|holds| !holds)?;
        let mut rows = bytes.chunks(row_size).skip(block * BLOCK_ROWS);
        Some(block * BLOCK_ROWS + rows.position(|row| !self.holds(row))?)
    }

    /// Returns true if the condition holds for all rows in these bytes, which are complete, aligned
    /// rows of the column.
    ///
    /// No early return within a block: a loop without one is vectorised.
    pub fn holds(self, bytes: &[u8]) -> bool {
        match self {
            RowCheck::Any => true,
            RowCheck::Finite => every(bytes, |c: &f32| c.is_finite()),
            RowCheck::Color => every(bytes, |c: &f32| c.is_finite() & (*c >= 0.0)),
            RowCheck::UnitInterval => every(bytes, |c: &f32| (*c >= 0.0) & (*c <= 1.0)),
            RowCheck::Positive => every(bytes, |c: &f32| c.is_finite() & (*c > 0.0)),
            RowCheck::Texture(count) => every(bytes, |&row: &u32| {
                (row == NO_TEXTURE) | ((row as usize) < count)
            }),
            RowCheck::Below(count) => every(bytes, |&row: &u32| (row as usize) < count),
            RowCheck::CornersOrNone(count) => every(bytes, |row: &[u32; 3]| {
                let [a, b, c] = row.map(|index| (index as usize) < count);
                (a & b & c) | (*row == [NO_INDEX; 3])
            }),
            RowCheck::Prims(counts) => every(bytes, |prim: &Prim| {
                prim.index() < counts[prim.kind() as usize]
            }),
        }
    }
}

fn every<T: bytemuck::Pod>(bytes: &[u8], good: impl Fn(&T) -> bool) -> bool {
    match bytemuck::try_cast_slice(bytes) {
        Ok(rows) => rows.iter().fold(true, |all, row| all & good(row)),
        Err(_) => false,
    }
}
