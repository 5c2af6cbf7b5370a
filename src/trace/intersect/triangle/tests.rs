//! Tests of hits against the boxes of their triangles, and of the planes of lanes.

use super::*;
use crate::full_or::full_or;
use crate::intersect::aabb::ENTRY_SLACK;
use crate::intersect::random::RandomSource;
use crate::intersect::shear::{MIXED, VertexColumns};
use crate::packet::RayPacket;
use crate::simd::{F32x8, LANES, Mask8, NATIVE, NativeMask, Vec3x8};

impl RandomSource {
    /// A triangle, as wide as `size` or a needle.
    fn corners(&mut self, size: f32) -> [Vec3; 3] {
        let far = if self.unit() > 0.9 { 29.0 } else { 10.0 };
        let position = self.position() * self.scale(far);
        let [a, b] = [0, 1].map(|_| position + self.position() * size);
        let along = a + (b - a) * self.unit();
        let aside = self.position() * size;
        let narrow = (self.unit() > 0.0).then(|| self.scale(12.0).min(1.0));
        [a, b, along + aside * narrow.unwrap_or(1.0)]
    }
}

/// Rays at the triangle, at its edges and vertices, along it, and past it on the line of an edge.
fn rays([a, b, c]: [Vec3; 3], from: &mut RandomSource) -> RayPacket {
    let org = a + from.position() * from.scale(8.0);
    // A tiny length, now and then: if that overflows, the distance is clamped all the same.
    let short = if from.unit() > 0.8 { from.scale(42.0) } else { 1.0 };
    let rays: [[Vec3; 2]; LANES] = std::array::from_fn(|lane| {
        let (s, t) = (from.unit().abs(), from.unit().abs());
        let on = match lane % 4 {
            0 => a + (b - a) * (s * 0.5) + (c - a) * (t * 0.5),
            1 => a + (b - a) * (s * 2.0 - 0.5),
            2 => c,
            _ => b + (c - b) * s,
        };
        let [org, dir] = match lane {
            0..4 => [org, on - org],
            4 => [on + (b - a) * 3.0, a - b],
            5 => [on + (c - b) * (from.unit() * 9.0), b - c],
            _ => [on + (c - a) + (b - a) * (t * 5.0), a - b + (a - c) * s],
        };
        [org, dir * short]
    });
    packet(&rays)
}

/// Rays without a limit, given by origin and direction.
fn packet(rays: &[[Vec3; 2]; LANES]) -> RayPacket {
    let column = |component: &dyn Fn(&[Vec3; 2]) -> f32| F32x8::new(rays.each_ref().map(component));
    RayPacket {
        org: Vec3x8::new(
            column(&|r| r[0].x),
            column(&|r| r[0].y),
            column(&|r| r[0].z),
        ),
        dir: Vec3x8::new(
            column(&|r| r[1].x),
            column(&|r| r[1].y),
            column(&|r| r[1].z),
        ),
        tmax: F32x8::splat(f32::INFINITY),
    }
}

/// A triangle so far and a direction so short that the product before the division overflows.
fn overflowing() -> ([Vec3; 3], RayPacket) {
    let a = 28.99f32.exp2();
    let column = F32x8::splat;
    let rays = RayPacket {
        org: Vec3x8::new(F32x8::ZERO, F32x8::ZERO, column(-0.5 * a)),
        dir: Vec3x8::new(F32x8::ZERO, F32x8::ZERO, column((-39f32).exp2())),
        tmax: column(f32::INFINITY),
    };
    let corners = [
        Vec3::new(-a, -a, a),
        Vec3::new(a, -a, a),
        Vec3::new(0.0, a, a),
    ];
    (corners, rays)
}

/// A needle across the z axis, and rays along it at the needle's edges, from so close that most of
/// it is next to them.
fn needle_ahead(size: f32, from: &mut RandomSource) -> ([Vec3; 3], RayPacket) {
    let position = from.position() * size;
    let along = (from.position() * size).with_z(0.0);
    let width = from.scale(20.0).min(1.0);
    let aside = (from.position() * (size * width)).with_z(0.0);
    let corners = [
        position,
        position + along,
        position + along * from.unit().abs() + aside,
    ];
    let [a, b, c] = corners;
    let height = size * from.scale(20.0).min(1.0);
    let rays: [[Vec3; 2]; LANES] = std::array::from_fn(|lane| {
        let t = from.unit().abs();
        let [start, end] = [[a, b], [b, c], [c, a]][lane % 3];
        let dir = (from.position() * 0.1).with_z(1.0) * height;
        [start + (end - start) * t - dir, dir]
    });
    (corners, packet(&rays))
}

