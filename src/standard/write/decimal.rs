//! Numbers as text.

use glam::DVec3;
use std::fmt;
use std::io::Write;

/// A number as the shortest text that reads back to its single-precision value.
pub(super) struct Decimal(pub(super) f64);

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = self.0 as f32;
        let size = number.abs();
        if let Some(text) = fast_text(number, &mut zmij::Buffer::new()) {
            f.write_str(text)
        } else if size != 0.0 && !(1e-5..1e16).contains(&size) {
            write!(f, "{number:e}")
        } else {
            write!(f, "{number}")
        }
    }
}

/// The text of the standard library, several times as fast, for most numbers.
///
/// Where two shortest texts are equally near, the standard library rounds up and zmij to even.
/// Such a number of p decimals is an odd multiple of 2^-(p+1), and as its 9 digits at most are half
/// of a multiple of 5^p, p is at most 13.
fn fast_text(number: f32, buffer: &mut zmij::Buffer) -> Option<&str> {
    let scaled = number * (1 << 14) as f32;
    let fast = (1e-5..1e12).contains(&number.abs()) && scaled != scaled.trunc();
    fast.then(|| buffer.format_finite(number))
}

/// Three numbers with spaces between them.
pub(super) struct Decimals(pub(super) DVec3);

impl fmt::Display for Decimals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let DVec3 { x, y, z } = self.0;
        write!(f, "{} {} {}", Decimal(x), Decimal(y), Decimal(z))
    }
}

/// Appends a vector as [`Decimals`] does.
pub(super) fn push_vector(out: &mut Vec<u8>, vector: DVec3) {
    let mut buffer = zmij::Buffer::new();
    for (axis, number) in vector.to_array().into_iter().enumerate() {
        if axis > 0 {
            out.push(b' ');
        }
        push(out, number, &mut buffer);
    }
}

fn push(out: &mut Vec<u8>, number: f64, buffer: &mut zmij::Buffer) {
    match fast_text(number as f32, buffer) {
        Some(text) => out.extend_from_slice(text.as_bytes()),
        // A vector takes any number of bytes.
        None => drop(write!(out, "{}", Decimal(number))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_those_of_the_standard_library() {
        // All exponents and signs, with mantissas spread evenly; and short binary fractions.
        let spread = (0..=u32::MAX).step_by(4099).map(f32::from_bits);
        let short = (1..1 << 20).map(|k| k as f32 / (1 << 14) as f32);
        for number in spread.chain(short) {
            let size = number.abs();
            let usual = if size != 0.0 && !(1e-5..1e16).contains(&size) {
                format!("{number:e}")
            } else {
                number.to_string()
            };
            let mut bytes = Vec::new();
            push_vector(&mut bytes, DVec3::new(f64::from(number), 0.5, -3.0));
            assert_eq!(String::from_utf8(bytes).unwrap(), format!("{usual} 0.5 -3"));
            assert_eq!(Decimal(f64::from(number)).to_string(), usual);
        }
    }
}
