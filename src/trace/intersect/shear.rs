//! The frame in which a ray is the z axis, and triangles in it (Woop, Benthin and Wald, "Watertight
//! Ray/Triangle Intersection", JCGT 2013): see [`triangle`](super::triangle).

use crate::bvh::TriangleBlock;
use crate::bvh::leaf::LeafTriangle;
use crate::simd::{LaneMask, LaneU32, Lanes, NATIVE, Native, Vec3Lanes};

/// The frame in which the rays are the z axis: the dominant axis of the direction, and the slopes
/// against it.
#[derive(Clone, Copy)]
pub(crate) struct Shear<L: Lanes> {
    /// Lanes whose dominant axis is x, and lanes where it is y; elsewhere it is z.
    x_major: L::Mask,
    y_major: L::Mask,
    /// The dominant axis if all lanes share it, else [`MIXED`].
    pub(crate) axis: usize,
    /// Origin with its components in the order of the frame.
    org: Vec3Lanes<L>,
    /// Slopes d_kx · scale and d_ky · scale, and scale = 1/d_kz.
    slope_x: L,
    slope_y: L,
    scale: L,
    /// The larger slope; infinite for rays beyond [`SAFE_RANGE`].
    steepness: L,
}

/// The triangles of a block by vertex, by axis; the fourth axis makes an index check unnecessary.
pub(crate) type VertexColumns = [[Native; 4]; 3];

/// Access to the vertices of one or several triangles.
pub(crate) trait Vertices {
    /// A coordinate of a vertex of the triangle in a lane.
    fn coordinate(&self, corner: usize, axis: usize, lane: usize) -> f32;
}

impl Vertices for VertexColumns {
    #[inline(always)]
    fn coordinate(&self, corner: usize, axis: usize, lane: usize) -> f32 {
        self[corner][axis & 3].lane(lane % NATIVE)
    }
}

impl Vertices for TriangleBlock {
    #[inline(always)]
    fn coordinate(&self, corner: usize, axis: usize, lane: usize) -> f32 {
        self.vertices[corner][axis.min(2)][lane % NATIVE]
    }
}

impl Vertices for LeafTriangle {
    #[inline(always)]
    fn coordinate(&self, corner: usize, axis: usize, _: usize) -> f32 {
        self.vertices[corner][axis.min(2)]
    }
}

/// A triangle of a block in every lane, with its axes in this order.
#[inline(always)]
fn in_frame<L: Lanes>(
    block: &impl Vertices,
    lane: usize,
    [x, y, z]: [usize; 3],
) -> [Vec3Lanes<L>; 3] {
    let one = |corner: usize, axis: usize| L::splat(block.coordinate(corner, axis, lane));
    let corner = |k: usize| Vec3Lanes::new(one(k, x), one(k, y), one(k, z));
    [corner(0), corner(1), corner(2)]
}

/// Orders (kx, ky, kz) by dominant axis; x, y, z if the lanes' axes differ.
pub(crate) const FRAMES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

