//! Text to tokens. Line ends do not matter: a record may take one line or many.

use crate::text::command::TextToken;

/// Returns true if a token is meant as a number, valid or not: no record has such a name.
pub(super) fn is_numeric(token: &TextToken) -> bool {
    let digits = token.text.trim_start_matches(['+', '-', '.']);
    let named = |name: &str| digits.eq_ignore_ascii_case(name);
    digits.starts_with(|c: char| c.is_ascii_digit())
        || named("nan")
        || named("inf")
        || named("infinity")
}

/// The tokens of a file, one ahead.
#[derive(Clone, Debug)]
pub(super) struct NffTokens<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> NffTokens<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let body = text.strip_prefix('\u{feff}').unwrap_or(text);
        NffTokens {
            text,
            at: text.len() - body.len(),
        }
    }

    /// Takes the next token.
    pub(super) fn next(&mut self) -> Option<TextToken<'a>> {
        let bytes = self.text.as_bytes();
        let mut start = self.at;
        loop {
            match bytes.get(start)? {
                b'#' => start = end_of_line(bytes, start),
                b if b.is_ascii_whitespace() => start += 1,
                _ => break,
            }
        }
        let ends = |b: &u8| b.is_ascii_whitespace() || *b == b'#';
        let length = bytes[start..].iter().position(ends);
        let end = length.map_or(bytes.len(), |length| start + length);
        self.at = end;
        Some(TextToken {
            text: &self.text[start..end],
            offset: start,
        })
    }

    /// The token that [`NffTokens::next`] would take.
    pub(super) fn peek(&self) -> Option<TextToken<'a>> {
        self.clone().next()
    }

    /// The next token, if it is on the line of the last one.
    pub(super) fn peek_in_line(&self) -> Option<TextToken<'a>> {
        let token = self.peek()?;
        let between = &self.text.as_bytes()[self.at..token.offset];
        (!between.iter().any(ends_line)).then_some(token)
    }

    /// Number of bytes of the file that are left.
    pub(super) fn left(&self) -> usize {
        self.text.len() - self.at
    }
}

/// Returns true for either character of a line end. Old files end lines in different ways.
fn ends_line(b: &u8) -> bool {
    matches!(b, b'\n' | b'\r')
}

fn end_of_line(bytes: &[u8], from: usize) -> usize {
    let length = bytes[from..].iter().position(ends_line);
    length.map_or(bytes.len(), |length| from + length)
}
