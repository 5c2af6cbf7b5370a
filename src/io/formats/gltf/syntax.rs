//! Words for the JSON library's errors, which are written for programmers.

const TRAILING_COMMA: &str = "a comma stands before the end of a list or an object";

/// The parser's words about a fault, and those for a user.
const WORDS: [(&str, &str); 21] = [
    (
        "EOF while parsing a list",
        "the document ends within a list",
    ),
    (
        "EOF while parsing a string",
        "the document ends within a text",
    ),
    (
        "EOF while parsing an object",
        "the document ends within an object",
    ),
    (
        "EOF while parsing a value",
        "the document ends where a value should stand",
    ),
    (
        "expected `:`",
        "a colon should stand here, between a name and its value",
    ),
    (
        "expected `,` or `]`",
        "a comma should stand here, or the end of the list, `]`",
    ),
    (
        "expected `,` or `}`",
        "a comma should stand here, or the end of the object, `}`",
    ),
    (
        "expected ident",
        "a value should stand here: an object, a list, a text, a number, true, false or null",
    ),
    (
        "expected value",
        "a value should stand here: an object, a list, a text, a number, true, false or null",
    ),
    (
        "key must be a string",
        "a name in double quotes should stand here",
    ),
    (
        "invalid escape",
        "a text has a backslash before a letter that JSON does not escape",
    ),
    ("invalid number", "a number is not written as JSON has it"),
    ("number out of range", "the number is too large"),
    ("invalid unicode code point", "a text is not UTF-8"),
    (
        "control character",
        "a text has a line break, a tab or another control character that is not escaped",
    ),
    ("trailing comma", TRAILING_COMMA),
    (
        "trailing characters",
        "something stands behind the end of the document",
    ),
    (
        "lone leading surrogate",
        "a text has half a letter, as two escapes `\\u` should name it",
    ),
    (
        "unexpected end of hex escape",
        "a text has half a letter, as two escapes `\\u` should name it",
    ),
    (
        "recursion limit exceeded",
        "lists and objects stand too deeply in each other",
    ),
    ("invalid type", "it is of another kind than it should be"),
];

/// A message in words of the format instead of the library's, without its line and column.
pub(super) fn plain(error: &serde_json::Error) -> String {
    let message = error.to_string();
    let end = message.rfind(" at line ").unwrap_or(message.len());
    let message = &message[..end];
    if let Some(member) = message.strip_prefix("missing field ") {
        return format!("it has no {member}");
    }
    if let Some(member) = message.strip_prefix("duplicate field ") {
        return format!("it has two members {member}");
    }
    let mut known = WORDS.iter();
    let found = known.find(|(start, _)| message.starts_with(start));
    found
        .map_or("it is not valid JSON", |(_, words)| words)
        .to_owned()
}

/// The offset of a fault in a document, and words for it.
pub(super) fn located(json: &[u8], error: &serde_json::Error) -> (usize, String) {
    let at = offset_of(json, error.line(), error.column());
    let ends = matches!(json.get(at), Some(b']' | b'}'));
    match ends && json[..at].trim_ascii_end().ends_with(b",") {
        true => (at, TRAILING_COMMA.to_owned()),
        false => (at, plain(error)),
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
