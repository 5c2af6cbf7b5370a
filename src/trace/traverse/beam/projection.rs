//! Projection of boxes and triangles along a beam. The coordinates are z, the depth along the
//! beam's dominant axis, and p and q, the positions on the other two axes, projected along the
//! rays. There a ray is a point and a sub-beam a rectangle.
//!
//! A point (x, y) beside the dominant axis, at depth z, has the projection
//!
//! ```text
//! p = (x − shear_p·z)/W,  q = (y − shear_q·z)/W,  W = w_0 + w_z·z
//! ```
//!
//! The two kinds of frame differ only in these numbers:
//!
//! - **Near.** The apex is the centre: shear 0, W = z, and p and q are slopes. It is for an eye,
//!   and for lights among the origins of the rays that go to them.
//! - **Local.** The centre is the origin of a shadow ray. The light is at A from it, and D is the
//!   distance to it along the dominant axis. Then p and q are where a ray's line passes the plane
//!   through the centre: shear A_p/A_z, W = 1 + z/D, which is 0 at the light. With W = 1 the rays
//!   are parallel. Shadow rays are tested mostly against objects near their origins. In coordinates
//!   that begin at the light, those would drown in rounding.
//!
//! # Why culled boxes and triangles are not hit
//!
//! A hit has two properties (see [`crate::intersect`]). Its ray passes the slab test of the
//! primitive's own box, and with that of every box around it. And a triangle's three edge
//! functions, as computed, do not differ in sign. All bounds err to the other side.
//!
//! | symbol | meaning |
//! |---|---|
//! | u | 2⁻²⁴ |
//! | O | largest coordinate of any origin |
//! | S | `scale`: largest coordinates of scene, centre and `around`, added up |
//! | a | `around`: distance of origins from the centre, along any axis |
//! | D | distance of the light from the centre along the dominant axis, or infinite |
//! | ρ | `blur`: distance at which rays pass the apex, along any axis; 0 for an eye |
//! | R | `reach`: largest component of vertex − centre, and of the rays' distance from it |
//! | H | `size`: longest edge along any axis, and four paddings |
//! | h | size of the own box with the paddings of box and origin: h ≤ H, h ≤ 2R |
//! | L | longest way from an origin to the apex |
//! | l | shortest way from an origin to the apex |
//! | ε | `box_epsilon`: growth of boxes |
//! | δ | `lateral_error`: distance of rays from their lines, by unit of depth |
//! | M | [`MIN_LIGHT_DISTANCE_RATIO`] |
//!
//! **Ratios.** A local frame needs depths from 4uS − D on, and boxes grown by more than 30uS. Both
//! are meaningless if S is as large as D/u: depths would begin behind the rays' origins, and hits
//! in between would be lost. So:
//!
//! | frame | condition |
//! |---|---|
//! | local | a ≤ D/4 and ε ≤ D/M |
//! | near, of a light | else, ε ≤ L/M |
//! | none | else; packets take the rays |
//!
//! In a local frame 4uS ≤ D/100, so depths begin before all origins; W of origins is within 1/4 of
//! 1; p, q ≤ 2/3·D; and slopes are < 5/3. A near frame has no term in S, so the ratio of scene and
//! way does not matter.
//!
//! **Lines.** Near: a ray passes the apex within ρ along any axis, and so is within ρ of a line
//! through it all along. Local: p and q of a ray are those of its origin. From there to the light
//! it leaves its line by ρ, so at depth z it is beside it by less than δ = 4ρ/D for each unit of z
//! and of a.
//!
//! **Boxes.** A ray that passes the slab test has a point within the box, but for:
//!
//! | source | near | local |
//! |---|---|---|
//! | padding of the origin | PAD·O | PAD·O |
//! | slab test, 4u of (plane − origin) | 8uL; 4u in p | 4uS |
//! | line | ρ | δ·(\|z\| + a) |
//! | planes less centre and slack | 4uO; 3u in p | 3uS |
//! | shear and its product | 0 | 4uS + 3uS |
//! | depth, times a slope | 2·`min_depth` | 3uS·5/3 + 8uS |
//! | W, wrong by 2u | 2u in p | 24u·a |
//! | covered by | ε, `rect_epsilon` = 64u | ε ≥ 1.02·PAD·O + (30S + 24a)u + 2δa |
//!
//! A ray may hit something before its light, and enter the box of that behind it. So boxes grow by
//! [`ENTRY_SLACK`] of L as well, more than the way between, unless the light is far outside of the
//! scene.
//!
//! Depths count from `min_depth` on, before the light: near, an eighth of ε without its
//! 2·`min_depth`; local, 4uS − D. Moving a point to that depth along its line moves it by no more
//! than 2·`min_depth`, because slopes are below 2. So boxes are grown by that as well, and smaller
//! depths count as `min_depth`. W is 3u at least there, because 4uS/D ≥ 3u wherever a box reaches
//! it. For a given z, p grows with x, and along an edge of constant x it goes one way only. So a
//! box projects to the range of the four values that its faces have at its two depths.
//!
//! **Triangles.** In a ray's own frame (Woop, Benthin and Wald, "Watertight Ray/Triangle
//! Intersection", 2013) vertices are moved by slopes of at most 1. Signs of differences of two
//! computed products are never wrong, at worst zero. Here an edge function is
//! (b × (c − b))·(p, q, 1) of the vertices (x − shear_p·z, y − shear_q·z, W). It is that of the
//! ray's own frame times the quotient k of the two dominant components of the direction.
//!
//! | error of an edge function | near, k ≤ 2 | local, k ≤ 5/3 |
//! |---|---|---|
//! | that of the ray's own frame (1) | 72uRH·k = 144uRH | 120uRH |
//! | vertex less centre and shear, times edges | 10uRH | 32uRH |
//! | W of vertices, 3u·W, times p, q ≤ 3.4R/W | 0 | 41uRH |
//! | edges, times the distance of line and vertex (2) | 72uRH | 114uRH |
//! | products and differences of the cross product | 20uRH | 120uRH |
//! | sum over p and q | 26uRH | (above) |
//! | line | 10ρH ≤ 20ρH | 12·5/3·RHρ/l ≤ 22·RHρ/l |
//! | **margin** | 288uRH + 20ρH | (448u + 22ρ/l)·RH |
//!
//! (1) 7uR a position, of 4·2h; 8uh² of two products. (2) Edges are differences of rounded
//! vertices.
//!
//! The near rows add up to 272uRH, the local ones to 427uRH; the rest covers the rounding of the
//! margin itself.
//!
//! If three computed signs agree, all three functions here are ≥ −margin or all are ≤ margin. A
//! triangle is kept for a sub-beam if either can be so anywhere in its rectangle.

