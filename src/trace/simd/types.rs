//! Lane types of eight and of sixteen lanes, over those of `wide`.
//!
//! Arithmetic, here and of vectors, is `inline`, and not `inline(always)`: LLVM then reduces each
//! layer between a kernel and its instructions before it copies it, which takes half the time.
//! Comparisons, masks, `abs` and `splat` are always inlined, because kernels whose rays part have 1
//! to 2 % more instructions if they are not (`perf/notes/compile-time.md`).

use super::{COLUMN_LANES, LANES, LaneMask, LaneU32, Lanes};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use wide::{f32x4, f32x8, f32x16, f64x8, u32x8, u32x16};

/// Folds all lanes, first in groups of four, then those four by halves. With any other order the
/// compiler generates masks and blends.
#[inline(always)]
fn fold<const N: usize>(
    lanes: [f32; N],
    fours: impl Fn(f32x4, f32x4) -> f32x4,
    pick: impl Fn(f32, f32) -> f32,
) -> f32 {
    let chunks = lanes.as_chunks::<4>().0;
    let mut best = f32x4::new(chunks[0]);
    for chunk in &chunks[1..] {
        best = fours(best, f32x4::new(*chunk));
    }
    let [a, b, c, d] = best.to_array();
    pick(pick(a, c), pick(b, d))
}

/// True if `wide`'s fastest minimum and maximum behave like [`Lanes::min`] and [`Lanes::max`], as
/// `minps` does. NEON's return NaN if either operand is NaN, and order zeros by sign; WebAssembly's
/// return the other operand than `minps` if the two do not compare.
const HAS_ORDERED_MIN_MAX: bool = cfg!(target_arch = "x86_64");

/// Operators of a type, lane by lane: those of the type in it.
macro_rules! lane_operators {
    ($type:ident, $inline:meta: $($Operator:ident $operate:ident),+) => {$(
        impl $Operator for $type {
            type Output = $type;
            #[$inline]
            fn $operate(self, other: $type) -> $type {
                $type(self.0.$operate(other.0))
            }
        }
    )+};
}

