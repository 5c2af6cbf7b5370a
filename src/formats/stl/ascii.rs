//! Ascii STL: `facet`, `outer loop`, three times `vertex x y z`, `endloop`, `endfacet`.
//!
//! Words may be in any case, and those that begin with `end` may be two. The normal is not used, so
//! it may be missing or invalid. Words after it and after `endloop` are skipped, and so is text
//! between facets that has none of the words of a facet. A loop of more than three vertices is a
//! fan of triangles.

use super::lexer::{StlLexer, is_in_remark};
use crate::diagnostics::{ChunkRemarks, DiagnosticSink, ParseError, Span, quoted_bytes};
use crate::mesh::named_runs::change;
use crate::text::{decimal, ends_word, mark_length, workers};
use glam::DVec3;
use std::ops::Range;

/// Corners as in the file, three for each facet.
pub(super) type Soup = Vec<[[f32; 3]; 3]>;

/// Word that ends a facet; chunks of the text end behind it.
const END: &[u8] = b"endfacet";

/// Most names and comments with that word that are passed in search of the end of a chunk.
const MAX_REMARKS: usize = 1000;

/// The corners of all facets, and the names of solids with the facet that each begins at. Errors
/// are added to the report.
///
/// `origin` is subtracted from corners before they are rounded.
pub(super) fn read(
    bytes: &[u8],
    threads: usize,
    chunk_bytes: usize,
    origin: DVec3,
    report: &mut DiagnosticSink,
) -> (Soup, Vec<(usize, Span)>) {
    let finder = memchr::memmem::Finder::new(END);
    let start = mark_length(bytes);
    let ranges = workers::chunk_ranges(start..bytes.len(), chunk_bytes, |offset| {
        // Names and comments may hold the word.
        let ends = finder.find_iter(&bytes[offset..]).map(|i| offset + i);
        let is_end =
            |&i: &usize| i > 0 && ends_word(bytes, i - 1) && ends_word(bytes, i + END.len());
        let mut ends = ends.filter(is_end).take(MAX_REMARKS);
        let end = ends.find(|i| !is_in_remark(bytes, *i));
        end.map_or(bytes.len(), |i| i + END.len())
    });
    let read = |range: Range<usize>| {
        let mut reader = StlAsciiReader::new(&bytes[..range.end], range.start, origin);
        reader.read();
        reader.chunk
    };
    if !begins_well(bytes, start, report) {
        return Default::default();
    }
    let (mut soups, mut names, mut facets) = (Vec::new(), Vec::new(), 0);
    let (mut remarks, mut cut_off) = (ChunkRemarks::default(), None);
    for chunk in workers::map(threads, ranges, read) {
        remarks.merge(chunk.remarks);
        cut_off = cut_off.or(chunk.cut_off);
        for (offset, name) in chunk.names {
            change(&mut names, facets + offset, name);
        }
        facets += chunk.soup.len();
        soups.push(chunk.soup);
    }
    remarks.emit(report);
    let soup = workers::join(soups);
    if let Some(error) = cut_off {
        if soup.is_empty() {
            report.error(error.span, error.message)
        } else {
            let message = "the file ends within this facet, which is left out";
            report.warning(error.span, format!("{message}: {}", error.message));
        }
    }
    (soup, names)
}

/// Takes a word that only facets have.
fn take_part(words: &mut StlLexer) -> bool {
    words.take(b"outer").is_some()
        || words.take(b"vertex").is_some()
        || words.take_end(b"loop").is_some()
        || words.take_end(b"facet").is_some()
}

/// Checks the first word.
fn begins_well(bytes: &[u8], start: usize, report: &mut DiagnosticSink) -> bool {
    let mut words = StlLexer::new(bytes, start);
    if words.take(b"solid").is_some() {
        return true;
    }
    let message = "text must begin with `solid`";
    match words.take(b"facet") {
        Some(word) => {
            report.warning(
                word,
                format!("this STL file lacks its first line: {message}"),
            );
            true
        }
        None => {
            report.error(Span::START, format!("this is not an STL file: {message}"));
            false
        }
    }
}

/// Span of a corner, found by counting; for a message.
pub(super) fn corner_span(bytes: &[u8], corner: usize) -> Span {
    let mut words = StlLexer::new(bytes, mark_length(bytes));
    let mut count = 0;
    loop {
        if words.take_solid() {
            words.name();
        }
        match words.word() {
            None => return Span::START,
            Some(word) if words.word_is(word, b"vertex") => {
                if count == corner {
                    return word;
                }
                count += 1;
            }
            Some(_) => {}
        }
    }
}

/// Contents of a chunk of the text.
#[derive(Default)]
struct StlChunk {
    soup: Soup,
    /// Spans of the names of solids, and the first facet of each.
    names: Vec<(usize, Span)>,
    remarks: ChunkRemarks,
    /// The error of a facet that the end of the text cuts off.
    cut_off: Option<ParseError>,
}

/// The reason why a facet is not complete.
enum FacetFault {
    Wrong(ParseError),
    /// The text ends.
    CutOff(ParseError),
}

struct StlAsciiReader<'a> {
    /// The file up to the end of the chunk.
    words: StlLexer<'a>,
    origin: DVec3,
    chunk: StlChunk,
}

