//! Coherence of the rays of a batch: its class, so that each class of rays can be tuned separately.
//!
//! Reflections off a floor are coherent, those off the objects on it are not. Packets are twice as
//! fast for the former and half as fast for the latter, and the crossover depends on the scene and
//! the machine. A single choice would be wrong for many batches; one per class is nearly always
//! right (`perf/notes/coherence.md`).
//!
//! Shadow rays of one batch have nearly the same direction, but differ in their origins: on one
//! surface, where beams are faster, or on several surfaces one behind the other.

use crate::packet::RayQueue;
use crate::simd::{F32x8, LANES, LaneMask, Lanes, Vec3x8};
use std::ops::Range;

/// Squared cosines of 3, 12, 30 and 60 degrees.
const SQUARED_COSINES: [f32; 4] = [0.997_26, 0.956_77, 0.75, 0.25];

/// Number of classes: most packets within the first angle, within the next, and so on; and beyond
/// the last.
pub(super) const DIVERGENCE_CLASSES: usize = SQUARED_COSINES.len() + 1;

/// First class, 30 degrees and more, of rays without a common point: those of ambient occlusion,
/// for instance, but not shadow rays.
pub(super) const FIRST_DIVERGENT: usize = 3;

/// The class of the given packets of a queue. It depends on the largest angle between the first ray
/// of a packet and any other, in at least half of the sampled packets, one in `stride`.
pub(super) fn divergence_class(rays: &RayQueue, packets: Range<usize>, stride: usize) -> usize {
    let looked_at = packets.step_by(stride);
    let count = looked_at.len();
    let mut within = [0; SQUARED_COSINES.len()];
    for packet in looked_at {
        let least = least_cosine(rays, packet);
        for (within, square) in within.iter_mut().zip(SQUARED_COSINES) {
            *within += usize::from(least >= square);
        }
    }
    within.iter().filter(|&&within| 2 * within < count).count()
}

/// Returns true if the rays of the given packets seem to start at one point: those of the first
/// packet and the first ray of the last one do.
pub(super) fn start_in_one_point(rays: &RayQueue, packets: Range<usize>) -> bool {
    if packets.is_empty() || rays.len() <= (packets.end - 1) * LANES {
        return false;
    }
    let (first, active) = rays.packet::<F32x8>(packets.start, 0.0);
    let ([x, y, z], _) = rays.ray(packets.end - 1, 0);
    !(active & !first.org.bits_eq(Vec3x8::splat(x, y, z))).any()
}

/// Number of classes of shadow rays: see [`OriginSpread`].
pub(super) const SPREAD_CLASSES: usize = 2;

/// Ratio to the usual spread beyond which the origins of a batch are not on one surface.
const MAX_USUAL_RATIO: f32 = 1.5;

/// Minimum step of the usual spread. With the n-th batch it changes by two n-ths, up or down, but
/// at least by this. So about half of a picture's batches lie above it. With larger steps it would
/// follow the current part of the picture.
const STEP: f32 = 0.002;

/// Usual spread of the origins of a batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct OriginSpread {
    /// Spread along an axis, as a share of the distance to the light; 0 until measured.
    usual: f32,
    step: f32,
}

impl OriginSpread {
    pub(super) const UNKNOWN: OriginSpread = OriginSpread {
        usual: 0.0,
        step: 2.0,
    };

    /// The class of the given packets of a queue: 1 if their rays' origins are spread wider than
    /// usual, else 0. One packet in `stride` is sampled.
    pub(super) fn spread_class(
        &mut self,
        rays: &RayQueue,
        packets: Range<usize>,
        stride: usize,
    ) -> usize {
        let spread = spread(rays, packets.step_by(stride));
        if !(spread > 0.0 && spread < f32::INFINITY) {
            return 0;
        }
        if self.usual == 0.0 {
            self.usual = spread;
        }
        let class = usize::from(spread > MAX_USUAL_RATIO * self.usual);
        let factor = 1.0 + self.step;
        self.usual *= if spread > self.usual { factor } else { 1.0 / factor };
        // The step 2/n becomes 2/(n + 1).
        self.step = (self.step / (1.0 + 0.5 * self.step)).max(STEP);
        class
    }
}

/// Spread of the origins of the given packets, along the axis of largest spread, as a share of the
/// longest direction.
fn spread(rays: &RayQueue, packets: impl Iterator<Item = usize>) -> f32 {
    let far = F32x8::splat(f32::INFINITY);
    let (mut low, mut high, mut way) = ([far; 3], [-far; 3], F32x8::ZERO);
    for packet in packets {
        let (rays, active) = rays.packet::<F32x8>(packet, 0.0);
        for (axis, x) in [rays.org.x, rays.org.y, rays.org.z].into_iter().enumerate() {
            low[axis] = low[axis].min(active.select(x, low[axis]));
            high[axis] = high[axis].max(active.select(x, high[axis]));
        }
        way = way.max(active.select(rays.dir.max_abs(), way));
    }
    let along = |axis: usize| high[axis].max_element() - low[axis].min_element();
    along(0).max(along(1)).max(along(2)) / way.max_element()
}

