//! Points of the unit square for the samples of a pixel: Sobol's first two dimensions, shuffled and
//! scrambled by Owen's method with a hash (Burley, "Practical Hash-based Owen Scrambling", JCGT
//! 2020; the hash is that of Vegdahl, "Building a Better LK Hash", 2021). A point is a function of
//! pixel, dimension and sample, so that the order of requests does not matter. The first 2^k points
//! of a pixel lie one in each rectangle of area 2^-k whose sides are powers of two.
//!
//! Beyond the camera, a ray's seed takes the place of the pixel. The camera ray's seed is that of
//! its pixel. The seed of a mirror or refracted ray is derived from its parent's. All samples of a
//! pixel that took the same path have the same seed. So each decision on each path is distributed
//! as evenly over the samples as those at the camera.
//!
//! The computation uses only integers, for any number of lanes at a time: one for the oracle, eight
//! for packets.

/// The decision of a ray for which a point is used. Points of different dimensions are independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Position of a camera ray in the pixel's filter.
    Pixel,
    /// Direction of a glossy mirror ray.
    Gloss,
    /// Position of a camera ray on the lens.
    Lens,
    /// Direction of an ambient occlusion ray.
    Sky,
    /// Position on the light of this number, at which a shadow ray ends.
    Light(u32),
}

impl Dimension {
    /// Index of the dimension. Lights come after all dimensions that exist once.
    fn index(self) -> u32 {
        match self {
            Dimension::Pixel => 0,
            Dimension::Gloss => 1,
            Dimension::Lens => 2,
            Dimension::Sky => 3,
            Dimension::Light(light) => light.wrapping_add(16),
        }
    }
}

/// Kind of ray that a surface sends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum BounceKind {
    /// A mirror ray.
    Mirror = 0xb529_7a4d,
    /// A refracted ray.
    Refracted = 0x68e3_1da4,
    /// A ray that continues through a partly transparent surface.
    Passed = 0x1b56_c4e9,
}

/// The seeds of the camera rays of some pixels, in columns `x` and rows `y`.
#[inline(always)]
pub fn seeds<const N: usize>(x: [u32; N], y: [u32; N]) -> [u32; N] {
    std::array::from_fn(|lane| mix(mix(x[lane]).wrapping_add(y[lane])))
}

/// The seeds of the rays that surfaces send on, where rays of these seeds hit them.
#[inline(always)]
pub fn child_seed<const N: usize>(seeds: [u32; N], way: BounceKind) -> [u32; N] {
    seeds.map(|seed| mix(seed ^ way as u32))
}

/// The points of N rays for one sample: both coordinates in \[0, 1), multiples of 2^-24.
#[inline(always)]
pub fn points<const N: usize>(seeds: [u32; N], sample: u32, dimension: Dimension) -> [[f32; N]; 2] {
    points_of(seeds, [sample; N], dimension)
}

/// The points of N rays, with a sample number for each.
#[inline(always)]
pub fn points_of<const N: usize>(
    seeds: [u32; N],
    samples: [u32; N],
    purpose: Dimension,
) -> [[f32; N]; 2] {
    let mut all = [[0.0; N]; 2];
    for lane in 0..N {
        let [u, v] = bits(seeds[lane], samples[lane], purpose);
        // The upper 24 bits, which an f32 holds exactly.
        (all[0][lane], all[1][lane]) = (unit_float(u), unit_float(v));
    }
    all
}