impl<'a> StlAsciiReader<'a> {
    fn new(text: &'a [u8], offset: usize, origin: DVec3) -> StlAsciiReader<'a> {
        StlAsciiReader {
            words: StlLexer::new(text, offset),
            origin,
            chunk: StlChunk::default(),
        }
    }

    fn read(&mut self) {
        loop {
            let read = if self.words.take(b"facet").is_some() {
                self.facet()
            } else if self.words.take(b"solid").is_some() {
                let name = self.words.name();
                change(&mut self.chunk.names, self.chunk.soup.len(), name);
                Ok(())
            } else if self.words.take_end(b"solid").is_some() {
                self.words.name();
                Ok(())
            } else {
                let Some(word) = self.words.peek() else {
                    return;
                };
                self.between_facets(word)
            };
            match read {
                Ok(()) => {}
                Err(FacetFault::Wrong(error)) => {
                    self.chunk.remarks.error(error);
                    self.resume();
                }
                Err(FacetFault::CutOff(error)) => self.chunk.cut_off = Some(error),
            }
            if self.chunk.remarks.is_full() {
                return;
            }
        }
    }

    /// Passes text up to the next facet or solid. It is an error if there is a word of a facet in
    /// it, because its beginning is lost then.
    fn between_facets(&mut self, first: Span) -> Result<(), FacetFault> {
        self.pass_until(|words| {
            take_part(words) || words.take(b"facet").is_some() || words.take_solid()
        });
        if take_part(&mut self.words.clone()) {
            let expected = "`facet` or `endsolid`";
            return Err(FacetFault::Wrong(self.unexpected(first, expected)));
        }
        self.chunk.remarks.warn(
            first,
            "this word and what follows it up to the next facet is no facet: it is ignored",
            "pieces of text between facets are ignored, this one first",
        );
        Ok(())
    }

    /// Moves behind the facet that has the fault.
    fn resume(&mut self) {
        self.pass_until(|words| words.take_end(b"facet").is_some());
        self.words.take_end(b"facet");
    }

    /// Passes words up to those that `takes` takes, or to the end of the text.
    fn pass_until(&mut self, takes: impl Fn(&mut StlLexer) -> bool) {
        while !takes(&mut self.words.clone()) && self.words.word().is_some() {}
    }

    fn facet(&mut self) -> Result<(), FacetFault> {
        self.skip_normal();
        self.keyword("outer")?;
        self.keyword("loop")?;
        let mut corners = [[0.0; 3]; 3];
        for corner in &mut corners {
            self.keyword("vertex")?;
            *corner = self.vertex()?;
        }
        let first = self.chunk.soup.len();
        self.chunk.soup.push(corners);
        let read = self.rest_of_facet(corners);
        if read.is_err() {
            self.chunk.soup.truncate(first);
        }
        read
    }

    /// Reads what follows the third vertex.
    fn rest_of_facet(&mut self, [a, _, mut last]: [[f32; 3]; 3]) -> Result<(), FacetFault> {
        while self.words.take(b"vertex").is_some() {
            let next = self.vertex()?;
            self.chunk.soup.push([a, last, next]);
            last = next;
        }
        self.end("loop")?;
        self.pass_words();
        self.end("facet")
    }

    fn vertex(&mut self) -> Result<[f32; 3], FacetFault> {
        let mut corner = [0.0; 3];
        for (axis, number) in corner.iter_mut().enumerate() {
            *number = match self.origin[axis] {
                0.0 => self.number(decimal::float)?,
                origin => (self.number(decimal::double)? - origin) as f32,
            };
        }
        Ok(corner)
    }

    /// Passes the normal, if there is one. It is not used, and real files contain all sorts of text
    /// here: `nan`, `-nan(ind)`, `-1.#IND`.
    fn skip_normal(&mut self) {
        if self.words.take(b"normal").is_some() {
            self.pass_words();
        }
    }

    /// Passes words up to one that only facets have.
    fn pass_words(&mut self) {
        self.pass_until(|words| take_part(words) || words.take(b"facet").is_some());
    }

    fn keyword(&mut self, expected: &str) -> Result<(), FacetFault> {
        match self.words.take(expected.as_bytes()) {
            Some(_) => Ok(()),
            None => Err(self.fault(&format!("`{expected}`"))),
        }
    }

    fn end(&mut self, part: &str) -> Result<(), FacetFault> {
        match self.words.take_end(part.as_bytes()) {
            Some(_) => Ok(()),
            None => Err(self.fault(&format!("`end{part}`"))),
        }
    }

    fn number<T: From<f32>>(
        &mut self,
        parse: impl Fn(&[u8], usize) -> (T, usize),
    ) -> Result<T, FacetFault> {
        self.words.skip_blanks();
        let StlLexer { text, position } = self.words;
        let (value, end) = parse(text, position);
        let (value, end) = if end > position && ends_word(text, end) {
            (value, end)
        } else {
            let special = decimal::not_finite(text, position);
            let special = special.filter(|&(_, end)| ends_word(text, end));
            let (value, end) = special.ok_or_else(|| self.fault("a number"))?;
            (value.into(), end)
        };
        self.words.position = end;
        Ok(value)
    }

    /// The fault of a word that is not the expected one. The word is not consumed: it may be the
    /// one that ends the facet.
    #[cold]
    fn fault(&mut self, expected: &str) -> FacetFault {
        match self.words.peek() {
            Some(word) => FacetFault::Wrong(self.unexpected(word, expected)),
            None => {
                let end = Span::at(self.words.text.trim_ascii_end().len());
                FacetFault::CutOff(ParseError::new(end, format!("{expected} is missing")))
            }
        }
    }

    #[cold]
    fn unexpected(&self, word: Span, expected: &str) -> ParseError {
        let quoted = quoted_bytes(&self.words.text[word.range()]);
        ParseError::new(
            word,
            format!("{quoted} stands where {expected} is expected"),
        )
    }
}
