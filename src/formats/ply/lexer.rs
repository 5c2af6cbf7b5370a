//! Words of an ascii file: numbers, lists, and the ends of rows.

use crate::diagnostics::{ParseError, Span, quoted_bytes};
use crate::text::{decimal, ends_word, word_at};

/// Number of lines that are neither blank nor a comment.
pub(super) fn count_rows(text: &[u8], eol: u8) -> u64 {
    let mut count = 0;
    let mut start = 0;
    for end in memchr::memchr_iter(eol, text).chain([text.len()]) {
        // The first byte decides in most cases.
        let line = &text[start..end];
        let filled = line.iter().position(|&byte| byte > b' ');
        count += u64::from(filled.is_some_and(|first| !is_remark(&line[first..])));
        start = end + 1;
    }
    count
}

/// Returns true if non-blank text begins a comment, which ends with its line. Rows never begin like
/// this.
#[inline]
fn is_remark(text: &[u8]) -> bool {
    let word = |word: &[u8]| text.starts_with(word) && ends_word(text, word.len());
    match text.first() {
        Some(b'#') => true,
        Some(b'c') => word(b"comment"),
        Some(b'o') => word(b"obj_info"),
        _ => false,
    }
}

/// A number without a fraction, as an integer.
pub(super) fn as_integer(number: f64) -> Option<i64> {
    let exact = number.fract() == 0.0 && number.abs() < (1u64 << 53) as f64;
    exact.then_some(number as i64)
}

/// A byte that does not occur in text.
pub(super) const NO_ROW_END: u8 = 0xff;

/// A position in the text, between words.
pub(super) struct PlyLexer<'a> {
    /// The file up to the end of the chunk.
    pub(super) text: &'a [u8],
    pub(super) at: usize,
    /// The byte that ends a row; [`NO_ROW_END`] if rows end with their last word.
    pub(super) eol: u8,
    /// The byte that ends a line.
    pub(super) line_end: u8,
}

impl PlyLexer<'_> {
    /// Moves to the next line that is neither blank nor a comment.
    pub(super) fn find_row(&mut self) -> bool {
        loop {
            while self.text.get(self.at).is_some_and(|&byte| byte <= b' ') {
                self.at += 1;
            }
            let rest = &self.text[self.at..];
            if !is_remark(rest) {
                return !rest.is_empty();
            }
            self.at += memchr::memchr(self.line_end, rest).unwrap_or(rest.len());
        }
    }

    pub(super) fn skip_line(&mut self) {
        let rest = &self.text[self.at..];
        self.at += memchr::memchr(self.eol, rest).unwrap_or(rest.len());
    }

    /// Passes the rest of the line; returns its span without the blanks at its end.
    pub(super) fn rest_of_line(&mut self) -> Span {
        let start = self.at;
        self.skip_line();
        let rest = &self.text[start..self.at];
        Span::new(start, rest.trim_ascii_end().len())
    }

    pub(super) fn span_since(&self, start: usize) -> Span {
        Span::between(start, self.at)
    }

    /// Passes a word.
    pub(super) fn pass_word(&mut self) -> Result<(), ParseError> {
        match self.word().length {
            0 => Err(self.missing()),
            _ => Ok(()),
        }
    }

    /// The next number as the count of a list.
    pub(super) fn count(&mut self) -> Result<usize, ParseError> {
        self.skip_blanks();
        let start = self.at;
        let count = self.whole_number()?;
        usize::try_from(count).map_err(|_| {
            ParseError::new(
                self.span_since(start),
                "a list cannot have a negative count",
            )
        })
    }

    #[inline]
    fn skip_blanks(&mut self) {
        if self.eol == NO_ROW_END {
            self.find_row();
            return;
        }
        while self
            .text
            .get(self.at)
            .is_some_and(|&byte| byte <= b' ' && byte != self.eol)
        {
            self.at += 1;
        }
    }

    #[inline]
    pub(super) fn at_line_end(&mut self) -> bool {
        self.skip_blanks();
        self.text.get(self.at).is_none_or(|&byte| byte == self.eol)
    }

    /// The next word of the line; empty at its end.
    fn word(&mut self) -> Span {
        self.skip_blanks();
        let word = word_at(self.text, self.at);
        self.at = word.end();
        word
    }

    /// The next number, from which an origin is subtracted.
    #[inline]
    pub(super) fn coordinate(&mut self, origin: f64) -> Result<f32, ParseError> {
        if origin == 0.0 {
            return self.real(decimal::float);
        }
        self.real(|text, offset| {
            let (value, end) = decimal::double(text, offset);
            ((value - origin) as f32, end)
        })
    }

    /// The next number, which need not be finite.
    #[inline(always)]
    fn real(&mut self, parse: impl Fn(&[u8], usize) -> (f32, usize)) -> Result<f32, ParseError> {
        self.skip_blanks();
        let (value, end) = parse(self.text, self.at);
        let is_number = end > self.at && ends_word(self.text, end);
        let special = (!is_number).then(|| decimal::not_finite(self.text, self.at));
        let (value, end) = special.flatten().unwrap_or((value, end));
        self.accept(value, end, "a number")
    }

    /// The next whole number, which may be written as `3.0` or `3e0`.
    #[inline]
    pub(super) fn whole_number(&mut self) -> Result<i64, ParseError> {
        self.skip_blanks();
        let (mut value, mut end) = decimal::integer(self.text, self.at);
        if matches!(self.text.get(end), Some(b'.' | b'e' | b'E')) {
            let (real, after) = decimal::double(self.text, self.at);
            if let Some(integer) = as_integer(real) {
                (value, end) = (integer, after);
            }
        }
        self.accept(value, end, "a whole number")
    }

    /// Moves behind a number that ends here, if it is one.
    #[inline]
    fn accept<T>(&mut self, value: T, end: usize, what: &str) -> Result<T, ParseError> {
        if end > self.at && ends_word(self.text, end) {
            self.at = end;
            return Ok(value);
        }
        Err(self.no_number(what))
    }

    #[cold]
    fn no_number(&mut self, what: &str) -> ParseError {
        if self.at_line_end() {
            return self.missing();
        }
        let word = self.word();
        ParseError::new(word, format!("{} is not {what}", self.quoted(word)))
    }

    #[cold]
    fn missing(&self) -> ParseError {
        ParseError::new(self.span_since(self.at), "the row ends too early")
    }

    fn quoted(&self, span: Span) -> String {
        quoted_bytes(&self.text[span.range()])
    }
}
