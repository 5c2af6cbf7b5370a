//! The list of primitives: the kind of each, and its index in the columns of that kind.

use bytemuck::{Pod, Zeroable};

/// The kinds of primitive a scene can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PrimKind {
    /// Sphere by centre and radius.
    Sphere = 0,
    /// Unit sphere under an affine map.
    Ellipsoid = 1,
    /// Triangle.
    Triangle = 2,
    /// Truncated cone or cylinder, open at both ends.
    Cone = 3,
}

impl PrimKind {
    /// The kind with this number (`kind as u32`).
    #[inline(always)]
    pub fn from_number(number: u32) -> PrimKind {
        match number {
            0 => PrimKind::Sphere,
            1 => PrimKind::Ellipsoid,
            2 => PrimKind::Triangle,
            _ => PrimKind::Cone,
        }
    }
}

/// One entry of the primitive list: kind in the upper two bits, index into that kind's columns
/// below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Prim(u32);

impl Prim {
    /// Most primitives of one kind.
    pub const MAX_INDEX: u32 = (1 << 30) - 1;

    /// Packs a kind and an index.
    #[inline]
    pub fn new(kind: PrimKind, index: u32) -> Self {
        assert!(index <= Self::MAX_INDEX, "more than 2^30 primitives");
        Prim((kind as u32) << 30 | index)
    }

    /// The kind.
    #[inline]
    pub fn kind(self) -> PrimKind {
        PrimKind::from_number(self.0 >> 30)
    }

    /// Index into the columns of [`Prim::kind`].
    #[inline]
    pub fn index(self) -> usize {
        (self.0 & Self::MAX_INDEX) as usize
    }
}
