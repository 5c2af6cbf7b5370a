//! Numbers, masks and vectors of eight and of sixteen lanes; the only module that uses `wide`.
//!
//! Every operation here is one IEEE operation per lane, so a lane's bits do not depend on its
//! neighbours, on the number of lanes or on the instruction set. Operations that would break that
//! are left out: `mul_add` (fuses or not by build), `recip` and `recip_sqrt` (12-bit
//! approximations), library functions. There is one exception, for bounds:
//! [`Lanes::mul_sub_any_rounding`]. [`Lanes::min`] and [`Lanes::max`] are `if a < b { a } else { b
//! }`, the bits of `minps`; the scalar oracle writes them out the same way.
//!
//! Eight lanes are the packet: queues, shading and the camera use [`F32x8`]. The traversal is
//! generic over [`Lanes`], so that two packets can traverse the tree as one [`F32x16`].

#[allow(unsafe_code, reason = "shuffles by a table have no safe name")]
mod compact;
#[allow(unsafe_code, reason = "the one instruction that has no safe name")]
#[cfg(all(target_arch = "x86_64", target_feature = "avx512vl"))]
mod mask_bits;
mod types;
mod vec3;

pub(crate) use compact::{COMPACT_LUT, LaneMove};
pub use types::{F32x8, F32x16, F64x8, Mask8, Mask16, U32x8, U32x16};
pub use vec3::{Vec3Lanes, Vec3x8};

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Lanes in a packet: part of the contract, independent of the machine's register width.
pub const LANES: usize = 8;

/// Vector as wide as the widest registers of the build: children of a wide node, and primitives of
/// a block. Results do not depend on that width.
#[cfg(target_feature = "avx512f")]
pub type Native = F32x16;
/// Vector as wide as the widest registers of the build: children of a wide node, and primitives of
/// a block. Results do not depend on that width.
#[cfg(not(target_feature = "avx512f"))]
pub type Native = F32x8;

/// Lanes of [`Native`].
pub const NATIVE: usize = <Native as Lanes>::PACKETS * LANES;

/// Booleans of [`Native`].
pub type NativeMask = <Native as Lanes>::Mask;

/// Vectors of [`Native`].
pub type Vec3Native = Vec3Lanes<Native>;

/// Floats in a column that is read by runs of lanes: see [`Lanes::load_run`].
pub const COLUMN_LANES: usize = 64;

/// Floats in lanes.
pub trait Lanes:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Booleans with the same number of lanes.
    type Mask: LaneMask<Self, Self::U32>;
    /// Unsigned integers with the same number of lanes.
    type U32: LaneU32<Self::Mask>;
    /// Packets of [`LANES`] that fit side by side.
    const PACKETS: usize;
    /// All lanes zero.
    const ZERO: Self;
    /// All lanes one.
    const ONE: Self;

    /// The same value in every lane.
    fn splat(value: f32) -> Self;
    /// Joins [`Lanes::PACKETS`] octets side by side; `eight(k)` gives the k-th.
    fn from_octets(eight: impl Fn(usize) -> [f32; LANES]) -> Self;
    /// The k-th octet of lanes.
    fn octet(self, k: usize) -> F32x8;
    /// The k-th run of lanes of a column.
    fn load_run(column: &[f32; COLUMN_LANES], k: usize) -> Self;
    /// The smallest lane; any lane, if one of them is NaN.
    fn min_element(self) -> f32;
    /// The largest lane; any lane, if one of them is NaN.
    fn max_element(self) -> f32;
    /// `if self < other { self } else { other }`: a NaN in `other` is returned, a NaN in `self` is
    /// not.
    fn min(self, other: Self) -> Self;
    /// `if self > other { self } else { other }`.
    fn max(self, other: Self) -> Self;
    /// Clears the sign bit.
    fn abs(self) -> Self;
    /// Correctly rounded square root.
    fn sqrt(self) -> Self;
    /// self · by − less, rounded once or twice, depending on the build: for bounds with a margin,
    /// never for values of a result.
    fn mul_sub_any_rounding(self, factor: Self, less: Self) -> Self;
    /// self < other
    fn lt(self, other: Self) -> Self::Mask;
    /// self ≤ other
    fn le(self, other: Self) -> Self::Mask;
    /// self > other
    fn gt(self, other: Self) -> Self::Mask;
    /// self ≥ other
    fn ge(self, other: Self) -> Self::Mask;
    /// self = other
    fn eq(self, other: Self) -> Self::Mask;
    /// Lanes whose bits are the same in both: zeros of different sign differ, equal NaNs do not.
    fn bits_eq(self, other: Self) -> Self::Mask;
}

