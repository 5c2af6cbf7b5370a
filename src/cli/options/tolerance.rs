//! Tolerances for comparing pictures.

use phalanx::jobs::spec::parse_number;

/// Number of pixels that may differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaxDiffering {
    /// Pixels.
    Count(u64),
    /// Share of all pixels, in \[0, 1\].
    Fraction(f64),
}

impl MaxDiffering {
    /// Number of pixels that may differ in a picture of `all` pixels.
    pub fn pixels(self, all: u64) -> u64 {
        match self {
            MaxDiffering::Count(pixels) => pixels,
            MaxDiffering::Fraction(share) => (share * all as f64) as u64,
        }
    }
}

/// Parses a number of pixels, or a share in percent.
pub fn parse_max_differing(text: &str) -> Result<MaxDiffering, String> {
    let expected = "a number of pixels, or a percentage from 0% to 100%, as in 0.1%";
    match text.strip_suffix('%') {
        Some(percent) => parse_number(percent.trim_end(), |p| (0.0..=100.0).contains(p), expected)
            .map(|percent: f64| MaxDiffering::Fraction(percent / 100.0)),
        None => parse_number(text, |_| true, expected).map(MaxDiffering::Count),
    }
}

/// Parses a difference of samples.
pub fn parse_tolerance(text: &str) -> Result<f64, String> {
    let good = |tolerance: &f64| tolerance.is_finite() && *tolerance >= 0.0;
    parse_number(text, good, "a difference of samples, 0 or more, as in 0.5")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_and_shares_are_told_apart() {
        let pixels = |text: &str| parse_max_differing(text).map(|most| most.pixels(2000));
        assert_eq!(pixels("7"), Ok(7));
        assert_eq!(pixels("0.1%"), Ok(2));
        assert_eq!(pixels("100 %"), Ok(2000));
        for wrong in ["-1", "0.5", "%", "101%", "-1%", "NaN%", "ten"] {
            assert!(pixels(wrong).is_err(), "{wrong}");
        }
        for wrong in ["-1", "NaN", "inf", ""] {
            assert!(parse_tolerance(wrong).is_err(), "{wrong}");
        }
        assert_eq!(parse_tolerance("0.5"), Ok(0.5));
    }
}
