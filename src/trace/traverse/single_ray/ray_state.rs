//! One ray in flight, against all boxes of a node or all primitives of a block at once.

use crate::bvh::{SphereBlock, TriangleBlock};
use crate::intersect::aabb::{REACH, TInterval};
use crate::intersect::hit::{HitCandidate, HitRecord};
use crate::intersect::leaf_prim::Candidates;
use crate::intersect::shear::Vertices;
use crate::intersect::sphere;
use crate::intersect::triangle::{self, Pairing};
use crate::packet::NO_PRIM;
use crate::simd::{F32x8, LaneU32, Lanes, NATIVE, Native, NativeMask, U32x8, Vec3Native};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Test data of a ray, in words of four bytes: those of a packet are made by transposing columns of
/// lanes to rows. Two cache lines; no word crosses their border.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct SingleRaySetup {
    /// Data of the slab test: see [`crate::intersect::aabb`].
    pub(super) rdir: [f32; 3],
    pub(super) first: [f32; 3],
    pub(super) last: [f32; 3],
    /// Rows of a box's planes that are crossed first and last, by axis: offsets in bytes from the
    /// first, by [`row_offset`].
    pub(super) near: [u32; 3],
    pub(super) far: [u32; 3],
    /// Data of the triangle test: the axes in the order of the ray's frame, the origin in that
    /// order, and [`Shear::slopes`](crate::intersect::shear::Shear::slopes).
    pub(super) axes: [u32; 3],
    pub(super) frame_org: [f32; 3],
    pub(super) slopes: [f32; 4],
    pub(super) org: [f32; 3],
    pub(super) dir: [f32; 3],
    /// Bits of the axes along which the ray goes toward larger coordinates; the fourth bit is
    /// always set, for rows without an axis.
    pub(super) up: u32,
}

impl SingleRaySetup {
    const NONE: SingleRaySetup = SingleRaySetup {
        rdir: [0.0; 3],
        first: [0.0; 3],
        last: [0.0; 3],
        near: [0; 3],
        far: [0; 3],
        axes: [0; 3],
        frame_org: [0.0; 3],
        slopes: [0.0; 4],
        org: [0.0; 3],
        dir: [0.0; 3],
        up: 0,
    };
}

/// Bytes of a row of planes.
const ROW: usize = size_of::<[f32; NATIVE]>();

/// Offset in bytes of the planes of a side across an axis, among those of a node.
pub(super) const fn row_offset(side: u32, axis: usize) -> u32 {
    (side as usize * 3 + axis) as u32 * ROW as u32
}

/// One ray in flight.
#[derive(Clone, Copy)]
pub(super) struct RayState {
    pub(super) ray: SingleRaySetup,
    pub(super) best: SingleHit,
    /// Beginning of the ray's stack among all, and its end.
    pub(super) bottom: usize,
    pub(super) top: usize,
    /// Code of the current row.
    pub(super) current: u32,
    /// Number of the ray in the queue.
    pub(super) number: usize,
}

/// The closest hit so far of one ray, as in [`HitRecord`].
#[derive(Clone, Copy)]
pub(super) struct SingleHit {
    pub(super) t: f32,
    pub(super) v: f32,
    pub(super) w: f32,
    pub(super) det: f32,
    pub(super) prim_id: u32,
}

impl RayState {
    /// A state without a ray.
    pub(super) const IDLE: RayState = RayState {
        ray: SingleRaySetup::NONE,
        best: SingleHit::none_before(0.0),
        bottom: 0,
        top: 0,
        current: 0,
        number: 0,
    };

    /// Returns true if the ray goes toward larger coordinates along an axis.
    #[inline(always)]
    pub(super) fn goes_up(&self, axis: u8) -> bool {
        self.ray.up >> (axis & 3) & 1 == 1
    }

    /// The ray's intervals in boxes, whose planes `row` gives by their [`row_offset`]. The
    /// arithmetic is that of `RaySlabs::intersect_box_same_octant`, with the roles of the lanes
    /// exchanged.
    #[inline(always)]
    pub(super) fn intersect_box(&self, row: impl Fn(usize) -> Native) -> TInterval<Native> {
        let line = self.intersect_children(row);
        TInterval {
            tnear: line.tnear.max(Native::ZERO),
            ..line
        }
    }

    /// Distances at which the ray's line, which extends behind its origin, enters and leaves boxes;
    /// as [`RayState::intersect_box`].
    #[inline(always)]
    pub(super) fn intersect_children(&self, row: impl Fn(usize) -> Native) -> TInterval<Native> {
        let ray = &self.ray;
        let enter = |axis: usize| {
            (row(ray.near[axis] as usize) - Native::splat(ray.first[axis]))
                * Native::splat(ray.rdir[axis])
        };
        let leave = |axis: usize| {
            (row(ray.far[axis] as usize) - Native::splat(ray.last[axis]))
                * Native::splat(ray.rdir[axis])
        };
        TInterval {
            tnear: enter(0).max(enter(1)).max(enter(2)),
            tfar: leave(0).min(leave(1)).min(leave(2)),
        }
    }

