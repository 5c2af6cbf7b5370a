//! Culling of pairs of a triangle and the shadow rays of a sub-beam, before the test that all
//! kernels share. It costs a fifth of that test, and most pairs go no further. A ray is culled if
//! it passes outside the triangle. It is also culled if it starts on the side of the triangle to
//! which it is heading, as for the surface that it leaves.
//!
//! # Why culled rays do not hit
//!
//! Symbols and bounds are those of [`super::projection`], and:
//!
//! | symbol | meaning |
//! |---|---|
//! | D | sum of the edge functions, linear in p and q |
//! | N | normal (b − a) × (c − a), turned toward the light |
//! | \|N\|₁ | sum of the magnitudes of N's components |
//! | o, d | a ray's origin, and its direction over its largest component |
//! | z | a computed hit's position along d |
//! | e | distance of P = o + z·d + e of the triangle from the ray at z |
//! | least | a bound below \|D\| in all of the rectangle around the beam's sub-beams |
//!
//! **Side.** If |D| > 3 · `margin` in all of the rectangle, with one sign, then three computed
//! signs that agree have that sign: else |D| ≤ 3 · `margin`. So only one side of each edge function
//! has to be tested. Triangles without such a sign, or with N·d ≤ 64u|N|₁, are not culled here.
//!
//! **Edges.** As in [`super::projection`], with p and q of a ray instead of a rectangle. Their
//! rounding is the growth of rectangles, times the slopes.
//!
//! **Plane.** The weights of the vertices, as computed, are of one sign, so they define a point P
//! of the triangle. N·(P − a) = 0, so N·(o − a) = −z N·d − N·e:
//!
//! | inequality | because |
//! |---|---|
//! | e ≤ 18uR + 12u(2H)³/\|det\| | vertices are within 2H of the ray, weights wrong by 4u(2H)² (1) |
//! | \|det\| ≥ D/2 | the frames' scales |
//! | z ≥ −10uR | the distance is computed as positive |
//! | R ≤ \|z\| + 2H + e | P is at z, within e, and vertices are within 2H of P |
//! | N·(o − a) ≤ \|N\|₁(62uH + 192uH³/D) | the three above; terms in z > 0 are below z N·d |
//! | N as computed: 24uH²R ≤ 48uH³ | 8uH² each (2) |
//! | N·o − N·a as computed: 10u\|N\|₁ · `scale` | three products and their sums, twice |
//!
//! (1) e is Σ w_i x_i / det beside rounding, where x_i is the position of a vertex beside the ray.
//! It would be 0 for weights w_i without error. (2) D > 3 · 448uRH, so terms in z > 0 are again
//! below z N·d.
//!
//! No ray with N·(o − a) above the sum of these has a hit. All bounds in the code except the last
//! are larger by a quarter or more, which covers their own rounding.

use super::projection::{BeamSpace, TriangleView, ULP};
use crate::simd::{LaneMask, Lanes, NATIVE, Native, NativeMask, Vec3Lanes, Vec3Native};

/// Culling data of the triangles of a block.
#[derive(Clone, Copy)]
pub(super) struct ShadowCull {
    /// Edge functions: slope along p, negated slope along q, constant; and their lower bound.
    edges: [[Native; 3]; 3],
    least: Native,
    /// Normal toward the light, its second component negated; and the bound that a start on that
    /// side exceeds.
    normal: [Native; 3],
    beyond: Native,
}

/// Projections of a packet's rays, and their origins.
pub(super) struct ProjectedRays<'a, L> {
    pub(super) p: L,
    pub(super) q: L,
    pub(super) org: &'a Vec3Lanes<L>,
}

impl ShadowCull {
    pub(super) const NONE: ShadowCull = ShadowCull {
        edges: [[Native::ZERO; 3]; 3],
        least: Native::ZERO,
        normal: [Native::ZERO; 3],
        beyond: Native::ZERO,
    };