use super::apex::{Apex, Spread};
use crate::intersect::aabb::ENTRY_SLACK;
use crate::intersect::shear::dominant_axis;
use crate::intersect::triangle::prim_aabbs;
use crate::packet::RayPacket;
use crate::simd::{Lanes, Native, NativeMask, Vec3Lanes, Vec3Native};
use phalanx_scene::PAD;

/// Limit on |p| and |q| of sub-beams in near frames, and on slopes in local ones.
pub(super) const MAX_RECT: f32 = 2.0;

/// 2⁻²⁴: half a unit in the last place of one.
pub(super) const ULP: f32 = 1.0 / 16_777_216.0;

/// Largest distance of origins from the first one in a local frame, as a share of the distance to
/// the light.
const MAX_LATERAL_RATIO: f32 = 0.25;

/// Smallest ratio of the distance to the light and the growth of boxes. Below it a frame culls too
/// little to be useful. A local frame is wrong if 4uS, some eighth of the growth, comes near 3/4 of
/// D.
const MIN_LIGHT_DISTANCE_RATIO: f32 = 16.0;

/// Margins of edge functions in units of uRH, near and local: see the table above.
const NEAR_MARGIN: f32 = 288.0;
const LOCAL_MARGIN: f32 = 448.0;

/// Axes, centre and error bounds of a beam's frame.
#[derive(Clone, Copy)]
pub(super) struct BeamSpace {
    /// The dominant axis, and the two others.
    pub(super) axes: [usize; 3],
    /// 1 if the beam goes up the dominant axis, away from the apex, −1 if down.
    pub(super) sign: f32,
    pub(super) center: [f32; 3],
    /// Sum of the largest coordinates of scene and origins.
    pub(super) scale: f32,
    /// Distance of the apex along the axis, in the units of p and q.
    pub(super) distance: f32,
    /// True for a near frame; and true if the rays end at its apex.
    pub(super) near: bool,
    pub(super) ahead: bool,
    shear: [f32; 2],
    /// Distance of rays from their lines, by unit of depth.
    lateral_error: f32,
    /// W at depth 0, and its growth by unit of depth.
    w: [f32; 2],
    /// Growth of boxes on each side.
    box_epsilon: f32,
    pub(super) min_depth: f32,
    /// Term that is added to depths at which rays start.
    start: f32,
    /// Growth of rectangles: in p, and as a share of it.
    pub(super) rect_epsilon: [f32; 2],
    /// Terms of R beyond vertex − centre, and of H beyond the edges.
    more_reach: f32,
    more_size: f32,
    /// Terms of the edge functions' error bound: margin = `edge_error[0]` · R · H + `edge_error[1]`
    /// · H (see the module).
    edge_error: [f32; 2],
}

