//! Columns out of binary rows of a fixed length.

use super::header::{Element, PropertyKind, Type};
use crate::diagnostics::Span;
use crate::mesh::NotFinite;
use crate::workers;

/// Takes one number out of each row and subtracts `origin`, which is 0 for numbers that single
/// precision holds.
pub(super) fn fill(
    out: &mut [f32],
    rows: &[u8],
    stride: usize,
    offset: usize,
    (kind, origin): (Type, f64),
    big: bool,
) {
    let of = PropertyColumn {
        rows,
        stride,
        offset,
    };
    let less = |number: f64| (number - origin) as f32;
    match (kind, big) {
        (Type::F32, false) => of.take(out, f32::from_le_bytes),
        (Type::F32, true) => of.take(out, f32::from_be_bytes),
        (Type::F64, false) => of.take(out, |b| less(f64::from_le_bytes(b))),
        (Type::F64, true) => of.take(out, |b| less(f64::from_be_bytes(b))),
        (Type::I8, _) => of.take(out, |b| f32::from(i8::from_le_bytes(b))),
        (Type::U8, _) => of.take(out, |b| f32::from(u8::from_le_bytes(b))),
        (Type::I16, false) => of.take(out, |b| f32::from(i16::from_le_bytes(b))),
        (Type::I16, true) => of.take(out, |b| f32::from(i16::from_be_bytes(b))),
        (Type::U16, false) => of.take(out, |b| f32::from(u16::from_le_bytes(b))),
        (Type::U16, true) => of.take(out, |b| f32::from(u16::from_be_bytes(b))),
        (Type::I32, false) => of.take(out, |b| less(i32::from_le_bytes(b).into())),
        (Type::I32, true) => of.take(out, |b| less(i32::from_be_bytes(b).into())),
        (Type::U32, false) => of.take(out, |b| less(u32::from_le_bytes(b).into())),
        (Type::U32, true) => of.take(out, |b| less(u32::from_be_bytes(b).into())),
    }
}

/// Numbers out of each row, given by their offsets and types, on several threads.
pub(super) fn columns<const N: usize>(
    rows: &[u8],
    stride: usize,
    sources: [(usize, Type); N],
    big: bool,
    (threads, rows_per_block): (usize, usize),
) -> [Vec<f32>; N] {
    let mut columns = [(); N].map(|()| vec![0.0f32; rows.len() / stride]);
    let jobs = columns
        .iter_mut()
        .zip(sources)
        .flat_map(|(column, source)| {
            let blocks = rows.chunks(rows_per_block * stride);
            let outs = column.chunks_mut(rows_per_block);
            outs.zip(blocks).map(move |(out, rows)| (out, rows, source))
        });
    workers::map(threads, jobs.collect(), |(out, rows, (offset, kind))| {
        fill(out, rows, stride, offset, (kind, 0.0), big);
    });
    columns
}

struct PropertyColumn<'a> {
    rows: &'a [u8],
    stride: usize,
    offset: usize,
}

impl PropertyColumn<'_> {
    #[inline]
    fn take<const N: usize>(&self, out: &mut [f32], convert: impl Fn([u8; N]) -> f32) {
        for (number, row) in out.iter_mut().zip(self.rows.chunks_exact(self.stride)) {
            if let Some(bytes) = row[self.offset..].first_chunk() {
                *number = convert(*bytes);
            }
        }
    }
}

/// Layout of a row that is a triangle.
pub(super) struct TriangleRowLayout {
    pub(super) stride: usize,
    /// The count of corners, which must be 3.
    pub(super) count: usize,
    pub(super) count_type: Type,
    pub(super) corners: usize,
    pub(super) item: Type,
    pub(super) big_endian: bool,
}

impl TriangleRowLayout {
    /// The corners of each row and the highest number among them; `None` if a row is not a
    /// triangle. A negative number becomes one that exceeds the vertices of every file.
    pub(super) fn triangles(&self, out: &mut [[u32; 3]], rows: &[u8]) -> Option<u32> {
        match (self.item, self.big_endian) {
            _ if !self.count_type.is_whole() => None,
            (Type::I32 | Type::U32, false) => self.take(out, rows, u32::from_le_bytes),
            (Type::I32 | Type::U32, true) => self.take(out, rows, u32::from_be_bytes),
            (Type::U16, false) => self.take(out, rows, |b| u32::from(u16::from_le_bytes(b))),
            (Type::U16, true) => self.take(out, rows, |b| u32::from(u16::from_be_bytes(b))),
            (Type::I16, false) => self.take(out, rows, |b| i16::from_le_bytes(b) as u32),
            (Type::I16, true) => self.take(out, rows, |b| i16::from_be_bytes(b) as u32),
            (Type::U8, _) => self.take(out, rows, |b| u32::from(u8::from_le_bytes(b))),
            (Type::I8, _) => self.take(out, rows, |b| i8::from_le_bytes(b) as u32),
            (Type::F32 | Type::F64, _) => None,
        }
    }

    #[inline]
    fn take<const N: usize>(
        &self,
        out: &mut [[u32; 3]],
        rows: &[u8],
        convert: impl Fn([u8; N]) -> u32,
    ) -> Option<u32> {
        // The bytes of a 3, regardless of its type.
        let mut three = [0; 8];
        let size = self.count_type.size();
        three[if self.big_endian { size - 1 } else { 0 }] = 3;
        let three = &three[..size];
        let mut highest = 0;
        for (out, row) in out.iter_mut().zip(rows.chunks_exact(self.stride)) {
            let count = &row[self.count..self.count + size];
            let fits = if size == 1 {
                count[0] == 3
            } else {
                count == three
            };
            if !fits {
                return None;
            }
            let mut corners = row[self.corners..].chunks_exact(N);
            for corner in out.iter_mut() {
                *corner = convert(*corners.next()?.first_chunk()?);
                highest = highest.max(*corner);
            }
        }
        Some(highest)
    }
}

/// Offset and type of a number in rows whose lists have `items` items each.
pub(super) fn source(element: &Element, index: usize, items: usize) -> (usize, Type) {
    let size = |kind| match kind {
        PropertyKind::One(kind) => kind.size(),
        PropertyKind::List { count, item } => count.size() + items * item.size(),
    };
    let before = &element.properties[..index];
    let offset = before.iter().map(|p| size(p.kind)).sum::<usize>();
    (offset, element.properties[index].kind.number_type())
}

/// Consecutive rows, and the output for them.
pub(super) struct RowChunk<'a, T> {
    pub(super) first: usize,
    pub(super) out: T,
    pub(super) rows: &'a [u8],
}

/// Replaces unusable vectors of a block; returns those that were replaced.
pub(super) fn checked(
    block: &mut RowChunk<[&mut [f32]; 3]>,
    span: impl Fn(usize) -> Span,
    check: &impl Fn([f32; 3], u32, Span, &mut Vec<NotFinite>) -> [f32; 3],
) -> Vec<NotFinite> {
    let mut bad = Vec::new();
    let [x, y, z] = &mut block.out;
    for (k, ((x, y), z)) in x.iter_mut().zip(y.iter_mut()).zip(z.iter_mut()).enumerate() {
        let row = block.first + k;
        [*x, *y, *z] = check([*x, *y, *z], row as u32, span(row), &mut bad);
    }
    bad
}
