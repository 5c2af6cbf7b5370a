//! Columns out of binary rows of a fixed length.

use super::header::{Element, PropertyKind, Type};
use crate::diagnostics::Span;
use crate::mesh::NotFinite;
use crate::text::workers;
use phalanx_scene::huge_pages::zeroed;

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
    let column = PropertyColumn {
        rows,
        stride,
        offset,
    };
    let less = |number: f64| (number - origin) as f32;
    match (kind, big) {
        (Type::F32, false) => column.take(out, f32::from_le_bytes),
        (Type::F32, true) => column.take(out, f32::from_be_bytes),
        (Type::F64, false) => column.take(out, |b| less(f64::from_le_bytes(b))),
        (Type::F64, true) => column.take(out, |b| less(f64::from_be_bytes(b))),
        (Type::I8, _) => column.take(out, |b| f32::from(i8::from_le_bytes(b))),
        (Type::U8, _) => column.take(out, |b| f32::from(u8::from_le_bytes(b))),
        (Type::I16, false) => column.take(out, |b| f32::from(i16::from_le_bytes(b))),
        (Type::I16, true) => column.take(out, |b| f32::from(i16::from_be_bytes(b))),
        (Type::U16, false) => column.take(out, |b| f32::from(u16::from_le_bytes(b))),
        (Type::U16, true) => column.take(out, |b| f32::from(u16::from_be_bytes(b))),
        (Type::I32, false) => column.take(out, |b| less(i32::from_le_bytes(b).into())),
        (Type::I32, true) => column.take(out, |b| less(i32::from_be_bytes(b).into())),
        (Type::U32, false) => column.take(out, |b| less(u32::from_le_bytes(b).into())),
        (Type::U32, true) => column.take(out, |b| less(u32::from_be_bytes(b).into())),
    }
}

/// Source of a column: the offset and type of its number in each row, and the origin to subtract.
pub(super) type ColumnSource = (usize, Type, f64);

/// Columns out of rows, on several threads. `check` gets each block of them, with the number of its
/// first row, and returns the rows that it replaced.
pub(super) fn columns<const N: usize>(
    rows: &[u8],
    stride: usize,
    sources: [ColumnSource; N],
    big: bool,
    (threads, rows_per_block): (usize, usize),
    check: impl Fn(usize, [&mut [f32]; N]) -> Vec<NotFinite> + Sync,
) -> ([Vec<f32>; N], Vec<NotFinite>) {
    let mut columns = [(); N].map(|()| zeroed(rows.len() / stride));
    let mut parts = columns.each_mut().map(|c| c.chunks_mut(rows_per_block));
    let blocks = rows.chunks(rows_per_block * stride).enumerate();
    let blocks = blocks.map(|(k, rows)| {
        let outs = parts.each_mut().map(|p| p.next().unwrap_or_default());
        (k * rows_per_block, rows, outs)
    });
    let bad = workers::map(threads, blocks.collect(), |(first, rows, mut outs)| {
        for (out, (offset, kind, origin)) in outs.iter_mut().zip(sources) {
            fill(out, rows, stride, offset, (kind, origin), big);
        }
        check(first, outs)
    });
    (columns, bad.into_iter().flatten().collect())
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
            let fits = if size == 1 { count[0] == 3 } else { count == three };
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

/// Source of a property in rows whose lists have `items` items each.
pub(super) fn source(element: &Element, index: usize, items: usize) -> ColumnSource {
    let size = |kind| match kind {
        PropertyKind::One(kind) => kind.size(),
        PropertyKind::List { count, item } => count.size() + items * item.size(),
    };
    let before = &element.properties[..index];
    let offset = before.iter().map(|p| size(p.kind)).sum::<usize>();
    (offset, element.properties[index].kind.number_type(), 0.0)
}

/// Replaces unusable vectors of a block; returns those that were replaced.
pub(super) fn checked(
    first: usize,
    [x, y, z]: [&mut [f32]; 3],
    span: impl Fn(usize) -> Span,
    check: &impl Fn([f32; 3], u32, Span, &mut Vec<NotFinite>) -> [f32; 3],
) -> Vec<NotFinite> {
    let mut bad = Vec::new();
    for (row, ((x, y), z)) in (first..).zip(x.iter_mut().zip(y).zip(z)) {
        [*x, *y, *z] = check([*x, *y, *z], row as u32, span(row), &mut bad);
    }
    bad
}
