//! Tests of `clamp_not_needed` against the result of the clamp, and of the planes of lanes.

use super::*;
use crate::intersect::random::RandomSource;
use crate::intersect::shear::{MIXED, VertexColumns};
use crate::packet::RayPacket;
use crate::simd::{F32x8, LANES, Mask8, NATIVE, NativeMask, Vec3x8};

/// A pair as [`RaysAndSlot`], for which every distance is clamped.
struct Unsettled<'a>(RaysAndSlot<'a, F32x8>);

impl Pairing<F32x8> for Unsettled<'_> {
    fn interval(&self) -> TInterval<F32x8> {
        self.0.interval()
    }

    fn in_safe_range(&self) -> bool {
        false
    }

    fn rays(&self) -> [Vec3x8; 2] {
        self.0.rays()
    }

    fn stored(&self) -> (&impl Vertices, Option<usize>) {
        self.0.stored()
    }
}

impl RandomSource {
    /// A triangle, as wide as `size` or a needle.
    fn corners(&mut self, size: f32) -> [Vec3; 3] {
        let far = if self.unit() > 0.9 { 29.0 } else { 10.0 };
        let at = self.position() * self.scale(far);
        let [a, b] = [0, 1].map(|_| at + self.position() * size);
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
    let short = if from.unit() > 0.8 {
        from.scale(42.0)
    } else {
        1.0
    };
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
    let column = |of: &dyn Fn(&[Vec3; 2]) -> f32| F32x8::new(rays.each_ref().map(of));
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
    let at = from.position() * size;
    let along = (from.position() * size).with_z(0.0);
    let width = from.scale(20.0).min(1.0);
    let aside = (from.position() * (size * width)).with_z(0.0);
    let corners = [at, at + along, at + along * from.unit().abs() + aside];
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

#[test]
fn what_is_settled_need_not_be_clamped() {
    let mut from = RandomSource(1);
    let (mut hits, mut sures, mut clamped) = (0, 0, 0);
    for round in 0..400_000 {
        let size = from.scale(10.0);
        let corners = from.corners(size);
        let (corners, rays) = match round {
            0 => overflowing(),
            _ if round % 4 == 0 => needle_ahead(size, &mut from),
            _ => (corners, rays(corners, &mut from)),
        };
        let all = Mask8::splat(true);
        let prepared = RaySetup::new(&rays, all);
        let shear = &prepared.shear;
        let slot = LeafTriangle {
            vertices: corners.map(|corner| corner.to_array()),
            prim_id: 0,
        };
        let relative = slot.vertices.map(|c| shear.relative::<MIXED>(&c));
        let own = || RaysAndSlot {
            rays: &prepared,
            slot: &slot,
        };
        let slopes = shear.slopes();
        let Some(always) = intersect(relative, slopes, &Unsettled(own())) else {
            continue;
        };
        let found = intersect(relative, slopes, &own()).expect("within the edges");
        let same = always.t.bits_eq(found.t) | !always.valid;
        assert_eq!(found.valid.bits(), always.valid.bits(), "round {round}");
        assert!(!(!same).any(), "round {round}: {corners:?} {rays:?}");
        let seen = edges(&relative, slopes);
        let by_edges = EdgeDistance::new(&seen, relative.map(|corner| corner.z), slopes[2]);
        let (raw, sure) = (by_edges.t, by_edges.clamp_not_needed());
        let sure = sure & Mask8::splat(shear.in_safe_range);
        let ahead = seen.inside & raw.gt(F32x8::ZERO);
        hits += always.valid.bits().count_ones();
        sures += (always.valid & sure).bits().count_ones();
        clamped += (ahead & !(always.valid & raw.bits_eq(always.t)))
            .bits()
            .count_ones();
    }
    assert!(sures * 5 > hits, "{sures} of {hits} were settled");
    assert!(clamped > 1000, "only {clamped} were clamped or refused");
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
        let asked =
            NativeMask::from_bits(round.wrapping_mul(2_654_435_761) >> 7 & ((1 << NATIVE) - 1));
        let found = distance::to_own_planes(raw, asked, |_| [org, dir], &stored).to_array();
        let splat = |v: Vec3| Vec3Native::splat(v.x, v.y, v.z);
        for (lane, t) in found.into_iter().enumerate() {
            let rays = [splat(org), splat(dir)];
            let all = NativeMask::splat(true);
            let alone = distance::to_planes(raw, all, rays, &stored, Some(lane));
            let asked = asked.bits() >> lane & 1 == 1;
            let want = if asked { alone } else { raw }.to_array()[lane];
            assert_eq!(t.to_bits(), want.to_bits(), "round {round}, lane {lane}");
        }
    }
}
