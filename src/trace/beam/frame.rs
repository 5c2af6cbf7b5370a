//! Boxes and triangles as they are seen along a beam: z, the depth along its dominant axis, and p and q, the places on the
//! other two axes, projected along the rays; there a ray is a point and a cell a rectangle.
//!
//! A place (x, y) beside the dominant axis, at depth z, is seen at p = (x − shear_p·z)/W, q = (y − shear_q·z)/W, where
//! W = w_0 + w_z·z. Two kinds of frame differ in nothing but these numbers:
//!
//! - **Near.** The apex is the centre: shear 0, W = z, and p and q are slopes. For an eye, and for lights among the things
//!   they shine on.
//! - **Far.** The centre is the origin of a shadow ray; with the light A away from it, p and q are where a ray's line passes
//!   the plane through the centre: shear A_p/A_z, W = 1 − z/A_z, near 1 everywhere. What a light far away hits is small
//!   against the way to it, and would drown in the rounding of coordinates that begin there. With W = 1 the rays are
//!   parallel.
//!
//! # What is left out cannot be hit
//!
//! A hit needs two things (see [`crate::trace`]): its ray passes the slab test of the primitive's own box, and with that of
//! every box around it; and a triangle's three edge functions, as computed, do not differ in sign. Everything here errs
//! to the other side. Let u = 2⁻²⁴, and O be the largest coordinate of any origin.
//!
//! **Lines.** Near: a ray passes the apex within ρ along any axis (0 for an eye), and so is within ρ of a line through it all
//! along. Far: a ray and the line from its origin to the light are, at a place within the scene, apart by ρ times the share of
//! the way to the light that this place is at most. Call either `blur`.
//!
//! **Boxes.** A ray that passes the slab test has a point within the box grown by its origin's padding, PAD·O, and by the
//! rounding of (plane − origin) · (1/d), 4u of their distance. Moved by `blur` it is on a line of the beam. `slack` covers
//! these and as much again; where distances are those from the centre, near, their share is in the rectangles instead, which
//! are made wider by more than 32u of what 1 is in p. Near, the point's depth may be next to nothing, but moving it to the
//! depth `tiny` along its line moves it by no more than 2·`tiny`, because cells lie within ±[`WIDEST`]; so boxes are grown by
//! that as well, and depths below `tiny` count as it. For a given z, p grows with x, and along an edge of constant x it
//! goes one way only; so a box is seen between the four values that its faces have at its two depths.
//!
//! **Triangles.** In a ray's own frame (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", 2013) corners are
//! moved by slopes of at most 1, each with an error of 7uR, R being the largest component of a corner relative to a ray's
//! origin. Since the ray passes the own box, whose size is H with all its padding, those corners are within 2H of it. So an
//! edge function comes out with an error below 4·2H·7uR + 24uH² ≤ 80uRH. Here it is ((b × (c − b))·(p, q, 1) of corners
//! (x − shear_p·z, y − shear_q·z, W), which is theirs times a number: near, at most 2, because a depth of one stands here
//! where a largest component of one stands there; far, at most W² < 2. The errors of edges (u of their length ≤ H), corners
//! (4uR) and sums here are below 112uRH, and `blur` changes it by less than 20 · blur · H. Together less than
//! 272uRH + 20 · blur · H, the `margin`. If three computed signs agree, all three functions here are ≥ −margin or all are
//! ≤ margin; a triangle is kept for a cell if either can be so anywhere in its rectangle.

use super::apex::{Apex, Spread};
use crate::lanes::{Lanes, Native, NativeMask, Vec3Lanes, Vec3Native};
use crate::packet::RayPacket;
use crate::scene::PAD;

/// Cells of near frames lie within ±this.
pub(super) const WIDEST: f32 = 2.0;

/// 2⁻²⁴: half a unit in the last place of one.
const ULP: f32 = 1.0 / 16_777_216.0;

/// A light is far if it is so many times as far as anything of the scene.
const FAR: f32 = 4.0;

/// Axes, centre and margins of a beam.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    /// The dominant axis, and the two others.
    pub(super) axes: [usize; 3],
    /// 1 if the beam goes up the dominant axis on its way from the apex, −1 if down.
    pub(super) sign: f32,
    pub(super) center: [f32; 3],
    /// Whether it is a near frame, and whether the rays end at its apex.
    pub(super) near: bool,
    pub(super) ahead: bool,
    shear: [f32; 2],
    /// W at depth 0, and how it grows.
    w: [f32; 2],
    /// By how much boxes are grown.
    slack: f32,
    /// The smallest depth.
    pub(super) tiny: f32,
    /// By how much rectangles are made wider: in p, and as a share of it.
    pub(super) wider: [f32; 2],
    /// What there is beyond corner minus centre in R, and beyond edges in H; and 20 · blur.
    more_reach: f32,
    more_size: f32,
    blur: f32,
}

