//! Rows of a binary file.
//!
//! Rows without lists, and faces that are all triangles, have a fixed length. Several threads
//! extract their numbers at once. Rows that are less regular, or faulty, are read one by one.

use super::columns::{ColumnSource, TriangleRowLayout, checked, columns, fill, source};
use super::header::{Element, Encoding, PropertyKind, Type};
use super::lexer::as_integer;
use super::plan::{ElementUse, ReadPlan, VertexPlan};
use super::row_reader::{PlyRowReader, RowWords};
use super::rows::{PlyChunk, too_short};
use crate::diagnostics::{DiagnosticSink, ParseError, Span};
use crate::mesh::NotFinite;
use crate::mesh::chunk::{checked_normal, checked_position};
use crate::mesh::faces::VERTEX;
use crate::mesh::vertex_colors::note_opacity;
use crate::text::workers;
use glam::DVec3;
use phalanx_scene::huge_pages::zeroed;

/// Reads the rows of all elements, up to one with an error.
pub(super) fn read(
    bytes: &[u8],
    plan: &ReadPlan,
    threads: usize,
    chunk_bytes: usize,
    report: &mut DiagnosticSink,
) -> Vec<PlyChunk> {
    let mut reader = PlyBinaryReader {
        bytes,
        at: plan.header.body,
        big_endian: plan.header.encoding == Encoding::BigEndian,
        threads,
        chunk_bytes,
        plan,
    };
    let mut chunks = Vec::new();
    for index in 0..plan.header.elements.len() {
        chunks.push(reader.element(index));
        if (chunks.last()).is_some_and(|chunk: &PlyChunk| chunk.remarks.has_errors()) {
            return chunks;
        }
    }
    let surplus = bytes.len() - reader.at;
    if surplus > 0 {
        let span = Span::new(reader.at, surplus);
        report.warning(
            span,
            format!("{surplus} bytes behind the last row are ignored"),
        );
    }
    chunks
}

struct PlyBinaryReader<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
    threads: usize,
    chunk_bytes: usize,
    plan: &'a ReadPlan<'a>,
}

/// A position within the rows.
struct BinaryWords<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl<'a> BinaryWords<'a> {
    /// The bytes of the next items, which must be there. The error is for a row that is cut off,
    /// which the caller reports.
    #[inline]
    fn take(&mut self, count: usize, kind: Type) -> Result<&'a [u8], ParseError> {
        let end = count.checked_mul(kind.size());
        let end = end.and_then(|length| self.at.checked_add(length));
        let bytes = end.and_then(|end| self.bytes.get(self.at..end));
        let bytes = bytes.ok_or_else(|| ParseError::new(Span::at(self.at), ""))?;
        self.at += bytes.len();
        Ok(bytes)
    }
}

impl RowWords for BinaryWords<'_> {
    fn float(&mut self, kind: Type, origin: f64) -> Result<f32, ParseError> {
        let row = self.take(1, kind)?;
        let mut value = [0.0];
        fill(
            &mut value,
            row,
            row.len(),
            0,
            (kind, origin),
            self.big_endian,
        );
        Ok(value[0])
    }

    /// The next number. One with a fraction is less than any index.
    #[inline]
    fn integer(&mut self, kind: Type) -> Result<i64, ParseError> {
        let bytes = self.take(1, kind)?;
        let mut value = 0u64;
        for k in 0..bytes.len() {
            let byte = if self.big_endian { bytes[k] } else { bytes[bytes.len() - 1 - k] };
            value = value << 8 | u64::from(byte);
        }
        Ok(match kind {
            Type::I8 => i64::from(value as i8),
            Type::I16 => i64::from(value as i16),
            Type::I32 => i64::from(value as i32),
            Type::F32 => as_integer(f32::from_bits(value as u32).into()).unwrap_or(i64::MIN),
            Type::F64 => as_integer(f64::from_bits(value)).unwrap_or(i64::MIN),
            _ => value as i64,
        })
    }

    #[inline]
    fn list_count(&mut self, count: Type, item: Type) -> Result<usize, ParseError> {
        // A negative count is too large for the file.
        let count = self.integer(count)? as usize;
        let items = self.at;
        self.take(count, item)?;
        self.at = items;
        Ok(count)
    }

    fn pass(&mut self, count: usize, kind: Type) -> Result<(), ParseError> {
        self.take(count, kind).map(drop)
    }

    fn position(&self) -> usize {
        self.at
    }

    fn face_span(&self, _: usize, corners: Span) -> Span {
        corners
    }

    fn strip_bytes(corners: usize) -> u64 {
        8 * corners as u64
    }
}

