//! Comparison of two pictures.

use super::encoder::Picture;
use super::png::Raster;

/// Differences of two pictures of one size, in steps of an 8-bit sample: 16-bit files give
/// fractions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// True if every sample is equal.
    pub exact: bool,
    /// Largest difference of a sample, 0 to 255.
    pub largest: f64,
    /// Root mean square difference over the red, green and blue samples.
    pub rmse: f64,
    /// Pixels with a sample that differs.
    pub differing: u64,
    /// Share of the pixels that differ, in \[0, 1\].
    pub share: f64,
}

/// Pictures of different sizes cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the pictures differ in size: {}x{} and {}x{}", .0.0, .0.1, .1.0, .1.1)]
pub struct DifferentSizes(pub (u32, u32), pub (u32, u32));

/// 16-bit steps in one 8-bit step.
const STEP: f64 = 257.0;

/// Compares two pictures, alpha included. The RMSE leaves alpha out, as opaque pictures would
/// dilute it.
///
/// # Errors
/// [`DifferentSizes`].
pub fn compare(a: &Raster, b: &Raster) -> Result<Comparison, DifferentSizes> {
    check_sizes(a, b)?;
    let (mut largest, mut differing, mut squares) = (0, 0, 0u64);
    for (p, q) in a.pixels.iter().zip(&b.pixels) {
        let most = largest_difference(p, q);
        largest = largest.max(most);
        differing += u64::from(most > 0);
        // Exact, and within u64 for the largest image: 3 · 2^28 · 65535² < 2^62.
        let square = |(s, t): (&u16, &u16)| u64::from(s.abs_diff(*t)).pow(2);
        squares += p[..3].iter().zip(&q[..3]).map(square).sum::<u64>();
    }
    let pixels = a.pixels.len().max(1) as f64;
    Ok(Comparison {
        exact: differing == 0,
        largest: f64::from(largest) / STEP,
        rmse: (squares as f64 / (3.0 * pixels)).sqrt() / STEP,
        differing,
        share: differing as f64 / pixels,
    })
}

/// A picture of the differences: black where the two are equal, then from dark red over yellow to
/// white.
///
/// # Errors
/// [`DifferentSizes`].
pub fn heat(a: &Raster, b: &Raster) -> Result<Picture, DifferentSizes> {
    check_sizes(a, b)?;
    let mut rgb = Vec::with_capacity(3 * a.pixels.len());
    for (p, q) in a.pixels.iter().zip(&b.pixels) {
        rgb.extend(ramp(f64::from(largest_difference(p, q)) / STEP));
    }
    Ok(Picture {
        width: a.width,
        height: a.height,
        rgb,
    })
}

fn check_sizes(a: &Raster, b: &Raster) -> Result<(), DifferentSizes> {
    let (size_a, size_b) = ((a.width, a.height), (b.width, b.height));
    if size_a == size_b {
        Ok(())
    } else {
        Err(DifferentSizes(size_a, size_b))
    }
}

fn largest_difference(p: &[u16; 4], q: &[u16; 4]) -> u16 {
    let differences = p.iter().zip(q).map(|(s, t)| s.abs_diff(*t));
    differences.max().unwrap_or(0)
}

/// Colour of a difference of 0 to 255: the square root lifts small ones, and one step is already
/// visible.
fn ramp(difference: f64) -> [u8; 3] {
    if difference <= 0.0 {
        return [0, 0, 0];
    }
    const FLOOR: f64 = 0.15;
    let heat = FLOOR + (1.0 - FLOOR) * (difference / 255.0).sqrt();
    // Three thirds: red rises, then green, then blue.
    [0.0, 1.0, 2.0].map(|third| ((3.0 * heat - third).clamp(0.0, 1.0) * 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, samples: &[u16]) -> Raster {
        let pixels: Vec<_> = samples.iter().map(|&s| [s, s, s, 65_535]).collect();
        Raster {
            width,
            height: pixels.len() as u32 / width,
            pixels,
        }
    }

    #[test]
    fn equal_pictures_are_exact() {
        let a = grey(2, &[0, 257, 514, 65_535]);
        let got = compare(&a, &a).unwrap();
        let nothing = Comparison {
            exact: true,
            largest: 0.0,
            rmse: 0.0,
            differing: 0,
            share: 0.0,
        };
        assert_eq!(got, nothing);
        assert_eq!(heat(&a, &a).unwrap().rgb, [0; 12]);
    }

    #[test]
    fn differences_are_measured_in_eight_bit_steps() {
        let a = grey(2, &[0, 257 * 10, 257 * 20, 257 * 30]);
        let mut b = a.clone();
        b.pixels[1][0] = 257 * 13; // red by 3
        b.pixels[2][2] = 257 * 16; // blue by 4
        let got = compare(&a, &b).unwrap();
        assert_eq!(
            (got.exact, got.largest, got.differing, got.share),
            (false, 4.0, 2, 0.5)
        );
        assert!((got.rmse - (25.0f64 / 12.0).sqrt()).abs() < 1e-12);
        assert_eq!(compare(&b, &a).unwrap(), got);
    }

    #[test]
    fn one_step_of_sixteen_bits_and_of_alpha_counts() {
        let a = grey(1, &[1000, 1000]);
        let mut b = a.clone();
        b.pixels[0][1] += 1;
        assert!(!compare(&a, &b).unwrap().exact);
        let mut b = a.clone();
        b.pixels[1][3] = 65_535 - 257;
        let got = compare(&a, &b).unwrap();
        assert_eq!((got.exact, got.largest, got.differing), (false, 1.0, 1));
    }

    #[test]
    fn sizes_must_agree() {
        let (a, b) = (grey(2, &[0; 4]), grey(4, &[0; 4]));
        let expected = DifferentSizes((2, 2), (4, 1));
        assert_eq!(compare(&a, &b).unwrap_err(), expected);
        assert_eq!(heat(&a, &b).unwrap_err(), expected);
        assert_eq!(
            expected.to_string(),
            "the pictures differ in size: 2x2 and 4x1"
        );
    }

    #[test]
    fn heat_rises_from_black_over_red_and_yellow_to_white() {
        assert_eq!(ramp(0.0), [0, 0, 0]);
        let [r, g, b] = ramp(1.0);
        assert!(r > 100 && g == 0 && b == 0, "one step is visible: {r}");
        assert_eq!(ramp(255.0), [255, 255, 255]);
        let brightness = |d| ramp(d).iter().map(|&c| u32::from(c)).sum::<u32>();
        assert!((1..255).all(|d| brightness(d.into()) <= brightness((d + 1).into())));
    }
}
