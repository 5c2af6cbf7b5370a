//! Eight-wide numbers, masks and vectors; the only place that names `wide`.
//!
//! Every operation here is one IEEE operation per lane, so a lane's bits do not depend on its neighbours or on the
//! instruction set. What would break that is left out: `mul_add` (fuses or not by build), `recip` and `recip_sqrt`
//! (12-bit approximations), library functions. [`F32x8::min`] and [`F32x8::max`] are `if a < b { a } else { b }`, the
//! bits of `minps`; the scalar oracle writes them out the same way.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use wide::{f32x8, u32x8};

/// Lanes in a packet: part of the contract, whatever the machine's registers hold.
pub const LANES: usize = 8;

/// Eight floats.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F32x8(f32x8);

/// Eight unsigned integers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct U32x8(u32x8);

/// Eight booleans, all bits of a lane set or clear.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Mask8(f32x8);

macro_rules! lanewise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for F32x8 {
            type Output = F32x8;
            #[inline(always)]
            fn $method(self, other: F32x8) -> F32x8 {
                F32x8(self.0 $op other.0)
            }
        }
    };
}
lanewise!(Add, add, +);
lanewise!(Sub, sub, -);
lanewise!(Mul, mul, *);
lanewise!(Div, div, /);

impl Neg for F32x8 {
    type Output = F32x8;
    /// Flips the sign bit of every lane.
    #[inline(always)]
    fn neg(self) -> F32x8 {
        F32x8(self.0 ^ f32x8::splat(-0.0))
    }
}

impl F32x8 {
    /// All lanes zero.
    pub const ZERO: F32x8 = F32x8(f32x8::new([0.0; 8]));
    /// All lanes one.
    pub const ONE: F32x8 = F32x8(f32x8::new([1.0; 8]));

    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(value: f32) -> F32x8 {
        F32x8(f32x8::splat(value))
    }

    /// Lane k takes `values[k]`.
    #[inline(always)]
    pub const fn new(values: [f32; 8]) -> F32x8 {
        F32x8(f32x8::new(values))
    }

    /// The lanes as an array.
    #[inline(always)]
    pub fn to_array(self) -> [f32; 8] {
        self.0.to_array()
    }

    /// One lane, read where it lies: for a packet in memory, cheaper than [`F32x8::to_array`].
    #[inline(always)]
    pub fn lane(&self, k: usize) -> f32 {
        self.0.as_array()[k]
    }

    /// `if self < other { self } else { other }`: the other's NaN comes through, one's own does not.
    #[inline(always)]
    pub fn min(self, other: F32x8) -> F32x8 {
        F32x8(self.0.fast_min(other.0))
    }

    /// `if self > other { self } else { other }`.
    #[inline(always)]
    pub fn max(self, other: F32x8) -> F32x8 {
        F32x8(self.0.fast_max(other.0))
    }

    /// Clears the sign bit.
    #[inline(always)]
    pub fn abs(self) -> F32x8 {
        F32x8(self.0.abs())
    }

    /// Correctly rounded square root.
    #[inline(always)]
    pub fn sqrt(self) -> F32x8 {
        F32x8(self.0.sqrt())
    }

    /// self < other
    #[inline(always)]
    pub fn lt(self, other: F32x8) -> Mask8 {
        Mask8(self.0.simd_lt(other.0))
    }

    /// self ≤ other
    #[inline(always)]
    pub fn le(self, other: F32x8) -> Mask8 {
        Mask8(self.0.simd_le(other.0))
    }

    /// self > other
    #[inline(always)]
    pub fn gt(self, other: F32x8) -> Mask8 {
        Mask8(self.0.simd_gt(other.0))
    }

    /// self ≥ other
    #[inline(always)]
    pub fn ge(self, other: F32x8) -> Mask8 {
        Mask8(self.0.simd_ge(other.0))
    }

    /// self = other
    #[inline(always)]
    pub fn eq(self, other: F32x8) -> Mask8 {
        Mask8(self.0.simd_eq(other.0))
    }

