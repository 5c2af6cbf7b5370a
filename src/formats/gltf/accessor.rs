//! Accessors: typed rows in a buffer view, with or without sparse replacements. Rows are read one
//! by one from the buffer, so that no allocation depends on a count.

use super::document::{GltfAccessor, Sparse};
use super::source::GltfSource;
use std::collections::BTreeMap;

/// An accessor whose last row has been checked to exist.
#[derive(Clone, Copy)]
pub(super) struct Accessor<'a> {
    /// Number of rows.
    pub(super) count: usize,
    /// Number of components of a row.
    pub(super) width: usize,
    rows: Option<StridedRows<'a>>,
    kind: Component,
    normalized: bool,
    replaced: Option<SparseOverride<'a>>,
}

#[derive(Clone, Copy)]
struct StridedRows<'a> {
    bytes: &'a [u8],
    stride: usize,
}

#[derive(Clone, Copy)]
struct SparseOverride<'a> {
    count: usize,
    indices: StridedRows<'a>,
    index_kind: Component,
    values: StridedRows<'a>,
}

#[derive(Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(number: u32) -> Result<Component, String> {
        Ok(match number {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return Err(format!("there is no component type {number}")),
        })
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// A component as an integer; `None` for types that cannot be indices.
    fn index(self, bytes: &[u8]) -> Option<u32> {
        match self {
            Component::U8 => Some(u32::from(bytes[0])),
            Component::U16 => Some(u32::from(u16::from_le_bytes([bytes[0], bytes[1]]))),
            Component::U32 => Some(u32::from_le_bytes(first_four(bytes))),
            _ => None,
        }
    }

    /// A component as a number; normalised integers reach from -1 or 0 to 1.
    #[inline]
    fn number(self, bytes: &[u8], normalized: bool) -> f32 {
        let two = || [bytes[0], bytes[1]];
        let (number, most) = match self {
            Component::F32 => return f32::from_le_bytes(first_four(bytes)),
            Component::I8 => (f32::from(bytes[0] as i8), 127.0),
            Component::U8 => (f32::from(bytes[0]), 255.0),
            Component::I16 => (f32::from(i16::from_le_bytes(two())), 32_767.0),
            Component::U16 => (f32::from(u16::from_le_bytes(two())), 65_535.0),
            Component::U32 => (
                u32::from_le_bytes(first_four(bytes)) as f32,
                4_294_967_295.0,
            ),
        };
        if normalized { (number / most).max(-1.0) } else { number }
    }
}

fn first_four(bytes: &[u8]) -> [u8; 4] {
    [bytes[0], bytes[1], bytes[2], bytes[3]]
}

/// Names of types, and their numbers of components.
const TYPES: [(&str, usize); 5] = [
    ("SCALAR", 1),
    ("VEC2", 2),
    ("VEC3", 3),
    ("VEC4", 4),
    ("MAT4", 16),
];

/// Number of rows that an accessor without a buffer view may have beyond the bytes of all buffers.
/// They are zeros, and cost nothing.
const FREE_ROWS: u64 = 1 << 16;

