//! Rows of an ascii file: one on each line that is neither blank nor a comment.
//!
//! Lines are counted first, so that the rows of each chunk of the text are known. Then several
//! threads read the chunks. If rows and lines do not agree, the words of the file are read once
//! more without regard to lines: some programs break rows, and others write several on a line.

use super::header::{Element, Property};
use super::lexer::{NO_ROW_END, PlyLexer, count_rows};
use super::plan::{ElementUse, ReadPlan, VertexPlan};
use super::rows::{
    Body, FaceRow, FaceSink, check_corners, checked_normal, checked_position, too_short,
};
use super::uvs::MAX_UVS;
use crate::diagnostics::{DiagnosticSink, Span};
use crate::memory_budget::BudgetShare;
use crate::mesh::{NotFinite, Occurrences, ParseError, ParseErrors, merge_floats};
use crate::workers;
use phalanx_scene::{Vec2s, Vec3s};
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
    let missing = missing_rows(elements, rows, bytes);
    if missing.is_some() || chunks.iter().any(|chunk| !chunk.errors.is_empty()) {
        let counted = plan.made.used();
        plan.made.reset(0);
        if let Some((chunk, span)) = PlyAsciiReader::new(bytes, plan).read_words() {
            report.warning(
                span,
                "rows and lines do not agree from here on: rows are read by their words",
            );
            return merge(vec![chunk], plan, threads, report);
        }
        plan.made.reset(counted);
    }
    let body = merge(chunks, plan, threads, report);
    if let Some(error) = missing {
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

/// Contents of a chunk of the text.
#[derive(Default)]
struct PlyChunk {
    vertices: [Vec<f32>; 3],
    normals: [Vec<f32>; 3],
    colors: [Vec<f32>; 3],
    uvs: [Vec<f32>; 2],
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
    let mut columns: [Vec<Vec<f32>>; 11] = Default::default();
    for chunk in &mut chunks {
        let parts = chunk.vertices.iter_mut().chain(&mut chunk.normals);
        let parts = parts.chain(&mut chunk.colors).chain(&mut chunk.uvs);
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
        body.face_colors.push(chunk.sink.colors);
        body.face_uvs.push(chunk.sink.uvs);
        surplus = surplus.or(chunk.surplus);
        surplus_operands.merge(chunk.surplus_operands);
    }
    surplus_operands.warn(report, |count| {
        format!("{count} rows have more operands than the header announces, this one first: they are ignored")
    });
    if surplus_operands.count > 0 {
        // MeshLab writes colours of corners where it announces those of faces.
        body.face_colors.clear();
    }
    if let Some(span) = surplus {
        report.warning(span, "this line and what follows the last row is ignored");
    }
    let [x, y, z, nx, ny, nz, r, g, b, u, v] = merge_floats(threads, columns);
    let vectors = |x, y, z| Vec3s { x, y, z };
    body.vertices = vectors(x, y, z);
    body.normals = plan.vertices.normal.map(|_| vectors(nx, ny, nz));
    body.colors = plan.vertices.color.map(|_| vectors(r, g, b));
    body.uvs = plan.vertices.uv.map(|_| Vec2s { x: u, y: v });
    body
}

/// Destination of a number of a vertex.
#[derive(Clone, Copy)]
enum VertexSlot {
    Position(usize),
    Normal(usize),
    Color(usize),
    Uv(usize),
    Unused,
}

/// Numbers of a vertex that are used.
struct VertexNumbers {
    position: [f32; 3],
    normal: [f32; 3],
    color: [f32; 3],
    uv: [f32; 2],
}

struct PlyAsciiReader<'a> {
    words: PlyLexer<'a>,
    plan: &'a ReadPlan,
    /// The destination of each property of a vertex.
    slots: Vec<VertexSlot>,
    corners: Vec<i64>,
    /// The colour of the face with these corners.
    color: [f32; 3],
    /// The texture coordinates of its corners.
    uvs: Vec<f32>,
    /// The number of its picture.
    picture: f32,
    share: BudgetShare<'a>,
    chunk: PlyChunk,
}

