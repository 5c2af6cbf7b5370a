//! Samples as shares of a screen's brightness.

use super::super::read::SampleKind;
use phalanx_scene::sampling::srgb_to_linear;

/// A sample as shown on a screen, in \[0, 1\]: radiance with the sRGB curve applied, clamped, and
/// NaN as black.
pub(super) fn on_screen(kind: SampleKind, bits: u32) -> f64 {
    let value = kind.value(bits);
    match kind {
        SampleKind::Display => value / 255.0,
        SampleKind::Float | SampleKind::Integer => linear_to_srgb(unit(value)),
    }
}

/// The linear brightness of a sample on a screen, in \[0, 1\].
pub(super) fn linear_on_screen(kind: SampleKind, bits: u32) -> f64 {
    let value = kind.value(bits);
    match kind {
        SampleKind::Display => srgb_to_linear(value / 255.0),
        SampleKind::Float | SampleKind::Integer => unit(value),
    }
}

/// Alpha of opaque pixels of pictures for a screen.
pub(super) const OPAQUE: u32 = u16::MAX as u32;

/// A sample for a screen with this straight alpha over black, blended as screens do, without
/// regard to the curve.
pub(super) fn over_black(sample: u32, alpha: u32) -> u32 {
    (sample * alpha + OPAQUE / 2) / OPAQUE
}

/// Clamped to \[0, 1\]; NaN gives 0.
pub(super) fn unit(value: f64) -> f64 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// Encoded value of a linear one in \[0, 1\], by IEC 61966-2-1.
fn linear_to_srgb(linear: f64) -> f64 {
    match linear {
        dark if dark <= 0.003_130_8 => 12.92 * dark,
        light => 1.055 * libm::pow(light, 1.0 / 2.4) - 0.055,
    }
}
