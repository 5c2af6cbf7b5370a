//! Parsers for numeric options.

use phalanx_scene::check_image_size;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Parses a number for which `good` holds; otherwise the message names the expected value.
///
/// # Errors
/// The message.
pub fn parse_number<T: FromStr>(
    text: &str,
    good: impl Fn(&T) -> bool,
    expected: impl Display,
) -> Result<T, String> {
    let number = text.parse().ok().filter(good);
    number.ok_or_else(|| format!("expected {expected}"))
}

/// Parses the size of a picture, `WIDTHxHEIGHT`.
///
/// # Errors
/// The reason why the text is not a valid size.
pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']);
    let sides = sides.and_then(|(w, h)| Some((side(w)?, side(h)?)));
    let (width, height) = sides.ok_or("expected WIDTHxHEIGHT in pixels, as in 640x480")?;
    check_image_size(width, height).map_err(|e| e.to_string())?;
    // Both are within the limits that were just checked.
    Ok((width as u32, height as u32))
}

/// Parses a side of any number of digits. Values beyond u64 become the largest u64, which is out of
/// range as well.
fn side(digits: &str) -> Option<u64> {
    let all_digits = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
    all_digits.then(|| digits.parse().unwrap_or(u64::MAX))
}

/// Parses a number of a range.
pub(super) fn parse_in(text: &str, range: RangeInclusive<u32>) -> Result<u32, String> {
    let expected = format!("{} to {}", range.start(), range.end());
    parse_number(text, |number| range.contains(number), expected)
}

pub(super) fn parse_threshold(text: &str) -> Result<f32, String> {
    let good = |threshold: &f32| (1e-9..=1e3).contains(threshold);
    parse_number(text, good, "a number above 0, as in 0.002")
}

pub(super) fn parse_weight(text: &str) -> Result<f32, String> {
    let good = |weight: &f32| (0.0..1.0).contains(weight);
    let weight = parse_number(text, good, "a number from 0 to less than 1, as in 0.001")?;
    // −0 becomes 0, so that it is shown as 0.
    Ok(weight + 0.0)
}

pub(super) fn parse_aperture(text: &str) -> Result<f32, String> {
    let good = |diameter: &f32| diameter.is_finite() && *diameter >= 0.0;
    parse_number(text, good, "a diameter of at least 0, as in 0.05")
}

pub(super) fn parse_distance(text: &str) -> Result<f32, String> {
    let good = |distance: &f32| distance.is_finite() && *distance > 0.0;
    parse_number(text, good, "a distance greater than 0, as in 2.5")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers_in_range() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        assert_eq!(parse_size("1X65536"), Ok((1, 65_536)));
        for bad in [
            "", "x", "640", "640x", "x480", "-1x5", "+1x5", "1.5x2", "4x4x4", " 4x4", "4*4",
        ] {
            assert!(
                parse_size(bad).unwrap_err().contains("WIDTHxHEIGHT"),
                "{bad}"
            );
        }
        let huge = [
            "0x4",
            "4x0",
            "65537x1",
            "1000000x1000000",
            "99999999999999999999999x1",
        ];
        for bad in huge {
            assert!(
                parse_size(bad).unwrap_err().contains("out of range"),
                "{bad}"
            );
        }
    }

    #[test]
    fn weights_are_from_0_to_less_than_1() {
        let good = [("0", 0.0), ("-0", 0.0), ("1e-9", 1e-9), (".999", 0.999)];
        for (text, weight) in good {
            let parsed = parse_weight(text).map(f32::to_bits);
            assert_eq!(parsed, Ok(f32::to_bits(weight)), "{text}");
        }
        for bad in ["", "1", "-0.1", "nan", "inf", "1%", "0,5"] {
            assert!(parse_weight(bad).is_err(), "{bad}");
        }
    }
}
