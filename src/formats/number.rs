//! Tokens of text formats to numbers.

use super::report::quoted;

/// A finite single-precision number; the error says what the text is instead.
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

/// A count or an index; the error says what the text is instead.
pub(super) fn count(text: &str) -> Result<u64, String> {
    text.parse::<u64>().map_err(|error| match error.kind() {
        std::num::IntErrorKind::PosOverflow => format!("{} is too large a count", quoted(text)),
        _ => format!("{} is not a whole number from 0 upward", quoted(text)),
    })
}