/// Defines the types of one lane count. A macro instead of a generic, because `wide`'s types share
/// no trait.
macro_rules! lane_types {
    ($count:literal, $F:ident($f:ident), $U:ident($u:ident), $M:ident, $bits:expr) => {
        #[doc = concat!(stringify!($count), " floats.")]
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub struct $F($f);

        #[doc = concat!(stringify!($count), " unsigned integers.")]
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub struct $U($u);

        #[doc = concat!(stringify!($count), " booleans, all bits of a lane set or clear.")]
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub struct $M($f);

        lane_operators!($F, inline: Add add, Sub sub, Mul mul, Div div);

        impl Neg for $F {
            type Output = $F;
            /// Flips the sign bit of every lane.
            #[inline(always)]
            fn neg(self) -> $F {
                $F(self.0 ^ $f::splat(-0.0))
            }
        }

        impl $F {
            /// Lanes from an array: lane k takes `values[k]`.
            #[inline(always)]
            pub const fn new(values: [f32; $count]) -> $F {
                $F($f::new(values))
            }

            /// The lanes as an array.
            #[inline(always)]
            pub fn to_array(self) -> [f32; $count] {
                self.0.to_array()
            }

            /// One lane, read in place: for a packet in memory, cheaper than `to_array`.
            #[inline(always)]
            pub fn lane(&self, k: usize) -> f32 {
                self.0.as_array()[k]
            }

            /// Replaces one lane in place.
            #[inline(always)]
            pub fn set_lane(&mut self, k: usize, value: f32) {
                self.0.as_mut_array()[k] = value;
            }

            /// The bit patterns.
            #[inline(always)]
            pub fn to_bits(self) -> $U {
                $U(self.0.to_bits())
            }

            /// Floats from bit patterns.
            #[inline(always)]
            pub fn from_bits(bits: $U) -> $F {
                $F($f::from_bits(bits.0))
            }
        }

        impl Lanes for $F {
            type Mask = $M;
            type U32 = $U;
            const PACKETS: usize = $count / LANES;
            const ZERO: $F = $F($f::new([0.0; $count]));
            const ONE: $F = $F($f::new([1.0; $count]));

            #[inline(always)]
            fn splat(value: f32) -> $F {
                $F($f::splat(value))
            }

            #[inline(always)]
            fn from_octets(eight: impl Fn(usize) -> [f32; LANES]) -> $F {
                let mut lanes = [0.0; $count];
                for (k, chunk) in lanes.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
                    *chunk = eight(k);
                }
                $F($f::new(lanes))
            }

            #[inline(always)]
            fn octet(self, k: usize) -> F32x8 {
                F32x8::new(self.0.as_array().as_chunks::<LANES>().0[k])
            }

            #[inline(always)]
            fn load_run(column: &[f32; COLUMN_LANES], k: usize) -> $F {
                let runs = column.as_chunks::<$count>().0;
                $F($f::new(runs[k % (COLUMN_LANES / $count)]))
            }

            #[inline(always)]
            fn min_element(self) -> f32 {
                fold(
                    self.to_array(),
                    f32x4::fast_min,
                    |a, b| if a < b { a } else { b },
                )
            }

            #[inline(always)]
            fn max_element(self) -> f32 {
                fold(
                    self.to_array(),
                    f32x4::fast_max,
                    |a, b| if a > b { a } else { b },
                )
            }

            #[inline]
            fn min(self, other: $F) -> $F {
                if HAS_ORDERED_MIN_MAX {
                    $F(self.0.fast_min(other.0))
                } else {
                    self.lt(other).select(self, other)
                }
            }

            #[inline]
            fn max(self, other: $F) -> $F {
                if HAS_ORDERED_MIN_MAX {
                    $F(self.0.fast_max(other.0))
                } else {
                    self.gt(other).select(self, other)
                }
            }

            #[inline(always)]
            fn abs(self) -> $F {
                $F(self.0.abs())
            }

            #[inline]
            fn sqrt(self) -> $F {
                $F(self.0.sqrt())
            }

            #[inline]
            fn mul_sub_any_rounding(self, factor: $F, less: $F) -> $F {
                $F(self.0.mul_sub(factor.0, less.0))
            }

            #[inline(always)]
            fn lt(self, other: $F) -> $M {
                $M(self.0.simd_lt(other.0))
            }

            #[inline(always)]
            fn le(self, other: $F) -> $M {
                $M(self.0.simd_le(other.0))
            }

            #[inline(always)]
            fn gt(self, other: $F) -> $M {
                $M(self.0.simd_gt(other.0))
            }

            #[inline(always)]
            fn ge(self, other: $F) -> $M {
                $M(self.0.simd_ge(other.0))
            }

            #[inline(always)]
            fn eq(self, other: $F) -> $M {
                $M(self.0.simd_eq(other.0))
            }

            #[inline(always)]
            fn bits_eq(self, other: $F) -> $M {
                $M($f::from_bits(self.0.to_bits().simd_eq(other.0.to_bits())))
            }
        }

        impl $U {
            /// Lanes from an array: lane k takes `values[k]`.
            #[inline(always)]
            pub const fn new(values: [u32; $count]) -> $U {
                $U($u::new(values))
            }

            /// The lanes as an array.
            #[inline(always)]
            pub fn to_array(self) -> [u32; $count] {
                self.0.to_array()
            }

            /// One lane, read in place.
            #[inline(always)]
            pub fn lane(&self, k: usize) -> u32 {
                self.0.as_array()[k]
            }

            /// Replaces one lane in place.
            #[inline(always)]
            pub fn set_lane(&mut self, k: usize, value: u32) {
                self.0.as_mut_array()[k] = value;
            }

            /// Wrapping difference.
            #[inline(always)]
            pub fn wrapping_sub(self, other: $U) -> $U {
                $U(self.0 - other.0)
            }

            /// Logical shift left of every lane.
            #[inline(always)]
            pub fn shift_left(self, bits: u32) -> $U {
                $U(self.0 << bits)
            }

            /// Logical shift right of every lane.
            #[inline(always)]
            pub fn shift_right(self, bits: u32) -> $U {
                $U(self.0 >> bits)
            }

            /// Bitwise or.
            #[inline(always)]
            pub fn or(self, other: $U) -> $U {
                $U(self.0 | other.0)
            }
        }

        impl LaneU32<$M> for $U {
            #[inline(always)]
            fn splat(value: u32) -> $U {
                $U($u::splat(value))
            }

            #[inline(always)]
            fn octet(self, k: usize) -> U32x8 {
                U32x8::new(self.0.as_array().as_chunks::<LANES>().0[k])
            }

            #[inline(always)]
            fn wrapping_add(self, other: $U) -> $U {
                $U(self.0 + other.0)
            }

            #[inline(always)]
            fn lt(self, other: $U) -> $M {
                $M($f::from_bits(other.0.simd_gt(self.0)))
            }

            #[inline(always)]
            fn eq(self, other: $U) -> $M {
                $M($f::from_bits(self.0.simd_eq(other.0)))
            }
        }

        lane_operators!($M, inline(always): BitAnd bitand, BitOr bitor);

        impl Not for $M {
            type Output = $M;
            #[inline(always)]
            fn not(self) -> $M {
                $M(!self.0)
            }
        }

        impl LaneMask<$F, $U> for $M {
            #[inline(always)]
            fn splat(value: bool) -> $M {
                $M($f::from_bits($u::splat(u32::from(value).wrapping_neg())))
            }

            #[inline(always)]
            fn none() -> $M {
                $M($f::splat(0.0))
            }

            #[inline(always)]
            fn from_bits(bits: u32) -> $M {
                const LANE_BITS: [u32; $count] = {
                    let mut bits = [0; $count];
                    let mut k = 0;
                    while k < $count {
                        bits[k] = 1 << k;
                        k += 1;
                    }
                    bits
                };
                let lane_bits = $u::new(LANE_BITS);
                $M($f::from_bits(
                    ($u::splat(bits) & lane_bits).simd_eq(lane_bits),
                ))
            }

            #[inline(always)]
            fn bits(self) -> u32 {
                $bits(self.0)
            }

            #[inline(always)]
            fn any(self) -> bool {
                self.bits() != 0
            }

            #[inline(always)]
            fn select(self, yes: $F, no: $F) -> $F {
                $F(self.0.bitselect(yes.0, no.0))
            }

            #[inline(always)]
            fn select_u32(self, yes: $U, no: $U) -> $U {
                $U(self.0.to_bits().bitselect(yes.0, no.0))
            }
        }
    };
}

