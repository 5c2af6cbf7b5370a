//! Parses numbers at a position of a text: correctly rounded, and fast for the numbers of few
//! digits that are typical of mesh files.

use fast_float2::FastFloat;
use std::ops::Neg;

/// Number of decimal digits that always fit a `u64`.
const DIGITS: usize = 19;
/// Integers up to here are exact in f64.
const EXACT: u64 = 1 << 53;
/// Powers of ten that are exact in f64.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// The number at `offset`, and the position where it ends: `offset` itself if there is none. `nan`,
/// `inf` and numbers too large for f32 are returned as such.
#[inline]
pub(crate) fn float(text: &[u8], offset: usize) -> (f32, usize) {
    let negative = text.get(offset) == Some(&b'-');
    let start = offset + usize::from(negative || text.get(offset) == Some(&b'+'));
    let (mut mantissa, mut i) = digits(text, start, 0);
    let mut count = i - start;
    let mut scale = 0;
    if text.get(i) == Some(&b'.') {
        let point = i;
        (mantissa, i) = digits(text, point + 1, mantissa);
        scale = i - point - 1;
        count += scale;
    }
    let exponent = matches!(text.get(i), Some(b'e' | b'E'));
    if count == 0 || count > DIGITS || mantissa > EXACT || scale >= POWERS.len() || exponent {
        return uncommon(text, offset);
    }
    // Both are exact, so the quotient is the f64 nearest to the number. Rounding that to f32 goes
    // wrong in only two cases: it is half-way between two f32s and the number is not exactly there,
    // or it is below f32's normal numbers.
    let wide = mantissa as f64 / POWERS[scale];
    let half_way = wide.to_bits() & 0x1fff_ffff == 0x1000_0000;
    if half_way || (wide < f64::from(f32::MIN_POSITIVE) && mantissa != 0) {
        return uncommon(text, offset);
    }
    let value = wide as f32;
    (if negative { -value } else { value }, i)
}

/// The number and its end as [`float`] returns them, in double precision.
#[inline]
pub(crate) fn double(text: &[u8], offset: usize) -> (f64, usize) {
    parsed(text, offset)
}

/// Continues `value` with the digits from `offset`. It wraps if there are too many.
#[inline(always)]
fn digits(text: &[u8], offset: usize, mut value: u64) -> (u64, usize) {
    let mut i = offset;
    while let Some(digit) = text
        .get(i)
        .map(|b| b.wrapping_sub(b'0'))
        .filter(|d| *d < 10)
    {
        value = value.wrapping_mul(10).wrapping_add(u64::from(digit));
        i += 1;
    }
    (value, i)
}

/// Handles exponents, many digits, and numbers that are not finite.
#[cold]
fn uncommon(text: &[u8], offset: usize) -> (f32, usize) {
    parsed(text, offset)
}

fn parsed<T: FastFloat + Default + Neg<Output = T>>(text: &[u8], offset: usize) -> (T, usize) {
    let sign = text.get(offset).filter(|sign| matches!(sign, b'+' | b'-'));
    let start = offset + usize::from(sign.is_some());
    let rest = text.get(start..).unwrap_or_default();
    match fast_float2::parse_partial::<T, _>(rest) {
        // A second sign is no part of a number.
        Ok((value, length)) if length > 0 && !matches!(rest[0], b'+' | b'-') => {
            let value = if sign == Some(&b'-') { -value } else { value };
            (value, start + length)
        }
        _ => (T::default(), offset),
    }
}