/// The boxes of a node, projected along a beam.
#[derive(Clone, Copy)]
pub(super) struct BoxView {
    pub(super) low_p: Native,
    pub(super) high_p: Native,
    pub(super) low_q: Native,
    pub(super) high_q: Native,
    /// Depth at which each box begins.
    pub(super) near: Native,
    /// Boxes of which a part is ahead of the apex.
    pub(super) ahead: NativeMask,
}

/// The triangles of a block, projected along a beam.
pub(super) struct TriangleView {
    /// The edge functions: constant, slope along p, slope along q.
    pub(super) edges: [[Native; 3]; 3],
    /// Error bound of the edge functions.
    pub(super) margin: Native,
    /// H of the bounds above.
    pub(super) size: Native,
    /// The triangles' own boxes.
    pub(super) own: BoxView,
}

impl BeamSpace {
    /// The frame of a beam with the approximate direction `toward`, in a tree whose largest
    /// coordinate is `extent`; none if rounding leaves no useful one.
    pub(super) fn new(apex: &Apex, toward: [f32; 3], extent: f32) -> Option<BeamSpace> {
        match apex {
            Apex::Eye(position) => {
                let farthest = max_abs(*position);
                let slack = 2.0 * PAD * farthest;
                let scale = extent + farthest;
                let space = BeamSpace::near(*position, toward, slack, [0.0; 2], [extent, scale]);
                Some(space)
            }
            Apex::Light { position, rays } => {
                let way = std::array::from_fn(|k| position[k] - rays.center[k]);
                let distance = max_abs(way);
                let useful = |slack: f32, way: f32| slack * MIN_LIGHT_DISTANCE_RATIO <= way;
                // Nothing is close behind a light that is far outside of the scene.
                let behind = ENTRY_SLACK * rays.longest;
                let in_scene = max_abs(*position) <= extent + rays.blur + behind;
                let grown = |space: BeamSpace| BeamSpace {
                    box_epsilon: space.box_epsilon + if in_scene { behind } else { 0.0 },
                    ..space
                };
                if rays.around <= MAX_LATERAL_RATIO * distance {
                    let local = grown(BeamSpace::local(rays, way, Some(distance), extent));
                    if useful(local.box_epsilon, distance) {
                        return Some(local);
                    }
                }
                let outward = toward.map(|d| -d);
                let slack = 2.0 * (PAD * rays.farthest + 8.0 * ULP * rays.longest);
                let slack = slack + 1.01 * rays.blur;
                let (along, sizes) = ([rays.longest, rays.blur], [extent, extent + rays.farthest]);
                let space = grown(BeamSpace::near(*position, outward, slack, along, sizes));
                useful(space.box_epsilon, rays.longest).then_some(BeamSpace {
                    ahead: true,
                    ..space
                })
            }
            Apex::Sun { dir, rays } => Some(BeamSpace::local(rays, *dir, None, extent)),
        }
    }

