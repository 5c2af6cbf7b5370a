//! Plain messages for the JSON library's errors, which are written for programmers.

use crate::diagnostics::quoted;

const TRAILING_COMMA: &str = "a comma stands before the end of a list or an object";
const TOO_LARGE: &str = "the number is too large";

/// The library's message for a list with rows behind the last one that is read.
const LONG_LIST: &str = "trailing characters";
/// Start of the library's message for a member that an object has twice.
const SECOND_MEMBER: &str = "duplicate field ";

/// The library's message without its line and column.
fn without_place(error: &serde_json::Error) -> String {
    let message = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    message.strip_suffix(&place).unwrap_or(&message).to_owned()
}

/// A message in the terms of the format instead of the library's.
fn plain(error: &serde_json::Error) -> String {
    let message = without_place(error);
    if let Some(member) = message.strip_prefix("missing field ") {
        return format!("it has no {member}");
    }
    if let Some(member) = message.strip_prefix(SECOND_MEMBER) {
        return format!("it has two members {member}");
    }
    let words = match &message[..] {
        "EOF while parsing a list" => "the document ends within a list",
        "EOF while parsing a string" => "the document ends within a text",
        "EOF while parsing an object" => "the document ends within an object",
        "EOF while parsing a value" => "the document ends where a value should stand",
        "expected `:`" => "a colon should stand here, between a name and its value",
        "expected `,` or `]`" => "a comma should stand here, or the end of the list, `]`",
        "expected `,` or `}`" => "a comma should stand here, or the end of the object, `}`",
        "expected ident" | "expected value" => {
            "a value should stand here: an object, a list, a text, a number, true, false or null"
        }
        "key must be a string" => "a name in double quotes should stand here",
        "invalid escape" => "a text has a backslash before a letter that JSON does not escape",
        "invalid number" => "a number is not written as JSON has it",
        "number out of range" => TOO_LARGE,
        "invalid unicode code point" => "a text is not UTF-8",
        "trailing comma" => TRAILING_COMMA,
        LONG_LIST => "something stands behind the end of the document",
        "lone leading surrogate in hex escape" | "unexpected end of hex escape" => {
            "a text has half a letter, as two escapes `\\u` should name it"
        }
        "recursion limit exceeded" => "lists and objects stand too deeply in each other",
        _ if message.starts_with("control character") => {
            "a text has a line break, a tab or another control character that is not escaped"
        }
        _ => "it is not valid JSON",
    };
    words.to_owned()
}

/// Returns true for an error that is found within the value that is at fault: a list has too many
/// rows, or an object two members of a name.
pub(super) fn is_inside_value(error: &serde_json::Error) -> bool {
    let message = without_place(error);
    message == LONG_LIST || message.starts_with(SECOND_MEMBER)
}

/// Message for a fault of the value with this text.
pub(super) fn of_value(error: &serde_json::Error, text: &str) -> String {
    let message = without_place(error);
    if message == LONG_LIST {
        return "it should be a shorter list".to_owned();
    }
    let Some((_, expected)) = message.rsplit_once(", expected ") else {
        return plain(error);
    };
    let wanted = match expected {
        "usize" | "u32" | "u64" => "a whole number",
        "f64" => "a number",
        "a string" => "a text",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        _ => match expected.strip_prefix("an array of length ") {
            Some(length) => &format!("a list of {length} numbers"),
            // A map, or a structure by its name.
            None => "an object",
        },
    };
    match text.parse::<f64>() {
        Ok(number) if wanted == "a whole number" => {
            if number > 0.0 && number.fract() == 0.0 {
                TOO_LARGE.to_owned()
            } else {
                format!(
                    "it should be a whole number from 0 on, not {}",
                    quoted(text)
                )
            }
        }
        _ => wrong_kind(wanted, text),
    }
}

/// Message for a value of another kind, or for a list of another length.
pub(super) fn wrong_kind(wanted: &str, text: &str) -> String {
    let found = match text.as_bytes().first() {
        Some(b'{') => "an object",
        Some(b'[') => "a list",
        Some(b'"') => "a text",
        Some(b't' | b'f') => "true or false",
        Some(b'n') | None => "null",
        Some(_) => "a number",
    };
    if wanted.starts_with(found) {
        format!("it should be {wanted}")
    } else {
        format!("it should be {wanted}, not {found}")
    }
}

/// The offset of a fault in a document, and a message.
pub(super) fn located(json: &[u8], error: &serde_json::Error) -> (usize, String) {
    let at = offset_of(json, error.line(), error.column());
    let ends = matches!(json.get(at), Some(b']' | b'}'));
    if ends && json[..at].trim_ascii_end().ends_with(b",") {
        (at, TRAILING_COMMA.to_owned())
    } else {
        (at, plain(error))
    }
}

/// Offset of a line and column (from 1, in bytes).
fn offset_of(json: &[u8], line: usize, column: usize) -> usize {
    let mut breaks = json.iter().enumerate().filter(|&(_, &byte)| byte == b'\n');
    let start = match line.checked_sub(2) {
        Some(nth) => breaks.nth(nth).map_or(json.len(), |(at, _)| at + 1),
        None => 0,
    };
    (start + column.saturating_sub(1)).min(json.len())
}
