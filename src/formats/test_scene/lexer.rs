//! Text to statements, statements to tokens, tokens to numbers.

use crate::diagnostics::Span;

pub(super) use crate::number::{count, double, number, widened};

/// A run of characters without white space, and its span.
#[derive(Clone, Copy, Debug)]
pub(super) struct TestToken<'a> {
    pub(super) text: &'a str,
    offset: usize,
}

impl TestToken<'_> {
    pub(super) fn span(&self) -> Span {
        Span::new(self.offset, self.text.len())
    }
}

/// The tokens of a line up to a comment.
#[derive(Clone, Debug)]
pub(super) struct TestTokens<'a> {
    rest: &'a str,
    offset: usize,
}

impl<'a> TestTokens<'a> {
    /// The tokens as one, from the first to the end of the last, with the white space between them.
    pub(super) fn joined(&self) -> Option<TestToken<'a>> {
        let mut tokens = self.clone();
        let first = tokens.next()?;
        let last = tokens.last().unwrap_or(first);
        let from = first.offset - self.offset;
        let to = last.offset + last.text.len() - self.offset;
        Some(TestToken {
            text: &self.rest[from..to],
            offset: first.offset,
        })
    }
}

impl<'a> Iterator for TestTokens<'a> {
    type Item = TestToken<'a>;

    fn next(&mut self) -> Option<TestToken<'a>> {
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
        let token = TestToken {
            text: &self.rest[start..end],
            offset: self.offset + start,
        };
        self.rest = &self.rest[end..];
        self.offset += end;
        Some(token)
    }
}

/// The lines of a file that hold more than a comment, each as its tokens.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (TestToken<'_>, TestTokens<'_>)> {
    let body = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut offset = text.len() - body.len();
    body.split('\n').filter_map(move |line| {
        let mut tokens = TestTokens { rest: line, offset };
        offset += line.len() + 1;
        let name = tokens.next()?;
        Some((name, tokens))
    })
}