/// A number that is not finite, as the C libraries of several systems print it, and the position
/// where it ends: `nan`, `-nan(ind)`, `1.#QNAN0`, `-1.#IND`, `1.#INF00`, `infinity`.
#[cold]
pub(crate) fn not_finite(text: &[u8], offset: usize) -> Option<(f32, usize)> {
    let sign = text.get(offset).filter(|sign| matches!(sign, b'+' | b'-'));
    let start = offset + usize::from(sign.is_some());
    let rest = text.get(start..)?;
    let word = |from: &[u8]| {
        from.iter()
            .take_while(|b| b.is_ascii_alphanumeric())
            .count()
    };
    let begins = |name: &[u8]| {
        let head = rest.get(..name.len());
        head.is_some_and(|head| head.eq_ignore_ascii_case(name))
    };
    let (value, length) = match rest {
        [b'1', b'.', b'#', kind @ ..] => {
            let length = word(kind);
            (special_value(&kind[..length])?, 3 + length)
        }
        _ if begins(b"nan") => {
            let length = word(rest);
            let note = rest[length..].strip_prefix(b"(");
            let note = note
                .map(word)
                .filter(|n| rest.get(length + 1 + n) == Some(&b')'));
            (f32::NAN, length + note.map_or(0, |n| n + 2))
        }
        _ if begins(b"inf") => (f32::INFINITY, word(rest)),
        _ => return None,
    };
    let negative = sign == Some(&b'-');
    Some((if negative { -value } else { value }, start + length))
}

/// The number that the C library of Visual C++ prints as `1.#` and this word, perhaps with zeros.
fn special_value(word: &[u8]) -> Option<f32> {
    let zeros = word.iter().rev().take_while(|&&byte| byte == b'0').count();
    let kind = word[..word.len() - zeros].to_ascii_lowercase();
    match &kind[..] {
        b"inf" => Some(f32::INFINITY),
        // With few digits, only one letter of the kind remains.
        b"qnan" | b"snan" | b"ind" | b"j" | b"r" => Some(f32::NAN),
        _ => None,
    }
}

