//! One NaN for all processors.

use super::TileBuffer;

/// The NaN of pixels without a value, as x86-64 makes it. Its sign and payload are left open by
/// IEEE 754: ARM clears the sign, and WebAssembly promises nothing.
const PIXEL_NAN: f32 = f32::from_bits(0xffc0_0000);

impl TileBuffer {
    /// Gives every NaN the same bits, so that a picture has the same bytes on every processor. A
    /// light too bright for single precision makes NaN where a black surface reflects it.
    pub fn unify_nans(&mut self) {
        let whole = self.aovs.channels().map(|(_, whole)| whole);
        // Whole numbers lie in planes as their bits, which may be those of a NaN.
        let aov_planes = self.aov_planes.iter_mut().zip(whole);
        let aov_planes = aov_planes.filter_map(|(plane, whole)| (!whole).then_some(plane));
        for plane in self.planes.iter_mut().chain(aov_planes) {
            for value in plane {
                *value = if value.is_nan() { PIXEL_NAN } else { *value };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Aov, Aovs, NO_ID, Tile};

    #[test]
    fn every_nan_has_the_same_bits_and_other_values_keep_theirs() {
        let (tile, aovs) = (Tile::whole(8, 1), Aovs::default().with(Aov::Depth));
        let aovs = aovs.with(Aov::Primitive);
        let mut pixels = TileBuffer::new(false).with_aovs(aovs);
        pixels.fit(tile);
        let values = [f32::NAN, -f32::NAN, f32::from_bits(0x7f80_0001), -0.0];
        for (x, value) in values.into_iter().enumerate() {
            pixels.set(x as u32, 0, [value, 1.0, f32::INFINITY]);
            pixels.set_layer(x as u32, 0, Aov::Depth, &[value]);
            pixels.set_layer(x as u32, 0, Aov::Primitive, &[f32::from_bits(NO_ID)]);
        }
        pixels.unify_nans();
        let planes = pixels.planes();
        for plane in [planes[0], planes[3]] {
            let bits: Vec<u32> = plane[..4].iter().map(|value| value.to_bits()).collect();
            assert_eq!(bits, [0xffc0_0000, 0xffc0_0000, 0xffc0_0000, 0x8000_0000]);
        }
        assert_eq!(planes[2][..4], [f32::INFINITY; 4]);
        assert!(planes[4][..4].iter().all(|id| id.to_bits() == NO_ID));
    }
}