    /// The bit patterns.
    #[inline(always)]
    pub fn to_bits(self) -> U32x8 {
        U32x8(self.0.to_bits())
    }

    /// Floats from bit patterns.
    #[inline(always)]
    pub fn from_bits(bits: U32x8) -> F32x8 {
        F32x8(f32x8::from_bits(bits.0))
    }
}

impl U32x8 {
    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(value: u32) -> U32x8 {
        U32x8(u32x8::splat(value))
    }

    /// Lane k takes `values[k]`.
    #[inline(always)]
    pub const fn new(values: [u32; 8]) -> U32x8 {
        U32x8(u32x8::new(values))
    }

    /// The lanes as an array.
    #[inline(always)]
    pub fn to_array(self) -> [u32; 8] {
        self.0.to_array()
    }

    /// One lane, read where it lies.
    #[inline(always)]
    pub fn lane(&self, k: usize) -> u32 {
        self.0.as_array()[k]
    }

    /// self < other, unsigned.
    #[inline(always)]
    pub fn lt(self, other: U32x8) -> Mask8 {
        Mask8(f32x8::from_bits(other.0.simd_gt(self.0)))
    }

    /// self = other
    #[inline(always)]
    pub fn eq(self, other: U32x8) -> Mask8 {
        Mask8(f32x8::from_bits(self.0.simd_eq(other.0)))
    }

    /// Wrapping sum.
    #[inline(always)]
    pub fn wrapping_add(self, other: U32x8) -> U32x8 {
        U32x8(self.0 + other.0)
    }

    /// Wrapping difference.
    #[inline(always)]
    pub fn wrapping_sub(self, other: U32x8) -> U32x8 {
        U32x8(self.0 - other.0)
    }

    /// Logical shift left of every lane.
    #[inline(always)]
    pub fn shift_left(self, bits: u32) -> U32x8 {
        U32x8(self.0 << bits)
    }

    /// Logical shift right of every lane.
    #[inline(always)]
    pub fn shift_right(self, bits: u32) -> U32x8 {
        U32x8(self.0 >> bits)
    }

    /// Bitwise and.
    #[inline(always)]
    pub fn and(self, other: U32x8) -> U32x8 {
        U32x8(self.0 & other.0)
    }

    /// Bitwise or.
    #[inline(always)]
    pub fn or(self, other: U32x8) -> U32x8 {
        U32x8(self.0 | other.0)
    }
}

impl BitAnd for Mask8 {
    type Output = Mask8;
    #[inline(always)]
    fn bitand(self, other: Mask8) -> Mask8 {
        Mask8(self.0 & other.0)
    }
}

impl BitOr for Mask8 {
    type Output = Mask8;
    #[inline(always)]
    fn bitor(self, other: Mask8) -> Mask8 {
        Mask8(self.0 | other.0)
    }
}

impl Not for Mask8 {
    type Output = Mask8;
    #[inline(always)]
    fn not(self) -> Mask8 {
        Mask8(!self.0)
    }
}

impl Mask8 {
    /// No lane set.
    #[inline(always)]
    pub fn none() -> Mask8 {
        Mask8(f32x8::splat(0.0))
    }

    /// Lane k is bit k.
    #[inline(always)]
    pub fn from_bits(bits: u8) -> Mask8 {
        const LANE_BIT: U32x8 = U32x8::new([1, 2, 4, 8, 16, 32, 64, 128]);
        U32x8::splat(bits as u32).and(LANE_BIT).eq(LANE_BIT)
    }

    /// Lanes 0 to `count` − 1.
    #[inline(always)]
    pub fn first(count: usize) -> Mask8 {
        Mask8::from_bits(((1u32 << count.min(LANES)) - 1) as u8)
    }

