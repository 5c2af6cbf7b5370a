//! x^s, eight lanes at a time: the wide half of [`phalanx_scene::sampling::pow`], operation for
//! operation.

use phalanx_scene::sampling::{EXP2_COEFFICIENTS, LOG2_COEFFICIENTS, ROUND_MAGIC, SQRT_HALF_BITS};
use phalanx_trace::simd::{F32x8, LaneMask, LaneU32, Lanes, U32x8};

/// x^s with x clamped to \[0, 1\] and s ≥ 0; pow(0, 0) = 1. The bits of
/// [`phalanx_scene::sampling::pow`].
pub fn pow(x: F32x8, s: F32x8) -> F32x8 {
    let x = x.min(F32x8::ONE);
    let power = exp2(s * log2(x));
    let at_zero = s.eq(F32x8::ZERO).select(F32x8::ONE, F32x8::ZERO);
    x.ge(F32x8::splat(f32::MIN_POSITIVE)).select(power, at_zero)
}

fn log2(x: F32x8) -> F32x8 {
    let bias = U32x8::splat(127 << 23);
    let bits = x.to_bits();
    let biased = bits
        .wrapping_sub(U32x8::splat(SQRT_HALF_BITS))
        .wrapping_add(bias)
        .shift_right(23);
    let shift = biased.wrapping_sub(U32x8::splat(127)).shift_left(23);
    let mantissa = F32x8::from_bits(bits.wrapping_sub(shift));
    let f = mantissa - F32x8::ONE;
    let z = f / (f + F32x8::splat(2.0));
    let zz = z * z;
    let [c0, c1, c2, c3, c4] = LOG2_COEFFICIENTS.map(F32x8::splat);
    let series = z * (c0 + zz * (c1 + zz * (c2 + zz * (c3 + zz * c4))));
    // A small integer as a float: put it into the low bits of 2^23 and subtract that; exact.
    let two_23 = F32x8::splat(8_388_608.0);
    let exponent = (F32x8::from_bits(biased.or(two_23.to_bits())) - two_23) - F32x8::splat(127.0);
    exponent + series
}

fn exp2(y: F32x8) -> F32x8 {
    let y = y.max(F32x8::splat(-127.0));
    let magic = F32x8::splat(ROUND_MAGIC);
    let rounded = y + magic;
    let r = y - (rounded - magic);
    let [c0, c1, c2, c3, c4, c5, c6, c7] = EXP2_COEFFICIENTS.map(F32x8::splat);
    let p = c0 + r * (c1 + r * (c2 + r * (c3 + r * (c4 + r * (c5 + r * (c6 + r * c7))))));
    let exponent = rounded
        .to_bits()
        .wrapping_sub(magic.to_bits())
        .wrapping_add(U32x8::splat(127));
    let power = p * F32x8::from_bits(exponent.shift_left(23));
    y.ge(F32x8::splat(-126.0)).select(power, F32x8::ZERO)
}
