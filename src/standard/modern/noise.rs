//! Random numbers and roughness from integers: hashes, and value noise made of them.
//!
//! Only integer arithmetic and + − × ÷ √ of f64, so that every platform draws the same scene.

use glam::{DVec2, DVec3, dvec2, dvec3};

/// 64 well-mixed bits of a number: the finalizer of SplitMix64 (Steele, Lea and Flood, "Fast
/// Splittable Pseudorandom Number Generators", OOPSLA 2014).
pub(super) fn mix(number: u64) -> u64 {
    let mut bits = number.wrapping_add(0x9E37_79B9_7F4A_7C15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}

/// A number in [0, 1) of 53 bits.
fn unit(bits: u64) -> f64 {
    const STEP: f64 = 1.0 / (1u64 << 53) as f64;
    (bits >> 11) as f64 * STEP
}

/// A sequence of pseudorandom numbers. Equal seeds give equal sequences.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dice(u64);

impl Dice {
    /// The sequence of the `index`-th object of a kind; the kind has a seed of its own.
    pub(super) fn of(seed: u64, index: u64) -> Dice {
        Dice(mix(seed ^ mix(index)))
    }

    /// The next 64 bits.
    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(1);
        mix(self.0)
    }

    /// Passes over the next numbers.
    pub(super) fn skip(&mut self, numbers: u64) {
        self.0 = self.0.wrapping_add(numbers);
    }

    /// The next number in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        unit(self.bits())
    }

    /// The next number in [from, to).
    pub(super) fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// The next three numbers in [from, to), as a vector.
    pub(super) fn vector(&mut self, from: f64, to: f64) -> DVec3 {
        let mut number = || self.range(from, to);
        dvec3(number(), number(), number())
    }

    /// The next integer below `count`, which is at least 1.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }
}

/// A smooth step from 0 at `from` to 1 at `to`.
pub(super) fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Linear interpolation, from `a` at 0 to `b` at 1.
#[inline(always)]
pub(super) fn blend(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// The lattice cell of a coordinate and the position in it.
#[inline(always)]
fn cell(x: f64) -> (i64, f64) {
    // Only arithmetic that any CPU does for several points at once; right at any position in a
    // scene. A number of this size has no binary places left.
    const SHIFT: f64 = 3.0 * (1u64 << 51) as f64;
    let nearest = (x + SHIFT) - SHIFT;
    let floor = if nearest > x { nearest - 1.0 } else { nearest };
    let shifted = (floor + SHIFT).to_bits().wrapping_sub(SHIFT.to_bits());
    (shifted as i64, x - floor)
}

/// Odd multipliers that keep the axes of a lattice apart.
const STRIDES: [u64; 4] = [
    0x9E37_79B9_7F4A_7C15,
    0xC2B2_AE3D_27D4_EB4F,
    0x1656_67B1_9E37_79F9,
    0xD6E8_FEB8_6659_FD93,
];

/// The parts of a coordinate and of its successor in the hash of a lattice point; `axis` chooses
/// the multiplier.
#[inline(always)]
fn parts(axis: usize, coordinate: i64) -> [u64; 2] {
    let part = (coordinate as u64).wrapping_mul(STRIDES[axis]);
    [part, part.wrapping_add(STRIDES[axis])]
}

/// Value at the lattice point of these parts, in [-1, 1). Less thorough than [`mix`], because most
/// of a scene's time is spent here.
#[inline(always)]
fn lattice(parts: u64) -> f64 {
    let mut bits = (parts ^ (parts >> 32)).wrapping_mul(STRIDES[1]);
    bits ^= bits >> 29;
    // The upper half of the product as a signed fraction.
    const HALF: f64 = 1.0 / (1u64 << 31) as f64;
    f64::from((bits.wrapping_mul(STRIDES[0]) >> 32) as u32 as i32) * HALF
}

/// A step from 0 at 0 to 1 at 1, quintic so that the second derivative has no jumps, which would
/// show as a lattice in the shading.
#[inline(always)]
fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Points in the plane. Loops over all of them compile to vector instructions, as each step is the
/// same for all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Points<const N: usize> {
    pub(super) x: [f64; N],
    pub(super) y: [f64; N],
}

impl<const N: usize> Points<N> {
    /// The images of all points.
    #[inline(always)]
    pub(super) fn map(&self, image: impl Fn(DVec2) -> DVec2) -> Points<N> {
        let mut points = *self;
        for (x, y) in points.x.iter_mut().zip(&mut points.y) {
            let p = image(dvec2(*x, *y));
            (*x, *y) = (p.x, p.y);
        }
        points
    }
}