impl<'a> PlyBinaryReader<'a> {
    fn element(&mut self, index: usize) -> PlyChunk {
        let plan = self.plan;
        let element = &plan.header.elements[index];
        let mut chunk = PlyChunk::default();
        let least = element.least_bytes();
        if least == 0 {
            return chunk;
        }
        let room = (self.bytes.len() - self.at) / least;
        if element.count > room as u64 {
            let error = too_short(element, room as u64, self.bytes.len());
            chunk.remarks.error(error);
            return chunk;
        }
        let count = element.count as usize;
        let purpose = plan.purpose(index);
        let regular = match purpose {
            ElementUse::Vertices | ElementUse::Nothing if element.has_lists() => None,
            ElementUse::Vertices => {
                self.vertices(element, count, &mut chunk);
                Some(count * least)
            }
            ElementUse::Faces(list) => self.triangles(element, list, count, &mut chunk),
            ElementUse::Strips(_) => None,
            ElementUse::Nothing => Some(count * least),
        };
        match regular {
            Some(length) => self.at += length,
            None => chunk = self.walk(element, purpose),
        }
        chunk
    }

    /// Reads rows one by one. Rows that are complete do not end it, whatever is wrong with them.
    fn walk(&mut self, element: &Element, purpose: ElementUse) -> PlyChunk {
        let words = BinaryWords {
            bytes: self.bytes,
            at: self.at,
            big_endian: self.big_endian,
        };
        let mut reader = PlyRowReader::new(words, self.plan);
        for row in 0..element.count {
            let start = reader.words.at;
            let Err(error) = reader.row(purpose, element, row) else {
                continue;
            };
            reader.words.at = start;
            let complete = reader.pass_row(element).is_ok();
            let cut_off = || too_short(element, row, self.bytes.len());
            let error = if complete { error } else { cut_off() };
            reader.chunk.remarks.error(error);
            if !complete || reader.chunk.remarks.is_full() {
                break;
            }
        }
        self.at = reader.words.at;
        reader.chunk
    }

    /// Reads vertices of a fixed length, for which there is memory.
    fn vertices(&self, element: &Element, count: usize, chunk: &mut PlyChunk) {
        let VertexPlan {
            position, origin, ..
        } = self.plan.vertices;
        (chunk.mesh.vertices, chunk.mesh.not_finite) =
            self.vectors(element, count, (position, origin), checked_position);
        if let Some(normal) = self.plan.vertices.normal {
            (chunk.mesh.normals, chunk.mesh.bad_normals) =
                self.vectors(element, count, (normal, DVec3::ZERO), checked_normal);
        }
        if let Some(color) = self.plan.vertices.color {
            chunk.colors = self.numbers(element, count, color.numbers);
            let alpha = color
                .alpha
                .map(|index| self.numbers(element, count, [index]));
            let stride = element.least_bytes();
            for (row, &alpha) in alpha.iter().flatten().flatten().enumerate() {
                let span = Span::new(self.at + row * stride, stride);
                note_opacity(alpha, span, &mut chunk.remarks);
            }
        }
        if let Some(uv) = self.plan.vertices.uv {
            chunk.mesh.uvs = self.numbers(element, count, uv);
        }
    }

