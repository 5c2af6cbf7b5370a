//! Triangles of a block, prepared for tests one by one against packets of a beam.

use super::batch::BeamGroup;
use super::projection::{BeamSpace, TriangleView};
use crate::bvh::TriangleBlock;
use crate::intersect::aabb::TInterval;
use crate::intersect::shear::{VertexColumns, Vertices};
use crate::intersect::triangle::{self, Pairing};
use crate::simd::{Lanes, NATIVE, Native, Vec3Lanes, Vec3Native};
use crate::traverse::query::Query;

/// The triangles of a block, for rays that all start at the apex.
pub(super) struct BeamTriangles<'a> {
    pub(super) seen: TriangleView,
    /// Vertices relative to the rays' common origin.
    corners: VertexColumns,
    block: &'a TriangleBlock,
}

impl<'a> BeamTriangles<'a> {
    #[inline(always)]
    pub(super) fn new(space: &BeamSpace, block: &'a TriangleBlock) -> BeamTriangles<'a> {
        let stored = vertices(block);
        let relative = space.relative(&stored);
        BeamTriangles {
            seen: space.triangles(&stored, &relative),
            corners: relative.map(|v| [v.x, v.y, v.z, Native::ZERO]),
            block,
        }
    }

    /// Tests one triangle against a packet; returns true if the query accepted a hit.
    #[inline(always)]
    pub(super) fn test<L: Lanes>(
        &self,
        lane: usize,
        rays: &BeamGroup<L>,
        query: &mut impl Query<L>,
    ) -> bool {
        self.intersect::<L, false>(lane, rays, query)
    }

    /// Tests one triangle against rays whose dominant axes differ. A separate function, because it
    /// is rare and needs many registers.
    #[cold]
    #[inline(never)]
    pub(super) fn test_apart<L: Lanes>(
        &self,
        lane: usize,
        rays: &BeamGroup<L>,
        query: &mut impl Query<L>,
    ) -> bool {
        self.intersect::<L, true>(lane, rays, query)
    }

    #[inline(always)]
    fn intersect<L: Lanes, const APART: bool>(
        &self,
        lane: usize,
        rays: &BeamGroup<L>,
        query: &mut impl Query<L>,
    ) -> bool {
        let corners = rays.shear.in_order::<APART>(&self.corners, lane);
        let block = self.block;
        RayTrianglePair { rays, block, lane }.intersect(corners, query)
    }
}

/// The vertices of a block's triangles.
#[inline(always)]
pub(super) fn vertices(block: &TriangleBlock) -> [Vec3Native; 3] {
    let position = |c: &[[f32; NATIVE]; 3]| {
        let [x, y, z] = c.map(Native::new);
        Vec3Native::new(x, y, z)
    };
    let [a, b, c] = &block.vertices;
    [position(a), position(b), position(c)]
}

/// A packet of a beam, and the triangle of a block that it is tested against.
pub(super) struct RayTrianglePair<'a, L: Lanes> {
    pub(super) rays: &'a BeamGroup<L>,
    pub(super) block: &'a TriangleBlock,
    pub(super) lane: usize,
}

impl<L: Lanes> RayTrianglePair<'_, L> {
    /// Intersects rays and triangle; returns true if the query accepted a hit. `corners` are the
    /// vertices relative to the rays' origins.
    #[inline(always)]
    pub(super) fn intersect(&self, corners: [Vec3Lanes<L>; 3], query: &mut impl Query<L>) -> bool {
        // Most remaining pairs are hits, and the misses are unpredictable.
        let hit = triangle::intersect_branchless(corners, self.rays.shear.slopes(), self);
        query.update(&hit, self.block.prim_id[self.lane % NATIVE])
    }
}

impl<L: Lanes> Pairing<L> for RayTrianglePair<'_, L> {
    #[inline(always)]
    fn interval(&self) -> TInterval<L> {
        let lane = |axis: &[f32; NATIVE]| axis[self.lane % NATIVE];
        let corners = self.block.vertices.each_ref();
        let corners = corners.map(|corner| corner.each_ref().map(lane));
        self.rays
            .slabs()
            .intersect_box(&triangle::prim_aabb(&corners))
    }

    #[inline(always)]
    fn rays(&self) -> [Vec3Lanes<L>; 2] {
        [self.rays.rays.org, self.rays.rays.dir]
    }

    #[inline(always)]
    fn stored(&self) -> (&impl Vertices, Option<usize>) {
        (self.block, Some(self.lane))
    }
}