lane_types!(8, F32x8(f32x8), U32x8(u32x8), Mask8, bits_of_eight);
lane_types!(
    16,
    F32x16(f32x16),
    U32x16(u32x16),
    Mask16,
    f32x16::to_bitmask
);

#[cfg(not(all(target_arch = "x86_64", target_feature = "avx512vl")))]
#[inline(always)]
fn bits_of_eight(mask: f32x8) -> u32 {
    mask.to_bitmask()
}

#[cfg(all(target_arch = "x86_64", target_feature = "avx512vl"))]
#[inline(always)]
fn bits_of_eight(mask: f32x8) -> u32 {
    super::mask_bits::bits(bytemuck::cast(mask))
}

impl F32x8 {
    /// Lanes by index. The calls are written out, so that lanes are assembled in a register: a
    /// loop, or a closure in an array's map, stores them one by one, and reading them back as eight
    /// stalls.
    #[inline(always)]
    pub fn from_lanes(lane: impl Fn(usize) -> f32) -> F32x8 {
        F32x8::new([
            lane(0),
            lane(1),
            lane(2),
            lane(3),
            lane(4),
            lane(5),
            lane(6),
            lane(7),
        ])
    }

    /// Transposes eight columns to eight rows; the bits do not change.
    #[inline(always)]
    pub fn transposed(columns: [F32x8; LANES]) -> [[f32; LANES]; LANES] {
        f32x8::transpose(columns.map(|column| column.0)).map(f32x8::to_array)
    }
}

/// Eight doubles, for results that are rounded to `f32` at the end.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F64x8(f64x8);

impl F64x8 {
    /// All lanes one.
    pub const ONE: F64x8 = F64x8(f64x8::ONE);

    /// The same value in every lane.
    #[inline]
    pub fn splat(value: f64) -> F64x8 {
        F64x8(f64x8::splat(value))
    }

    /// Every lane rounded to `f32`, to the nearest, ties to even.
    #[inline(always)]
    pub fn rounded(self) -> F32x8 {
        F32x8::new(self.0.to_array().map(|lane| lane as f32))
    }

    /// `if self > other { self } else { other }`.
    #[inline]
    pub fn max(self, other: F64x8) -> F64x8 {
        F64x8(if HAS_ORDERED_MIN_MAX {
            self.0.fast_max(other.0)
        } else {
            self.0.simd_gt(other.0).bitselect(self.0, other.0)
        })
    }

    /// Clears the sign bit.
    #[inline(always)]
    pub fn abs(self) -> F64x8 {
        F64x8(self.0.abs())
    }

    /// Correctly rounded square root.
    #[inline]
    pub fn sqrt(self) -> F64x8 {
        F64x8(self.0.sqrt())
    }

    /// self > other
    #[inline(always)]
    pub fn gt(self, other: F64x8) -> Mask8 {
        Mask8::from_bits(self.0.simd_gt(other.0).to_bitmask())
    }

    /// self ≤ other
    #[inline(always)]
    pub fn le(self, other: F64x8) -> Mask8 {
        Mask8::from_bits(self.0.simd_le(other.0).to_bitmask())
    }
}

impl From<F32x8> for F64x8 {
    #[inline(always)]
    fn from(lanes: F32x8) -> F64x8 {
        F64x8(f64x8::new(lanes.to_array().map(f64::from)))
    }
}

lane_operators!(F64x8, inline: Add add, Sub sub, Mul mul, Div div);