/// A triangle of a few units in the last place, and rays that pass it at many times its size: the
/// signs of its edge functions are those of rounding.
fn speck_beside(from: &mut RandomSource) -> ([Vec3; 3], RayPacket) {
    let position = from.position().with_z(1.0);
    let size = (-23f32).exp2() * from.scale(4.0).max(1.0);
    let corners = [0; 3].map(|_| position + from.position() * size);
    let org = (from.position() * 0.5).with_z(-from.scale(8.0));
    let rays = [0; LANES].map(|_| [org, (from.position() * 0.01).with_z(1.0)]);
    (corners, packet(&rays))
}

/// A triangle, and rays that graze it at its vertices.
fn grazed(size: f32, from: &mut RandomSource) -> ([Vec3; 3], RayPacket) {
    let corners = from.corners(size);
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize_or(Vec3::X) * size;
    let rays: [[Vec3; 2]; LANES] = std::array::from_fn(|lane| {
        let along = (b - a) * from.unit() + (c - a) * from.unit();
        let dir = along + normal * (from.scale(12.0) * (-12f32).exp2());
        [corners[lane % 3] - dir * from.scale(2.0), dir]
    });
    (corners, packet(&rays))
}

/// Checks that rays enter the own box of what they hit no later than the hit, and leave it no
/// earlier, but for [`ENTRY_SLACK`].
#[test]
fn hits_are_in_the_box_of_their_triangle() {
    let mut from = RandomSource(1);
    let (mut free, mut clamped) = (0, 0);
    let rounds = full_or(400_000, 40_000);
    for round in 0..rounds {
        let size = from.scale(10.0);
        let corners = from.corners(size);
        let (corners, rays) = match (round, round % 4) {
            (0, _) => overflowing(),
            (_, 0) => needle_ahead(size, &mut from),
            (_, 1) => speck_beside(&mut from),
            (_, 2) => grazed(size, &mut from),
            _ => (corners, rays(corners, &mut from)),
        };
        let prepared = RaySetup::new(&rays, Mask8::splat(true));
        let shear = &prepared.shear;
        let slot = LeafTriangle {
            vertices: corners.map(|corner| corner.to_array()),
            prim_id: 0,
        };
        let relative = slot.vertices.map(|c| shear.relative::<MIXED>(&c));
        let own = RaysAndSlot {
            rays: &prepared,
            slot: &slot,
        };
        let slopes = shear.slopes();
        let Some(hit) = intersect(relative, slopes, &own) else {
            continue;
        };
        let seen = edges(&relative, slopes);
        let by_edges = EdgeDistance::new(&seen, relative.map(|corner| corner.z), slopes);
        let sure = by_edges.accurate | by_edges.in_box();
        let TInterval { tnear, tfar } = own.interval();
        for lane in hit.valid.lanes() {
            let [t, enter, leave] = [hit.t, tnear, tfar].map(|x| x.lane(lane));
            let off = (enter - t).max(t - leave).max(0.0) / t;
            let slack = match sure.bits() >> lane & 1 {
                1 => ENTRY_SLACK,
                _ => 0.0,
            };
            free += usize::from(slack > 0.0);
            clamped += usize::from(slack == 0.0);
            assert!(
                off <= slack && enter <= leave,
                "{t} in {enter} to {leave}, round {round}: {corners:?} {rays:?} {lane}"
            );
        }
    }
    let least = free.min(clamped);
    assert!(4 * least > 3 * rounds, "{free}, {clamped}");
}

/// Checks the distances to planes of triangles in lanes against those of one triangle for all.
#[test]
fn planes_of_lanes_are_those_of_their_triangles() {
    let mut from = RandomSource(9);
    for round in 0..2_000_u32 {
        let corners: [[Vec3; 3]; NATIVE] = std::array::from_fn(|_| {
            let size = from.scale(10.0);
            from.corners(size)
        });
        let column = |k: usize, axis: usize| {
            Native::new(corners.each_ref().map(|corner| corner[k][axis.min(2)]))
        };
        let stored: VertexColumns =
            std::array::from_fn(|k| std::array::from_fn(|axis| column(k, axis)));
        let org = from.position() * from.scale(8.0);
        let dir = from.position();
        let raw = Native::new(std::array::from_fn(|_| from.unit()));
        let vague =
            NativeMask::from_bits(round.wrapping_mul(2_654_435_761) >> 7 & ((1 << NATIVE) - 1));
        let distances = distance::to_own_planes(raw, vague, |_| [org, dir], &stored).to_array();
        let splat = |v: Vec3| Vec3Native::splat(v.x, v.y, v.z);
        for (lane, t) in distances.into_iter().enumerate() {
            let rays = [splat(org), splat(dir)];
            let all = NativeMask::splat(true);
            let alone = distance::to_planes(raw, all, rays, &stored, Some(lane));
            let vague = vague.bits() >> lane & 1 == 1;
            let want = if vague { alone } else { raw }.to_array()[lane];
            assert_eq!(t.to_bits(), want.to_bits(), "round {round}, lane {lane}");
        }
    }
}
