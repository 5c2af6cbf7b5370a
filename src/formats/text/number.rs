//! Tokens of text formats to numbers.

use crate::diagnostics::quoted;
use glam::DVec3;

/// A finite single-precision number; the error describes the text otherwise.
pub(crate) fn number(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        // `inf` and `nan` parse too, but have no digits.
        Ok(_) if text.bytes().any(|b| b.is_ascii_digit()) => Err(format!(
            "{} is beyond the range of single precision",
            quoted(text)
        )),
        Ok(_) => Err(format!("{} is not a finite number", quoted(text))),
        Err(_) => Err(format!("{} is not a number", quoted(text))),
    }
}

/// The way to read coordinates: they are in double precision if the scene has an origin, which is
/// subtracted first, and else rounded to single precision at once.
pub(crate) fn coordinate(origin: DVec3) -> fn(&str) -> Result<f64, String> {
    if origin == DVec3::ZERO {
        |text| number(text).map(f64::from)
    } else {
        |text| {
            number(text)?;
            text.parse()
                .map_err(|_| format!("{} is not a number", quoted(text)))
        }
    }
}

/// A count or an index; the error describes the text otherwise.
pub(crate) fn count(text: &str) -> Result<u64, String> {
    text.parse::<u64>().map_err(|error| match error.kind() {
        std::num::IntErrorKind::PosOverflow => format!("{} is too large a count", quoted(text)),
        _ => format!("{} is not a whole number from 0 upward", quoted(text)),
    })
}