    fn near(
        center: [f32; 3],
        toward: [f32; 3],
        slack: f32,
        [reach, blur]: [f32; 2],
        [extent, scale]: [f32; 2],
    ) -> BeamSpace {
        let axis = dominant_axis(&toward);
        let tiny = slack / 8.0 + f32::MIN_POSITIVE;
        BeamSpace {
            axes: [axis, (axis + 1) % 3, (axis + 2) % 3],
            sign: 1f32.copysign(toward[axis]),
            center,
            scale,
            distance: 1.0,
            near: true,
            ahead: false,
            shear: [0.0; 2],
            lateral_error: 0.0,
            w: [0.0, 1.0],
            box_epsilon: slack + 2.0 * tiny,
            min_depth: tiny,
            start: 0.0,
            rect_epsilon: [64.0 * ULP; 2],
            more_reach: reach + slack,
            more_size: 4.0 * (slack + PAD * extent),
            edge_error: [NEAR_MARGIN * ULP, 20.0 * blur],
        }
    }

    /// A local frame for rays to a light at `way` from the centre. The light is `distance` away
    /// along the dominant axis, or infinitely far.
    fn local(rays: &Spread, way: [f32; 3], distance: Option<f32>, extent: f32) -> BeamSpace {
        let axis = dominant_axis(&way);
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        let sign = -1f32.copysign(way[axis]);
        let scene = extent + max_abs(rays.center) + rays.around;
        let [aside, bent] = distance.map_or([0.0; 2], |distance| {
            [4.0 * rays.blur / distance, 22.0 * rays.blur / rays.shortest]
        });
        let slack = 1.02 * PAD * rays.farthest
            + (30.0 * scene + 24.0 * rays.around) * ULP
            + 2.0 * aside * rays.around;
        BeamSpace {
            axes: [axis, p, q],
            sign,
            center: rays.center,
            scale: extent + rays.farthest,
            distance: distance.unwrap_or(f32::INFINITY),
            near: false,
            ahead: true,
            // Shear along z, which goes away from the light.
            shear: [p, q].map(|k| way[k] / (sign * way[axis])),
            lateral_error: aside,
            w: [1.0, distance.map_or(0.0, |distance| 1.0 / distance)],
            box_epsilon: slack,
            start: 8.0 * ULP * rays.around + f32::MIN_POSITIVE,
            min_depth: distance.map_or(f32::MIN, |distance| 4.0 * ULP * scene - distance),
            rect_epsilon: [32.0 * ULP * rays.around + f32::MIN_POSITIVE, 32.0 * ULP],
            more_reach: rays.around + slack,
            more_size: 4.0 * (slack + PAD * extent),
            edge_error: [LOCAL_MARGIN * ULP + bent, 0.0],
        }
    }

    /// Sign that makes a direction's component along the dominant axis point away from the apex.
    #[inline(always)]
    pub(super) fn depth_per_t(&self) -> f32 {
        if self.ahead { -self.sign } else { self.sign }
    }

