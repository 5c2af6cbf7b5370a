//! Text to statements, statements to tokens, tokens to numbers.

use crate::formats::report::Place;

pub(super) use crate::formats::number::{count, double, number, widened};

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