/// The smallest squared cosine between the first ray of a packet and any other; negative if rays
/// are more than 90 degrees apart.
#[inline(always)]
fn least_cosine(rays: &RayQueue, packet: usize) -> f32 {
    let (rays, active) = rays.packet::<F32x8>(packet, 0.0);
    let dir = rays.dir;
    let first = Vec3x8::splat(dir.x.lane(0), dir.y.lane(0), dir.z.lane(0));
    let along = dir.dot(first);
    let square = along * along.abs() / (dir.dot(dir) * first.dot(first));
    active.select(square, F32x8::ONE).min_element()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bumpalo::Bump;

    /// The class of a packet in which every other ray is at this angle to the rest.
    fn class_at(degrees: f64) -> usize {
        let arena = Bump::new();
        let mut rays = RayQueue::with_capacity(&arena, 512);
        for k in 0..512 {
            let (y, x) = libm::sincos((degrees * (k % 2) as f64).to_radians());
            // Lengths do not matter.
            let [x, y] = [x, y].map(|part| part as f32 * (1 + k % 7) as f32);
            rays.push_ray([k as f32, 0.0, 0.0], [x, y, 0.0]);
        }
        divergence_class(&rays, 0..64, 4)
    }

    #[test]
    fn classes_go_by_angle() {
        let classes = [
            0.0, 2.9, 3.1, 11.9, 12.1, 29.9, 30.1, 59.9, 60.1, 89.0, 179.0,
        ]
        .map(class_at);
        assert_eq!(classes, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]);
    }

    /// Classes of batches that start on a square of the given side each.
    fn classes(starts: &mut OriginSpread, sides: &[f32]) -> Vec<usize> {
        let class = |&side: &f32| {
            let arena = Bump::new();
            let mut rays = RayQueue::with_capacity(&arena, 512);
            for k in 0..512 {
                let [x, y] = [k % 8, k / 64].map(|part| side * part as f32 / 7.0);
                rays.push_ray([x - 3.0, 5.0, y], [0.0, 1.0, 0.0]);
            }
            starts.spread_class(&rays, 0..64, 8)
        };
        sides.iter().map(class).collect()
    }

    #[test]
    fn what_starts_on_several_surfaces_is_a_class_of_its_own() {
        let mut starts = OriginSpread::UNKNOWN;
        // Points, NaN and infinity are not valid spreads.
        let none = [0.0, f32::NAN, f32::INFINITY];
        assert_eq!(classes(&mut starts, &none), [0; 3]);
        for _ in 0..200 {
            classes(&mut starts, &[1.0, 1.2, 0.8]);
        }
        assert_eq!(
            classes(&mut starts, &[1.4, 1.0, 1.8, 100.0, 0.1]),
            [0, 0, 1, 1, 0]
        );
        assert_eq!(classes(&mut starts, &none), [0; 3]);
        // A part of the picture does not change the usual spread, most of it does.
        assert_eq!(classes(&mut starts, &[2.0; 50]), [1; 50]);
        assert_eq!(classes(&mut starts, &[2.0; 500])[499], 0);
    }

    #[test]
    fn how_far_the_light_is_matters() {
        let mut starts = OriginSpread::UNKNOWN;
        classes(&mut starts, &[1.0; 50]);
        let arena = Bump::new();
        let mut rays = RayQueue::with_capacity(&arena, 512);
        for k in 0..512 {
            rays.push_ray([0.0, 0.0, (k % 8) as f32], [0.0, -20.0, 0.0]);
        }
        assert_eq!(starts.spread_class(&rays, 0..64, 8), 0);
        let mut rays = RayQueue::with_capacity(&arena, 512);
        for k in 0..512 {
            rays.push_ray([0.0, 0.0, (k % 8) as f32], [0.0, -2.0, 0.0]);
        }
        assert_eq!(starts.spread_class(&rays, 0..64, 8), 1);
    }

    #[test]
    fn half_of_the_packets_say() {
        let arena = Bump::new();
        let mut rays = RayQueue::with_capacity(&arena, 512);
        for k in 0..512 {
            let spread = k < 256 && k % 8 == 3;
            let x = if spread { -1.0 } else { 1.0 };
            rays.push_ray([0.0; 3], [x, 0.0, 0.0]);
        }
        assert_eq!(divergence_class(&rays, 0..64, 4), 0);
        assert_eq!(divergence_class(&rays, 0..56, 4), 4);
        assert_eq!(divergence_class(&rays, 32..64, 4), 0);
    }
}
