//! The angle of a vector, as a share of a full turn.

/// Coefficients of atan(a) / 2π = a (c0 + c1 a² + c2 a⁴ + …) on \[0, 1\], fitted for the least
/// largest error: 4e-8 rad, and 2e-7 rad with roundings.
const ATAN: [f32; 8] = [
    0.159_154_83,
    -0.053_046_122,
    0.031_745_944,
    -0.022_136_271,
    0.015_346_031,
    -0.008_898_718,
    0.003_479_594_4,
    -0.000_645_303_4,
];

/// Angle from the x axis to (x, y) in full turns, from −½ to ½: atan2(y, x) / 2π, and 0 for the
/// zero vector. The library's atan2 is not used because its last bits differ between systems.
#[inline]
pub fn turns(y: f32, x: f32) -> f32 {
    let (across, up) = (x.abs(), y.abs());
    let is_steep = up > across;
    let (short, long) = if is_steep { (across, up) } else { (up, across) };
    let a = if long > 0.0 { short / long } else { 0.0 };
    let square = a * a;
    let [c0, c1, c2, c3, c4, c5, c6, c7] = ATAN;
    let upper = c4 + square * (c5 + square * (c6 + square * c7));
    let eighth = a * (c0 + square * (c1 + square * (c2 + square * (c3 + square * upper))));
    let quarter = if is_steep { 0.25 - eighth } else { eighth };
    let half = if x < 0.0 { 0.5 - quarter } else { quarter };
    if y < 0.0 { -half } else { half }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_those_of_atan2() {
        let mut worst = 0.0f64;
        for k in 0..100_000 {
            let angle = (f64::from(k) / 50_000.0 - 1.0) * std::f64::consts::PI;
            let size = libm::exp2(f64::from(k % 61) - 30.0);
            let [x, y] = [libm::cos(angle), libm::sin(angle)].map(|c| (c * size) as f32);
            let want = libm::atan2(y.into(), x.into());
            let got = f64::from(turns(y, x)) * std::f64::consts::TAU;
            worst = worst.max((got - want).abs());
        }
        assert!(worst < 3e-7, "{worst}");
    }

    #[test]
    fn axes_and_diagonals_are_exact() {
        let cases = [
            ([0.0, 0.0], 0.0),
            ([0.0, 2.0], 0.0),
            ([2.0, 0.0], 0.25),
            ([0.0, -2.0], 0.5),
            ([-2.0, 0.0], -0.25),
        ];
        for ([y, x], want) in cases {
            assert_eq!(turns(y, x), want, "{y} {x}");
        }
        // An eighth is the sum of all coefficients.
        assert!((turns(3.0, 3.0) - 0.125).abs() < 2e-8);
    }
}
