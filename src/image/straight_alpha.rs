//! Samples of PNG files, with straight alpha if the film has that layer.
//!
//! In a film, alpha is associated: radiance is already weighted by it. In PNG it is straight ("PNG
//! Specification (Third Edition)", 6.2), so colour is divided by alpha before exposure, tone
//! curve, clamp and transfer. Alpha itself gets neither exposure nor transfer.

use super::description::Depth;
use super::encoder::{Encoder, linear_sample, unit};
use phalanx_scene::film::{Aov, Film};
use std::ops::Range;

impl Encoder {
    /// Samples of some rows of a film as a PNG stores them: red, green and blue of each pixel, then
    /// alpha if the film has it.
    pub(super) fn png_samples(&self, film: &Film, rows: Range<usize>, depth: Depth) -> Vec<u8> {
        let width = film.width as usize;
        let pixels = rows.start * width..rows.end * width;
        let planes = film.planes.each_ref().map(|plane| &plane[pixels.clone()]);
        // Opaque pixels keep their colour even if a filter's negative weights give them more.
        let alpha = film.layer(Aov::Alpha).first();
        let alpha = alpha.map(|alpha| alpha[pixels].iter().map(|a| unit(*a)).collect::<Vec<_>>());
        let straight = alpha
            .as_ref()
            .map(|alpha| planes.map(|plane| straighten(plane, alpha)));
        let straight = straight
            .as_ref()
            .map(|planes| planes.each_ref().map(Vec::as_slice));
        let (planes, quantize) = (straight.unwrap_or(planes), self.exposure.encoding.quantize);
        match depth {
            Depth::Standard => with_alpha(self.rgb_8(planes), alpha, |a| {
                linear_sample(a, 255.0, quantize) as u8
            }),
            Depth::Sixteen => {
                let samples = with_alpha(self.rgb_16(planes), alpha, |a| {
                    linear_sample(a, 65_535.0, quantize) as u16
                });
                let bytes: Vec<[u8; 2]> = samples.iter().map(|s| s.to_be_bytes()).collect();
                bytes.into_flattened()
            }
        }
    }
}

/// Radiance divided by alpha. Pixels of alpha 0 show nothing whatever their colour, and become
/// black, which compresses best.
fn straighten(plane: &[f32], alpha: &[f32]) -> Vec<f32> {
    let straight = |(color, alpha): (&f32, &f32)| if *alpha > 0.0 { color / alpha } else { 0.0 };
    plane.iter().zip(alpha).map(straight).collect()
}

/// Adds alpha to the samples of each pixel, if there is any.
fn with_alpha<S: Copy>(rgb: Vec<S>, alpha: Option<Vec<f32>>, sample: impl Fn(f32) -> S) -> Vec<S> {
    let Some(alpha) = alpha else { return rgb };
    let pixels = rgb.as_chunks::<3>().0.iter().zip(alpha);
    let pixels = pixels.map(|(&[r, g, b], a)| [r, g, b, sample(a)]);
    pixels.collect::<Vec<_>>().into_flattened()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Exposure;
    use phalanx_scene::film::Aovs;
    use phalanx_scene::{OutputEncoding, Quantize, Transfer};

    /// Samples of pixels of this radiance and alpha.
    fn samples(
        pixels: &[([f32; 3], f32)],
        (stops, encoding): (f32, OutputEncoding),
        depth: Depth,
    ) -> Vec<u8> {
        let alpha = Aovs::NONE.with(Aov::Alpha);
        let mut film = Film::new(pixels.len() as u32, 1, false).with_aovs(alpha);
        for (k, (rgb, a)) in pixels.iter().enumerate() {
            (0..3).for_each(|c| film.planes[c][k] = rgb[c]);
            film.aov_planes[0][k] = *a;
        }
        let exposure = Exposure {
            stops,
            ..encoding.into()
        };
        Encoder::new(exposure).png_samples(&film, 0..1, depth)
    }

    const FLOOR: OutputEncoding = OutputEncoding {
        transfer: Transfer::None,
        quantize: Quantize::Floor,
    };
    const ROUND: OutputEncoding = OutputEncoding {
        transfer: Transfer::Srgb,
        quantize: Quantize::Round,
    };

    #[test]
    fn colour_is_divided_by_alpha_before_the_transfer() {
        let pixels = [([0.25, 0.05, 0.5], 0.5), ([0.25, 0.05, 0.5], 1.0)];
        let plain = samples(&pixels, (0.0, FLOOR), Depth::Standard);
        assert_eq!(plain, [127, 25, 255, 127, 63, 12, 127, 255]);
        // 0.5 is 187.5 in sRGB, 0.1 is 89.0; 0.25 is 137.0, 0.05 is 63.3.
        let srgb = samples(&pixels, (0.0, ROUND), Depth::Standard);
        assert_eq!(srgb, [188, 89, 255, 128, 137, 63, 188, 255]);
        // Neither an exposure nor the curve changes alpha.
        let dark = samples(&pixels, (-1.0, FLOOR), Depth::Standard);
        assert_eq!(dark, [63, 12, 127, 127, 31, 6, 63, 255]);
        let deep = samples(&pixels[..1], (0.0, FLOOR), Depth::Sixteen);
        let deep: Vec<u16> = deep
            .as_chunks()
            .0
            .iter()
            .map(|s| u16::from_be_bytes(*s))
            .collect();
        assert_eq!(deep, [32_767, 6_553, 65_535, 32_767]);
    }

    #[test]
    fn transparent_pixels_are_black_and_alpha_above_1_is_opaque() {
        let rgb = [0.5, 0.25, f32::INFINITY];
        for nothing in [0.0, -0.0, -0.01, f32::NAN] {
            let got = samples(&[(rgb, nothing)], (0.0, ROUND), Depth::Standard);
            assert_eq!(got, [0; 4], "{nothing}");
        }
        let got = samples(&[(rgb, 1.01)], (0.0, FLOOR), Depth::Standard);
        assert_eq!(got, [127, 63, 255, 255]);
    }
}