impl<'a> Accessor<'a> {
    /// Opens an accessor of `width` components a row.
    pub(super) fn open(
        source: &'a GltfSource,
        row: usize,
        width: usize,
    ) -> Result<Accessor<'a>, String> {
        Accessor::open_any(source, row, &[width])
    }

    /// Opens the accessor of an attribute, if there is one, of `width` components a row.
    pub(super) fn of_attribute(
        source: &'a GltfSource,
        attributes: &BTreeMap<String, usize>,
        name: &str,
        width: usize,
    ) -> Result<Option<Accessor<'a>>, String> {
        let row = attributes.get(name);
        row.map(|&row| Accessor::open(source, row, width))
            .transpose()
    }

    /// Opens an accessor of colours, which may have an alpha. Integers are normalized even if the
    /// file does not say so.
    pub(super) fn open_colors(source: &'a GltfSource, row: usize) -> Result<Accessor<'a>, String> {
        let opened = Accessor::open_any(source, row, &[3, 4])?;
        Ok(Accessor {
            normalized: true,
            ..opened
        })
    }

    /// Opens an accessor of integers, which are not normalized even if the file says so.
    pub(super) fn open_joints(source: &'a GltfSource, row: usize) -> Result<Accessor<'a>, String> {
        let opened = Accessor::open(source, row, 4)?;
        Ok(Accessor {
            normalized: false,
            ..opened
        })
    }

    fn open_any(
        source: &'a GltfSource,
        row: usize,
        widths: &[usize],
    ) -> Result<Accessor<'a>, String> {
        let accessor = source.document.accessors.get(row);
        let accessor = accessor.ok_or_else(|| format!("there is no accessors[{row}]"))?;
        let types = TYPES.iter().filter(|(_, width)| widths.contains(width));
        let opened = match types.clone().find(|(name, _)| *name == accessor.kind) {
            Some(&(_, width)) => Accessor::checked(source, row, accessor, width),
            None => {
                let names: Vec<&str> = types.map(|(name, _)| *name).collect();
                Err(format!("its type should be {}", names.join(" or ")))
            }
        };
        opened.map_err(|reason| format!("accessors[{row}]: {reason}"))
    }

    fn checked(
        source: &'a GltfSource,
        number: usize,
        row: &GltfAccessor,
        width: usize,
    ) -> Result<Accessor<'a>, String> {
        let kind = Component::of(row.component_type)?;
        let count = usize::try_from(row.count).map_err(|_| "its count is out of range")?;
        let size = kind.size() * width;
        let open = |view| StridedRows::checked(source, view, row.byte_offset, size, count);
        let rows = row.buffer_view.map(open).transpose()?;
        // Zeros without a buffer: more rows than the file has bytes are useless.
        if rows.is_none() && row.count > FREE_ROWS.saturating_add(source.buffer_bytes()) {
            return Err(format!(
                "its {count} rows are too many for a file of this size"
            ));
        }
        let replaced = row.sparse.as_ref();
        let replaced = replaced.map(|s| SparseOverride::checked(source, number, s, size, count));
        Ok(Accessor {
            count,
            width,
            rows,
            kind,
            normalized: row.normalized,
            replaced: replaced.transpose()?,
        })
    }

    /// Returns true if its components can be indices.
    pub(super) fn holds_indices(&self) -> bool {
        matches!(self.kind, Component::U8 | Component::U16 | Component::U32)
    }

    /// The bytes of a row below `count`; `None` stands for zeros.
    #[inline]
    fn row(&self, row: usize) -> Option<&'a [u8]> {
        let replacement = self.replaced.and_then(|replaced| replaced.row(row));
        replacement.or_else(|| self.rows.map(|rows| rows.get(row)))
    }

    /// A row below `count` as numbers.
    #[inline]
    pub(super) fn get<const N: usize>(&self, row: usize) -> [f32; N] {
        let size = self.kind.size();
        let mut numbers = [0.0; N];
        if let Some(bytes) = self.row(row) {
            for (number, bytes) in numbers.iter_mut().zip(bytes.chunks(size)) {
                *number = self.kind.number(bytes, self.normalized);
            }
        }
        numbers
    }

    /// Calls `put` with each of some rows below `count` as numbers, and its index among them.
    #[inline]
    pub(super) fn each<const N: usize>(&self, rows: &[u32], mut put: impl FnMut(usize, [f32; N])) {
        // The plain case without a choice in each row.
        if let (Some(strided), Component::F32, None) = (self.rows, self.kind, self.replaced) {
            for (k, &row) in rows.iter().enumerate() {
                let (words, _) = strided.get(row as usize).as_chunks::<4>();
                let mut numbers = [0.0; N];
                for (number, word) in numbers.iter_mut().zip(words) {
                    *number = f32::from_le_bytes(*word);
                }
                put(k, numbers);
            }
            return;
        }
        for (k, &row) in rows.iter().enumerate() {
            put(k, self.get(row as usize));
        }
    }

    /// A row below `count` as a colour and its alpha, which is `alpha` if it has none.
    #[inline]
    pub(super) fn color(&self, row: usize, alpha: f32) -> [f32; 4] {
        match self.width {
            4 => self.get(row),
            _ => {
                let [r, g, b] = self.get(row);
                [r, g, b, alpha]
            }
        }
    }

    /// A row below `count` as an index.
    #[inline]
    pub(super) fn index(&self, row: usize) -> u32 {
        let bytes = self.row(row);
        bytes.and_then(|bytes| self.kind.index(bytes)).unwrap_or(0)
    }

    /// Rows from `first` on as indices, all of them below `count`.
    pub(super) fn fill_indices(&self, first: usize, out: &mut [u32]) {
        match (self.rows, self.kind, self.replaced) {
            (Some(rows), Component::U32, None) => rows.fill(first, out, u32::from_le_bytes),
            (Some(rows), Component::U16, None) => {
                rows.fill(first, out, |b| u16::from_le_bytes(b).into());
            }
            _ => (first..)
                .zip(out)
                .for_each(|(row, out)| *out = self.index(row)),
        }
    }
}

