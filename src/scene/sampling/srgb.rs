//! The bytes of textures as linear numbers.

use crate::fork_safe_once::ForkSafeOnce;

/// Decoding table of IEC 61966-2-1: computed once in f64 through `libm`, so that every build holds
/// the same bits.
static LINEAR: ForkSafeOnce<[f32; 256]> = ForkSafeOnce::new();

/// The linear value of a number on the sRGB curve. Numbers above 1 follow the same curve.
#[inline]
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        libm::pow((encoded + 0.055) / 1.055, 2.4)
    }
}

/// The linear value, 0 to 1, of each sRGB byte.
#[inline]
pub fn linear_of_srgb() -> &'static [f32; 256] {
    let linear = |byte| srgb_to_linear(byte as f64 / 255.0) as f32;
    LINEAR.get_or_init(|| std::array::from_fn(linear))
}

/// Each byte as a share of 255.
static SHARES: [f32; 256] = {
    let mut shares = [0.0; 256];
    let mut byte = 0;
    while byte < 256 {
        shares[byte] = byte as f32 / 255.0;
        byte += 1;
    }
    shares
};

/// The share of 255 of each byte: the value of pictures that are data, not colours.
#[inline]
pub fn share_of_byte() -> &'static [f32; 256] {
    &SHARES
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        let table = linear_of_srgb();
        assert_eq!((table[0], table[255]), (0.0, 1.0));
        assert!((f64::from(table[188]) - 0.502_886_5).abs() < 1e-6);
        assert!((f64::from(table[10]) - 10.0 / 255.0 / 12.92).abs() < 1e-9);
        assert!(table.windows(2).all(|w| w[0] < w[1]));
        // Pinned bit for bit on every build.
        let bits = table
            .iter()
            .fold(0u32, |h, c| h.rotate_left(5) ^ c.to_bits());
        assert_eq!(bits, 0xa370_148c, "{bits:#x}");
    }
}
