//! Rows of an ascii file: one on each line that is not blank.
//!
//! Lines are counted first, so that the rows of each chunk of the text are known. Then several
//! threads read the chunks.

use super::header::{Element, Property, PropertyKind};
use super::plan::{ElementUse, ReadPlan};
use super::rows::{Body, FaceSink, check_corners, checked_normal, checked_position, too_short};
use crate::formats::decimal;
use crate::formats::diagnostics::{DiagnosticSink, Span, quoted_bytes};
use crate::formats::memory_budget::BudgetShare;
use crate::formats::mesh::{NotFinite, Occurrences, ParseError, ParseErrors, merge_floats};
use crate::formats::workers;
use phalanx_scene::Vec3s;
use std::ops::Range;

/// Reads the rows of all elements; errors are added to the report.
pub(super) fn read(
    bytes: &[u8],
    plan: &ReadPlan,
    threads: usize,
    chunk_bytes: usize,
    report: &mut DiagnosticSink,
) -> Body {
    let eol = plan.header.line_end;
    let ranges = workers::cut(plan.header.body..bytes.len(), chunk_bytes, |at| {
        memchr::memchr(eol, &bytes[at..]).map_or(bytes.len(), |length| at + length + 1)
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
    let chunks = workers::map(threads, jobs, |(range, first)| {
        let mut reader = PlyAsciiReader::new(&bytes[..range.end], plan);
        reader.read(range.start, first);
        reader.chunk
    });
    let body = merge(chunks, plan, threads, report);
    if let Some(error) = missing_rows(elements, rows, bytes) {
        let mut errors = ParseErrors::default();
        errors.push(error);
        errors.emit(report);
    }
    body
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

/// Number of lines that are not blank.
fn count_rows(text: &[u8], eol: u8) -> u64 {
    let mut count = 0;
    let mut start = 0;
    for end in memchr::memchr_iter(eol, text).chain([text.len()]) {
        // The first byte decides in most cases.
        let filled = text[start..end].iter().any(|&byte| byte > b' ');
        count += u64::from(filled);
        start = end + 1;
    }
    count
}

/// Contents of a chunk of the text.
#[derive(Default)]
struct PlyChunk {
    vertices: [Vec<f32>; 3],
    normals: [Vec<f32>; 3],
    sink: FaceSink,
    not_finite: Vec<NotFinite>,
    bad_normals: Vec<NotFinite>,
    errors: ParseErrors,
    /// Rows with more operands than the header announces.
    surplus_operands: Occurrences,
    /// The first line after the last row, if it is in this chunk.
    surplus: Option<Span>,
}

fn merge(
    mut chunks: Vec<PlyChunk>,
    plan: &ReadPlan,
    threads: usize,
    report: &mut DiagnosticSink,
) -> Body {
    let mut body = Body::default();
    let mut columns: [Vec<Vec<f32>>; 6] = Default::default();
    for chunk in &mut chunks {
        let parts = chunk.vertices.iter_mut().chain(&mut chunk.normals);
        for (column, part) in columns.iter_mut().zip(parts) {
            column.push(std::mem::take(part));
        }
    }
    let mut surplus = None;
    let mut surplus_operands = Occurrences::default();
    for chunk in chunks {
        chunk.errors.emit(report);
        body.not_finite.extend(chunk.not_finite);
        body.bad_normals.extend(chunk.bad_normals);
        body.skipped.merge(chunk.sink.skipped);
        body.faces.push(chunk.sink.faces);
        surplus = surplus.or(chunk.surplus);
        surplus_operands.merge(chunk.surplus_operands);
    }
    surplus_operands.warn(report, |count| {
        format!("{count} rows have more operands than the header announces, this one first: they are ignored")
    });
    if let Some(span) = surplus {
        report.warning(span, "this line and what follows the last row is ignored");
    }
    let [x, y, z, nx, ny, nz] = merge_floats(threads, columns);
    body.vertices = Vec3s { x, y, z };
    body.normals = plan.vertices.normal.map(|_| Vec3s {
        x: nx,
        y: ny,
        z: nz,
    });
    body
}

/// Destination of a number of a vertex.
#[derive(Clone, Copy)]
enum VertexSlot {
    Position(usize),
    Normal(usize),
    Unused,
}

struct PlyAsciiReader<'a> {
    /// The file up to the end of the chunk.
    text: &'a [u8],
    at: usize,
    plan: &'a ReadPlan,
    eol: u8,
    /// The destination of each property of a vertex.
    slots: Vec<VertexSlot>,
    corners: Vec<i64>,
    share: BudgetShare<'a>,
    chunk: PlyChunk,
}

impl<'a> PlyAsciiReader<'a> {
    fn new(text: &'a [u8], plan: &'a ReadPlan) -> PlyAsciiReader<'a> {
        let count = plan.header.elements[plan.vertices.element].properties.len();
        let slot = |index: usize| {
            let position = plan.vertices.position.iter().position(|&p| p == index);
            let normal = plan
                .vertices
                .normal
                .and_then(|n| n.iter().position(|&p| p == index));
            match (position, normal) {
                (Some(axis), _) => VertexSlot::Position(axis),
                (_, Some(axis)) => VertexSlot::Normal(axis),
                _ => VertexSlot::Unused,
            }
        };
        PlyAsciiReader {
            text,
            at: 0,
            plan,
            eol: plan.header.line_end,
            slots: (0..count).map(slot).collect(),
            corners: Vec::new(),
            share: plan.made.share(),
            chunk: PlyChunk::default(),
        }
    }

    /// Reads the rows from `start` on. The first of them has number `first` in the whole body.
    fn read(&mut self, start: usize, mut first: u64) {
        self.at = start;
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
                if !self.find_row() {
                    return;
                }
                if let Err(error) = self.row(purpose, element, row) {
                    self.chunk.errors.push(error);
                    self.skip_line();
                }
            }
            first = 0;
        }
        if self.find_row() {
            let offset = self.at;
            self.skip_line();
            let length = self.text[offset..self.at].trim_ascii_end().len();
            self.chunk.surplus = Some(Span::new(offset, length));
        }
    }

    /// Moves to the next line that is not blank.
    fn find_row(&mut self) -> bool {
        while self.text.get(self.at).is_some_and(|&byte| byte <= b' ') {
            self.at += 1;
        }
        self.at < self.text.len()
    }

    fn skip_line(&mut self) {
        let rest = &self.text[self.at..];
        self.at += memchr::memchr(self.eol, rest).unwrap_or(rest.len());
    }

    #[inline]
    fn row(&mut self, purpose: ElementUse, element: &Element, row: u64) -> Result<(), ParseError> {
        let start = self.at;
        match purpose {
            ElementUse::Vertices => self.vertex(element, row as u32)?,
            ElementUse::Faces(list) => {
                self.row_with_list(element, list, true)?;
                let span = self.since(start);
                if self.has_room(span) {
                    let vertices = self.plan.vertices.count;
                    self.chunk.sink.add(&self.corners, vertices, span)?;
                }
            }
            ElementUse::Strips(list) => {
                self.row_with_list(element, list, false)?;
                let span = self.since(start);
                if self.has_room(span) {
                    let vertices = self.plan.vertices.count;
                    self.chunk.sink.add_strips(&self.corners, vertices, span)?;
                }
            }
            ElementUse::Nothing => {
                for property in &element.properties {
                    self.pass(property)?;
                }
            }
        }
        if self.at_line_end() {
            return Ok(());
        }
        // Real files have them: MeshLab announces four numbers of a colour and writes ten.
        let offset = self.at;
        self.skip_line();
        let length = self.text[offset..self.at].trim_ascii_end().len();
        self.chunk.surplus_operands.add(Span::new(offset, length));
        Ok(())
    }

    /// Takes memory for the face with the current corners, whose row has this span.
    #[inline]
    fn has_room(&mut self, span: Span) -> bool {
        let bytes = self.plan.bytes_beyond(self.corners.len(), span.length);
        self.share.take(bytes)
    }

    fn since(&self, start: usize) -> Span {
        Span::between(start, self.at)
    }

    #[inline]
    fn vertex(&mut self, element: &Element, number: u32) -> Result<(), ParseError> {
        let start = self.at;
        let (mut position, mut normal) = ([0.0; 3], [0.0, 0.0, 1.0]);
        let read = self.vertex_numbers(element, &mut position, &mut normal);
        // A faulty vertex is stored, too, so that later ones keep their numbers.
        let span = self.since(start);
        let position = checked_position(position, number, span, &mut self.chunk.not_finite);
        push(&mut self.chunk.vertices, position);
        if self.plan.vertices.normal.is_some() {
            let normal = checked_normal(normal, number, span, &mut self.chunk.bad_normals);
            push(&mut self.chunk.normals, normal);
        }
        read
    }

    #[inline]
    fn vertex_numbers(
        &mut self,
        element: &Element,
        position: &mut [f32; 3],
        normal: &mut [f32; 3],
    ) -> Result<(), ParseError> {
        for (index, property) in element.properties.iter().enumerate() {
            match self.slots[index] {
                VertexSlot::Position(axis) => position[axis] = self.coordinate(axis)?,
                VertexSlot::Normal(axis) => normal[axis] = self.float()?,
                VertexSlot::Unused => self.pass(property)?,
            }
        }
        Ok(())
    }

    /// Reads the list of corners, which may be those of one face, and passes the rest of the row.
    #[inline]
    fn row_with_list(
        &mut self,
        element: &Element,
        list: usize,
        face: bool,
    ) -> Result<(), ParseError> {
        self.corners.clear();
        for (index, property) in element.properties.iter().enumerate() {
            if index != list {
                self.pass(property)?;
                continue;
            }
            let start = self.at;
            let count = self.list_count()?;
            if face {
                check_corners(count as usize, self.since(start))?;
            }
            for _ in 0..count {
                let corner = self.integer()?;
                self.corners.push(corner);
            }
        }
        Ok(())
    }

    /// Passes a property that is not used.
    fn pass(&mut self, property: &Property) -> Result<(), ParseError> {
        let count = match property.kind {
            PropertyKind::One(_) => 1,
            PropertyKind::List { .. } => self.list_count()?,
        };
        for _ in 0..count {
            if self.at_line_end() {
                return Err(self.missing());
            }
            self.word();
        }
        Ok(())
    }

    fn list_count(&mut self) -> Result<i64, ParseError> {
        self.skip_blanks();
        let start = self.at;
        let count = self.integer()?;
        match count {
            0.. => Ok(count),
            _ => Err(ParseError::new(
                self.since(start),
                "a list cannot have a negative count",
            )),
        }
    }

    #[inline]
    fn skip_blanks(&mut self) {
        while self
            .text
            .get(self.at)
            .is_some_and(|&byte| byte <= b' ' && byte != self.eol)
        {
            self.at += 1;
        }
    }

    #[inline]
    fn at_line_end(&mut self) -> bool {
        self.skip_blanks();
        self.text.get(self.at).is_none_or(|&byte| byte == self.eol)
    }

    /// The next word of the line; empty at its end.
    fn word(&mut self) -> Span {
        self.skip_blanks();
        let rest = &self.text[self.at..];
        let length = rest.iter().position(|&byte| byte <= b' ');
        let span = Span::new(self.at, length.unwrap_or(rest.len()));
        self.at += span.length;
        span
    }

    #[inline]
    fn float(&mut self) -> Result<f32, ParseError> {
        self.skip_blanks();
        let (value, end) = decimal::float(self.text, self.at);
        self.ended(value, end, "a number")
    }

    /// A coordinate of a vertex, from which the origin is subtracted.
    #[inline]
    fn coordinate(&mut self, axis: usize) -> Result<f32, ParseError> {
        let origin = self.plan.vertices.origin[axis];
        if origin == 0.0 {
            return self.float();
        }
        self.skip_blanks();
        let (value, end) = decimal::double(self.text, self.at);
        self.ended((value - origin) as f32, end, "a number")
    }

    #[inline]
    fn integer(&mut self) -> Result<i64, ParseError> {
        self.skip_blanks();
        let (value, end) = decimal::integer(self.text, self.at);
        self.ended(value, end, "a whole number")
    }

    /// Moves behind a number that ends here, if it is one.
    #[inline]
    fn ended<T>(&mut self, value: T, end: usize, what: &str) -> Result<T, ParseError> {
        let delimited = self.text.get(end).is_none_or(|&byte| byte <= b' ');
        if end > self.at && delimited {
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
        ParseError::new(self.since(self.at), "the row ends too early")
    }

    fn quoted(&self, span: Span) -> String {
        quoted_bytes(&self.text[span.range()])
    }
}

#[inline]
fn push(columns: &mut [Vec<f32>; 3], row: [f32; 3]) {
    for (column, number) in columns.iter_mut().zip(row) {
        column.push(number);
    }
}