impl<'a> PlyAsciiReader<'a> {
    fn new(text: &'a [u8], plan: &'a ReadPlan) -> PlyAsciiReader<'a> {
        let count = plan.header.elements[plan.vertices.element].properties.len();
        let slot = |index: usize| {
            let VertexPlan {
                position,
                normal,
                color,
                uv,
                ..
            } = &plan.vertices;
            let place = |numbers: &[usize]| numbers.iter().position(|&number| number == index);
            let normal = normal.as_ref().and_then(|normal| place(normal));
            let color = color.as_ref().and_then(|color| place(&color.numbers));
            let uv = uv.as_ref().and_then(|uv| place(uv));
            match (place(position), normal, color, uv) {
                (Some(axis), ..) => VertexSlot::Position(axis),
                (_, Some(axis), ..) => VertexSlot::Normal(axis),
                (.., Some(channel), _) => VertexSlot::Color(channel),
                (.., Some(axis)) => VertexSlot::Uv(axis),
                _ => VertexSlot::Unused,
            }
        };
        PlyAsciiReader {
            words: PlyLexer {
                text,
                at: 0,
                eol: plan.header.line_end,
                line_end: plan.header.line_end,
            },
            plan,
            slots: (0..count).map(slot).collect(),
            corners: Vec::new(),
            color: [0.0; 3],
            uvs: Vec::new(),
            picture: 0.0,
            share: plan.made.share(),
            chunk: PlyChunk::default(),
        }
    }

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
                if let Err(error) = self.row(purpose, element, row) {
                    self.chunk.errors.push(error);
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
            let rows = match element.properties.is_empty() {
                true => 0,
                false => element.count,
            };
            for row in 0..rows {
                let before = self.words.at;
                if !self.words.find_row() {
                    return None;
                }
                let start = self.words.at;
                self.row(purpose, element, row).ok()?;
                let ends_line = |from: usize, to: usize| {
                    memchr::memchr(plan.header.line_end, &self.words.text[from..to]).is_some()
                };
                if ends_line(start, self.words.at) {
                    broken.get_or_insert(self.words.since(start));
                }
                if start > plan.header.body
                    && before > plan.header.body
                    && !ends_line(before, start)
                {
                    joined.get_or_insert(self.words.since(start));
                }
                if broken.is_some() && joined.is_some() {
                    return None;
                }
            }
        }
        let span = broken.or(joined)?;
        (!self.words.find_row()).then_some((self.chunk, span))
    }

    #[inline]
    fn row(&mut self, purpose: ElementUse, element: &Element, row: u64) -> Result<(), ParseError> {
        let start = self.words.at;
        match purpose {
            ElementUse::Vertices => self.vertex(element, row as u32)?,
            ElementUse::Faces(list) => {
                self.row_with_list(element, list, true)?;
                let span = self.words.since(start);
                if self.has_room(span) {
                    let vertices = self.plan.vertices.count;
                    let face = FaceRow {
                        corners: &self.corners,
                        color: self.plan.face_color.map(|_| self.color),
                        uvs: self.plan.face_uvs.list.map(|_| &self.uvs[..]),
                        picture: self.plan.face_uvs.picture.map(|_| self.picture),
                    };
                    self.chunk.sink.add(face, vertices, span)?;
                }
            }
            ElementUse::Strips(list) => {
                self.row_with_list(element, list, false)?;
                let span = self.words.since(start);
                if self.has_room(span) {
                    let vertices = self.plan.vertices.count;
                    self.chunk.sink.add_strips(&self.corners, vertices, span)?;
                }
            }
            ElementUse::Nothing => {
                for property in &element.properties {
                    self.words.pass(property)?;
                }
            }
        }
        if self.words.eol == NO_ROW_END || self.words.at_line_end() {
            return Ok(());
        }
        // Real files have them: MeshLab announces four numbers of a colour and writes ten.
        let surplus = self.words.rest_of_line();
        self.chunk.surplus_operands.add(surplus);
        Ok(())
    }

    /// Takes memory for the face with the current corners, whose row has this span.
    #[inline]
    fn has_room(&mut self, span: Span) -> bool {
        let bytes = self.plan.bytes_beyond(self.corners.len(), span.length);
        self.share.take(bytes)
    }

    #[inline]
    fn vertex(&mut self, element: &Element, number: u32) -> Result<(), ParseError> {
        let start = self.words.at;
        let mut numbers = VertexNumbers {
            position: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            color: [0.0; 3],
            uv: [0.0; 2],
        };
        let read = self.vertex_numbers(element, &mut numbers);
        let VertexNumbers {
            position,
            normal,
            color,
            uv,
        } = numbers;
        // A faulty vertex is stored, too, so that later ones keep their numbers.
        let span = self.words.since(start);
        let position = checked_position(position, number, span, &mut self.chunk.not_finite);
        push(&mut self.chunk.vertices, position);
        if self.plan.vertices.normal.is_some() {
            let normal = checked_normal(normal, number, span, &mut self.chunk.bad_normals);
            push(&mut self.chunk.normals, normal);
        }
        if self.plan.vertices.color.is_some() {
            push(&mut self.chunk.colors, color);
        }
        if self.plan.vertices.uv.is_some() {
            push(&mut self.chunk.uvs, uv);
        }
        read
    }

    #[inline]
    fn vertex_numbers(
        &mut self,
        element: &Element,
        numbers: &mut VertexNumbers,
    ) -> Result<(), ParseError> {
        let origin = self.plan.vertices.origin;
        for (index, property) in element.properties.iter().enumerate() {
            match self.slots[index] {
                VertexSlot::Position(axis) => {
                    numbers.position[axis] = self.words.coordinate(origin[axis])?
                }
                VertexSlot::Normal(axis) => numbers.normal[axis] = self.words.float()?,
                VertexSlot::Color(channel) => numbers.color[channel] = self.words.float()?,
                VertexSlot::Uv(axis) => numbers.uv[axis] = self.words.float()?,
                VertexSlot::Unused => self.words.pass(property)?,
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
                match face {
                    true => self.face_property(property, index)?,
                    false => self.words.pass(property)?,
                }
                continue;
            }
            let start = self.words.at;
            let count = self.words.list_count()?;
            if face {
                check_corners(count as usize, self.words.since(start))?;
            }
            for _ in 0..count {
                let corner = self.words.integer()?;
                self.corners.push(corner);
            }
        }
        Ok(())
    }

    /// Reads a property of a face that is not its corners.
    fn face_property(&mut self, property: &Property, index: usize) -> Result<(), ParseError> {
        let color = self.plan.face_color;
        let uvs = self.plan.face_uvs;
        let channel = color.and_then(|c| c.numbers.iter().position(|&p| p == index));
        if let Some(channel) = channel {
            self.color[channel] = self.words.float()?;
        } else if uvs.list == Some(index) {
            self.uvs.clear();
            for _ in 0..self.words.list_count()? {
                let number = self.words.float()?;
                if self.uvs.len() < MAX_UVS {
                    self.uvs.push(number);
                }
            }
        } else if uvs.picture == Some(index) {
            self.picture = self.words.float()?;
        } else {
            self.words.pass(property)?;
        }
        Ok(())
    }
}

#[inline]
fn push<const N: usize>(columns: &mut [Vec<f32>; N], row: [f32; N]) {
    for (column, number) in columns.iter_mut().zip(row) {
        column.push(number);
    }
}
