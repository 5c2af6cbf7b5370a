//! Memory that is read: structures that say their size, and rows; checked before any is touched.

use crate::status::{ApiError, misplaced};
use std::any::type_name;
use std::borrow::Cow;
use std::ffi::c_void;
use std::{mem, slice};

/// `phx_rows`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxRows {
    pub data: *const c_void,
    pub stride: usize,
}

/// Maximum number of rows: that of primitives, and of rays of a batch.
const MAX_ROWS: usize = u32::MAX as usize;

/// Maximum number of bytes of an allocation.
const MAX_BYTES: usize = isize::MAX as usize;

/// Where checked rows lie.
#[derive(Clone, Copy, Default)]
pub struct RowSpan {
    pub start: usize,
    /// From the first row to the end of the last.
    pub bytes: usize,
    stride: usize,
    row: usize,
}

impl RowSpan {
    pub fn overlaps(&self, other: &RowSpan) -> bool {
        self.start < other.start + other.bytes && other.start < self.start + self.bytes
    }

    /// Returns true if rows of both may share bytes: unless they lie between each other, as fields
    /// of one structure do.
    pub fn collides(&self, other: &RowSpan) -> bool {
        let distance = other.start as isize - self.start as isize;
        let is_between = |offset: isize| {
            offset as usize >= self.row && offset as usize + other.row <= self.stride
        };
        let offset = distance.checked_rem_euclid(self.stride as isize);
        self.overlaps(other) && !(self.stride == other.stride && offset.is_some_and(is_between))
    }
}

/// Most columns that a call writes.
const MAX_WRITTEN: usize = 8;