/// Unsigned integers in lanes.
pub trait LaneU32<M>: Copy {
    /// The same value in every lane.
    fn splat(value: u32) -> Self;
    /// The k-th octet of lanes.
    fn octet(self, k: usize) -> U32x8;
    /// self + other, modulo 2³².
    fn wrapping_add(self, other: Self) -> Self;
    /// self < other, unsigned.
    fn lt(self, other: Self) -> M;
    /// self = other
    fn eq(self, other: Self) -> M;
}

/// Booleans in lanes, all bits of a lane set or clear.
pub trait LaneMask<F, U>:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// The same value in every lane.
    fn splat(value: bool) -> Self;
    /// No lane set.
    fn none() -> Self;
    /// A mask from bits: lane k is bit k.
    fn from_bits(bits: u32) -> Self;
    /// The mask as bits: bit k is lane k.
    fn bits(self) -> u32;
    /// Returns true if any lane is set.
    fn any(self) -> bool;
    /// Lanes of `yes` where set, of `no` elsewhere.
    fn select(self, yes: F, no: F) -> F;
    /// Lanes of `yes` where set, of `no` elsewhere.
    fn select_u32(self, yes: U, no: U) -> U;

    /// Lanes 0 to `count` − 1.
    #[inline(always)]
    fn first(count: usize) -> Self {
        Self::from_bits(((1u64 << count.min(32)) - 1) as u32)
    }

    /// The set lanes, in order.
    #[inline(always)]
    fn lanes(self) -> impl Iterator<Item = usize> {
        let mut rest = self.bits();
        std::iter::from_fn(move || {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest.wrapping_sub(1);
            (lane < 32).then_some(lane)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAN: f32 = f32::NAN;

    /// Pairs that machines' own minimum and maximum treat in different ways.
    const LEFT: [f32; LANES] = [NAN, 1.0, 0.0, -0.0, NAN, 2.0, f32::INFINITY, -NAN];
    const RIGHT: [f32; LANES] = [1.0, NAN, -0.0, 0.0, -NAN, 3.0, NAN, 0.0];

    fn bits<F: Lanes>(lanes: F) -> [u32; LANES] {
        lanes.octet(F::PACKETS - 1).to_bits().to_array()
    }

    fn compare<F: Lanes>() {
        let (left, right) = (F::from_octets(|_| LEFT), F::from_octets(|_| RIGHT));
        let lanes = || LEFT.into_iter().zip(RIGHT);
        let least = lanes().map(|(a, b)| if a < b { a } else { b }.to_bits());
        assert!(least.eq(bits(left.min(right))));
        let greatest = lanes().map(|(a, b)| if a > b { a } else { b }.to_bits());
        assert!(greatest.eq(bits(left.max(right))));
    }

    #[test]
    fn minimum_and_maximum_are_those_of_a_comparison() {
        compare::<F32x8>();
        compare::<F32x16>();
        let doubles = |lanes: [f32; LANES]| F64x8::from(F32x8::new(lanes));
        let rounded = doubles(LEFT).max(doubles(RIGHT)).rounded().to_array();
        for ((a, b), rounded) in LEFT.into_iter().zip(RIGHT).zip(rounded) {
            let want = if a > b { a } else { b };
            assert!(want.to_bits() == rounded.to_bits() || want.is_nan() && rounded.is_nan());
        }
    }
}
