//! Rows of an ascii file: one on each line that is neither blank nor a comment.
//!
//! Lines are counted first, so that the rows of each chunk of the text are known. Then several
//! threads read the chunks. If rows and lines do not agree, the words of the file are read once
//! more without regard to lines: some programs break rows, and others write several on a line.

use super::header::{Element, Type};
use super::lexer::{NO_ROW_END, PlyLexer, count_rows};
use super::plan::{ElementUse, ReadPlan};
use super::row_reader::{PlyRowReader, RowWords};
use super::rows::{PlyChunk, too_short};
use crate::diagnostics::{ChunkRemarks, DiagnosticSink, ParseError, Span};
use crate::text::workers;
use std::ops::Range;

/// Reads the rows of all elements; errors are added to the report.
pub(super) fn read(
    bytes: &[u8],
    plan: &ReadPlan,
    threads: usize,
    chunk_bytes: usize,
    report: &mut DiagnosticSink,
) -> Vec<PlyChunk> {
    let eol = plan.header.line_end;
    let used = plan.memory.used();
    let ranges = workers::chunk_ranges(plan.header.body..bytes.len(), chunk_bytes, |offset| {
        memchr::memchr(eol, &bytes[offset..]).map_or(bytes.len(), |length| offset + length + 1)
    });
    let counts = workers::map(threads, ranges.clone(), |range| {
        count_rows(&bytes[range], eol)
    });
    let mut first = 0;
    let jobs = ranges.into_iter().zip(counts).map(|(range, count)| {
        let job = (range, first);
        first += count;
        job
    });
    let jobs: Vec<(Range<usize>, u64)> = jobs.collect();
    let elements = &plan.header.elements;
    let rows = first;
    let mut chunks = workers::map(threads, jobs, |(range, first)| {
        let mut reader = reader_of(&bytes[..range.end], plan);
        reader.read(range.start, first);
        reader.chunk
    });
    let missing = missing_rows(elements, rows, bytes);
    if missing.is_some() || chunks.iter().any(|chunk| chunk.remarks.has_errors()) {
        let counted = plan.memory.used();
        plan.memory.reset(used);
        if let Some((chunk, span)) = reader_of(bytes, plan).read_words() {
            report.warning(
                span,
                "rows and lines do not agree from here on: rows are read by their words",
            );
            return vec![chunk];
        }
        plan.memory.reset(counted);
    }
    chunks.extend(missing.map(|error| {
        let mut remarks = ChunkRemarks::default();
        remarks.error(error);
        PlyChunk {
            remarks,
            ..PlyChunk::default()
        }
    }));
    chunks
}

/// The first element that is not complete.
fn missing_rows(elements: &[Element], rows: u64, bytes: &[u8]) -> Option<ParseError> {
    let mut left = rows;
    for element in elements.iter().filter(|e| !e.properties.is_empty()) {
        if element.count > left {
            return Some(too_short(element, left, bytes.trim_ascii_end().len()));
        }
        left -= element.count;
    }
    None
}

fn reader_of<'a>(text: &'a [u8], plan: &'a ReadPlan<'a>) -> PlyRowReader<'a, PlyLexer<'a>> {
    let words = PlyLexer {
        text,
        at: 0,
        eol: plan.header.line_end,
        line_end: plan.header.line_end,
    };
    PlyRowReader::new(words, plan)
}

impl RowWords for PlyLexer<'_> {
    #[inline]
    fn float(&mut self, _: Type, origin: f64) -> Result<f32, ParseError> {
        self.coordinate(origin)
    }

    #[inline]
    fn integer(&mut self, _: Type) -> Result<i64, ParseError> {
        self.whole_number()
    }

    fn list_count(&mut self, _: Type, _: Type) -> Result<usize, ParseError> {
        self.count()
    }

    fn pass(&mut self, count: usize, _: Type) -> Result<(), ParseError> {
        (0..count).try_for_each(|_| self.pass_word())
    }

    fn position(&self) -> usize {
        self.at
    }

    fn face_span(&self, row: usize, _: Span) -> Span {
        self.span_since(row)
    }

    fn strip_bytes(_: usize) -> u64 {
        0
    }
}

impl PlyRowReader<'_, PlyLexer<'_>> {
    /// Reads the rows from `start` on. The first of them has number `first` in the whole body.
    fn read(&mut self, start: usize, mut first: u64) {
        self.words.at = start;
        let plan = self.plan;
        for (index, element) in plan.header.elements.iter().enumerate() {
            if element.properties.is_empty() {
                continue;
            }
            if first >= element.count {
                first -= element.count;
                continue;
            }
            let purpose = plan.purpose(index);
            for row in first..element.count {
                if !self.words.find_row() {
                    return;
                }
                if let Err(error) = self.line(purpose, element, row) {
                    self.chunk.remarks.error(error);
                    self.words.skip_line();
                }
            }
            first = 0;
        }
        if self.words.find_row() {
            self.chunk.surplus = Some(self.words.rest_of_line());
        }
    }

    /// Reads all rows word by word. `None` if they do not end with the file, if one of them is
    /// faulty, or if lines end within some rows while others begin within a line: then there is a
    /// word too many or too few. Else also the span of the first row that is no line.
    fn read_words(mut self) -> Option<(PlyChunk, Span)> {
        self.words.at = self.plan.header.body;
        self.words.eol = NO_ROW_END;
        let plan = self.plan;
        let (mut broken, mut joined) = (None, None);
        for (index, element) in plan.header.elements.iter().enumerate() {
            let purpose = plan.purpose(index);
            let rows = if element.properties.is_empty() { 0 } else { element.count };
            for row in 0..rows {
                let before = self.words.at;
                if !self.words.find_row() {
                    return None;
                }
                let start = self.words.at;
                self.line(purpose, element, row).ok()?;
                let ends_line = |from: usize, to: usize| {
                    memchr::memchr(plan.header.line_end, &self.words.text[from..to]).is_some()
                };
                if ends_line(start, self.words.at) {
                    broken.get_or_insert(self.words.span_since(start));
                }
                if start > plan.header.body
                    && before > plan.header.body
                    && !ends_line(before, start)
                {
                    joined.get_or_insert(self.words.span_since(start));
                }
                if broken.is_some() && joined.is_some() {
                    return None;
                }
            }
        }
        let span = broken.or(joined)?;
        (!self.words.find_row()).then_some((self.chunk, span))
    }

    /// Reads a row, with the rest of its line.
    #[inline]
    fn line(&mut self, purpose: ElementUse, element: &Element, row: u64) -> Result<(), ParseError> {
        self.row(purpose, element, row)?;
        if self.words.eol != NO_ROW_END && !self.words.at_line_end() {
            // Real files have them: MeshLab announces four numbers of a colour and writes ten.
            let surplus = self.words.rest_of_line();
            self.chunk.remarks.warn(
                surplus,
                "this row has more operands than the header announces: they are ignored",
                "rows have more operands than the header announces, this one first: they are ignored",
            );
            self.chunk.surplus_operands = true;
        }
        Ok(())
    }
}
