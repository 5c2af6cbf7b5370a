//! The common point of a beam's rays: the eye from which they start, the light at which they end,
//! or none, because they are parallel.

use crate::packet::RayQueue;
use crate::simd::{F32x8, LANES, LaneMask, Lanes, Native, Vec3Native, Vec3x8};
use std::ops::Range;

/// Common property of the rays of a beam.
#[derive(Clone, Copy)]
pub(super) enum Apex {
    /// The origin of all rays.
    Eye([f32; 3]),
    /// A point at which all rays end.
    Light { position: [f32; 3], rays: Spread },
    /// The direction of all rays.
    Sun { dir: [f32; 3], rays: Spread },
}

/// Distances of rays that end at one point, or nearly so, from each other and from that point; all
/// are maxima over the axes.
#[derive(Clone, Copy)]
pub(super) struct Spread {
    /// The first origin.
    pub(super) center: [f32; 3],
    /// Largest distance of the other origins from it.
    pub(super) around: f32,
    /// The largest absolute coordinate of any origin.
    pub(super) farthest: f32,
    /// Largest and smallest distance from an origin to the apex.
    pub(super) longest: f32,
    pub(super) shortest: f32,
    /// Largest distance at which rays pass the apex.
    pub(super) blur: f32,
}

/// Largest distance by which rays may miss a point and still count as ending there, as a share of
/// the smallest distance to it: 2⁻¹⁰. Shadow rays start off the surface by a few units in the last
/// place, and miss their light by the same amount.
const BLUR: f32 = 1.0 / 1024.0;

impl Apex {
    /// The origin of the first ray, if all rays of its packet have the same bits. The other packets
    /// are checked when they are loaded.
    #[inline(always)]
    pub(super) fn behind(rays: &RayQueue, packets: &Range<usize>) -> Option<Apex> {
        if rays.len() <= packets.start * LANES {
            return None;
        }
        let (org, _) = rays.ray(packets.start, 0);
        let (rays, active) = rays.packet::<F32x8>(packets.start, 0.0);
        let apart = active & !rays.org.bits_eq(Vec3x8::splat(org[0], org[1], org[2]));
        (!apart.any()).then_some(Apex::Eye(org))
    }

    /// The common point of all rays at `tmax`, if any; or their direction, if it has the same bits.
    #[inline(never)]
    pub(super) fn ahead(rays: &RayQueue, packets: Range<usize>, tmax: f32) -> Option<Apex> {
        if rays.len() <= packets.start * LANES {
            return None;
        }
        let (org, dir) = rays.ray(packets.start, 0);
        let position: [f32; 3] = std::array::from_fn(|k| org[k] + dir[k] * tmax);
        let [center, apex, first] =
            [org, position, dir].map(|v| Vec3Native::splat(v[0], v[1], v[2]));
        let far = Native::splat(f32::INFINITY);
        let (mut blur, mut farthest, mut longest) = (Native::ZERO, Native::ZERO, Native::ZERO);
        let (mut around, mut shortest, mut parallel) = (Native::ZERO, far, true);
        for packet in packets.step_by(Native::PACKETS) {
            let (rays, active) = rays.packet::<Native>(packet, tmax);
            let most = |largest: Native, x: Native| largest.max(active.select(x, Native::ZERO));
            let way = rays.dir.scale(rays.tmax);
            let miss = (rays.org + way - apex).max_abs();
            // A ray with a NaN end reaches no point.
            blur = most(blur, miss.lt(far).select(miss, far));
            farthest = most(farthest, rays.org.max_abs());
            around = most(around, (rays.org - center).max_abs());
            longest = most(longest, way.max_abs());
            shortest = shortest.min(active.select(way.max_abs(), far));
            parallel &= !(active & !rays.dir.bits_eq(first)).any();
        }
        let rays = Spread {
            center: org,
            around: around.max_element(),
            farthest: farthest.max_element(),
            longest: longest.max_element(),
            shortest: shortest.min_element(),
            // Four roundings of sums and products of that magnitude.
            blur: blur.max_element()
                + (longest.max_element() + farthest.max_element()) * f32::EPSILON * 2.0,
        };
        // Infinite distances do not lead to a point.
        if rays.blur <= BLUR * rays.shortest && rays.shortest < f32::INFINITY {
            return Some(Apex::Light { position, rays });
        }
        parallel.then_some(Apex::Sun { dir, rays })
    }
}