/// Value noise in the plane, in [-1, 1), and its gradient.
#[inline(always)]
pub(super) fn noise2(seed: u64, p: DVec2) -> (f64, DVec2) {
    let ((xi, x), (yi, y)) = (cell(p.x), cell(p.y));
    let slope = |t: f64| 30.0 * t * t * (t - 1.0) * (t - 1.0);
    let (hx, hy) = (parts(0, xi), parts(1, yi));
    let seed = seed.wrapping_mul(STRIDES[3]);
    let corner = |dx: usize, dy: usize| lattice(hx[dx] ^ hy[dy] ^ seed);
    let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1));
    let (u, v) = (fade(x), fade(y));
    let (ab, ac, twist) = (b - a, c - a, a - b - c + d);
    let value = a + ab * u + ac * v + twist * u * v;
    let gradient = dvec2((ab + twist * v) * slope(x), (ac + twist * u) * slope(y));
    (value, gradient)
}

/// Value noise in space, in [-1, 1).
#[inline(always)]
pub(super) fn noise3(seed: u64, p: DVec3) -> f64 {
    let ((xi, x), (yi, y), (zi, z)) = (cell(p.x), cell(p.y), cell(p.z));
    let (u, v, w) = (fade(x), fade(y), fade(z));
    let (hx, hy, hz) = (parts(0, xi), parts(1, yi), parts(2, zi));
    let seed = seed.wrapping_mul(STRIDES[3]);
    let edge = |dy: usize, dz: usize| {
        let corner = |dx: usize| lattice(hx[dx] ^ hy[dy] ^ hz[dz] ^ seed);
        blend(corner(0), corner(1), u)
    };
    let face = |dz: usize| blend(edge(0, dz), edge(1, dz), v);
    blend(face(0), face(1), w)
}

/// Turns by the angle of the 3-4-5 triangle, so that the lattices of successive octaves never line
/// up.
#[inline(always)]
pub(super) fn turned(p: DVec2) -> DVec2 {
    dvec2(0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y)
}

/// Octaves of noise in the plane, each of half the size and half the height; about [-1, 1].
pub(super) fn fractal2(seed: u64, p: DVec2, octaves: u32) -> f64 {
    let [value] = fractal2_of(seed, Points { x: [p.x], y: [p.y] }, octaves);
    value
}

/// [`fractal2`] at several points.
#[inline]
pub(super) fn fractal2_of<const N: usize>(
    seed: u64,
    mut points: Points<N>,
    octaves: u32,
) -> [f64; N] {
    let (mut sums, mut height) = ([0.0; N], 0.5);
    for octave in 0..octaves {
        let seed = seed + u64::from(octave);
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += height * noise2(seed, dvec2(points.x[k], points.y[k])).0;
        }
        points = points.map(|p| turned(p) * 2.03);
        height *= 0.5;
    }
    sums
}

/// Octaves of noise in space, each of half the size and half the height; about [-1, 1]. At several
/// points.
pub(super) fn fractal3<const N: usize>(seed: u64, points: [DVec3; N], octaves: u32) -> [f64; N] {
    let (mut sums, mut height) = ([0.0; N], 0.5);
    let (mut x, mut y, mut z) = ([0.0; N], [0.0; N], [0.0; N]);
    for (k, p) in points.iter().enumerate() {
        (x[k], y[k], z[k]) = (p.x, p.y, p.z);
    }
    for octave in 0..octaves {
        let seed = seed + u64::from(octave);
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += height * noise3(seed, dvec3(x[k], y[k], z[k]));
        }
        for k in 0..N {
            let t = turned(dvec2(x[k], y[k]));
            (x[k], y[k], z[k]) = (t.y * 2.03, z[k] * 2.03, t.x * 2.03);
        }
        height *= 0.5;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_within_its_range_and_its_gradient_is_its_slope() {
        let mut dice = Dice::of(1, 1);
        for _ in 0..1000 {
            let p = dvec2(dice.range(-50.0, 50.0), dice.range(-50.0, 50.0));
            let (value, gradient) = noise2(7, p);
            assert!((-1.0..1.0).contains(&value), "{value}");
            let h = 1e-6;
            let x = (noise2(7, p + DVec2::X * h).0 - value) / h;
            let y = (noise2(7, p + DVec2::Y * h).0 - value) / h;
            assert!((gradient - dvec2(x, y)).length() < 1e-3, "{p}");
        }
    }

    #[test]
    fn noise_has_no_steps_between_its_cells() {
        let mut dice = Dice::of(2, 1);
        for _ in 0..1000 {
            let p = dvec3(
                dice.range(-9.0, 9.0).floor(),
                dice.range(-9.0, 9.0),
                dice.range(-9.0, 9.0),
            );
            let step = noise3(3, p + DVec3::X * 1e-9) - noise3(3, p - DVec3::X * 1e-9);
            assert!(step.abs() < 1e-7, "{p}");
        }
    }

    #[test]
    fn dice_are_even_and_repeatable() {
        let mut dice = Dice::of(3, 4);
        let mut counts = [0; 10];
        for _ in 0..10_000 {
            counts[dice.below(10)] += 1;
        }
        assert!(counts.iter().all(|n| (850..1150).contains(n)), "{counts:?}");
        let (mut a, mut b) = (Dice::of(5, 6), Dice::of(5, 6));
        assert!((0..100).all(|_| a.bits() == b.bits()));
        assert_ne!(Dice::of(5, 7).bits(), Dice::of(5, 6).bits());
    }
}
