//! How far the rays of a batch part: which class they are of, so that each class can find out what is best for it.
//!
//! Reflections off a floor go together, those off what stands on it do not; packets are twice as fast for the ones and half as
//! fast for the others, and where the turn is, the scene and the machine say. With one choice for all, either would be wrong
//! for many batches; with one for each class it is nearly always right (`perf/notes/coherence.md`).

use crate::lanes::{F32x8, LaneMask, Lanes, Vec3x8};
use crate::packet::RayQueue;
use std::ops::Range;

/// Squared cosines of 3, 12, 30 and 60 degrees.
const WITHIN: [f32; 4] = [0.997_26, 0.956_77, 0.75, 0.25];

/// Classes: most packets within the first angle, within the next, and so on; and beyond the last.
pub(super) const CLASSES: usize = WITHIN.len() + 1;

/// Classes from this one on, 30 degrees and more, are of rays that come together nowhere: of ambient occlusion, say, and not shadow
/// rays.
pub(super) const PARTED: usize = 3;

/// The class of some packets of a queue: by the largest angle between the first ray of a packet and any other, in at least half
/// of those that are looked at, one in `stride`.
pub(super) fn class(rays: &RayQueue, packets: Range<usize>, stride: usize) -> usize {
    let looked_at = packets.step_by(stride);
    let count = looked_at.len();
    let mut within = [0; WITHIN.len()];
    for packet in looked_at {
        let least = least_cosine(rays, packet);
        for (within, square) in within.iter_mut().zip(WITHIN) {
            *within += usize::from(least >= square);
        }
    }
    within.iter().filter(|&&within| 2 * within < count).count()
}

/// The least squared cosine between the first ray of a packet and any other; negative where rays go more than 90 degrees apart.
#[inline(always)]
fn least_cosine(rays: &RayQueue, packet: usize) -> f32 {
    let (rays, active) = rays.packet::<F32x8>(packet, 0.0);
    let dir = rays.dir;
    let first = Vec3x8::splat(dir.x.lane(0), dir.y.lane(0), dir.z.lane(0));
    let along = dir.dot(first);
    let square = along * along.abs() / (dir.dot(dir) * first.dot(first));
    active.select(square, F32x8::ONE).least()
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
        class(&rays, 0..64, 4)
    }

    #[test]
    fn classes_go_by_angle() {
        let found = [
            0.0, 2.9, 3.1, 11.9, 12.1, 29.9, 30.1, 59.9, 60.1, 89.0, 179.0,
        ]
        .map(class_at);
        assert_eq!(found, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]);
    }

    #[test]
    fn half_of_the_packets_say() {
        let arena = Bump::new();
        let mut rays = RayQueue::with_capacity(&arena, 512);
        for k in 0..512 {
            let apart = k < 256 && k % 8 == 3;
            let x = if apart { -1.0 } else { 1.0 };
            rays.push_ray([0.0; 3], [x, 0.0, 0.0]);
        }
        assert_eq!(class(&rays, 0..64, 4), 0);
        assert_eq!(class(&rays, 0..56, 4), 4);
        assert_eq!(class(&rays, 32..64, 4), 0);
    }
}