    /// Prepares the triangles of a block with these vertices. `around` is the rectangle around the
    /// beam's sub-beams, in p and q.
    #[inline(always)]
    pub(super) fn new(
        space: &BeamSpace,
        around: &[[f32; 2]; 2],
        seen: &TriangleView,
        [a, b, c]: &[Vec3Native; 3],
    ) -> ShadowCull {
        let middle = around.map(|[low, high]| Native::splat(0.5 * (low + high)));
        let half = around.map(|[low, high]| Native::splat(0.501 * (high - low)));
        let widest = |[low, high]: [f32; 2]| low.abs().max(high.abs());
        let [wider, share] = space.rect_epsilon;
        let wider = Native::splat(wider + share * widest(around[0]).max(widest(around[1])));
        let sum = |k: usize| (seen.edges[0][k] + seen.edges[1][k]) + seen.edges[2][k];
        let (constant, slope_p, slope_q) = (sum(0), sum(1), sum(2));
        let facing = constant + (slope_p * middle[0] + slope_q * middle[1]);
        let steep = |[_, p, q]: [Native; 3]| p.abs() + q.abs();
        let steepest = seen.edges.map(steep);
        let steepest = steepest[0].max(steepest[1]).max(steepest[2]);
        let margin = seen.margin + steepest * wider;
        let spread = slope_p.abs() * half[0] + slope_q.abs() * half[1];
        let least = facing.abs() - (spread + margin * Native::splat(3.1));
        let normal = (*b - *a).cross(*c - *a);
        let backs = facing.lt(Native::ZERO);
        let turn = |x: Native| backs.select(-x, x);
        // D and N·(the way from the light) have one sign if the beam goes up its axis.
        let toward = Native::splat(space.depth_per_t());
        let normal = [normal.x, normal.y, normal.z].map(|n| turn(n * toward));
        let size = seen.size;
        let sized = (normal[0].abs() + normal[1].abs()) + normal[2].abs();
        let cube = size * size * size;
        let rounding = sized * (Native::splat(10.0 * space.scale) + size * Native::splat(80.0))
            + (sized * Native::splat(240.0) / least + Native::splat(64.0)) * cube;
        // The underflow below the smallest numbers, in scenes of 10⁻¹² and less, is less than the
        // smallest normal number.
        let more = rounding * Native::splat(ULP) + Native::splat(f32::MIN_POSITIVE);
        let beyond = (normal[0] * a.x + normal[1] * a.y) + normal[2] * a.z + more;
        // A NaN does not compare as larger, so such triangles are tested.
        let clear = least.gt(sized * Native::splat(256.0 * ULP));
        let always = Native::splat(f32::INFINITY);
        ShadowCull {
            edges: seen
                .edges
                .map(|[constant, p, q]| [turn(p), -turn(q), turn(constant)]),
            least: clear.select(-margin, -always),
            normal: [normal[0], -normal[1], normal[2]],
            beyond: clear.select(beyond, always),
        }
    }

    /// Triangles whose edges may contain a ray of a rectangle, given by its middle and its half
    /// width.
    #[inline(always)]
    pub(super) fn within(&self, [p, q]: [Native; 2], [half_p, half_q]: [Native; 2]) -> NativeMask {
        let most = |[slope_p, less_q, constant]: &[Native; 3]| {
            let middle =
                p.mul_sub_any_rounding(*slope_p, q.mul_sub_any_rounding(*less_q, *constant));
            middle + (slope_p.abs() * half_p + less_q.abs() * half_q)
        };
        let [u, v, w] = self.edges.each_ref().map(most);
        u.min(v).min(w).ge(self.least)
    }