impl<'a> StridedRows<'a> {
    /// Rows of `size` bytes, the last of which has been checked to exist.
    fn checked(
        source: &'a GltfSource,
        view: usize,
        offset: u64,
        size: usize,
        count: usize,
    ) -> Result<StridedRows<'a>, String> {
        let bytes = source.view(view)?;
        // A stride of 0 is from the first version: rows without gaps.
        let stride = source.document.buffer_views[view].byte_stride;
        let stride = stride.filter(|&stride| stride > 0).unwrap_or(size as u64);
        let stride = usize::try_from(stride).unwrap_or(usize::MAX);
        if stride < size {
            return Err(format!(
                "its rows of {size} bytes overlap in bufferViews[{view}]"
            ));
        }
        let offset = usize::try_from(offset).unwrap_or(usize::MAX);
        let bytes = bytes.get(offset..).unwrap_or_default();
        let before_last = count.saturating_sub(1).checked_mul(stride);
        let end = before_last.and_then(|before| before.checked_add(size));
        if count == 0 || end.is_some_and(|end| end <= bytes.len()) {
            Ok(StridedRows { bytes, stride })
        } else {
            Err(format!("its {count} rows reach beyond bufferViews[{view}]"))
        }
    }

    #[inline]
    fn get(&self, row: usize) -> &'a [u8] {
        &self.bytes[row * self.stride..]
    }

    /// Converts the first bytes of rows from `first` on.
    #[inline]
    fn fill<const N: usize>(
        &self,
        first: usize,
        out: &mut [u32],
        convert: impl Fn([u8; N]) -> u32,
    ) {
        let rows = self.bytes.get(first * self.stride..).unwrap_or_default();
        for (out, row) in out.iter_mut().zip(rows.chunks(self.stride)) {
            if let Some(bytes) = row.first_chunk() {
                *out = convert(*bytes);
            }
        }
    }
}

impl<'a> SparseOverride<'a> {
    fn checked(
        source: &'a GltfSource,
        accessor: usize,
        sparse: &Sparse,
        size: usize,
        rows: usize,
    ) -> Result<SparseOverride<'a>, String> {
        let count =
            usize::try_from(sparse.count).map_err(|_| "its sparse count is out of range")?;
        let index_kind = Component::of(sparse.indices.component_type)?;
        let (indices, values) = (&sparse.indices, &sparse.values);
        let rows_of = |view: usize, offset: u64, size: usize| {
            StridedRows::checked(source, view, offset, size, count)
        };
        let replaced = SparseOverride {
            count,
            indices: rows_of(indices.buffer_view, indices.byte_offset, index_kind.size())?,
            index_kind,
            values: rows_of(values.buffer_view, values.byte_offset, size)?,
        };
        // Any number of primitives and morph targets may share an accessor, so it is checked once.
        if !source.is_first_check(accessor) {
            return Ok(replaced);
        }
        let mut before = None;
        for k in 0..count {
            let index = replaced.index(k);
            let index = index.ok_or("its sparse indices are not unsigned integers")?;
            if before.is_some_and(|before| before >= index) {
                return Err("its sparse indices do not ascend".into());
            }
            if index as usize >= rows {
                return Err(format!(
                    "its sparse index {index} is not below its count {rows}"
                ));
            }
            before = Some(index);
        }
        Ok(replaced)
    }

    fn index(&self, k: usize) -> Option<u32> {
        self.index_kind.index(self.indices.get(k))
    }

    /// The replacement of a row.
    #[inline]
    fn row(&self, row: usize) -> Option<&'a [u8]> {
        let (mut from, mut to) = (0, self.count);
        while from < to {
            let middle = from + (to - from) / 2;
            let index = self.index(middle)? as usize;
            match index.cmp(&row) {
                std::cmp::Ordering::Equal => return Some(self.values.get(middle)),
                std::cmp::Ordering::Less => from = middle + 1,
                std::cmp::Ordering::Greater => to = middle,
            }
        }
        None
    }
}
