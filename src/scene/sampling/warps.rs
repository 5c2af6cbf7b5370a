//! Maps from points of the unit square to sampled shapes. They preserve areas, so uniform points
//! stay uniform, and neighbours stay neighbours (Shirley and Chiu, "A Low Distortion Map Between
//! Disk and Square", 1997).
//!
//! Sine and cosine are polynomials of this crate, because the library's last bits differ between
//! systems.

use super::pow::pow;
use std::f32::consts::FRAC_PI_4;

/// A point of the unit disc: distance from the centre, and direction as a unit vector.
#[derive(Clone, Copy, Debug)]
struct DiskPoint {
    radius: f32,
    x: f32,
    y: f32,
}

/// Taylor's coefficients of sin a = a (1 + c0 a² + c1 a⁴ + …) for |a| ≤ π/4; the first omitted term
/// is below 2e-9.
const SIN: [f32; 4] = [-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5_040.0, 1.0 / 362_880.0];

/// Taylor's coefficients of cos a = 1 + c0 a² + c1 a⁴ + … for |a| ≤ π/4; the first omitted term is
/// below 2e-10.
const COS: [f32; 5] = [
    -0.5,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
];

/// Maps squares about the centre to circles. The larger coordinate is the radius. The other one's
/// share of it becomes the share of an eighth of the circle.
#[inline(always)]
fn polar(u: f32, v: f32) -> DiskPoint {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let flat = a.abs() > b.abs();
    let (main, other) = if flat { (a, b) } else { (b, a) };
    let share = if main == 0.0 { 0.0 } else { other / main };
    let angle = FRAC_PI_4 * share;
    let square = angle * angle;
    let [s0, s1, s2, s3] = SIN;
    let sin = angle * (1.0 + square * (s0 + square * (s1 + square * (s2 + square * s3))));
    let [c0, c1, c2, c3, c4] = COS;
    let cos = 1.0 + square * (c0 + square * (c1 + square * (c2 + square * (c3 + square * c4))));
    let side = if main < 0.0 { -1.0 } else { 1.0 };
    let (x, y) = if flat { (cos, sin) } else { (sin, cos) };
    DiskPoint {
        radius: main.abs(),
        x: side * x,
        y: side * y,
    }
}

/// Maps each of the N points through `map`.
#[inline(always)]
fn each<const N: usize, const M: usize>(
    [u, v]: [[f32; N]; 2],
    map: impl Fn(DiskPoint) -> [f32; M],
) -> [[f32; N]; M] {
    let mut all = [[0.0; N]; M];
    for lane in 0..N {
        for (column, value) in all.iter_mut().zip(map(polar(u[lane], v[lane]))) {
            column[lane] = value;
        }
    }
    all
}

/// Maps points to the unit disc.
#[inline(always)]
pub fn concentric_disk<const N: usize>(points: [[f32; N]; 2]) -> [[f32; N]; 2] {
    each(points, |DiskPoint { radius, x, y }| {
        [radius * x, radius * y]
    })
}

/// Maps points to the unit sphere's surface.
#[inline(always)]
pub fn uniform_sphere<const N: usize>(points: [[f32; N]; 2]) -> [[f32; N]; 3] {
    // The disc around a pole becomes a cap of the same share of the area (Archimedes): z = 1 - 2
    // r².
    each(points, |DiskPoint { radius, x, y }| {
        let square = radius * radius;
        let away = 2.0 * radius * (1.0 - square).sqrt();
        [away * x, away * y, 1.0 - 2.0 * square]
    })
}

/// Maps points to unit vectors about z whose density is proportional to the cosine of their angle
/// to z: those above each point of the disc (Malley's method).
#[inline(always)]
pub fn cosine_hemisphere<const N: usize>(points: [[f32; N]; 2]) -> [[f32; N]; 3] {
    each(points, |DiskPoint { radius, x, y }| {
        [radius * x, radius * y, (1.0 - radius * radius).sqrt()]
    })
}

/// Maps points to unit vectors about z whose density is proportional to cosⁿ of their angle to z
/// (Phong's lobe), for an exponent n of 0 to about 10⁶. Beyond that, the cosine's last bits begin
/// to matter.
#[inline(always)]
pub fn phong_lobe<const N: usize>(points: [[f32; N]; 2], exponent: f32) -> [[f32; N]; 3] {
    // A share 1 - cosⁿ⁺¹ of the lobe lies within an angle, and a share r² of the disc within a
    // radius.
    let root = 1.0 / (exponent + 1.0);
    each(points, |DiskPoint { radius, x, y }| {
        let cos = pow(1.0 - radius * radius, root);
        let away = (1.0 - cos * cos).sqrt();
        [away * x, away * y, cos]
    })
}

