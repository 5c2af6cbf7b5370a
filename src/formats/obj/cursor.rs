//! A position in the text of an OBJ or MTL file, with methods for blanks, line ends, continued
//! lines, words and numbers.

use crate::diagnostics::{ParseError, Span, quoted_bytes};
use crate::text::{decimal, ends_word, word_at};

/// Walks over a chunk of a text. Offsets are those of the whole file.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    /// The file up to the end of the chunk.
    pub(super) text: &'a [u8],
    pub(super) at: usize,
}

/// Bytes of a word that are compared with keywords, all of which are shorter.
pub(super) const KEYWORD_BYTES: usize = 12;

fn ends_line(byte: u8) -> bool {
    byte == b'\n' || byte == b'\r'
}

impl<'a> Cursor<'a> {
    #[inline(always)]
    pub(super) fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.at >= self.text.len()
    }

    /// Passes blanks within a statement; a `\` before a line end makes the next line part of this
    /// one.
    #[inline]
    pub(super) fn skip_blanks(&mut self) {
        while let Some(byte) = self.peek() {
            match byte {
                b'\n' | b'\r' => return,
                0..=b' ' => self.at += 1,
                b'\\' => match self.continued() {
                    Some(length) => self.at += length,
                    None => return,
                },
                _ => return,
            }
        }
    }

    /// The length of a `\` and the line end behind it, perhaps after blanks.
    #[cold]
    fn continued(&self) -> Option<usize> {
        let rest = self.text.get(self.at + 1..)?;
        let blanks = rest.iter().position(|&b| b != b' ' && b != b'\t')?;
        match &rest[blanks..] {
            [b'\r', b'\n', ..] => Some(blanks + 3),
            [b'\n' | b'\r', ..] => Some(blanks + 2),
            _ => None,
        }
    }

    /// Passes blanks and line ends.
    #[inline]
    pub(super) fn skip_to_statement(&mut self) {
        while self.peek().is_some_and(|byte| byte <= b' ') {
            self.at += 1;
        }
    }

    /// Returns true if the statement has no more operands. A `#` begins a comment.
    #[inline]
    pub(super) fn at_statement_end(&mut self) -> bool {
        self.skip_blanks();
        self.peek()
            .is_none_or(|byte| ends_line(byte) || byte == b'#')
    }

    /// Passes the rest of the statement, with the lines that continue it unless it is a comment.
    pub(super) fn skip_statement(&mut self) {
        match self.peek() {
            // The usual case: all of it has been read.
            None | Some(b'\n') => {}
            Some(b'#') => self.skip_to_line_end(),
            Some(_) => _ = self.rest_of_line(),
        }
    }

    fn skip_to_line_end(&mut self) {
        let rest = self.text.get(self.at..).unwrap_or_default();
        self.at += memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
    }

    /// The next word of the statement; empty at its end.
    #[inline]
    pub(super) fn word(&mut self) -> Span {
        self.skip_blanks();
        let word = word_at(self.text, self.at);
        self.at = word.end();
        word
    }

    /// The rest of the statement without the blanks around it, with the lines that continue it. It
    /// is a name, which may hold blanks and `#`: see [`super::name::spellings`].
    pub(super) fn rest_of_line(&mut self) -> Span {
        self.skip_blanks();
        let start = self.at;
        loop {
            self.skip_to_line_end();
            let line = &self.text[start..self.at];
            if self.is_at_end() || !line.ends_with(b"\\") {
                return Span::new(start, line.trim_ascii_end().len());
            }
            self.at += if self.text[self.at..].starts_with(b"\r\n") { 2 } else { 1 };
        }
    }

    /// The next operand as a number, which need not be finite.
    #[inline]
    pub(super) fn float(&mut self) -> Result<f32, ParseError> {
        self.number(decimal::float)
    }

    /// The next operand as a number in double precision.
    #[inline]
    pub(super) fn double(&mut self) -> Result<f64, ParseError> {
        self.number(decimal::double)
    }

    #[inline(always)]
    fn number<T: From<f32>>(
        &mut self,
        parse: impl Fn(&[u8], usize) -> (T, usize),
    ) -> Result<T, ParseError> {
        self.skip_blanks();
        let (value, end) = parse(self.text, self.at);
        let next = self.text.get(end);
        if end > self.at && (ends_word(self.text, end) || next == Some(&b'\\')) {
            self.at = end;
            return Ok(value);
        }
        // A `#` may begin a comment, or stand in `1.#QNAN`.
        if let Some((special, end)) = decimal::not_finite(self.text, self.at)
            && ends_word(self.text, end)
        {
            self.at = end;
            return Ok(special.into());
        }
        if end > self.at && next == Some(&b'#') {
            self.at = end;
            return Ok(value);
        }
        Err(self.no_number())
    }

    #[cold]
    fn no_number(&mut self) -> ParseError {
        let start = self.at;
        let word = self.word();
        if word.length == 0 {
            return self.missing("a number");
        }
        let message = format!("{} is not a number", self.quoted(word));
        ParseError::new(Span::new(start, word.length), message)
    }

    /// The error of a statement that ends too early.
    #[cold]
    pub(super) fn missing(&self, what: &str) -> ParseError {
        let span = Span::at(self.at);
        ParseError::new(span, format!("{what} is missing"))
    }

    /// The bytes of a span.
    pub(super) fn bytes(&self, span: Span) -> &'a [u8] {
        let end = span.offset.saturating_add(span.length).min(self.text.len());
        self.text.get(span.offset..end).unwrap_or_default()
    }

    /// A word in lower case, for comparison with keywords: only as much as distinguishes them.
    pub(super) fn keyword<'b>(&self, word: Span, lower: &'b mut [u8; KEYWORD_BYTES]) -> &'b [u8] {
        let text = self.bytes(word);
        let keyword = &mut lower[..text.len().min(KEYWORD_BYTES)];
        keyword.copy_from_slice(&text[..keyword.len()]);
        keyword.make_ascii_lowercase();
        keyword
    }

    /// The text of a span in the form for a message.
    pub(super) fn quoted(&self, span: Span) -> String {
        quoted_bytes(self.bytes(span))
    }
}