/// The boxes of a node seen along a beam.
#[derive(Clone, Copy)]
pub(super) struct BoxView {
    pub(super) low_p: Native,
    pub(super) high_p: Native,
    pub(super) low_q: Native,
    pub(super) high_q: Native,
    /// Depth at which each begins.
    pub(super) near: Native,
    /// Which have anything ahead of the apex.
    pub(super) ahead: NativeMask,
}

/// The triangles of a block seen along a beam.
pub(super) struct TriangleView {
    /// The edge functions: constant, slope along p, slope along q.
    pub(super) edges: [[Native; 3]; 3],
    /// By how much an edge function may be wrong.
    pub(super) margin: Native,
    /// Their own boxes.
    pub(super) own: BoxView,
}

impl Frame {
    /// The frame of a beam that goes about `toward`, in a tree whose largest coordinate is `extent`.
    pub(super) fn new(apex: &Apex, toward: [f32; 3], extent: f32) -> Frame {
        match apex {
            Apex::Eye(place) => {
                let farthest = largest(*place);
                let slack = 2.0 * PAD * farthest;
                Frame::near(*place, toward, slack, [0.0; 2], extent)
            }
            Apex::Light { place, rays } => {
                let outward = toward.map(|d| -d);
                let scene = extent + largest(rays.center);
                if rays.shortest > FAR * scene {
                    let way = std::array::from_fn(|k| place[k] - rays.center[k]);
                    let blur = 2.0 * rays.blur * (scene + rays.around) / rays.shortest;
                    return Frame::far(rays, way, Some(largest(way)), blur, extent);
                }
                let slack = 2.0 * (PAD * rays.farthest + 8.0 * ULP * rays.longest);
                let slack = slack + 1.01 * rays.blur;
                let frame = Frame::near(*place, outward, slack, [rays.longest, rays.blur], extent);
                Frame {
                    ahead: true,
                    ..frame
                }
            }
            Apex::Sun { dir, rays } => Frame::far(rays, *dir, None, 0.0, extent),
        }
    }

    fn near(
        center: [f32; 3],
        toward: [f32; 3],
        slack: f32,
        [reach, blur]: [f32; 2],
        extent: f32,
    ) -> Frame {
        let axis = dominant(toward);
        let tiny = slack / 8.0 + f32::MIN_POSITIVE;
        Frame {
            axes: [axis, (axis + 1) % 3, (axis + 2) % 3],
            sign: 1f32.copysign(toward[axis]),
            center,
            near: true,
            ahead: false,
            shear: [0.0; 2],
            w: [0.0, 1.0],
            slack: slack + 2.0 * tiny,
            tiny,
            wider: [64.0 * ULP; 2],
            more_reach: reach + slack,
            more_size: 4.0 * (slack + PAD * extent),
            blur: 20.0 * blur,
        }
    }

    /// For rays that go to a light at `way` from the centre, `distance` away along the dominant axis or endlessly far.
    fn far(rays: &Spread, way: [f32; 3], distance: Option<f32>, blur: f32, extent: f32) -> Frame {
        let axis = dominant(way);
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        let sign = -1f32.copysign(way[axis]);
        let scene = extent + largest(rays.center);
        let slack = 2.0 * (PAD * rays.farthest + 16.0 * ULP * (scene + rays.around)) + 1.01 * blur;
        Frame {
            axes: [axis, p, q],
            sign,
            center: rays.center,
            near: false,
            ahead: true,
            // Along z, which goes away from the light.
            shear: [p, q].map(|k| way[k] / (sign * way[axis])),
            w: [1.0, distance.map_or(0.0, |distance| 1.0 / distance)],
            slack,
            tiny: f32::MIN,
            wider: [32.0 * ULP * rays.around + f32::MIN_POSITIVE, 32.0 * ULP],
            more_reach: rays.around + slack,
            more_size: 4.0 * (slack + PAD * extent),
            blur: 20.0 * blur,
        }
    }

    /// What a direction's part along the dominant axis is multiplied with to point away from the apex.
    #[inline(always)]
    pub(super) fn pace(&self) -> f32 {
        if self.ahead { -self.sign } else { self.sign }
    }