/// Rotates vectors about z to vectors about the unit vectors `axis` (Duff et al., "Building an
/// Orthonormal Basis, Revisited", JCGT 2017).
#[inline(always)]
pub fn to_frame<const N: usize>(local: [[f32; N]; 3], axis: [[f32; N]; 3]) -> [[f32; N]; 3] {
    let mut all = [[0.0; N]; 3];
    for lane in 0..N {
        let [p, q, r] = local.map(|column| column[lane]);
        let [x, y, z] = axis.map(|column| column[lane]);
        let sign = if z < 0.0 { -1.0 } else { 1.0 };
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        let first = [1.0 + sign * (x * x * a), sign * b, -sign * x];
        let second = [b, sign + y * y * a, -y];
        for (k, column) in all.iter_mut().enumerate() {
            column[lane] = (first[k] * p + second[k] * q) + axis[k][lane] * r;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a regular grid, at the centres of its squares.
    fn grid(side: u32) -> impl Iterator<Item = [[f32; 1]; 2]> {
        let center = move |k: u32| [(k as f32 + 0.5) / side as f32];
        (0..side * side).map(move |k| [center(k % side), center(k / side)])
    }

    #[test]
    fn ways_are_those_of_sine_and_cosine() {
        for point in grid(256) {
            let [[u], [v]] = point;
            let DiskPoint { radius, x, y } = polar(u, v);
            let (a, b) = (2.0 * f64::from(u) - 1.0, 2.0 * f64::from(v) - 1.0);
            let quarter = std::f64::consts::FRAC_PI_4;
            let angle = if a.abs() > b.abs() {
                quarter * (b / a)
            } else {
                2.0 * quarter - quarter * (a / b)
            };
            let side = if a.abs() > b.abs() { a } else { b }.signum();
            let want = [side * libm::cos(angle), side * libm::sin(angle)];
            // Some five roundings of numbers of size 1.
            let most = 3.0 * f64::from(f32::EPSILON);
            assert!(
                (f64::from(x) - want[0]).abs() < most,
                "{u} {v}: {x} {want:?}"
            );
            assert!(
                (f64::from(y) - want[1]).abs() < most,
                "{u} {v}: {y} {want:?}"
            );
            assert!((f64::from(radius) - a.abs().max(b.abs())).abs() < most);
        }
    }

    #[test]
    fn the_middle_and_the_rim_are_numbers() {
        for (u, v) in [(0.5, 0.5), (0.0, 0.0), (0.0, 0.5), (0.5, 0.0)] {
            let DiskPoint { radius, x, y } = polar(u, v);
            assert!((x * x + y * y - 1.0).abs() < 1e-6, "{u} {v}");
            assert!(radius == 0.0 || radius == 1.0);
            for [[x], [y], [z]] in [
                uniform_sphere([[u], [v]]),
                cosine_hemisphere([[u], [v]]),
                phong_lobe([[u], [v]], 5.0),
                phong_lobe([[u], [v]], 1e30),
            ] {
                assert!((x * x + y * y + z * z - 1.0).abs() < 1e-6, "{u} {v}");
            }
        }
    }

    /// Second moments of the uniform sphere: x̄² = ȳ² = z̄² = 1/3, and z itself is uniform from -1
    /// to 1.
    #[test]
    fn the_sphere_is_even() {
        let side = 256;
        let count = f64::from(side * side);
        let (mut first, mut second, mut heights) = ([0.0; 3], [0.0; 3], [0u32; 16]);
        for point in grid(side) {
            let point_on_sphere = uniform_sphere(point).map(|[c]| f64::from(c));
            for axis in 0..3 {
                first[axis] += point_on_sphere[axis] / count;
                second[axis] += point_on_sphere[axis] * point_on_sphere[axis] / count;
            }
            heights[((point_on_sphere[2] + 1.0) * 8.0).clamp(0.0, 15.0) as usize] += 1;
        }
        // A grid's error falls with the square of its step.
        assert!(first.iter().all(|m| m.abs() < 1e-4), "{first:?}");
        assert!(
            second.iter().all(|m| (m - 1.0 / 3.0).abs() < 1e-4),
            "{second:?}"
        );
        // Caps end between rings of the grid; one ring is a hundredth of a cap.
        let even = count / 16.0;
        assert!(
            heights
                .iter()
                .all(|&n| (f64::from(n) / even - 1.0).abs() < 0.15),
            "{heights:?}"
        );
    }

    /// The mean of the cosine is 2/3, that of its square 1/2, and that of the components across is
    /// 0.
    #[test]
    fn the_hemisphere_is_a_cosine() {
        let side = 256;
        let count = f64::from(side * side);
        let mut moments = [0.0; 4];
        for point in grid(side) {
            let [x, y, z] = cosine_hemisphere(point).map(|[c]| f64::from(c));
            for (moment, value) in moments.iter_mut().zip([x, y, z, z * z]) {
                *moment += value / count;
            }
        }
        let want = [0.0, 0.0, 2.0 / 3.0, 0.5];
        for (k, (got, want)) in moments.into_iter().zip(want).enumerate() {
            // The grid's error: at the rim the cosine falls as a square root.
            assert!((got - want).abs() < 1e-3, "{k}: {got} {want}");
        }
    }

    /// Second moments of the uniform disc: x̄² = ȳ² = 1/4, and the mean distance from the centre is
    /// 2/3.
    #[test]
    fn the_disc_is_even() {
        let side = 256;
        let count = f64::from(side * side);
        let mut moments = [0.0; 6];
        for point in grid(side) {
            let [x, y] = concentric_disk(point).map(|[c]| f64::from(c));
            let away = libm::sqrt(x * x + y * y);
            for (moment, value) in moments.iter_mut().zip([x, y, x * y, x * x, y * y, away]) {
                *moment += value / count;
            }
        }
        let want = [0.0, 0.0, 0.0, 0.25, 0.25, 2.0 / 3.0];
        for (k, (got, want)) in moments.into_iter().zip(want).enumerate() {
            // A grid's error falls with the square of its step.
            assert!((got - want).abs() < 1e-4, "{k}: {got} {want}");
        }
    }

    /// The mean of the cosine is (n + 1)/(n + 2), that of its square (n + 1)/(n + 3), and that of
    /// the components across is 0.
    #[test]
    fn lobes_are_cosines_to_the_power() {
        let side = 256;
        let count = f64::from(side * side);
        for exponent in [0.0f32, 1.0, 2.5, 20.0, 1000.0, 1e5] {
            let n = f64::from(exponent);
            let mut moments = [0.0; 4];
            for point in grid(side) {
                let [x, y, z] = phong_lobe(point, exponent).map(|[c]| f64::from(c));
                for (moment, value) in moments.iter_mut().zip([x, y, z, z * z]) {
                    *moment += value / count;
                }
            }
            let want = [0.0, 0.0, (n + 1.0) / (n + 2.0), (n + 1.0) / (n + 3.0)];
            for (k, (got, want)) in moments.into_iter().zip(want).enumerate() {
                // The grid's error: at the rim the cosine falls to 0 within its last ring, a
                // hundredth of all.
                assert!(
                    (got - want).abs() < 2e-2 / (n + 1.0) + 1e-7,
                    "{n}, {k}: {got} {want}"
                );
            }
        }
    }

    #[test]
    fn turned_vectors_keep_their_lengths_and_angles() {
        for point in grid(32) {
            let axis = uniform_sphere(point);
            let [x, y, z] = axis.map(|[c]| f64::from(c));
            for local in [
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                [0.6, -0.48, 0.64],
            ] {
                let [a, b, c] = to_frame(local.map(|c| [c]), axis).map(|[c]| f64::from(c));
                let (length, along) = (a * a + b * b + c * c, a * x + b * y + c * z);
                // Some ten roundings of numbers of size 1.
                assert!((length - 1.0).abs() < 1e-6, "{axis:?} {local:?}: {length}");
                let want = f64::from(local[2]);
                assert!((along - want).abs() < 1e-6, "{axis:?} {local:?}: {along}");
            }
        }
        for z in [1.0, -1.0, 0.0, -0.0] {
            let axis = [[0.0], [f32::sqrt(1.0 - z * z)], [z]];
            assert_eq!(to_frame([[0.0], [0.0], [1.0]], axis), axis);
        }
    }
}