/// The whole number at `offset`, and the position where it ends: `offset` itself if there is none.
/// Numbers beyond ±10¹⁸ are clamped to it.
#[inline]
pub(crate) fn integer(text: &[u8], offset: usize) -> (i64, usize) {
    let negative = text.get(offset) == Some(&b'-');
    let start = offset + usize::from(negative || text.get(offset) == Some(&b'+'));
    let (value, end) = digits(text, start, 0);
    let most = 1_000_000_000_000_000_000;
    let value = match end - start {
        0 => return (0, offset),
        1..=18 => value as i64,
        _ => most,
    };
    (if negative { -value } else { value }, end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str) {
        let expected: f32 = text.trim_start_matches('+').parse().unwrap();
        let (value, end) = float(text.as_bytes(), 0);
        assert_eq!(
            (value.to_bits(), end),
            (expected.to_bits(), text.len()),
            "{text}"
        );
        let embedded = format!("v {text} 5");
        assert_eq!(
            float(embedded.as_bytes(), 2),
            (value, 2 + text.len()),
            "{text}"
        );
    }

    #[test]
    fn numbers_are_rounded_as_the_standard_library_rounds_them() {
        for text in [
            "0",
            "-0",
            "+1",
            "1.",
            ".5",
            "-.5e1",
            "1e-46",
            "1e-45",
            "1.17549430e-38",
            "0.00000000000000001",
            "16777217",
            "16777217.0000001",
            "33554433",
            "1.00000005960464477539",
            "1.000000059604644775390625",
            "1.0000000596046447753906251",
            "3.4028235677973366e38",
            "340282350000000000000000000000000000000",
            "1e30",
            "9007199254740993",
            "-0.35444599999999998",
            "1E5",
            "1e+5",
            "00000000000000000000001.5",
            "0.1",
        ] {
            check(text);
        }
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        for _ in 0..200_000 {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let (mantissa, scale) = (state >> (state & 63), (state >> 40) as usize % 24);
            let all = format!("{mantissa:024}");
            let (integer, fraction) = all.split_at(24 - scale);
            let integer = integer.trim_start_matches('0');
            let integer = if integer.is_empty() && fraction.is_empty() { "0" } else { integer };
            check(
                &format!("{integer}.{fraction}")
                    .replace(".", if fraction.is_empty() { "" } else { "." }),
            );
            let f = f32::from_bits(state as u32);
            if f.is_finite() {
                check(&format!("{f}"));
                check(&format!("{f:e}"));
                // Half-way to the next one.
                check(&format!(
                    "{:.30}",
                    (f64::from(f) + f64::from(f.next_up())) / 2.0
                ));
            }
        }
    }

    #[test]
    fn what_is_no_number_ends_where_it_begins() {
        for text in ["", "x", "-", "+", ".", "--1", "+-1", "e5", "/"] {
            assert_eq!(float(text.as_bytes(), 0).1, 0, "{text}");
            assert_eq!(integer(text.as_bytes(), 0).1, 0, "{text}");
        }
        assert!(float(b"nan", 0).0.is_nan());
        assert_eq!(float(b"-inf", 0), (f32::NEG_INFINITY, 4));
        assert_eq!(float(b"1e39 ", 0), (f32::INFINITY, 4));
        assert_eq!(float(b"1.5x", 0), (1.5, 3));
    }

    #[test]
    fn doubles_end_where_floats_do() {
        for text in [
            "500000.31",
            "-4012345.125",
            "+1.",
            ".5",
            "1e-5x",
            "nan",
            "-inf",
            "1e39 ",
            "",
            "x",
            "-",
            "+",
            ".",
            "--1",
            "+-1",
            "e5",
            "/",
            "0.1\\",
            "12#",
        ] {
            let (single, end) = float(text.as_bytes(), 0);
            let (double, double_end) = double(text.as_bytes(), 0);
            assert_eq!(end, double_end, "{text}");
            assert_eq!((double as f32).to_bits(), single.to_bits(), "{text}");
        }
        assert_eq!(double(b"v 500000.31", 2), (500_000.31, 11));
    }

    #[test]
    fn every_spelling_of_what_is_not_finite_is_read_to_its_end() {
        for text in [
            "nan",
            "NaN",
            "-nan",
            "+NAN",
            "nan(ind)",
            "-nan(ind)",
            "nan(snan)",
            "nan(0x7fffff)",
            "NaNQ",
            "1.#QNAN",
            "-1.#QNAN0",
            "1.#SNAN",
            "-1.#IND",
            "-1.#IND00",
            "1.#J",
            "1.#R",
        ] {
            let (value, end) = not_finite(text.as_bytes(), 0).unwrap();
            assert!(
                value.is_nan() && end == text.len(),
                "{text}: {value}, {end}"
            );
        }
        for text in ["inf", "+Inf", "INFINITY", "1.#INF", "1.#INF00", "1.#inf"] {
            let value = not_finite(format!("v {text} 2").as_bytes(), 2);
            assert_eq!(value, Some((f32::INFINITY, 2 + text.len())), "{text}");
            let negative = not_finite(format!("-{}", text.trim_start_matches('+')).as_bytes(), 0);
            assert_eq!(negative.map(|n| n.0), Some(f32::NEG_INFINITY));
        }
        for text in [
            "1.5",
            "1.",
            "",
            "-",
            "x",
            "na",
            "in",
            "1.Q",
            "1.#c",
            "1.#",
            "1.#Infinite",
        ] {
            assert_eq!(not_finite(text.as_bytes(), 0), None, "{text}");
        }
        assert_eq!(
            not_finite(b"nan(ind x", 0).map(|n| n.1),
            Some(3),
            "an open parenthesis is no part"
        );
    }

    #[test]
    fn integers_saturate() {
        assert_eq!(integer(b"x-12/", 1), (-12, 4));
        assert_eq!(integer(b"+7", 0), (7, 2));
        assert_eq!(
            integer(b"99999999999999999999999", 0).0,
            1_000_000_000_000_000_000
        );
        assert_eq!(
            integer(b"-99999999999999999999999", 0).0,
            -1_000_000_000_000_000_000
        );
    }
}