    /// Rays of a packet that may hit the triangle in a lane.
    #[inline(always)]
    pub(super) fn may_hit<L: Lanes>(&self, lane: usize, rays: &ProjectedRays<L>) -> L::Mask {
        // Taken by reference: a lane of a copy would be read from a copy in memory.
        let one = |column: &Native| L::splat(column.lane(lane % NATIVE));
        let edge = |[slope_p, less_q, constant]: &[Native; 3]| {
            let rest = rays.q.mul_sub_any_rounding(one(less_q), one(constant));
            rays.p.mul_sub_any_rounding(one(slope_p), rest)
        };
        let (u, v, w) = (
            edge(&self.edges[0]),
            edge(&self.edges[1]),
            edge(&self.edges[2]),
        );
        let within = !u.min(v).min(w).lt(one(&self.least));
        let start = rays
            .org
            .x
            .mul_sub_any_rounding(one(&self.normal[0]), one(&self.beyond));
        let start = rays.org.y.mul_sub_any_rounding(one(&self.normal[1]), start);
        let start = rays.org.z.mul_sub_any_rounding(one(&self.normal[2]), start);
        within & !start.gt(L::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::TriangleBlock;
    use crate::bvh::leaf::LeafTriangle;
    use crate::full_or::full_or;
    use crate::intersect::random::RandomSource;
    use crate::intersect::ray_setup::RaySetup;
    use crate::intersect::shear::MIXED;
    use crate::intersect::triangle::TriangleAlong;
    use crate::packet::RayQueue;
    use crate::simd::{F32x8, LANES, Mask8};
    use crate::traverse::beam::apex::Apex;
    use crate::traverse::beam::block::vertices;
    use crate::traverse::beam::ray_extent::directions;
    use crate::traverse::beam::sub_beams::{Added, SubBeams};
    use crate::traverse::query::{AnyHit, Query};
    use bumpalo::Bump;
    use bytemuck::TransparentWrapper;
    use glam::Vec3;
    use phalanx_scene::OFFSET_PER_COORDINATE;

    const PACKETS: usize = 4;

    /// Triangles side by side; some are seen edge-on and some are thin.
    fn block(from: &mut RandomSource, middle: Vec3, size: f32) -> TriangleBlock {
        let triangles: [[Vec3; 3]; NATIVE] = std::array::from_fn(|_| {
            let thin = if from.unit() > 0.7 { 0.01 } else { 1.0 };
            let a = middle + from.position() * size;
            let (b, c) = (a + from.position() * size, a + from.position() * size);
            [a, b, b + (c - b) * thin]
        });
        let column = |corner: usize, axis: usize| triangles.map(|t| t[corner][axis]);
        let corners = std::array::from_fn(|k| std::array::from_fn(|axis| column(k, axis)));
        TriangleBlock {
            vertices: corners,
            prim_id: std::array::from_fn(|lane| lane as u32),
        }
    }

    fn slot(block: &TriangleBlock, lane: usize) -> LeafTriangle {
        LeafTriangle {
            vertices: block.vertices.map(|corner| corner.map(|axis| axis[lane])),
            prim_id: lane as u32,
        }
    }

    /// A position on a triangle or on the line of an edge, moved to either side by the offset of
    /// shadow rays or less; or anywhere.
    fn start(from: &mut RandomSource, block: &TriangleBlock, size: f32) -> Vec3 {
        let lane = (from.unit().abs() * NATIVE as f32) as usize % NATIVE;
        let [a, b, c] = slot(block, lane).vertices.map(Vec3::from_array);
        let (v, w) = match from.unit() {
            x if x > 0.5 => (from.unit() * 1.1, 0.0),
            _ => (from.unit().abs() * 0.5, from.unit().abs() * 0.5),
        };
        let normal = (b - a).cross(c - a).normalize_or_zero();
        // Some positions are as near to the plane as possible: their computed side is rounding.
        let side = match from.unit() {
            x if x > 0.5 => 0.01 * from.unit(),
            x if x > 0.0 => 1.0,
            _ => -1.0,
        };
        let off = OFFSET_PER_COORDINATE * a.abs().max_element() * side;
        let position = a + (b - a) * v + (c - a) * w + normal * off;
        match from.unit() {
            x if x > 0.8 => position + from.position() * size,
            _ => position,
        }
    }

    #[test]
    fn what_a_ray_hits_is_kept_and_most_of_the_rest_is_not() {
        let mut from = RandomSource(3);
        let (mut hits, mut local, mut unculled, mut seen, mut pairs) = (0, 0, 0, 0, 0);
        let rounds = full_or(30_000, 3000);
        for round in 0..rounds {
            let size = (from.unit() * 6.0 - 5.0).exp2();
            let middle = from.position() * if round % 5 == 0 { 20.0 } else { 1.0 };
            let block = block(&mut from, middle, size);
            let far = (from.unit() * 5.0).exp2();
            let light = middle + from.position() * far;
            let sun = round % 7 == 0;
            let (arena, tmax) = (Bump::new(), if sun { f32::INFINITY } else { 1.0 });
            let mut rays = RayQueue::with_capacity(&arena, PACKETS * LANES);
            for _ in 0..PACKETS * LANES {
                let org = start(&mut from, &block, size);
                let dir = if !sun {
                    light - org
                } else if round % 2 == 0 {
                    Vec3::Y
                } else {
                    light - middle
                };
                rays.push_ray(org.to_array(), dir.to_array());
            }
            let Some(apex) = Apex::ahead(&rays, 0..PACKETS, tmax) else {
                continue;
            };
            assert_eq!(sun, matches!(apex, Apex::Sun { .. }));
            let extent = middle.abs().max_element() + 3.0 * size;
            let Some(space) = BeamSpace::new(&apex, (middle - light).to_array(), extent) else {
                continue;
            };
            local += usize::from(!space.near);
            let packets: Vec<_> = (0..PACKETS)
                .map(|k| rays.packet::<F32x8>(k, tmax))
                .collect();
            let projected: Vec<_> = packets
                .iter()
                .map(|(rays, _)| directions(&space, rays))
                .collect();
            let mut sub_beams = Box::new(SubBeams::new());
            sub_beams.look_at(&space, &projected);
            let limit = F32x8::splat(tmax);
            let mut sub_beam = [None; PACKETS];
            let mut count = 0;
            for (k, projected) in projected.iter().enumerate() {
                // A packet that is not split is one sub-beam.
                let before = sub_beams.all().count_ones();
                let everyone = Mask8::splat(true);
                let added = sub_beams.add(space.near, *projected, limit, everyone, k) == Added::All;
                let after = sub_beams.all().count_ones();
                sub_beam[k] = (added && after == before + 1).then_some(before as usize);
                count += usize::from(added);
            }
            if count < PACKETS {
                continue;
            }
            sub_beams.finish(&space);
            let stored = vertices(&block);
            let view = space.triangles(&stored, &space.relative(&stored));
            let cull = ShadowCull::new(&space, sub_beams.around(), &view, &stored);
            for (k, (rays, _)) in packets.iter().enumerate() {
                let everyone = Mask8::splat(true);
                let prepared = RaySetup::new(rays, everyone);
                let candidates =
                    sub_beam[k].map(|sub_beam| sub_beams.may_hit(sub_beam, &cull, &view.own));
                for lane in 0..NATIVE {
                    let slot = [slot(&block, lane)];
                    let mut query = AnyHit::new(limit, everyone);
                    query.test_each(&prepared, TriangleAlong::<MIXED>::wrap_slice(&slot));
                    let hit = query.occluded();
                    let [_, p, q] = projected[k];
                    let may = cull.may_hit(
                        lane,
                        &ProjectedRays {
                            p,
                            q,
                            org: &rays.org,
                        },
                    );
                    assert_eq!(
                        (hit & !may).bits(),
                        0,
                        "round {round}, packet {k}, triangle {lane}"
                    );
                    if let Some(candidates) = candidates {
                        assert!(
                            !hit.any() || candidates >> lane & 1 == 1,
                            "round {round}, sub-beam {k}, triangle {lane}"
                        );
                        seen += usize::from(candidates >> lane & 1 == 1);
                    }
                    hits += hit.bits().count_ones();
                    unculled += may.bits().count_ones();
                    pairs += 8;
                }
            }
        }
        assert!(2 * local > rounds, "{local} local frames");
        assert!(3 * hits as usize > 10 * rounds, "{hits} hits");
        assert!(3 * seen > 10 * rounds, "{seen} triangles met by sub-beams");
        let needless = unculled - hits;
        assert!(
            20 * needless < pairs,
            "{needless} of {pairs} kept, {hits} hits"
        );
    }
}
