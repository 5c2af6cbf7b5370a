//! The surfaces visible in a pixel, and the share of the pixel that each of them covers.

/// Number of ranks of a pixel: the surfaces that cover most of it.
pub const RANKS: usize = 6;

/// Part of a camera ray that ends on a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceShare {
    /// Identifiers of the object and of the material: see [`MatteIds`](crate::MatteIds).
    pub ids: [u32; 2],
    /// The share, greater than 0. It is 1 for an opaque surface; the shares of a ray add up to 1 if
    /// nothing of it reaches the background.
    pub share: f32,
}

/// A sum over samples, with their weights and without.
#[derive(Clone, Copy, Debug, Default)]
struct TwoSums {
    weighted: f64,
    unweighted: f64,
}

/// Accumulates the surfaces of a pixel's samples, as
/// [`PixelAccumulator`](super::PixelAccumulator) does their radiance, with the same weights.
#[derive(Clone, Debug, Default)]
pub struct PixelCoverage {
    /// Sums by identifier, of objects and of materials.
    ids: [Vec<(u32, TwoSums)>; 2],
    all: TwoSums,
    weights: f64,
    count: f64,
}

impl PixelCoverage {
    /// Removes all samples.
    #[inline]
    pub fn clear(&mut self) {
        let [objects, materials] = &mut self.ids;
        objects.clear();
        materials.clear();
        (self.all, self.weights, self.count) = (TwoSums::default(), 0.0, 0.0);
    }

    /// Adds the surfaces of a sample that stands for a share of the pixel.
    pub fn add(
        &mut self,
        surfaces: impl IntoIterator<Item = SurfaceShare>,
        weight: f32,
        share: f64,
    ) {
        let weight = share * f64::from(weight);
        self.weights += weight;
        self.count += share;
        for surface in surfaces {
            let part = f64::from(surface.share);
            let add = |sums: &mut TwoSums| {
                sums.weighted += weight * part;
                sums.unweighted += share * part;
            };
            add(&mut self.all);
            for (sums, id) in self.ids.iter_mut().zip(surface.ids) {
                match sums.iter_mut().find(|(other, _)| *other == id) {
                    Some((_, sums)) => add(sums),
                    None => {
                        let mut first = TwoSums::default();
                        add(&mut first);
                        sums.push((id, first));
                    }
                }
            }
        }
    }

    /// The mean of a sum, by the rule of radiance.
    fn mean(&self, sums: &TwoSums) -> f32 {
        if self.weights >= 0.5 * self.count {
            (sums.weighted / self.weights) as f32
        } else {
            (sums.unweighted / self.count) as f32
        }
    }

    /// The part of the pixel that is not background. A filter with negative weights may leave it a
    /// little below 0 or above 1, as it does with radiance.
    #[inline]
    pub fn alpha(&self) -> f32 {
        self.mean(&self.all)
    }

    /// Identifiers of objects (`table` 0) or materials (1), each followed by the part of the pixel
    /// that it covers, the largest first; zeros after the last.
    pub fn ranks(&self, table: usize) -> [f32; 2 * RANKS] {
        let sums = self.ids[table].iter();
        let means = sums.map(|(id, sums)| (*id, self.mean(sums).min(1.0)));
        let mut means: Vec<(u32, f32)> = means.filter(|(_, mean)| *mean > 0.0).collect();
        means.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut ranks = [0.0; 2 * RANKS];
        for (rank, (id, mean)) in ranks.as_chunks_mut::<2>().0.iter_mut().zip(means) {
            *rank = [f32::from_bits(id), mean];
        }
        ranks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(object: u32, share: f32) -> SurfaceShare {
        SurfaceShare {
            ids: [object, 7],
            share,
        }
    }

    #[test]
    fn parts_are_weighed_and_ranked() {
        let mut pixel = PixelCoverage::default();
        pixel.add([surface(3, 1.0)], 1.0, 1.0);
        pixel.add([surface(2, 0.25), surface(3, 0.5)], 1.0, 1.0);
        pixel.add([surface(1, 0.25)], 1.0, 1.0);
        pixel.add([], 1.0, 1.0);
        assert_eq!(pixel.alpha(), 0.5);
        let pairs = |ranks: [f32; 12]| ranks.as_chunks::<2>().0.to_vec();
        let id = f32::from_bits;
        // Equal parts are in the order of their identifiers.
        let objects = [[id(3), 0.375], [id(1), 0.0625], [id(2), 0.0625]];
        let rest = [[0.0; 2]; 3];
        assert_eq!(pairs(pixel.ranks(0)), [objects, rest].concat());
        assert_eq!(pairs(pixel.ranks(1))[..2], [[id(7), 0.5], [0.0; 2]]);
        pixel.clear();
        for (object, weight) in (1..9).zip([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, -1.0]) {
            pixel.add([surface(object, 1.0)], weight, 0.5);
        }
        let ranks = pairs(pixel.ranks(0));
        let ids: Vec<u32> = ranks.iter().map(|rank| rank[0].to_bits()).collect();
        assert_eq!(ids, [7, 6, 5, 4, 3, 2]);
        assert_eq!(ranks[0][1], (7.0f64 / 27.0) as f32);
        assert_eq!(pixel.alpha(), 1.0);
        // Where weights nearly cancel, samples count alike.
        pixel.clear();
        pixel.add([surface(1, 1.0)], 1.0, 1.0);
        pixel.add([], -1.0, 1.0);
        assert_eq!(pixel.alpha(), 0.5);
    }
}
