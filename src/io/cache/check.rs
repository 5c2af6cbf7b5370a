//! Conditions that must hold for every row of a column, so that no engine meets a number it does
//! not expect.

use phalanx_scene::{Prim, PrimKind};

/// Bytes that one task checks: they stay in a core's own cache between the checksum and the check
/// of the rows.
pub(super) const BLOCK: usize = 1 << 18;

/// The condition on a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Check {
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
    /// A u32 below this.
    Below(usize),
    /// Three u32 below `count`, or three times `none`.
    Corners {
        /// Number of rows they index.
        count: usize,
        /// The value that stands for no index.
        none: Option<u32>,
    },
    /// A primitive whose row exists in the column of its kind.
    Prims([usize; PrimKind::COUNT]),
}

impl Check {
    /// Returns true if the condition holds for all rows in these bytes, which are whole, aligned
    /// rows of the column.
    ///
    /// No early return within a block: a loop without one is vectorised.
    pub(super) fn holds(self, bytes: &[u8]) -> bool {
        match self {
            Check::Any => true,
            Check::Finite => every(bytes, |c: &f32| c.is_finite()),
            Check::Color => every(bytes, |c: &f32| c.is_finite() & (*c >= 0.0)),
            Check::UnitInterval => every(bytes, |c: &f32| (*c >= 0.0) & (*c <= 1.0)),
            Check::Positive => every(bytes, |c: &f32| c.is_finite() & (*c > 0.0)),
            Check::Below(count) => every(bytes, |&row: &u32| (row as usize) < count),
            Check::Corners { count, none: None } => Check::Below(count).holds(bytes),
            Check::Corners {
                count,
                none: Some(none),
            } => every(bytes, |&[a, b, c]: &[u32; 3]| {
                let within = |row: u32| (row as usize) < count;
                let nothing = (a == none) & (b == none) & (c == none);
                (within(a) & within(b) & within(c)) | nothing
            }),
            Check::Prims(counts) => every(bytes, |prim: &Prim| {
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