/// Rows that a call writes, by name. Not on the heap, which a small batch would feel.
pub struct WrittenRows {
    rows: [(&'static str, RowSpan); MAX_WRITTEN],
    count: usize,
}

impl WrittenRows {
    pub const NONE: &WrittenRows = &WrittenRows::none();

    pub const fn none() -> WrittenRows {
        let nowhere = RowSpan {
            start: 0,
            bytes: 0,
            stride: 0,
            row: 0,
        };
        WrittenRows {
            rows: [("", nowhere); MAX_WRITTEN],
            count: 0,
        }
    }

    pub fn push(&mut self, name: &'static str, rows: RowSpan) {
        self.rows[self.count] = (name, rows);
        self.count += 1;
    }

    fn all(&self) -> &[(&'static str, RowSpan)] {
        &self.rows[..self.count]
    }

    /// Returns true if any of them shares memory with rows that are read.
    pub fn overlap(&self, rows: &RowSpan) -> bool {
        self.all().iter().any(|(_, output)| output.overlaps(rows))
    }

    /// Checks that no two of them share bytes.
    pub fn check_apart(&self) -> Result<(), ApiError> {
        let all = self.all();
        for (k, (a, first)) in all.iter().enumerate() {
            let collides = |(_, second): &&(_, RowSpan)| first.collides(second);
            if let Some((b, _)) = all[..k].iter().find(collides) {
                let words = format!("the outputs {b} and {a} overlap");
                return Err(ApiError::argument(words));
            }
        }
        Ok(())
    }
}

impl PhxRows {
    /// Checks `count` rows of `T`.
    pub fn check<T>(&self, what: &str, count: usize) -> Result<RowSpan, ApiError> {
        let (start, stride, align) = (self.data.addr(), self.stride, align_of::<T>());
        if count == 0 {
            return Ok(RowSpan::default());
        }
        if start == 0 {
            let words = format!("{what} is null, and has {count} rows");
            return Err(ApiError::argument(words));
        }
        if !start.is_multiple_of(align) || !stride.is_multiple_of(align) {
            return Err(ApiError::argument(format!(
                "{what} begins at {start:#x} and has a stride of {stride}: both are multiples of {align}"
            )));
        }
        let row = size_of::<T>();
        if count > 1 && (1..row).contains(&stride) {
            let rows = format!("rows of {row} bytes: set {row} for a flat array");
            let words = format!("{what} has a stride of {stride}, and {rows}");
            return Err(ApiError::argument(words));
        }
        let bytes = stride.checked_mul(count - 1);
        let bytes = bytes.and_then(|bytes| bytes.checked_add(row));
        let fits = |bytes: &usize| count <= MAX_ROWS && (*bytes).max(stride) <= MAX_BYTES;
        let bytes = bytes.filter(fits).ok_or_else(|| {
            let words = format!("{what} has {count} rows of {stride} bytes: more than memory");
            ApiError::argument(words)
        })?;
        Ok(RowSpan {
            start,
            bytes,
            stride,
            row,
        })
    }

    /// A row of `T`.
    ///
    /// # Safety
    /// Row `k` has been checked, and is memory that can be read.
    #[inline(always)]
    pub unsafe fn get<T: Copy>(&self, k: usize) -> T {
        // SAFETY: the caller's.
        unsafe { *self.data.byte_add(k * self.stride).cast::<T>() }
    }

    /// All rows side by side; copied where they are not, or where an output would write.
    ///
    /// # Safety
    /// All rows are memory that can be read, and that nobody else writes during the call.
    pub unsafe fn all<'r, T: Copy>(
        &self,
        what: &str,
        count: usize,
        outputs: &WrittenRows,
    ) -> Result<Cow<'r, [T]>, ApiError> {
        let span = self.check::<T>(what, count)?;
        // SAFETY: checked, and the caller's.
        Ok(unsafe {
            if count > 0 && self.stride == size_of::<T>() && !outputs.overlap(&span) {
                Cow::Borrowed(slice::from_raw_parts(self.data.cast(), count))
            } else {
                Cow::Owned((0..count).map(|k| self.get(k)).collect())
            }
        })
    }
}

/// A structure of the caller's that begins with its size.
///
/// # Safety
/// Null, or memory of the size that the structure says.
pub unsafe fn structure<T: Copy>(pointer: *const T) -> Result<T, ApiError> {
    if pointer.is_null() || !pointer.is_aligned() {
        return Err(misplaced(&name_in_c::<T>()));
    }
    // SAFETY: the caller's: each begins with its size.
    let size = unsafe { *pointer.cast::<usize>() };
    let expected = size_of::<T>();
    if size != expected {
        let name = name_in_c::<T>();
        let words = format!("{name}.size is {size} and not {expected}: set it to sizeof");
        return Err(ApiError::argument(words));
    }
    // SAFETY: the caller's.
    Ok(unsafe { *pointer })
}

/// The same; null is a structure of zeros.
///
/// # Safety
/// As [`structure`], and zeros are valid.
pub unsafe fn structure_or_zeros<T: Copy>(pointer: *const T) -> Result<T, ApiError> {
    // SAFETY: the caller's.
    unsafe { if pointer.is_null() { Ok(mem::zeroed()) } else { structure(pointer) } }
}

/// Name of a structure in C: `phx_rows` of `phalanx_c::rows::PhxRows`.
fn name_in_c<T>() -> String {
    let path = type_name::<T>();
    let mut name = String::new();
    for letter in path.rsplit(':').next().unwrap_or(path).chars() {
        if letter.is_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.extend(letter.to_lowercase());
    }
    name
}

/// The `T` at a pointer.
///
/// # Safety
/// Null, misaligned, or memory of a `T` that nobody writes during the call.
#[inline(always)]
pub unsafe fn read<'r, T>(what: &str, pointer: *const T) -> Result<&'r T, ApiError> {
    if !pointer.is_aligned() {
        return Err(misplaced(what));
    }
    // SAFETY: the caller's.
    unsafe { pointer.as_ref() }.ok_or_else(|| misplaced(what))
}

/// Refuses what this version does not know.
pub fn check_reserved(reserved: u32) -> Result<(), ApiError> {
    match reserved {
        0 => Ok(()),
        other => Err(ApiError::argument(format!(
            "reserved is {other}, and not 0"
        ))),
    }
}
