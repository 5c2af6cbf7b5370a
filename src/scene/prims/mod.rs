//! The kinds of primitive: a list of all primitives, and the columns of each kind.

mod columns;
mod cones;
mod ellipsoids;
mod row_check;
mod spheres;
mod triangles;

pub use columns::{ColumnInfo, PrimColumns};
pub(crate) use columns::{RowScale, ScaleFactors, column_infos, column_list};
pub use cones::{Cone, ConeFrame, ConeProfile, Cones};
pub use ellipsoids::Ellipsoids;
pub use row_check::{NO_INDEX, RowCheck};
pub use spheres::Spheres;
pub use triangles::{INWARD, Mesh, MeshMaterial, Triangles};

use bytemuck::{Pod, Zeroable};

/// Primitive number of a miss: 2³² − 1.
pub const NO_PRIM: u32 = u32::MAX;

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
    /// Every kind, in the order of their numbers.
    pub const ALL: [PrimKind; PrimKind::COUNT] = [
        PrimKind::Sphere,
        PrimKind::Ellipsoid,
        PrimKind::Triangle,
        PrimKind::Cone,
    ];

    /// Number of kinds. The match makes a new kind a compile error here, where the last is named.
    pub const COUNT: usize = 1 + match PrimKind::Sphere {
        PrimKind::Sphere | PrimKind::Ellipsoid | PrimKind::Triangle | PrimKind::Cone => {
            PrimKind::Cone as usize
        }
    };

    /// Name in counts and records, in the singular.
    pub const fn name(self) -> &'static str {
        match self {
            PrimKind::Sphere => "sphere",
            PrimKind::Ellipsoid => "ellipsoid",
            PrimKind::Triangle => "triangle",
            PrimKind::Cone => "cone",
        }
    }

    /// The kinds in the order of their columns in scene caches.
    pub const FILE_ORDER: [PrimKind; PrimKind::COUNT] = [
        PrimKind::Triangle,
        PrimKind::Sphere,
        PrimKind::Ellipsoid,
        PrimKind::Cone,
    ];

    /// Returns true if each primitive of the kind is an object by itself, and not a part of a
    /// surface.
    pub(crate) const fn is_whole_object(self) -> bool {
        match self {
            PrimKind::Sphere | PrimKind::Ellipsoid => true,
            PrimKind::Triangle | PrimKind::Cone => false,
        }
    }

    /// Bits of a kind in packed words.
    pub const BITS: u32 = 2;

    /// The kind with this number (`kind as u32`); its lowest [`PrimKind::BITS`] count.
    #[inline(always)]
    pub const fn from_number(number: u32) -> PrimKind {
        match number & ((1 << PrimKind::BITS) - 1) {
            0 => PrimKind::Sphere,
            1 => PrimKind::Ellipsoid,
            2 => PrimKind::Triangle,
            // Whatever a damaged cache holds is a kind.
            _ => PrimKind::Cone,
        }
    }
}

const _: () = assert!(
    PrimKind::COUNT <= 1 << PrimKind::BITS,
    "packed words have no room for another kind: see the uses of PrimKind::BITS"
);

const KIND_SHIFT: u32 = u32::BITS - PrimKind::BITS;

/// One entry of the primitive list: kind in the upper bits, index into that kind's columns below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Prim(u32);

impl Prim {
    /// Maximum number of primitives of one kind.
    pub const MAX_INDEX: u32 = (1 << KIND_SHIFT) - 1;

    /// Packs a kind and an index.
    #[inline]
    pub fn new(kind: PrimKind, index: u32) -> Self {
        assert!(index <= Self::MAX_INDEX, "more than 2^30 primitives");
        assert!((kind as usize) < PrimKind::COUNT);
        Prim((kind as u32) << KIND_SHIFT | index)
    }

    /// The kind.
    #[inline]
    pub fn kind(self) -> PrimKind {
        PrimKind::from_number(self.0 >> KIND_SHIFT)
    }

    /// Index into the columns of [`Prim::kind`].
    #[inline]
    pub fn index(self) -> usize {
        (self.0 & Self::MAX_INDEX) as usize
    }
}
