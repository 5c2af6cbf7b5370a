//! Khronos PBR Neutral, a tone curve that keeps the base colours of materials.
//!
//! Source: Khronos Group, "PBR Neutral Tone Mapping" (2024), `pbrNeutral.glsl`. Colours whose
//! largest channel is below 0.8 lose only the share that a surface's own reflection at normal
//! incidence adds (0.04 at most); brighter ones are compressed below 1, and their colour fades.

/// Reflection at normal incidence of a material with an index of refraction of 1.5.
const F90: f32 = 0.04;

/// The largest channel from which on colours are compressed.
const START_COMPRESSION: f32 = 0.8 - F90;

/// Speed at which bright colours fade to white.
const DESATURATION: f32 = 0.15;

/// A colour after the curve. NaN and negative values count as 0, as they do without a curve; an
/// infinite value counts as the largest finite one.
///
/// The published terms are joined so that grey is monotone in floats, too: the smallest and the
/// largest channel become `base` and `new_peak` without another rounding.
#[inline]
pub(super) fn neutral(rgb: [f32; 3]) -> [f32; 3] {
    let [r, g, b] = rgb.map(|c| if c > 0.0 { c.min(f32::MAX) } else { 0.0 });
    let least = r.min(g).min(b);
    let base = if least < 2.0 * F90 { least * least / (4.0 * F90) } else { least - F90 };
    let rgb = [r - least + base, g - least + base, b - least + base];
    let peak = rgb[0].max(rgb[1]).max(rgb[2]);
    if peak < START_COMPRESSION {
        return rgb;
    }
    let rest = 1.0 - START_COMPRESSION;
    let new_peak = 1.0 - rest * rest / (peak + rest - START_COMPRESSION);
    let color = 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    rgb.map(|c| new_peak - (peak - c) * (new_peak / peak) * color)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published function, in double precision.
    fn published(rgb: [f64; 3]) -> [f64; 3] {
        let (start, desaturation) = (0.8 - 0.04, 0.15);
        let x = rgb[0].min(rgb[1]).min(rgb[2]);
        let offset = if x < 0.08 { x - 6.25 * x * x } else { 0.04 };
        let color = rgb.map(|c| c - offset);
        let peak = color[0].max(color[1]).max(color[2]);
        if peak < start {
            return color;
        }
        let d = 1.0 - start;
        let new_peak = 1.0 - d * d / (peak + d - start);
        let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
        color.map(|c| c * (new_peak / peak) * (1.0 - g) + new_peak * g)
    }

    /// Values from 2⁻²⁰ to 2²⁰ and 0, denser around 1.
    fn values() -> Vec<f32> {
        let powers = (-20..20).map(|k| f32::from_bits((127 + k) as u32 * (1 << 23)));
        let octaves = powers.flat_map(|power| [1.0, 1.17, 1.4, 1.9].map(|m| m * power));
        let near = (0..80).map(|k| k as f32 / 40.0);
        octaves.chain(near).collect()
    }

    #[test]
    fn colours_are_those_of_the_published_function() {
        let values = values();
        for &r in &values {
            for &g in &values {
                for b in [0.0, 0.03, 0.079, 0.08, 0.081, 0.5, 1.0, 30.0, g] {
                    let got = neutral([r, g, b]);
                    let want = published([r, g, b].map(f64::from));
                    for (got, want) in got.iter().zip(want) {
                        let error = (f64::from(*got) - want).abs();
                        assert!(error < 4e-7, "{r} {g} {b}: {got} {want}");
                    }
                }
            }
        }
    }

    #[test]
    fn grey_is_monotone_and_stays_grey() {
        let mut last = -1.0;
        let steps = (0..4_000_000u32).map(|k| f32::from_bits(k * 300));
        for c in steps.chain([1e30, f32::MAX, f32::INFINITY]) {
            let [r, g, b] = neutral([c; 3]);
            assert!(
                r >= last && r == g && g == b,
                "{c:e}: {r} {g} {b} after {last}"
            );
            assert!((0.0..=1.0).contains(&r), "{c:e}: {r}");
            last = r;
        }
        assert_eq!(last, 1.0);
    }

    /// The hue of HSV: the order of channels, and where the middle one lies between the others.
    #[test]
    fn hue_is_kept_and_bright_colours_fade() {
        for base in [[0.9f32, 0.3, 0.1], [0.2, 0.25, 0.8], [0.0, 1.0, 0.4]] {
            let hue = |[r, g, b]: [f32; 3]| {
                let (least, most) = (r.min(g).min(b), r.max(g).max(b));
                [r, g, b].map(|c| (c - least) / (most - least))
            };
            let mut saturation = 1.0;
            for gain in [0.05, 0.5, 1.0, 2.0, 8.0, 64.0] {
                let rgb = base.map(|c| c * gain);
                let toned = neutral(rgb);
                for (got, want) in hue(toned).iter().zip(hue(rgb)) {
                    assert!((got - want).abs() < 1e-4, "{rgb:?}: {toned:?}");
                }
                let most = toned[0].max(toned[1]).max(toned[2]);
                let least = toned[0].min(toned[1]).min(toned[2]);
                let now = (most - least) / most;
                if gain > 1.0 {
                    assert!(now < saturation, "{rgb:?}: {toned:?}");
                }
                saturation = now;
            }
        }
    }

    #[test]
    fn what_is_no_light_counts_as_black() {
        let black = [0.0; 3];
        for odd in [f32::NAN, -1.0, -0.0, f32::NEG_INFINITY, -1e38] {
            assert_eq!(neutral([odd; 3]), black);
            assert_eq!(neutral([odd, 0.5, 0.2]), neutral([0.0, 0.5, 0.2]));
        }
        let lamp = neutral([f32::INFINITY, 1.0, f32::NAN]);
        assert_eq!(lamp, neutral([f32::MAX, 1.0, 0.0]));
        assert!(lamp.iter().all(|c| (0.99..=1.0).contains(c)), "{lamp:?}");
    }
}