/// The axis of a direction's largest component.
#[inline(always)]
pub(crate) fn dominant_axis(dir: &[f32; 3]) -> usize {
    let [x, y, z] = dir.map(f32::abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Value of [`Shear::axis`] if the lanes' dominant axes differ.
pub(crate) const MIXED: usize = 3;

impl<L: Lanes> Shear<L> {
    #[inline(always)]
    pub(crate) fn new(org: Vec3Lanes<L>, dir: Vec3Lanes<L>, active: L::Mask) -> Shear<L> {
        let size = dir.abs();
        let x_major = size.x.ge(size.y) & size.x.ge(size.z);
        let y_major = !x_major & size.y.ge(size.z);
        let (x, y, live) = (x_major.bits(), y_major.bits(), active.bits());
        let axis = if x & live == live {
            0
        } else if y & live == live {
            1
        } else if (x | y) & live == 0 {
            2
        } else {
            MIXED
        };
        let frame = |v: Vec3Lanes<L>| match axis {
            0 => Vec3Lanes::new(v.y, v.z, v.x),
            1 => Vec3Lanes::new(v.z, v.x, v.y),
            2 => v,
            _ => permute(x_major, y_major, v),
        };
        let d = frame(dir);
        let scale = L::ONE / d.z;
        let (slope_x, slope_y) = (d.x * scale, d.y * scale);
        let steepness = slope_x.abs().max(slope_y.abs());
        Shear {
            x_major,
            y_major,
            axis,
            org: frame(org),
            slope_x,
            slope_y,
            scale,
            steepness: usual(org, d.z).select(steepness, L::splat(f32::INFINITY)),
        }
    }

    /// The axes in the order of the frame, and the origins in that order.
    #[inline(always)]
    pub(crate) fn columns(&self) -> ([L::U32; 3], Vec3Lanes<L>) {
        let [by_x, by_y, by_z] = [0, 1, 2].map(|major| FRAMES[major]);
        let axis = |k: usize| {
            let [x, y, z] = [by_x[k], by_y[k], by_z[k]].map(|axis| L::U32::splat(axis as u32));
            self.x_major.select_u32(x, self.y_major.select_u32(y, z))
        };
        ([axis(0), axis(1), axis(2)], self.org)
    }

    /// A triangle's vertices, with their components in the order of the frames. `APART` is true if
    /// the rays' dominant axes differ.
    #[inline(always)]
    pub(crate) fn in_order<const APART: bool>(
        &self,
        block: &impl Vertices,
        lane: usize,
    ) -> [Vec3Lanes<L>; 3] {
        if APART {
            in_frame(block, lane, [0, 1, 2]).map(|corner| self.turn(corner))
        } else {
            in_frame(block, lane, FRAMES[self.axis & 3])
        }
    }

    /// A triangle's vertices relative to the rays' origins, with their components in the order of
    /// the frames.
    #[inline(always)]
    pub(crate) fn less_origins<const APART: bool>(
        &self,
        block: &impl Vertices,
        lane: usize,
    ) -> [Vec3Lanes<L>; 3] {
        let [a, b, c] = self.in_order::<APART>(block, lane);
        [a - self.org, b - self.org, c - self.org]
    }

    #[inline(always)]
    fn turn(&self, v: Vec3Lanes<L>) -> Vec3Lanes<L> {
        permute(self.x_major, self.y_major, v)
    }

    /// Slopes, scale and steepness, for [`intersect`](super::triangle::intersect).
    #[inline(always)]
    pub(crate) fn slopes(&self) -> [L; 4] {
        [self.slope_x, self.slope_y, self.scale, self.steepness]
    }

    /// A vertex relative to the origin, with its components in the order of the frame whose z is
    /// `AXIS`.
    #[inline(always)]
    pub(crate) fn relative<const AXIS: usize>(&self, corner: &[f32; 3]) -> Vec3Lanes<L> {
        let wide = |k: usize| L::splat(corner[k]);
        let ordered = match AXIS {
            0 => Vec3Lanes::new(wide(1), wide(2), wide(0)),
            1 => Vec3Lanes::new(wide(2), wide(0), wide(1)),
            2 => Vec3Lanes::new(wide(0), wide(1), wide(2)),
            _ => permute(
                self.x_major,
                self.y_major,
                Vec3Lanes::new(wide(0), wide(1), wide(2)),
            ),
        };
        ordered - self.org
    }
}

/// Orders components (kx, ky, kz) = (y, z, x), (z, x, y) or (x, y, z) by dominant axis.
#[inline(always)]
fn permute<L: Lanes>(x_major: L::Mask, y_major: L::Mask, v: Vec3Lanes<L>) -> Vec3Lanes<L> {
    let pick = |by_x, by_y, by_z| x_major.select(by_x, y_major.select(by_y, by_z));
    Vec3Lanes::new(
        pick(v.y, v.z, v.x),
        pick(v.z, v.x, v.y),
        pick(v.x, v.y, v.z),
    )
}

/// Limit on the coordinates of an origin, on the largest component of a direction, and on its
/// reciprocal: 2⁴⁰. Beyond it, intermediate numbers of a distance may overflow or vanish, and the
/// reciprocals of the slab test are not those of the directions: no distance counts as accurate.
const SAFE_RANGE: f32 = (1u64 << 40) as f32;

#[inline(always)]
fn usual<L: Lanes>(org: Vec3Lanes<L>, along: L) -> L::Mask {
    let (most, least) = (L::splat(SAFE_RANGE), L::splat(1.0 / SAFE_RANGE));
    let size = along.abs();
    org.max_abs().le(most) & size.le(most) & size.ge(least)
}

/// [`usual`] of one ray, by the largest components of its origin and of its direction.
#[inline(always)]
pub(crate) fn is_usual(org: f32, along: f32) -> bool {
    org <= SAFE_RANGE && (1.0 / SAFE_RANGE..=SAFE_RANGE).contains(&along)
}
