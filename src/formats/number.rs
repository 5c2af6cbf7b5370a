//! Tokens of text formats to numbers.

use super::diagnostics::quoted;

/// A finite single-precision number; the error describes the text otherwise.
pub(super) fn number(text: &str) -> Result<f32, String> {
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

/// A number of [`number`] in double precision, and not rounded to single precision first.
pub(super) fn double(text: &str) -> Result<f64, String> {
    number(text)?;
    text.parse()
        .map_err(|_| format!("{} is not a number", quoted(text)))
}

/// A number of [`number`], widened.
pub(super) fn widened(text: &str) -> Result<f64, String> {
    number(text).map(f64::from)
}

/// A count or an index; the error describes the text otherwise.
pub(super) fn count(text: &str) -> Result<u64, String> {
    text.parse::<u64>().map_err(|error| match error.kind() {
        std::num::IntErrorKind::PosOverflow => format!("{} is too large a count", quoted(text)),
        _ => format!("{} is not a whole number from 0 upward", quoted(text)),
    })
}
