//! Ascii STL: `facet`, `outer loop`, three times `vertex x y z`, `endloop`, `endfacet`.

use crate::formats::decimal;
use crate::formats::diagnostics::{DiagnosticSink, Span, quoted_bytes};
use crate::formats::mesh::{ParseError, ParseErrors};
use crate::formats::workers;
use glam::DVec3;

/// Corners as in the file, three for each facet.
pub(super) type Soup = Vec<[[f32; 3]; 3]>;

/// The length of the byte order mark that some editors put before text.
pub(super) fn mark_length(bytes: &[u8]) -> usize {
    let mark = "\u{feff}".as_bytes();
    if bytes.starts_with(mark) {
        mark.len()
    } else {
        0
    }
}

/// Word that ends a facet; chunks of the text end behind it.
const END: &[u8] = b"endfacet";

/// The corners of all facets; errors are added to the report.
///
/// `origin` is subtracted from corners before they are rounded.
pub(super) fn read(
    bytes: &[u8],
    threads: usize,
    chunk_bytes: usize,
    origin: DVec3,
    report: &mut DiagnosticSink,
) -> Soup {
    let finder = memchr::memmem::Finder::new(END);
    let start = mark_length(bytes);
    let blank = |at: usize| bytes.get(at).is_none_or(|&byte| byte <= b' ');
    let ranges = workers::cut(start..bytes.len(), chunk_bytes, |at| {
        // Names may hold the letters, but not as a separate word.
        let mut ends = finder.find_iter(&bytes[at..]).map(|i| at + i);
        let end = ends.find(|&i| i > 0 && blank(i - 1) && blank(i + END.len()));
        end.map_or(bytes.len(), |i| i + END.len())
    });
    let read = |range: std::ops::Range<usize>| {
        let mut reader = StlAsciiReader::new(&bytes[..range.end], range.start, origin);
        reader.read();
        (reader.soup, reader.errors)
    };
    let first = bytes[start..].trim_ascii_start().get(..5);
    if first.is_none_or(|word| !word.eq_ignore_ascii_case(b"solid")) {
        let message = "this is not an STL file: text must begin with `solid`";
        report.error(Span::START, message);
        return Soup::new();
    }
    let mut soups = Vec::new();
    for (soup, errors) in workers::map(threads, ranges, read) {
        errors.emit(report);
        soups.push(soup);
    }
    workers::joined(soups)
}

/// Span of a corner, found by counting; for a message.
pub(super) fn corner_span(bytes: &[u8], corner: usize) -> Span {
    let mut reader = StlAsciiReader::new(bytes, mark_length(bytes), DVec3::ZERO);
    let mut count = 0;
    while let Some(word) = reader.word() {
        let keyword = reader.lower(word);
        if keyword == b"solid" || keyword == b"endsolid" {
            reader.skip_line();
        } else if keyword == b"vertex" {
            if count == corner {
                return word;
            }
            count += 1;
        }
    }
    Span::START
}

struct StlAsciiReader<'a> {
    /// The file up to the end of the chunk.
    text: &'a [u8],
    at: usize,
    origin: DVec3,
    soup: Soup,
    errors: ParseErrors,
}

impl<'a> StlAsciiReader<'a> {
    fn new(text: &'a [u8], at: usize, origin: DVec3) -> StlAsciiReader<'a> {
        StlAsciiReader {
            text,
            at,
            origin,
            soup: Soup::new(),
            errors: ParseErrors::default(),
        }
    }

    fn read(&mut self) {
        while let Some(word) = self.word() {
            let read = match &self.lower(word)[..] {
                b"facet" => self.facet(),
                b"solid" | b"endsolid" => {
                    self.skip_line();
                    Ok(())
                }
                _ => Err(self.unexpected(word, "`facet` or `endsolid`")),
            };
            if let Err(error) = read {
                self.errors.push(error);
                self.resume();
            }
            if self.errors.is_full() {
                return;
            }
        }
    }

    /// Moves behind the facet that has the fault.
    fn resume(&mut self) {
        while let Some(word) = self.word() {
            if self.lower(word) == END {
                return;
            }
        }
    }

    fn facet(&mut self) -> Result<(), ParseError> {
        self.keyword(b"normal")?;
        // Any number is accepted: it is not used, and real files have NaN here.
        (0..3).try_for_each(|_| self.number(decimal::float).map(|_| ()))?;
        self.keyword(b"outer")?;
        self.keyword(b"loop")?;
        let mut corners = [[0.0; 3]; 3];
        for corner in &mut corners {
            self.keyword(b"vertex")?;
            for (axis, number) in corner.iter_mut().enumerate() {
                *number = match self.origin[axis] {
                    0.0 => self.number(decimal::float)?,
                    origin => (self.number(decimal::double)? - origin) as f32,
                };
            }
        }
        self.keyword(b"endloop")?;
        self.keyword(END)?;
        self.soup.push(corners);
        Ok(())
    }

    fn keyword(&mut self, expected: &[u8]) -> Result<(), ParseError> {
        let name = || format!("`{}`", String::from_utf8_lossy(expected));
        match self.word() {
            Some(word) if self.text[word.range()].eq_ignore_ascii_case(expected) => Ok(()),
            Some(word) => {
                // The word may be the one that ends the facet.
                self.at = word.offset;
                Err(self.unexpected(word, &name()))
            }
            None => Err(self.missing(&name())),
        }
    }

    #[cold]
    fn unexpected(&self, word: Span, expected: &str) -> ParseError {
        let found = quoted_bytes(&self.text[word.range()]);
        ParseError::new(word, format!("{found} stands where {expected} is expected"))
    }

    fn number<T>(&mut self, parse: impl Fn(&[u8], usize) -> (T, usize)) -> Result<T, ParseError> {
        self.skip_blanks();
        let (value, end) = parse(self.text, self.at);
        if end > self.at && self.text.get(end).is_none_or(|&byte| byte <= b' ') {
            self.at = end;
            return Ok(value);
        }
        match self.word() {
            Some(word) => Err(self.unexpected(word, "a number")),
            None => Err(self.missing("a number")),
        }
    }

    #[cold]
    fn missing(&self, what: &str) -> ParseError {
        let end = Span::at(self.text.trim_ascii_end().len());
        ParseError::new(end, format!("{what} is missing"))
    }

    fn skip_blanks(&mut self) {
        while self.text.get(self.at).is_some_and(|&byte| byte <= b' ') {
            self.at += 1;
        }
    }

    fn skip_line(&mut self) {
        let rest = &self.text[self.at..];
        self.at += memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
    }

    fn word(&mut self) -> Option<Span> {
        self.skip_blanks();
        let rest = &self.text[self.at..];
        let length = rest.iter().position(|&byte| byte <= b' ');
        let span = Span::new(self.at, length.unwrap_or(rest.len()));
        self.at += span.length;
        (span.length > 0).then_some(span)
    }

    /// A word in lower case, cut to the length of a keyword.
    fn lower(&self, word: Span) -> Vec<u8> {
        let length = word.length.min(16);
        self.text[word.offset..word.offset + length].to_ascii_lowercase()
    }
}