#[inline(always)]
fn unit_float(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[inline(always)]
fn bits(seed: u32, sample: u32, dimension: Dimension) -> [u32; 2] {
    let seed = mix(seed.wrapping_add(dimension.index()));
    // Shuffled within blocks of powers of two, so that a prefix of the samples is again a block of
    // the sequence.
    let index = scrambled(sample.reverse_bits(), mix(seed ^ 0x9e37_79b9)).reverse_bits();
    [
        scrambled(index, seed).reverse_bits(),
        scrambled(pascal(index), mix(seed ^ 0x85eb_ca6b)).reverse_bits(),
    ]
}

/// Sobol's second dimension of an index, its first bit lowest: Pascal's triangle modulo 2 times the
/// index.
#[inline(always)]
fn pascal(mut v: u32) -> u32 {
    v ^= v >> 1 & 0x5555_5555;
    v ^= v >> 2 & 0x3333_3333;
    v ^= v >> 4 & 0x0f0f_0f0f;
    v ^= v >> 8 & 0x00ff_00ff;
    v ^ (v >> 16 & 0x0000_ffff)
}

/// Owen's scrambling of digits that come lowest first: each is flipped or not, depending on those
/// below it.
#[inline(always)]
fn scrambled(mut v: u32, seed: u32) -> u32 {
    v ^= v.wrapping_mul(0x3d20_adea);
    v = v.wrapping_add(seed);
    v = v.wrapping_mul(seed >> 16 | 1);
    v ^= v.wrapping_mul(0x0552_6c56);
    v ^ v.wrapping_mul(0x53a2_2864)
}

/// A number in which each bit depends on all bits of `v` (Wellons, "lowbias32", 2018).
#[inline(always)]
fn mix(mut v: u32) -> u32 {
    v ^= v >> 16;
    v = v.wrapping_mul(0x7feb_352d);
    v ^= v >> 15;
    v = v.wrapping_mul(0x846c_a68b);
    v ^ v >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: u32, y: u32, sample: u32) -> [u32; 2] {
        let [seed] = seeds([x], [y]);
        bits(seed, sample, Dimension::Pixel)
    }

    /// Compares with the direction numbers of Joe and Kuo, 2008.
    #[test]
    fn the_second_dimension_is_sobols() {
        let mut direction = [0u32; 32];
        let odd = [1u32, 3, 5, 15, 17, 51, 85, 255];
        for k in 0..32 {
            direction[k] = match odd.get(k) {
                Some(m) => m << (31 - k),
                // The recurrence of the polynomial x + 1.
                None => direction[k - 1] ^ direction[k - 1] >> 1,
            };
        }
        let mut index = 1u32;
        for _ in 0..10_000 {
            index = mix(index);
            let direction_bits = |bit: usize| {
                if index >> bit & 1 == 1 { direction[bit] } else { 0 }
            };
            let want = (0..32).map(direction_bits).fold(0, |sum, d| sum ^ d);
            assert_eq!(pascal(index).reverse_bits(), want, "{index:#x}");
        }
    }

    #[test]
    fn every_rectangle_has_its_point() {
        for (x, y) in [(0, 0), (7, 3), (65_535, 40_000)] {
            for power in [0, 1, 4, 6, 10] {
                let count = 1u32 << power;
                // Rectangles that are divided by `wide` bits across and by the other bits down.
                for wide in 0..=power {
                    let mut seen = vec![0u8; count as usize];
                    for sample in 0..count {
                        let [u, v] = point(x, y, sample).map(u64::from);
                        let (column, row) = (u >> (32 - wide), v >> (32 - (power - wide)));
                        seen[(row << wide | column) as usize] += 1;
                    }
                    assert!(seen.iter().all(|&n| n == 1), "{x},{y}: 2^{power}, {wide}");
                }
            }
        }
    }

    /// Checks that a sum of cosines over pixels and samples is as small as for independent numbers.
    #[test]
    fn neighbours_and_coordinates_know_nothing_of_each_other() {
        let side = 128u32;
        let phase = |bits: u32| f64::from(bits) / 4_294_967_296.0;
        let (mut along, mut across) = (0.0, 0.0);
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let [u, v] = point(x, y, 0).map(phase);
            let [right, _] = point(x + 1, y, 0).map(phase);
            along += libm::cos(std::f64::consts::TAU * (u - right));
            across += libm::cos(std::f64::consts::TAU * (u - v));
        }
        // The deviation of either sum is √(n/2); five of them is one in a million.
        let most = 5.0 * libm::sqrt(f64::from(side * side) / 2.0);
        assert!(
            along.abs() < most && across.abs() < most,
            "{along} {across}"
        );
    }

    /// Checks the same for the decisions of one ray, and of the rays that follow from it.
    #[test]
    fn decisions_and_ways_know_nothing_of_each_other() {
        let side = 128u32;
        let phase = |seed: u32, dimension| f64::from(bits(seed, 0, dimension)[0]) / 4_294_967_296.0;
        let mut sums = [0.0; 8];
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let here = seeds([x], [y]);
            let [[seed], [mirror], [refracted], [twice]] = [
                here,
                child_seed(here, BounceKind::Mirror),
                child_seed(here, BounceKind::Refracted),
                child_seed(child_seed(here, BounceKind::Mirror), BounceKind::Mirror),
            ];
            let own = phase(seed, Dimension::Light(0));
            let others = [
                phase(seed, Dimension::Pixel),
                phase(seed, Dimension::Gloss),
                phase(seed, Dimension::Lens),
                phase(seed, Dimension::Sky),
                phase(seed, Dimension::Light(1)),
                phase(mirror, Dimension::Light(0)),
                phase(refracted, Dimension::Light(0)),
                phase(twice, Dimension::Light(0)),
            ];
            for (sum, other) in sums.iter_mut().zip(others) {
                *sum += libm::cos(std::f64::consts::TAU * (own - other));
            }
        }
        let most = 5.0 * libm::sqrt(f64::from(side * side) / 2.0);
        assert!(sums.iter().all(|sum| sum.abs() < most), "{sums:?}");
    }

    #[test]
    fn eight_at_a_time_are_those_one_by_one() {
        let (x, y) = ([3, 4, 5, 6, 3, 4, 5, 6], [9, 9, 9, 9, 10, 10, 10, 10]);
        for sample in 0..100 {
            let [us, vs] = points(seeds(x, y), sample, Dimension::Pixel);
            for lane in 0..8 {
                let [[u], [v]] = points(seeds([x[lane]], [y[lane]]), sample, Dimension::Pixel);
                assert_eq!((us[lane], vs[lane]), (u, v));
                assert!((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v));
            }
        }
    }

    /// Pins the contract "same bytes on every build".
    #[test]
    fn points_are_pinned() {
        assert_eq!(point(0, 0, 0), [856_270_757, 3_408_659_583]);
        let mut all = 0u32;
        for sample in 0..1000 {
            let [u, v] = point(sample * 31, sample * 17, sample * sample);
            all = mix(mix(all ^ u) ^ v);
        }
        assert_eq!(all, 0xf072_9559, "{all:#x}");
    }
}
