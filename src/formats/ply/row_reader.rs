//! Rows one by one, in either encoding: numbers in the order of the header, and what is made of
//! them.

use super::header::{Element, Property, PropertyKind, Type};
use super::plan::{ElementUse, ReadPlan, VertexPlan};
use super::rows::{FaceRow, PlyChunk};
use super::uvs::MAX_UVS;
use crate::diagnostics::{ParseError, Span};
use crate::memory::LedgerShare;
use crate::mesh::chunk::push;
use crate::mesh::faces::check_corners;
use crate::mesh::vertex_colors::note_opacity;

/// Numbers of rows, one after the other, in one of the encodings.
pub(super) trait RowWords {
    /// The next number, less an origin.
    fn float(&mut self, kind: Type, origin: f64) -> Result<f32, ParseError>;
    /// The next number, which must be whole.
    fn integer(&mut self, kind: Type) -> Result<i64, ParseError>;
    /// The next number, as the count of a list of items.
    fn list_count(&mut self, count: Type, item: Type) -> Result<usize, ParseError>;
    /// Passes some numbers.
    fn pass(&mut self, count: usize, kind: Type) -> Result<(), ParseError>;
    /// The position of what comes next.
    fn position(&self) -> usize;
    /// The span of a face by the start of its row and by its list of corners. Its length accounts
    /// for the memory of the face.
    fn face_span(&self, row: usize, corners: Span) -> Span;
    /// Bytes that the corners of a strip take before its row is read, beyond what the row accounts
    /// for.
    fn strip_bytes(corners: usize) -> u64;
}

/// For each of `count` properties of a vertex, the origin that is subtracted from it; `None` for
/// those that are not used.
fn origins(plan: &VertexPlan, count: usize) -> Vec<Option<f64>> {
    let mut origins = vec![None; count];
    let vectors = plan
        .normal
        .into_iter()
        .chain(plan.color.map(|color| color.numbers));
    let numbers = vectors.flatten().chain(plan.uv.into_iter().flatten());
    for property in numbers.chain(plan.color.and_then(|color| color.alpha)) {
        origins[property] = Some(0.0);
    }
    for (axis, property) in plan.position.into_iter().enumerate() {
        origins[property] = Some(plan.origin[axis]);
    }
    origins
}

/// Reads rows into a chunk.
pub(super) struct PlyRowReader<'a, W> {
    pub(super) words: W,
    pub(super) plan: &'a ReadPlan<'a>,
    pub(super) chunk: PlyChunk,
    /// The origin of each property of a vertex that is used.
    origins: Vec<Option<f64>>,
    /// The numbers of a vertex, each at its property.
    numbers: Vec<f32>,
    corners: Vec<i64>,
    /// The colour of the face with these corners.
    color: [f32; 3],
    /// The texture coordinates of its corners.
    uvs: Vec<f32>,
    /// The number of its picture.
    picture: f32,
    share: LedgerShare<'a>,
}