    /// Bit k is lane k.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        self.0.to_bitmask() as u8
    }

    /// The set lanes, in order.
    #[inline(always)]
    pub fn lanes(self) -> impl Iterator<Item = usize> {
        let mut rest = self.bits() as u32;
        std::iter::from_fn(move || {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest.wrapping_sub(1);
            (lane < LANES).then_some(lane)
        })
    }

    /// Whether any lane is set.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.to_bitmask() != 0
    }

    /// Lanes of `yes` where set, of `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: F32x8, no: F32x8) -> F32x8 {
        F32x8(self.0.bitselect(yes.0, no.0))
    }

    /// Lanes of `yes` where set, of `no` elsewhere.
    #[inline(always)]
    pub fn select_u32(self, yes: U32x8, no: U32x8) -> U32x8 {
        U32x8(self.0.to_bits().bitselect(yes.0, no.0))
    }

    /// Lanes of `yes` where set, of `no` elsewhere.
    #[inline(always)]
    pub fn select_vec(self, yes: Vec3x8, no: Vec3x8) -> Vec3x8 {
        Vec3x8 {
            x: self.select(yes.x, no.x),
            y: self.select(yes.y, no.y),
            z: self.select(yes.z, no.z),
        }
    }
}

/// Eight vectors as three columns of lanes.
#[derive(Clone, Copy, Debug)]
pub struct Vec3x8 {
    /// x components.
    pub x: F32x8,
    /// y components.
    pub y: F32x8,
    /// z components.
    pub z: F32x8,
}

impl Vec3x8 {
    /// All zero.
    pub const ZERO: Vec3x8 = Vec3x8::new(F32x8::ZERO, F32x8::ZERO, F32x8::ZERO);

    /// From three columns.
    #[inline(always)]
    pub const fn new(x: F32x8, y: F32x8, z: F32x8) -> Vec3x8 {
        Vec3x8 { x, y, z }
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(x: f32, y: f32, z: f32) -> Vec3x8 {
        Vec3x8::new(F32x8::splat(x), F32x8::splat(y), F32x8::splat(z))
    }

    /// (x·x' + y·y') + z·z', in the order of glam's `Vec3::dot`.
    #[inline(always)]
    pub fn dot(self, o: Vec3x8) -> F32x8 {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// The cross product, in the order of glam's `Vec3::cross`.
    #[inline(always)]
    pub fn cross(self, o: Vec3x8) -> Vec3x8 {
        Vec3x8::new(
            self.y * o.z - o.y * self.z,
            self.z * o.x - o.z * self.x,
            self.x * o.y - o.x * self.y,
        )
    }

    /// Every component times `s`.
    #[inline(always)]
    pub fn scale(self, s: F32x8) -> Vec3x8 {
        Vec3x8::new(self.x * s, self.y * s, self.z * s)
    }

    /// Componentwise product.
    #[inline(always)]
    pub fn times(self, o: Vec3x8) -> Vec3x8 {
        Vec3x8::new(self.x * o.x, self.y * o.y, self.z * o.z)
    }

    /// v · (1/|v|): one division, three products; NaN for the zero vector.
    #[inline(always)]
    pub fn normalized(self) -> Vec3x8 {
        self.scale(F32x8::ONE / self.dot(self).sqrt())
    }

    /// Componentwise absolute value.
    #[inline(always)]
    pub fn abs(self) -> Vec3x8 {
        Vec3x8::new(self.x.abs(), self.y.abs(), self.z.abs())
    }
}

impl Add for Vec3x8 {
    type Output = Vec3x8;
    #[inline(always)]
    fn add(self, o: Vec3x8) -> Vec3x8 {
        Vec3x8::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl Sub for Vec3x8 {
    type Output = Vec3x8;
    #[inline(always)]
    fn sub(self, o: Vec3x8) -> Vec3x8 {
        Vec3x8::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl Neg for Vec3x8 {
    type Output = Vec3x8;
    #[inline(always)]
    fn neg(self) -> Vec3x8 {
        Vec3x8::new(-self.x, -self.y, -self.z)
    }
}
