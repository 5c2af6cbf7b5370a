//! How far the rays of a batch part: which class they are of, so that each class can find out what
//! is best for it.
//!
//! Reflections off a floor go together, those off what stands on it do not; packets are twice as
//! fast for the ones and half as fast for the others, and where the turn is, the scene and the
//! machine say. With one choice for all, either would be wrong for many batches; with one for each
//! class it is nearly always right (`perf/notes/coherence.md`).
//!
//! Shadow rays of one batch go nearly the same way, all of them; what tells them apart is whether
//! they start on one surface, where beams are the faster, or on several one behind the other.

use crate::packet::RayQueue;
use crate::simd::{F32x8, LaneMask, Lanes, Vec3x8};
use std::ops::Range;

/// Squared cosines of 3, 12, 30 and 60 degrees.
const SQUARED_COSINES: [f32; 4] = [0.997_26, 0.956_77, 0.75, 0.25];

/// Classes: most packets within the first angle, within the next, and so on; and beyond the last.
pub(super) const DIVERGENCE_CLASSES: usize = SQUARED_COSINES.len() + 1;

/// Classes from this one on, 30 degrees and more, are of rays that come together nowhere: of
/// ambient occlusion, say, and not shadow rays.
pub(super) const FIRST_DIVERGENT: usize = 3;

/// The class of some packets of a queue: by the largest angle between the first ray of a packet and
/// any other, in at least half of those that are looked at, one in `stride`.
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

/// Classes of shadow rays: see [`OriginSpread`].
pub(super) const SPREAD_CLASSES: usize = 2;

/// Starts of a batch that lie so many times as far apart as is usual are not on one surface.
const MAX_USUAL_RATIO: f32 = 1.5;

/// What is usual changes with the n-th batch by two n-ths, up or down, and by no less than this:
/// about as many batches of a picture have more as have less. With larger steps it would follow the
/// part of the picture that is at hand.
const STEP: f32 = 0.002;

/// How far apart the starts of a batch usually are.
#[derive(Clone, Copy, Debug)]
pub(super) struct OriginSpread {
    /// Along an axis, as a share of the way to the light; 0 until there was one.
    usual: f32,
    step: f32,
}

impl OriginSpread {
    pub(super) const UNKNOWN: OriginSpread = OriginSpread {
        usual: 0.0,
        step: 2.0,
    };

    /// The class of some packets of a queue, 1 if their rays start farther apart than is usual and
    /// else 0; one packet in `stride` is looked at.
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
        self.usual *= if spread > self.usual {
            factor
        } else {
            1.0 / factor
        };
        // Of 2/n it makes 2/(n + 1).
        self.step = (self.step / (1.0 + 0.5 * self.step)).max(STEP);
        class
    }
}

/// How far apart the origins of some packets are, along the axis where that is most, as a share of
/// the longest direction.
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

/// The least squared cosine between the first ray of a packet and any other; negative where rays go
/// more than 90 degrees apart.
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

    /// Every other ray goes at this angle to the rest.
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
        let found = [
            0.0, 2.9, 3.1, 11.9, 12.1, 29.9, 30.1, 59.9, 60.1, 89.0, 179.0,
        ]
        .map(class_at);
        assert_eq!(found, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]);
    }

    /// Of batches that start on a square of this side each.
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
        // Points, and what is no number, are no measure.
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
        // A part of the picture does not change what is usual, most of it does.
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
