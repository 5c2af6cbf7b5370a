//! References to objects during a tree build: number, kind and padded box, in 32 bytes.

use super::LeafKind;
use crate::simd::{F32x8, Lanes};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use phalanx_scene::Bounds;

/// Number of an object: a stored primitive below [`Scene::prim_count`], an instance from there on.
///
/// [`Scene::prim_count`]: phalanx_scene::Scene::prim_count
pub(super) type PrimIndex = u32;

/// An object and its padded box. The upper corner is stored negated, so that the minimum of eight
/// lanes is the union of two boxes (as in tinybvh).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(super) struct PrimRef {
    lo: [f32; 3],
    pub(super) object: PrimIndex,
    minus_hi: [f32; 3],
    kind: u32,
}

impl PrimRef {
    #[inline]
    pub(super) fn new(object: PrimIndex, kind: LeafKind, bounds: Bounds) -> PrimRef {
        PrimRef {
            lo: bounds.lo.to_array(),
            object,
            minus_hi: (-bounds.hi).to_array(),
            kind: kind.number() as u32,
        }
    }

    #[inline]
    pub(super) fn kind(&self) -> LeafKind {
        LeafKind::from_number(self.kind as usize)
    }

    #[inline]
    pub(super) fn bounds(&self) -> Bounds {
        Bounds::new(Vec3::from(self.lo), -Vec3::from(self.minus_hi))
    }

    /// The box: lower corner by axis, then upper corner.
    #[inline(always)]
    pub(super) fn planes(&self) -> [f32; 6] {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.lo, self.minus_hi);
        [x0, y0, z0, -x1, -y1, -z1]
    }

    /// Twice the centre of the box.
    #[inline(always)]
    pub(super) fn center(&self) -> Vec3 {
        Vec3::from(self.lo) - Vec3::from(self.minus_hi)
    }

    /// The row as lanes: the lower corner, an unused lane, the negated upper corner, and another
    /// unused lane.
    #[inline(always)]
    pub(super) fn lanes(&self) -> F32x8 {
        F32x8::new(bytemuck::cast(*self))
    }
}

/// The box around twice the centres of objects.
pub(super) fn center_extent(items: &[PrimRef]) -> Bounds {
    let mut extent = Bounds::EMPTY;
    for item in items {
        let center = item.center();
        extent = extent.union(Bounds::new(center, center));
    }
    extent
}

/// A box as lanes, in the layout of [`PrimRef::lanes`]; the minimum is the union.
#[derive(Clone, Copy)]
pub(super) struct LaneBounds(pub(super) F32x8);

impl LaneBounds {
    pub(super) const EMPTY: LaneBounds = LaneBounds(F32x8::new([f32::INFINITY; 8]));

    #[inline(always)]
    pub(super) fn union(self, other: LaneBounds) -> LaneBounds {
        LaneBounds(self.0.min(other.0))
    }

    #[inline]
    pub(super) fn bounds(self) -> Bounds {
        let [x, y, z, _, minus_x, minus_y, minus_z, _] = self.0.to_array();
        Bounds::new(Vec3::new(x, y, z), Vec3::new(-minus_x, -minus_y, -minus_z))
    }
}