    #[inline(always)]
    pub(super) fn triangles(&self, block: &TriangleBlock) -> Option<HitCandidate<Native>> {
        // Never larger than 2; the bound removes index checks.
        let [kx, ky, kz] = self.ray.axes.map(|axis| (axis as usize).min(2));
        let column = |corner: usize, axis: usize| Native::new(block.vertices[corner][axis]);
        let corner = |c: usize| {
            Vec3Native::new(
                column(c, kx) - Native::splat(self.ray.frame_org[0]),
                column(c, ky) - Native::splat(self.ray.frame_org[1]),
                column(c, kz) - Native::splat(self.ray.frame_org[2]),
            )
        };
        let corners = [corner(0), corner(1), corner(2)];
        let slopes = self.ray.slopes.map(Native::splat);
        let pairs = RayAndBlock {
            context: self,
            block,
        };
        triangle::intersect(corners, slopes, &pairs)
    }

    #[inline(always)]
    pub(super) fn spheres<const FAR: bool>(&self, block: &SphereBlock) -> Candidates<Native> {
        let column =
            |axis: usize| Native::splat(self.ray.org[axis]) - Native::new(block.center[axis]);
        let from_center = Vec3Native::new(column(0), column(1), column(2));
        let dir = Vec3Native::splat(self.ray.dir[0], self.ray.dir[1], self.ray.dir[2]);
        let roots = sphere::roots(from_center, dir, Native::new(block.radius))?;
        let row = |row: usize| Native::new(block.prim_aabb.as_flattened()[row / ROW]);
        let (valid, t) = sphere::root_ahead::<_, FAR>(roots, self.intersect_box(row));
        Some(HitCandidate::without_uv(valid, t))
    }

    /// Marks the ray as occluded: nothing is left to visit.
    pub(super) fn mark_occluded(&mut self) {
        self.best.prim_id = 0;
        self.top = self.bottom;
    }
}

/// A ray and the triangles of a block, one in each lane.
struct RayAndBlock<'a> {
    context: &'a RayState,
    block: &'a TriangleBlock,
}

impl Pairing<Native> for RayAndBlock<'_> {
    #[inline(always)]
    fn interval(&self) -> TInterval<Native> {
        let [a, b, c] = &self.block.vertices;
        let all = |corner: &[[f32; NATIVE]; 3]| {
            Vec3Native::new(
                Native::new(corner[0]),
                Native::new(corner[1]),
                Native::new(corner[2]),
            )
        };
        let [lo, hi] = triangle::prim_aabbs([all(a), all(b), all(c)]);
        let rows = [lo.x, lo.y, lo.z, hi.x, hi.y, hi.z];
        self.context.intersect_box(|row| rows[row / ROW % 6])
    }

    #[inline(always)]
    fn rays(&self) -> [Vec3Native; 2] {
        let ray = &self.context.ray;
        [ray.org, ray.dir].map(|[x, y, z]| Vec3Native::splat(x, y, z))
    }

    #[inline(always)]
    fn stored(&self) -> (&impl Vertices, Option<usize>) {
        (self.block, None)
    }

    /// Inline, because a call would save all registers.
    #[inline(always)]
    fn to_planes(&self, raw: Native, vague: NativeMask) -> Native {
        let ray = [self.context.ray.org, self.context.ray.dir].map(Vec3::from_array);
        triangle::to_own_planes(raw, vague, |_| ray, self.block)
    }
}

impl SingleHit {
    /// No hit yet; only hits nearer than `limit` will count.
    pub(super) const fn none_before(limit: f32) -> SingleHit {
        SingleHit {
            t: limit,
            v: 0.0,
            w: 0.0,
            det: 1.0,
            prim_id: NO_PRIM,
        }
    }

    /// Distance, barycentric weights and number, if the hit is nearer than `tmax`.
    #[inline(always)]
    pub(super) fn below(&self, tmax: f32) -> Option<([f32; 3], u32)> {
        (self.t < tmax).then_some((self.weights(), self.prim_id))
    }

    /// Distance and barycentric weights.
    #[inline(always)]
    pub(super) fn weights(&self) -> [f32; 3] {
        [self.t, self.v / self.det, self.w / self.det]
    }

    /// Distance up to which boxes are entered.
    #[inline(always)]
    pub(super) fn reach(&self) -> f32 {
        self.t * REACH
    }

    /// The hit in every lane, with `limit` as its distance.
    pub(super) fn spread(&self, limit: F32x8) -> HitRecord<F32x8> {
        HitRecord {
            t: limit,
            v: F32x8::splat(self.v),
            w: F32x8::splat(self.w),
            det: F32x8::splat(self.det),
            prim_id: U32x8::splat(self.prim_id),
        }
    }

    /// The hit in the first lane.
    pub(super) fn of(best: &HitRecord<F32x8>) -> SingleHit {
        SingleHit {
            t: best.t.lane(0),
            v: best.v.lane(0),
            w: best.w.lane(0),
            det: best.det.lane(0),
            prim_id: best.prim_id.lane(0),
        }
    }
}

/// Distance, barycentric weights and number of a hit, the last [`NO_PRIM`] for none. These sixteen
/// bytes are returned in two registers; an `Option` would be stored by floats and loaded by wider
/// words, which waits for the stores, fifteen cycles each time.
#[derive(Clone, Copy)]
pub(crate) struct OneHit {
    weights: [f32; 3],
    prim_id: u32,
}

impl OneHit {
    #[inline(always)]
    pub(super) fn below(tmax: f32, best: &SingleHit) -> OneHit {
        let (weights, prim_id) = best.below(tmax).unwrap_or(([0.0; 3], NO_PRIM));
        OneHit { weights, prim_id }
    }

    #[inline(always)]
    pub(crate) fn found(self) -> Option<([f32; 3], u32)> {
        (self.prim_id != NO_PRIM).then_some((self.weights, self.prim_id))
    }
}