    /// Some properties of each row of a fixed length, as they are.
    fn numbers<const N: usize>(
        &self,
        element: &Element,
        count: usize,
        properties: [usize; N],
    ) -> [Vec<f32>; N] {
        let sources = properties.map(|index| source(element, index, 0));
        let stride = element.least_bytes();
        self.columns(count, stride, sources, |_, _| Vec::new()).0
    }

    /// Three properties of each row, less an origin, replaced by `check` if they are unusable.
    fn vectors(
        &self,
        element: &Element,
        count: usize,
        (properties, origin): ([usize; 3], DVec3),
        check: impl Fn([f32; 3], u32, Span, &mut Vec<NotFinite>) -> [f32; 3] + Sync,
    ) -> ([Vec<f32>; 3], Vec<NotFinite>) {
        let stride = element.least_bytes();
        let span = |row: usize| Span::new(self.at + row * stride, stride);
        let sources = [0, 1, 2].map(|axis| {
            let (offset, kind, _) = source(element, properties[axis], 0);
            (offset, kind, origin[axis])
        });
        self.columns(count, stride, sources, |first, block| {
            checked(first, block, span, &check)
        })
    }

    fn columns<const N: usize>(
        &self,
        count: usize,
        stride: usize,
        sources: [ColumnSource; N],
        check: impl Fn(usize, [&mut [f32]; N]) -> Vec<NotFinite> + Sync,
    ) -> ([Vec<f32>; N], Vec<NotFinite>) {
        let rows = &self.bytes[self.at..self.at + count * stride];
        let blocks = self.blocks(stride);
        columns(rows, stride, sources, self.big_endian, blocks, check)
    }

    /// The number of threads, and of rows of this length that one takes at a time.
    fn blocks(&self, stride: usize) -> (usize, usize) {
        (self.threads, (self.chunk_bytes / stride).max(1))
    }

    /// Reads faces that are all correct and have three corners; returns their length in bytes.
    /// `None` for others.
    fn triangles(
        &self,
        element: &Element,
        list: usize,
        count: usize,
        chunk: &mut PlyChunk,
    ) -> Option<usize> {
        let PropertyKind::List {
            count: count_type,
            item,
        } = element.properties[list].kind
        else {
            return None;
        };
        if self.plan.face_uvs.picture.is_some() {
            return None;
        }
        let size = |index: usize| match element.properties[index].kind {
            PropertyKind::One(kind) => Some(kind.size()),
            PropertyKind::List { .. } => None,
        };
        let before = (0..list).map(size).sum::<Option<usize>>()?;
        let after = list + 1..element.properties.len();
        let after = after.map(size).sum::<Option<usize>>()?;
        let first = before + count_type.size();
        let stride = first + 3 * item.size() + after;
        let length = count.checked_mul(stride)?;
        let rows = self.bytes[self.at..].get(..length)?;
        let layout = TriangleRowLayout {
            stride,
            count: before,
            count_type,
            corners: first,
            item,
            big_endian: self.big_endian,
        };
        let bytes = self.plan.bytes_beyond(3, stride);
        let bytes = bytes.saturating_mul(count as u64);
        if !self.plan.memory.share().take(bytes) {
            return Some(length);
        }
        let mut corners = zeroed(count);
        let (threads, size) = self.blocks(stride);
        let blocks = corners.chunks_mut(size).zip(rows.chunks(size * stride));
        let vertices = self.plan.vertices.count;
        let right = workers::map(threads, blocks.collect(), |(out, rows)| {
            let highest = layout.triangles(out, rows);
            highest.is_some_and(|highest| u64::from(highest) < vertices)
        });
        if !right.into_iter().all(|right| right) {
            return None;
        }
        chunk.mesh.faces.columns[VERTEX] = corners;
        if let Some(color) = self.plan.face_color {
            let sources = color.numbers.map(|index| source(element, index, 3));
            let rgb = self.columns(count, stride, sources, |_, _| Vec::new()).0;
            chunk.face_colors.rgb = rgb;
            chunk.face_colors.numbers = (0..count as u32).collect();
        }
        Some(length)
    }
}
