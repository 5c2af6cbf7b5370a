//! Metallic-roughness materials as the document's Kd, Ks and s, and a highlight without a mirror:
//! one rule for readers, which convert what is constant, and for both engines, which convert what
//! varies over a surface.

/// Roughness from which on nothing is mirrored.
const MATT: f32 = 0.5;
/// Largest Blinn exponent.
const SHARPEST: f32 = 10_000.0;

/// How a surface reflects: like a metal or not, and how roughly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetallicRoughness {
    /// Share that reflects like a metal, in its colour, 0 to 1.
    pub metallic: f32,
    /// Roughness of the mirror image, 0 to 1.
    pub roughness: f32,
}

/// Effect of metallic and roughness on a material whose Kd is its base colour and whose Ks is the
/// reflectance of its non-metal part: Kd·(1 − metal), Ks·dielectric + Kd·metal, Ks·highlight for
/// lamps alone, and the exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeWeights<const N: usize> {
    /// Weight of the base colour in Ks: metallic times gloss.
    pub metal: [f32; N],
    /// Weight of the non-metal reflectance in Ks.
    pub dielectric: [f32; N],
    /// Weight of the non-metal reflectance in the highlight: 1 − metallic. The rough share of metal
    /// is diffuse already.
    pub highlight: [f32; N],
    /// Blinn exponent.
    pub shininess: [f32; N],
}

impl<const N: usize> LobeWeights<N> {
    /// The weights at N points. Numbers beyond 0 to 1 count as the nearer of these.
    ///
    /// The weight of the mirror image, gloss g = max(0, 1 − 2r)², is 1 for a polished surface and 0
    /// from roughness 0.5 on, because Ks weighs a perfect mirror. The exponent 2/r⁴ − 2 has a lobe
    /// as wide as that of α = r² (Karis, "Specular BRDF Reference", 2013).
    #[inline]
    pub fn of(metallic: [f32; N], roughness: [f32; N]) -> LobeWeights<N> {
        let share = |x: f32| x.clamp(0.0, 1.0);
        let gloss = roughness.map(|r| {
            let left = (1.0 - share(r) / MATT).max(0.0);
            left * left
        });
        LobeWeights {
            metal: std::array::from_fn(|k| share(metallic[k]) * gloss[k]),
            dielectric: std::array::from_fn(|k| (1.0 - share(metallic[k])) * gloss[k]),
            highlight: metallic.map(|m| 1.0 - share(m)),
            shininess: roughness.map(|r| {
                let alpha = share(r) * share(r);
                (2.0 / (alpha * alpha) - 2.0).clamp(0.0, SHARPEST)
            }),
        }
    }
}