impl<'a, W: RowWords> PlyRowReader<'a, W> {
    pub(super) fn new(words: W, plan: &'a ReadPlan<'a>) -> PlyRowReader<'a, W> {
        let count = plan.header.elements[plan.vertices.element].properties.len();
        PlyRowReader {
            words,
            plan,
            chunk: PlyChunk::default(),
            origins: origins(&plan.vertices, count),
            numbers: vec![0.0; count],
            corners: Vec::new(),
            color: [0.0; 3],
            uvs: Vec::new(),
            picture: 0.0,
            share: plan.memory.share(),
        }
    }

    /// Reads the row of this number of an element.
    #[inline]
    pub(super) fn row(
        &mut self,
        purpose: ElementUse,
        element: &Element,
        row: u64,
    ) -> Result<(), ParseError> {
        match purpose {
            ElementUse::Vertices => self.vertex(element, row as u32),
            ElementUse::Faces(list) => self.face(element, list),
            ElementUse::Strips(list) => self.strips(element, list),
            ElementUse::Nothing => self.pass_row(element),
        }
    }

    /// Passes a row.
    pub(super) fn pass_row(&mut self, element: &Element) -> Result<(), ParseError> {
        let mut properties = element.properties.iter();
        properties.try_for_each(|property| self.pass(property))
    }

    /// Passes a property that is not used.
    fn pass(&mut self, property: &Property) -> Result<(), ParseError> {
        let (count, kind) = match property.kind {
            PropertyKind::One(kind) => (1, kind),
            PropertyKind::List { count, item } => (self.words.list_count(count, item)?, item),
        };
        self.words.pass(count, kind)
    }

    #[inline]
    fn vertex(&mut self, element: &Element, number: u32) -> Result<(), ParseError> {
        let start = self.words.position();
        let read = self.vertex_numbers(element);
        if read.is_err() {
            // A faulty vertex is stored, too, so that later ones keep their numbers.
            self.numbers.fill(0.0);
        }
        let span = Span::between(start, self.words.position());
        let plan = &self.plan.vertices;
        let number_of = |property: usize| self.numbers[property];
        let mesh = &mut self.chunk.mesh;
        mesh.add_vertex(plan.position.map(number_of), number, span);
        if let Some(normal) = plan.normal {
            mesh.add_normal(normal.map(number_of), number, span);
        }
        if let Some(uv) = plan.uv {
            push(&mut mesh.uvs, uv.map(number_of));
        }
        if let Some(color) = plan.color {
            push(&mut self.chunk.colors, color.numbers.map(number_of));
            let alpha = color.alpha.map_or(1.0, number_of);
            note_opacity(alpha, span, &mut self.chunk.remarks);
        }
        read
    }

    #[inline]
    fn vertex_numbers(&mut self, element: &Element) -> Result<(), ParseError> {
        for (index, property) in element.properties.iter().enumerate() {
            match self.origins[index] {
                Some(origin) => {
                    let kind = property.kind.number_type();
                    self.numbers[index] = self.words.float(kind, origin)?;
                }
                None => self.pass(property)?,
            }
        }
        Ok(())
    }

    #[inline]
    fn face(&mut self, element: &Element, list: usize) -> Result<(), ParseError> {
        let start = self.words.position();
        let mut corners = Span::START;
        for (index, property) in element.properties.iter().enumerate() {
            match property.kind {
                PropertyKind::List { count, item } if index == list => {
                    let start = self.words.position();
                    let count = self.words.list_count(count, item)?;
                    check_corners(count, Span::between(start, self.words.position()))?;
                    corners = self.read_corners(count, item)?;
                }
                _ => self.face_property(property, index)?,
            }
        }
        let span = self.words.face_span(start, corners);
        if self.has_room(self.corners.len(), span) {
            let face = FaceRow {
                corners: &self.corners,
                color: self.plan.face_color.map(|_| self.color),
                uvs: self.plan.face_uvs.list.map(|_| &self.uvs[..]),
                picture: self.plan.face_uvs.picture.map(|_| self.picture),
            };
            let vertices = self.plan.vertices.count;
            self.chunk.add_face(face, vertices, span)?;
        }
        Ok(())
    }

    fn strips(&mut self, element: &Element, list: usize) -> Result<(), ParseError> {
        let start = self.words.position();
        let (mut corners, mut length) = (Span::START, 0);
        for (index, property) in element.properties.iter().enumerate() {
            match property.kind {
                PropertyKind::List { count, item } if index == list => {
                    length = self.words.list_count(count, item)?;
                    // Strips may be long; their corners are held as numbers for a while.
                    if self.share.take(W::strip_bytes(length)) {
                        corners = self.read_corners(length, item)?
                    } else {
                        self.words.pass(length, item)?
                    }
                }
                _ => self.pass(property)?,
            }
        }
        let span = self.words.face_span(start, corners);
        if self.has_room(length, span) {
            let vertices = self.plan.vertices.count;
            self.chunk.add_strips(&self.corners, vertices, span)?;
        }
        Ok(())
    }

    /// Reads the corners of a list; returns its span.
    #[inline]
    fn read_corners(&mut self, count: usize, item: Type) -> Result<Span, ParseError> {
        let start = self.words.position();
        self.corners.clear();
        for _ in 0..count {
            let corner = self.words.integer(item)?;
            self.corners.push(corner);
        }
        Ok(Span::between(start, self.words.position()))
    }

    /// Takes memory for a face with this number of corners. The length of the span accounts for a
    /// part of it.
    #[inline]
    fn has_room(&mut self, corners: usize, span: Span) -> bool {
        let bytes = self.plan.bytes_beyond(corners, span.length);
        self.share.take(bytes)
    }

    /// Reads a property of a face that is not its corners.
    fn face_property(&mut self, property: &Property, index: usize) -> Result<(), ParseError> {
        let color = self.plan.face_color;
        let uvs = self.plan.face_uvs;
        let kind = property.kind.number_type();
        let channel = color.and_then(|c| c.numbers.iter().position(|&p| p == index));
        match property.kind {
            PropertyKind::List { count, item } if uvs.list == Some(index) => {
                self.uvs.clear();
                for _ in 0..self.words.list_count(count, item)? {
                    let number = self.words.float(item, 0.0)?;
                    if self.uvs.len() < MAX_UVS {
                        self.uvs.push(number);
                    }
                }
            }
            _ if uvs.picture == Some(index) => self.picture = self.words.float(kind, 0.0)?,
            _ => match channel {
                Some(channel) => self.color[channel] = self.words.float(kind, 0.0)?,
                None => self.pass(property)?,
            },
        }
        Ok(())
    }
}
