//! The function x^s for the specular lobe, x in \[0, 1\]: the scalar half, and the constants of the
//! eight-wide half in `shade`.
//!
//! x^s = exp2(s · log2 x). The library's pow is not used because its last bits differ between
//! systems. The two halves here perform the same operations in the same order, so they agree bit
//! for bit. The relative error is at most 4e-7 · (1 + |s log2 x|). log2 is accurate relative to
//! itself near x = 1, where large exponents matter.

/// log2(1+f) = z·(c0 + z²(c1 + z²(c2 + z²(c3 + z² c4)))) with z = f/(2+f): the atanh series, 2/(ln
/// 2 · (2k+1)). At |z| ≤ 0.1716 the first term left out is below 2e-9 of the sum.
pub const LOG2_COEFFICIENTS: [f32; 5] =
    [2.885_39, 0.961_796_7, 0.577_078, 0.412_198_6, 0.320_598_9];

/// 2^r = Σ c_k r^k on \[−½, ½\], c_k = (ln 2)^k / k!; the first term left out is below 6e-9.
pub const EXP2_COEFFICIENTS: [f32; 8] = [
    1.0,
    std::f32::consts::LN_2,
    0.240_226_5,
    0.055_504_11,
    0.009_618_129,
    0.001_333_355_8,
    0.000_154_035_3,
    0.000_015_252_734,
];

/// 1.5 · 2²³: adding it rounds a float of modest size to an integer in its low bits.
pub const ROUND_MAGIC: f32 = 12_582_912.0;

/// Bits of √½, the lower end of the mantissa range \[√½, √2).
pub const SQRT_HALF_BITS: u32 = 0x3f35_04f3;

/// x^s with x clamped to \[0, 1\] and s ≥ 0; pow(0, 0) = 1. Values below 2⁻¹²⁶ are 0.
pub fn pow(x: f32, s: f32) -> f32 {
    let x = if x < 1.0 { x } else { 1.0 };
    let power = exp2(s * log2(x));
    let at_zero = if s == 0.0 { 1.0 } else { 0.0 };
    if x >= f32::MIN_POSITIVE { power } else { at_zero }
}

/// log2 of a positive normal number, within 2e-7 · (1 + |log2 x|).
pub fn log2(x: f32) -> f32 {
    let bits = x.to_bits();
    // Exponent such that the mantissa falls into [√½, √2), kept positive by the bias of 127.
    let biased = bits.wrapping_sub(SQRT_HALF_BITS).wrapping_add(127 << 23) >> 23;
    let mantissa = f32::from_bits(bits.wrapping_sub(biased.wrapping_sub(127) << 23));
    let f = mantissa - 1.0;
    let z = f / (f + 2.0);
    let zz = z * z;
    let [c0, c1, c2, c3, c4] = LOG2_COEFFICIENTS;
    let series = z * (c0 + zz * (c1 + zz * (c2 + zz * (c3 + zz * c4))));
    let exponent = biased as f32 - 127.0;
    exponent + series
}

/// 2^y, y ≤ 0 or tiny; 0 below −126.
fn exp2(y: f32) -> f32 {
    let y = if y > -127.0 { y } else { -127.0 };
    let rounded = y + ROUND_MAGIC;
    let r = y - (rounded - ROUND_MAGIC);
    let [c0, c1, c2, c3, c4, c5, c6, c7] = EXP2_COEFFICIENTS;
    let p = c0 + r * (c1 + r * (c2 + r * (c3 + r * (c4 + r * (c5 + r * (c6 + r * c7))))));
    let exponent = rounded
        .to_bits()
        .wrapping_sub(ROUND_MAGIC.to_bits())
        .wrapping_add(127);
    let power = p * f32::from_bits(exponent << 23);
    if y >= -126.0 { power } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{log2, pow};

    #[test]
    fn stays_within_its_stated_error() {
        let mut worst = 0.0f64;
        for i in 0..200_000u32 {
            let x = (i as f32 + 1.0) / 200_000.0;
            for s in [0.0f32, 0.5, 1.0, 2.0, 20.0, 100.0, 1000.0, 100_000.0] {
                let exact = libm::pow(x as f64, s as f64);
                let y = s as f64 * libm::log2(x as f64);
                if y < -125.0 {
                    continue;
                }
                let error = (pow(x, s) as f64 - exact).abs() / exact;
                worst = worst.max(error / (1.0 + y.abs()));
            }
        }
        assert!(worst < 4e-7, "relative error {worst:e} times (1 + |y|)");
    }

    #[test]
    fn logarithms_stay_within_their_stated_error() {
        let first = f32::MIN_POSITIVE.to_bits();
        for bits in (first..f32::INFINITY.to_bits()).step_by(997) {
            let x = f32::from_bits(bits);
            let exact = libm::log2(x.into());
            let error = (f64::from(log2(x)) - exact).abs();
            assert!(error <= 2e-7 * (1.0 + exact.abs()), "{x:e}: {error:e}");
        }
    }

    #[test]
    fn corners() {
        assert_eq!(pow(0.0, 0.0), 1.0);
        assert_eq!(pow(0.0, 3.0), 0.0);
        assert_eq!(pow(1.0, 1e30), 1.0);
        assert_eq!(pow(0.5, 1.0), 0.5);
        assert_eq!(pow(0.25, 1000.0), 0.0);
        assert_eq!(pow(1.000_001, 10.0), 1.0);
    }
}
