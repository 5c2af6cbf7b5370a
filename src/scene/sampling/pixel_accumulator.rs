//! The sum of a pixel's samples, its mean and its variance.

/// Accumulates a pixel's samples. They are added in their order, in f64, because there may be many.
#[derive(Clone, Copy, Debug, Default)]
pub struct PixelAccumulator {
    weighted: [f64; 3],
    weights: f64,
    unweighted: [f64; 3],
    squares: f64,
    count: f64,
}

impl PixelAccumulator {
    /// Adds a sample's radiance and weight.
    #[inline]
    pub fn add(&mut self, rgb: [f32; 3], weight: f32) {
        self.add_share(rgb, weight, 1.0);
    }

    /// Adds a sample that represents a share of the pixel. If all samples are added this way,
    /// shares are counted instead of samples.
    #[inline]
    pub fn add_share(&mut self, rgb: [f32; 3], weight: f32, share: f64) {
        let weight = share * f64::from(weight);
        for (k, c) in rgb.map(f64::from).into_iter().enumerate() {
            self.weighted[k] += weight * c;
            self.unweighted[k] += share * c;
            self.squares += share * (c * c);
        }
        self.weights += weight;
        self.count += share;
    }

    /// Number of samples.
    #[inline]
    pub fn count(&self) -> f64 {
        self.count
    }

    /// The unweighted variance of the samples, over all channels together.
    #[inline]
    pub fn variance(&self) -> f64 {
        let [r, g, b] = self.unweighted.map(|sum| sum / self.count);
        (self.squares / self.count - ((r * r + g * g) + b * b)).max(0.0)
    }

    /// The weighted mean. If the sum of weights is nearly zero, as it may be for a few samples with
    /// negative weights, all samples get equal weights.
    #[inline]
    pub fn mean(&self) -> [f32; 3] {
        if self.weights >= 0.5 * self.count {
            self.weighted.map(|sum| (sum / self.weights) as f32)
        } else {
            self.unweighted.map(|sum| (sum / self.count) as f32)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_what_it_is() {
        for weights in [
            &[1.0; 4][..],
            &[1.1, 0.9, -0.3, 1.2],
            &[1.0, -1.0],
            &[-1.2, -1.1],
        ] {
            let mut pixels = PixelAccumulator::default();
            for &weight in weights {
                pixels.add([0.25, 0.1, 1e30], weight);
            }
            assert_eq!(pixels.mean(), [0.25, 0.1, 1e30], "{weights:?}");
        }
    }
}
