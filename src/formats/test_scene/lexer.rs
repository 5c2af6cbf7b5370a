//! Text to statements, statements to tokens, tokens to numbers.

use crate::formats::report::{Place, quoted};

/// A run of characters without white space, and where it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'a> {
    pub(super) text: &'a str,
    offset: usize,
}

impl Token<'_> {
    pub(super) fn place(&self) -> Place {
        Place {
            offset: self.offset,
            length: self.text.len(),
        }
    }
}

/// The tokens of a line up to a comment.
#[derive(Clone, Debug)]
pub(super) struct Tokens<'a> {
    rest: &'a str,
    offset: usize,
}

impl<'a> Tokens<'a> {
    /// From the first token to the end of the last, with the white space between them.
    pub(super) fn joined(&self) -> Option<Token<'a>> {
        let mut tokens = self.clone();
        let first = tokens.next()?;
        let last = tokens.last().unwrap_or(first);
        let from = first.offset - self.offset;
        let to = last.offset + last.text.len() - self.offset;
        Some(Token {
            text: &self.rest[from..to],
            offset: first.offset,
        })
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = Token<'a>;

    fn next(&mut self) -> Option<Token<'a>> {
        let bytes = self.rest.as_bytes();
        let start = bytes.iter().position(|b| !b.is_ascii_whitespace())?;
        // A comment starts where a token could: `1#2` is one (bad) token, `1 #2` a number and a comment.
        if bytes[start] == b'#' {
            self.rest = "";
            return None;
        }
        let length = bytes[start..].iter().position(u8::is_ascii_whitespace);
        let end = length.map_or(bytes.len(), |length| start + length);
        let token = Token {
            text: &self.rest[start..end],
            offset: self.offset + start,
        };
        self.rest = &self.rest[end..];
        self.offset += end;
        Some(token)
    }
}

/// The lines of a file that hold anything but a comment, each as its tokens.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (Token<'_>, Tokens<'_>)> {
    let body = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut offset = text.len() - body.len();
    body.split('\n').filter_map(move |line| {
        let mut tokens = Tokens { rest: line, offset };
        offset += line.len() + 1;
        let name = tokens.next()?;
        Some((name, tokens))
    })
}

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
