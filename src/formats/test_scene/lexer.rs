//! Text to statements, and statements to tokens.

use crate::text::command::TextToken;

/// The tokens of a line up to a comment.
#[derive(Clone, Debug)]
pub(super) struct TestTokens<'a> {
    rest: &'a str,
    offset: usize,
}

impl<'a> TestTokens<'a> {
    /// The tokens as one, from the first to the end of the last, with the white space between them.
    pub(super) fn joined(&self) -> Option<TextToken<'a>> {
        let mut tokens = self.clone();
        let first = tokens.next()?;
        let last = tokens.last().unwrap_or(first);
        let from = first.offset - self.offset;
        let to = last.offset + last.text.len() - self.offset;
        Some(TextToken {
            text: &self.rest[from..to],
            offset: first.offset,
        })
    }
}

impl<'a> Iterator for TestTokens<'a> {
    type Item = TextToken<'a>;

    fn next(&mut self) -> Option<TextToken<'a>> {
        let bytes = self.rest.as_bytes();
        let start = bytes.iter().position(|b| !b.is_ascii_whitespace())?;
        // A comment starts where a token could: `1#2` is one (bad) token, `1 #2` a number and a
        // comment.
        if bytes[start] == b'#' {
            self.rest = "";
            return None;
        }
        let length = bytes[start..].iter().position(u8::is_ascii_whitespace);
        let end = length.map_or(bytes.len(), |length| start + length);
        let token = TextToken {
            text: &self.rest[start..end],
            offset: self.offset + start,
        };
        self.rest = &self.rest[end..];
        self.offset += end;
        Some(token)
    }
}

/// The lines of a file that hold more than a comment, each as its tokens.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (TextToken<'_>, TestTokens<'_>)> {
    let body = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut offset = text.len() - body.len();
    body.split('\n').filter_map(move |line| {
        let mut tokens = TestTokens { rest: line, offset };
        offset += line.len() + 1;
        let name = tokens.next()?;
        Some((name, tokens))
    })
}