    /// Projects boxes, given by corner and axis. Empty boxes are not ahead.
    #[inline(always)]
    pub(super) fn boxes(&self, corners: &[[Native; 3]; 2]) -> BoxView {
        let [axis, p, q] = self.axes.map(|axis| axis % 3);
        let (first, last) = if self.sign > 0.0 { (0, 1) } else { (1, 0) };
        let along = Native::splat(self.sign);
        let depth = self.sign * self.center[axis];
        let tiny = Native::splat(self.min_depth);
        let near = corners[first][axis] * along - Native::splat(depth + self.box_epsilon);
        let far = corners[last][axis] * along - Native::splat(depth - self.box_epsilon);
        let near = near.max(tiny);
        let depth =
            |z: Native| Native::ONE / (Native::splat(self.w[0]) + Native::splat(self.w[1]) * z);
        let (by_near, by_far) = (depth(near), depth(far));
        let seen = |axis: usize, shear: f32| {
            let side = |side: usize, slack: f32| {
                corners[side][axis] - Native::splat(self.center[axis] + slack)
            };
            let (low, high) = (side(0, self.box_epsilon), side(1, -self.box_epsilon));
            let [to_low, to_high] =
                [-self.lateral_error, self.lateral_error].map(|x| Native::splat(shear + x));
            (
                ((low - to_low * near) * by_near).min((low - to_low * far) * by_far),
                ((high - to_high * near) * by_near).max((high - to_high * far) * by_far),
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

    /// Positions relative to the centre.
    #[inline(always)]
    pub(super) fn relative(&self, vertices: &[Vec3Native; 3]) -> [Vec3Native; 3] {
        let [x, y, z] = self.center;
        let center = Vec3Native::splat(x, y, z);
        let [a, b, c] = *vertices;
        [a - center, b - center, c - center]
    }

    /// Projects triangles, given by their vertices as they are and relative to the centre. Lanes of
    /// NaN are within no edge.
    #[inline(always)]
    pub(super) fn triangles(
        &self,
        vertices: &[Vec3Native; 3],
        relative: &[Vec3Native; 3],
    ) -> TriangleView {
        let [a, b, c] = *relative;
        let (ab, bc, ca) = (b - a, c - b, a - c);
        let reach = a.max_abs().max(b.max_abs()).max(c.max_abs());
        let size = ab.max_abs().max(bc.max_abs()).max(ca.max_abs());
        let reach = reach + Native::splat(self.more_reach);
        let size = size + Native::splat(self.more_size);
        let [by_reach, always] = self.edge_error.map(Native::splat);
        let margin = (reach * by_reach + always) * size;
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
            size,
            own: self.boxes(&prim_aabbs(*vertices).map(|v| [v.x, v.y, v.z])),
        }
    }

    /// A position relative to the centre, or a vector, in the coordinates of the frame: beside the
    /// axis, less the shear, and depth.
    #[inline(always)]
    fn seen<L: Lanes>(&self, v: Vec3Lanes<L>) -> Vec3Lanes<L> {
        let [axis, p, q] = v.from_axis(self.axes[0]);
        let z = axis * L::splat(self.sign);
        let [shear_p, shear_q] = self.shear.map(L::splat);
        Vec3Lanes::new(p - shear_p * z, q - shear_q * z, z)
    }

    /// Replaces the depth by W.
    #[inline(always)]
    fn weighed<L: Lanes>(&self, v: Vec3Lanes<L>) -> Vec3Lanes<L> {
        let [zero, slope] = self.w.map(L::splat);
        Vec3Lanes::new(v.x, v.y, zero + slope * v.z)
    }

    /// Projections of the lines of rays to a far light, and the depths at which they start.
    #[inline(always)]
    pub(super) fn starts<L: Lanes>(&self, rays: &RayPacket<L>) -> [L; 3] {
        let [x, y, z] = self.center;
        let position = self.seen(rays.org - Vec3Lanes::splat(x, y, z));
        let w = self.weighed(position).z;
        [
            position.z + L::splat(self.start),
            position.x / w,
            position.y / w,
        ]
    }
}

fn max_abs(v: [f32; 3]) -> f32 {
    v.iter().fold(0.0, |most, x| x.abs().max(most))
}
