//! The triangles of a block, ready to be tested one by one against packets of a beam.

use super::Group;
use super::frame::{Frame, TriangleView};
use crate::bvh::TriangleBlock;
use crate::simd::{Lanes, NATIVE, Native, Vec3Lanes, Vec3Native};
use crate::traverse::aabb::Stay;
use crate::traverse::goal::Goal;
use crate::traverse::triangle::{self, Columns, Corners, Pairing};

/// The triangles of a block, for rays that all start at the apex.
pub(super) struct Triangles<'a> {
    pub(super) seen: TriangleView,
    /// Less the origin.
    corners: Columns,
    block: &'a TriangleBlock,
}

impl<'a> Triangles<'a> {
    #[inline(always)]
    pub(super) fn new(frame: &Frame, block: &'a TriangleBlock) -> Triangles<'a> {
        let places = places(block);
        let relative = frame.relative(&places);
        Triangles {
            seen: frame.triangles(&places, &relative),
            corners: relative.map(|v| [v.x, v.y, v.z, Native::ZERO]),
            block,
        }
    }

    /// Whether any ray of a packet meets one of them, so that the goal took it.
    #[inline(always)]
    pub(super) fn test<L: Lanes>(
        &self,
        lane: usize,
        rays: &Group<L>,
        goal: &mut impl Goal<L>,
    ) -> bool {
        self.meet::<L, false>(lane, rays, goal)
    }

    /// The same for rays whose dominant axes differ. Apart, because it is rare and wants many registers.
    #[cold]
    #[inline(never)]
    pub(super) fn test_apart<L: Lanes>(
        &self,
        lane: usize,
        rays: &Group<L>,
        goal: &mut impl Goal<L>,
    ) -> bool {
        self.meet::<L, true>(lane, rays, goal)
    }

    #[inline(always)]
    fn meet<L: Lanes, const APART: bool>(
        &self,
        lane: usize,
        rays: &Group<L>,
        goal: &mut impl Goal<L>,
    ) -> bool {
        let corners = rays.shear.in_order::<APART>(&self.corners, lane);
        let block = self.block;
        Pair { rays, block, lane }.meet(corners, goal)
    }
}

/// The corners of a block's triangles.
#[inline(always)]
pub(super) fn places(block: &TriangleBlock) -> [Vec3Native; 3] {
    let place = |c: &[[f32; NATIVE]; 3]| {
        let [x, y, z] = c.map(Native::new);
        Vec3Native::new(x, y, z)
    };
    let [a, b, c] = &block.vertices;
    [place(a), place(b), place(c)]
}

/// A packet of a beam, and the triangle of a block that it is tested against.
pub(super) struct Pair<'a, L: Lanes> {
    pub(super) rays: &'a Group<L>,
    pub(super) block: &'a TriangleBlock,
    pub(super) lane: usize,
}

impl<L: Lanes> Pair<'_, L> {
    /// Whether any ray meets the triangle, so that the goal took it; its corners are those less the rays' origins.
    #[inline(always)]
    pub(super) fn meet(&self, corners: [Vec3Lanes<L>; 3], goal: &mut impl Goal<L>) -> bool {
        // Most of what is left by now is met, and which is not nobody can foretell.
        let hit = triangle::meet_likely(corners, self.rays.shear.slopes(), self);
        goal.take(&hit, self.block.prim_id[self.lane % NATIVE])
    }
}

impl<L: Lanes> Pairing<L> for Pair<'_, L> {
    #[inline(always)]
    fn stay(&self) -> Stay<L> {
        let lane = |axis: &[f32; NATIVE]| axis[self.lane % NATIVE];
        let corners = self.block.vertices.each_ref();
        let corners = corners.map(|corner| corner.each_ref().map(lane));
        self.rays.slabs().stay(&triangle::prim_aabb(&corners))
    }

    #[inline(always)]
    fn usual(&self) -> bool {
        self.rays.shear.usual
    }

    #[inline(always)]
    fn rays(&self) -> [Vec3Lanes<L>; 2] {
        [self.rays.rays.org, self.rays.rays.dir]
    }

    #[inline(always)]
    fn stored(&self) -> (&impl Corners, Option<usize>) {
        (self.block, Some(self.lane))
    }
}
