//! Rows of an ascii file: one on each line that is not blank.
//!
//! Lines are counted first, so that each piece of the text knows which rows it holds; then several threads read the
//! pieces.

use super::header::{Element, Kind, Property};
use super::rows::{FaceSink, check_corners, checked_normal, checked_place, too_short};
use super::{Body, Plan, Purpose};
use crate::formats::allowance::Share;
use crate::formats::decimal;
use crate::formats::mesh::{Fault, Faults, NotFinite, Tally, join_floats};
use crate::formats::report::{Place, Report, quoted};
use crate::formats::workers;
use phalanx_scene::Vec3s;
use std::ops::Range;

/// Reads the rows of all elements; what is wrong stands in the report.
pub(super) fn read(
    bytes: &[u8],
    plan: &Plan,
    threads: usize,
    piece: usize,
    report: &mut Report,
) -> Body {
    let eol = plan.header.line_end;
    let ranges = workers::cut(plan.header.body..bytes.len(), piece, |at| {
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
    let pieces = workers::map(threads, jobs, |(range, first)| {
        let mut reader = Reader::new(&bytes[..range.end], plan);
        reader.read(range.start, first);
        reader.piece
    });
    let body = join(pieces, plan, threads, report);
    if let Some(fault) = missing_rows(elements, rows, bytes) {
        let mut faults = Faults::default();
        faults.push(fault);
        faults.tell(report);
    }
    body
}

/// The first element that is not complete.
fn missing_rows(elements: &[Element], rows: u64, bytes: &[u8]) -> Option<Fault> {
    let mut left = rows;
    for element in elements.iter().filter(|e| !e.properties.is_empty()) {
        if element.count > left {
            return Some(too_short(element, left, bytes.trim_ascii_end().len()));
        }
        left -= element.count;
    }
    None
}

/// Lines with anything on them.
fn count_rows(text: &[u8], eol: u8) -> u64 {
    let mut count = 0;
    let mut start = 0;
    for end in memchr::memchr_iter(eol, text).chain([text.len()]) {
        // Mostly told by its first byte.
        let filled = text[start..end].iter().any(|&byte| byte > b' ');
        count += u64::from(filled);
        start = end + 1;
    }
    count
}

/// What a piece of the text holds.
#[derive(Default)]
struct Piece {
    vertices: [Vec<f32>; 3],
    normals: [Vec<f32>; 3],
    sink: FaceSink,
    not_finite: Vec<NotFinite>,
    bad_normals: Vec<NotFinite>,
    faults: Faults,
    /// Rows with more operands than the header announces.
    surplus_operands: Tally,
    /// The first line behind the last row, if it is in this piece.
    surplus: Option<Place>,
}

fn join(mut pieces: Vec<Piece>, plan: &Plan, threads: usize, report: &mut Report) -> Body {
    let mut body = Body::default();
    let mut columns: [Vec<Vec<f32>>; 6] = Default::default();
    for piece in &mut pieces {
        let parts = piece.vertices.iter_mut().chain(&mut piece.normals);
        for (column, part) in columns.iter_mut().zip(parts) {
            column.push(std::mem::take(part));
        }
    }
    let mut surplus = None;
    let mut surplus_operands = Tally::default();
    for piece in pieces {
        piece.faults.tell(report);
        body.not_finite.extend(piece.not_finite);
        body.bad_normals.extend(piece.bad_normals);
        body.skipped.merge(piece.sink.skipped);
        body.faces.push(piece.sink.faces);
        surplus = surplus.or(piece.surplus);
        surplus_operands.merge(piece.surplus_operands);
    }
    surplus_operands.warn(report, |count| {
        format!("{count} rows have more operands than the header announces, this one first: they are ignored")
    });
    if let Some(place) = surplus {
        report.warning(place, "this line and what follows the last row is ignored");
    }
    let [x, y, z, nx, ny, nz] = join_floats(threads, columns);
    body.vertices = Vec3s { x, y, z };
    body.normals = plan.vertices.normal.map(|_| Vec3s {
        x: nx,
        y: ny,
        z: nz,
    });
    body
}

/// What becomes of a number of a vertex.
#[derive(Clone, Copy)]
enum Slot {
    Place(usize),
    Normal(usize),
    Unused,
}

struct Reader<'a> {
    /// The file up to the end of the piece.
    text: &'a [u8],
    at: usize,
    plan: &'a Plan,
    eol: u8,
    /// For each property of a vertex.
    slots: Vec<Slot>,
    corners: Vec<i64>,
    share: Share<'a>,
    piece: Piece,
}

impl<'a> Reader<'a> {
    fn new(text: &'a [u8], plan: &'a Plan) -> Reader<'a> {
        let count = plan.header.elements[plan.vertices.element].properties.len();
        let slot = |index: usize| {
            let place = plan.vertices.place.iter().position(|&p| p == index);
            let normal = plan
                .vertices
                .normal
                .and_then(|n| n.iter().position(|&p| p == index));
            match (place, normal) {
                (Some(axis), _) => Slot::Place(axis),
                (_, Some(axis)) => Slot::Normal(axis),
                _ => Slot::Unused,
            }
        };
        Reader {
            text,
            at: 0,
            plan,
            eol: plan.header.line_end,
            slots: (0..count).map(slot).collect(),
            corners: Vec::new(),
            share: plan.made.share(),
            piece: Piece::default(),
        }
    }

    /// Reads the rows from `start` on, the first of which has number `first` in the whole body.
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
                if let Err(fault) = self.row(purpose, element, row) {
                    self.piece.faults.push(fault);
                    self.skip_line();
                }
            }
            first = 0;
        }
        if self.find_row() {
            let offset = self.at;
            self.skip_line();
            let length = self.text[offset..self.at].trim_ascii_end().len();
            self.piece.surplus = Some(Place { offset, length });
        }
    }

    /// Goes to the next line with anything on it.
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
    fn row(&mut self, purpose: Purpose, element: &Element, row: u64) -> Result<(), Fault> {
        let start = self.at;
        match purpose {
            Purpose::Vertices => self.vertex(element, row as u32)?,
            Purpose::Faces(list) => {
                self.row_with_list(element, list, true)?;
                let place = self.since(start);
                if self.has_room(place) {
                    let vertices = self.plan.vertices.count;
                    self.piece.sink.add(&self.corners, vertices, place)?;
                }
            }
            Purpose::Strips(list) => {
                self.row_with_list(element, list, false)?;
                let place = self.since(start);
                if self.has_room(place) {
                    let vertices = self.plan.vertices.count;
                    self.piece.sink.add_strips(&self.corners, vertices, place)?;
                }
            }
            Purpose::Nothing => {
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
        self.piece.surplus_operands.add(Place { offset, length });
        Ok(())
    }

    /// Takes memory for the face of the corners at hand, which stand here.
    #[inline]
    fn has_room(&mut self, place: Place) -> bool {
        let bytes = self.plan.bytes_beyond(self.corners.len(), place.length);
        self.share.take(bytes)
    }

    fn since(&self, start: usize) -> Place {
        Place {
            offset: start,
            length: self.at - start,
        }
    }

    #[inline]
    fn vertex(&mut self, element: &Element, number: u32) -> Result<(), Fault> {
        let start = self.at;
        let (mut place, mut normal) = ([0.0; 3], [0.0, 0.0, 1.0]);
        let read = self.vertex_numbers(element, &mut place, &mut normal);
        // Even a faulty one, so that those behind it keep their numbers.
        let span = self.since(start);
        let place = checked_place(place, number, span, &mut self.piece.not_finite);
        push(&mut self.piece.vertices, place);
        if self.plan.vertices.normal.is_some() {
            let normal = checked_normal(normal, number, span, &mut self.piece.bad_normals);
            push(&mut self.piece.normals, normal);
        }
        read
    }

    #[inline]
    fn vertex_numbers(
        &mut self,
        element: &Element,
        place: &mut [f32; 3],
        normal: &mut [f32; 3],
    ) -> Result<(), Fault> {
        for (index, property) in element.properties.iter().enumerate() {
            match self.slots[index] {
                Slot::Place(axis) => place[axis] = self.coordinate(axis)?,
                Slot::Normal(axis) => normal[axis] = self.float()?,
                Slot::Unused => self.pass(property)?,
            }
        }
        Ok(())
    }

    /// Reads the list of corners, which may be those of one face, and passes the rest.
    #[inline]
    fn row_with_list(&mut self, element: &Element, list: usize, face: bool) -> Result<(), Fault> {
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

    /// Passes a property that nobody wants.
    fn pass(&mut self, property: &Property) -> Result<(), Fault> {
        let count = match property.kind {
            Kind::One(_) => 1,
            Kind::List { .. } => self.list_count()?,
        };
        for _ in 0..count {
            if self.at_line_end() {
                return Err(self.missing());
            }
            self.word();
        }
        Ok(())
    }

    fn list_count(&mut self) -> Result<i64, Fault> {
        self.skip_blanks();
        let start = self.at;
        let count = self.integer()?;
        match count {
            0.. => Ok(count),
            _ => Err(Fault::new(
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
    fn word(&mut self) -> Place {
        self.skip_blanks();
        let rest = &self.text[self.at..];
        let length = rest.iter().position(|&byte| byte <= b' ');
        let place = Place {
            offset: self.at,
            length: length.unwrap_or(rest.len()),
        };
        self.at += place.length;
        place
    }

    #[inline]
    fn float(&mut self) -> Result<f32, Fault> {
        self.skip_blanks();
        let (value, end) = decimal::float(self.text, self.at);
        self.ended(value, end, "a number")
    }

    /// A coordinate of a vertex, taken from the origin.
    #[inline]
    fn coordinate(&mut self, axis: usize) -> Result<f32, Fault> {
        let origin = self.plan.vertices.origin[axis];
        if origin == 0.0 {
            return self.float();
        }
        self.skip_blanks();
        let (value, end) = decimal::double(self.text, self.at);
        self.ended((value - origin) as f32, end, "a number")
    }

    #[inline]
    fn integer(&mut self) -> Result<i64, Fault> {
        self.skip_blanks();
        let (value, end) = decimal::integer(self.text, self.at);
        self.ended(value, end, "a whole number")
    }

    /// Goes behind a number that ends here, if it is one.
    #[inline]
    fn ended<T>(&mut self, value: T, end: usize, what: &str) -> Result<T, Fault> {
        let delimited = self.text.get(end).is_none_or(|&byte| byte <= b' ');
        if end > self.at && delimited {
            self.at = end;
            return Ok(value);
        }
        Err(self.no_number(what))
    }

    #[cold]
    fn no_number(&mut self, what: &str) -> Fault {
        if self.at_line_end() {
            return self.missing();
        }
        let word = self.word();
        Fault::new(word, format!("{} is not {what}", self.quoted(word)))
    }

    #[cold]
    fn missing(&self) -> Fault {
        Fault::new(self.since(self.at), "the row ends too early")
    }

    fn quoted(&self, place: Place) -> String {
        let bytes = &self.text[place.offset..place.offset + place.length.min(200)];
        quoted(&String::from_utf8_lossy(bytes))
    }
}

#[inline]
fn push(columns: &mut [Vec<f32>; 3], row: [f32; 3]) {
    for (column, number) in columns.iter_mut().zip(row) {
        column.push(number);
    }
}