    /// Boxes by corner, by axis. Empty ones are not ahead.
    #[inline(always)]
    pub(super) fn boxes(&self, corners: &[[Native; 3]; 2]) -> BoxView {
        let [axis, p, q] = self.axes.map(|axis| axis % 3);
        let (first, last) = if self.sign > 0.0 { (0, 1) } else { (1, 0) };
        let along = Native::splat(self.sign);
        let at = self.sign * self.center[axis];
        let tiny = Native::splat(self.tiny);
        let near = corners[first][axis] * along - Native::splat(at + self.slack);
        let far = corners[last][axis] * along - Native::splat(at - self.slack);
        let near = near.max(tiny);
        let depth =
            |z: Native| Native::ONE / (Native::splat(self.w[0]) + Native::splat(self.w[1]) * z);
        let (by_near, by_far) = (depth(near), depth(far));
        let seen = |axis: usize, shear: f32| {
            let shear = Native::splat(shear);
            let (at_near, at_far) = (shear * near, shear * far);
            let side = |side: usize, slack: f32| {
                corners[side][axis] - Native::splat(self.center[axis] + slack)
            };
            let (low, high) = (side(0, self.slack), side(1, -self.slack));
            (
                ((low - at_near) * by_near).min((low - at_far) * by_far),
                ((high - at_near) * by_near).max((high - at_far) * by_far),
            )
        };
        let (low_p, high_p) = seen(p, self.shear[0]);
        let (low_q, high_q) = seen(q, self.shear[1]);
        BoxView {
            low_p,
            high_p,
            low_q,
            high_q,
            near,
            ahead: far.ge(tiny),
        }
    }

    /// Triangles by their corners relative to the centre, and their own boxes. Lanes of NaN are within no edge.
    #[inline(always)]
    pub(super) fn triangles(
        &self,
        corners: &[Vec3Native; 3],
        own: &[Vec3Native; 2],
    ) -> TriangleView {
        let [a, b, c] = *corners;
        let (ab, bc, ca) = (b - a, c - b, a - c);
        let reach = a.largest().max(b.largest()).max(c.largest());
        let size = ab.largest().max(bc.largest()).max(ca.largest());
        let reach = reach + Native::splat(self.more_reach);
        let size = size + Native::splat(self.more_size);
        let margin = (reach * Native::splat(272.0 * ULP) + Native::splat(self.blur)) * size;
        let (a, b, c) = (self.seen(a), self.seen(b), self.seen(c));
        let (ab, bc, ca) = (self.seen(ab), self.seen(bc), self.seen(ca));
        let (a, b, c) = (self.weighed(a), self.weighed(b), self.weighed(c));
        let weigh = |v: Vec3Native| Vec3Native::new(v.x, v.y, v.z * Native::splat(self.w[1]));
        let edge = |corner: Vec3Native, way: Vec3Native| {
            let f = corner.cross(weigh(way));
            [f.z, f.x, f.y]
        };
        TriangleView {
            edges: [edge(b, bc), edge(c, ca), edge(a, ab)],
            margin,
            own: self.boxes(&own.map(|v| [v.x, v.y, v.z])),
        }
    }

    /// A place relative to the centre, or a way: beside the axis, less the shear, and depth.
    #[inline(always)]
    fn seen<L: Lanes>(&self, v: Vec3Lanes<L>) -> Vec3Lanes<L> {
        let [axis, p, q] = v.from_axis(self.axes[0]);
        let z = axis * L::splat(self.sign);
        let [shear_p, shear_q] = self.shear.map(L::splat);
        Vec3Lanes::new(p - shear_p * z, q - shear_q * z, z)
    }

    /// With W instead of the depth.
    #[inline(always)]
    fn weighed<L: Lanes>(&self, v: Vec3Lanes<L>) -> Vec3Lanes<L> {
        let [zero, slope] = self.w.map(L::splat);
        Vec3Lanes::new(v.x, v.y, zero + slope * v.z)
    }

    /// Where the lines of rays to a far light are, and how deep they start.
    #[inline(always)]
    pub(super) fn starts<L: Lanes>(&self, rays: &RayPacket<L>) -> [L; 3] {
        let [x, y, z] = self.center;
        let at = self.seen(rays.org - Vec3Lanes::splat(x, y, z));
        let w = self.weighed(at).z;
        [at.z + L::splat(self.slack), at.x / w, at.y / w]
    }
}

fn largest(v: [f32; 3]) -> f32 {
    v.iter().fold(0.0, |most, x| x.abs().max(most))
}

fn dominant(v: [f32; 3]) -> usize {
    let size = v.map(f32::abs);
    match () {
        () if size[0] >= size[1] && size[0] >= size[2] => 0,
        () if size[1] >= size[2] => 1,
        () => 2,
    }
}
