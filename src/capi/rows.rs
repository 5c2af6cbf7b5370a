//! The caller's memory: structures that say their size, and rows, checked before any is touched.

use crate::status::ApiError;
use std::ffi::c_void;
use std::slice;

/// `phx_rows`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxRows {
    pub data: *const c_void,
    pub stride: usize,
}

/// No program's memory goes further, on x86-64 or ARM.
const MAX_ADDRESS: usize = 1 << 48;

/// A structure of the header's that begins with its size. Zeros are valid in all of its fields.
///
/// # Safety
/// As said.
pub unsafe trait SizedStruct: Copy {
    const NAME: &'static str;
}

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
    fn collides(&self, other: &RowSpan) -> bool {
        let offset =
            (other.start as isize - self.start as isize).checked_rem_euclid(self.stride as isize);
        let is_between = |offset: isize| {
            offset as usize >= self.row && offset as usize + other.row <= self.stride
        };
        self.overlaps(other) && !(self.stride == other.stride && offset.is_some_and(is_between))
    }
}

impl PhxRows {
    /// Checks `count` rows of `T`, of which an input may repeat the first.
    pub fn check<T>(&self, what: &str, count: usize) -> Result<RowSpan, ApiError> {
        let (start, align) = (self.data.addr(), align_of::<T>());
        if count == 0 {
            return Ok(RowSpan::default());
        }
        if start == 0 {
            return Err(ApiError::argument(format!(
                "{what} is null, and has {count} rows"
            )));
        }
        if !start.is_multiple_of(align) || !self.stride.is_multiple_of(align) {
            return Err(ApiError::argument(format!(
                "{what} begins at {start:#x} and has a stride of {}: both are multiples of {align}",
                self.stride
            )));
        }
        let bytes = (count - 1).checked_mul(self.stride);
        let bytes = bytes.and_then(|bytes| bytes.checked_add(size_of::<T>()));
        let fits = |bytes: &usize| {
            start
                .checked_add(*bytes)
                .is_some_and(|end| end <= MAX_ADDRESS)
        };
        let bytes = bytes.filter(fits).ok_or_else(|| {
            let stride = self.stride;
            ApiError::argument(format!(
                "{what} has {count} rows of {stride} bytes: more than memory"
            ))
        })?;
        let (stride, row) = (self.stride, size_of::<T>());
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

    /// PhxRows side by side, copied only where they are not.
    ///
    /// # Safety
    /// All rows are memory that can be read, and that nobody writes during the call.
    pub unsafe fn with<T: Copy, R>(
        &self,
        what: &str,
        count: usize,
        take: impl FnOnce(&[T]) -> Result<R, ApiError>,
    ) -> Result<R, ApiError> {
        self.check::<T>(what, count)?;
        if count == 0 {
            return take(&[]);
        }
        if self.stride < size_of::<T>() {
            let words = format!("{what} has a stride of {}: less than a row", self.stride);
            return Err(ApiError::argument(words));
        }
        if self.stride == size_of::<T>() {
            // SAFETY: checked, and the caller's.
            return take(unsafe { slice::from_raw_parts(self.data.cast(), count) });
        }
        // SAFETY: checked, and the caller's.
        let rows: Vec<T> = (0..count).map(|k| unsafe { self.get(k) }).collect();
        take(&rows)
    }
}

/// A structure that the caller has filled as far as it knows it.
///
/// # Safety
/// Null, or memory of the size that the structure says.
pub unsafe fn structure<T: SizedStruct>(pointer: *const T) -> Result<T, ApiError> {
    let name = T::NAME;
    if pointer.is_null() || !pointer.is_aligned() {
        return Err(ApiError::argument(format!(
            "the {name} is null or misaligned"
        )));
    }
    // SAFETY: the caller's: each begins with its size.
    let size = unsafe { *pointer.cast::<usize>() };
    if size != size_of::<T>() {
        let (expected, words) = (size_of::<T>(), "set it to sizeof");
        return Err(ApiError::argument(format!(
            "{name}.size is {size} and not {expected}: {words}"
        )));
    }
    // SAFETY: the caller's.
    Ok(unsafe { *pointer })
}

/// The same, or `None` for null.
///
/// # Safety
/// As [`structure`].
pub unsafe fn structure_if<T: SizedStruct>(pointer: *const T) -> Result<Option<T>, ApiError> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's.
    unsafe { structure(pointer) }.map(Some)
}

/// `phx_column`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct PhxColumn {
    pub data: *mut c_void,
    pub stride: usize,
    pub miss: i32,
    pub reserved: u32,
}

/// A column of `T`, checked.
pub struct OutputColumn<T> {
    rows: PhxRows,
    /// Answer of a miss, if it writes any.
    miss: Option<T>,
    /// True if a miss writes what is usual.
    is_plain: bool,
}

// SAFETY: threads write different rows.
unsafe impl<T: Sync> Sync for OutputColumn<T> {}

impl PhxColumn {
    /// Checks a column of `count` rows, and adds it to the outputs; `None` if it is not wanted.
    /// `misses` are what a miss writes by default, and where it is to write -1.
    pub fn check<T: Copy>(
        &self,
        name: &'static str,
        count: usize,
        misses: [T; 2],
        outputs: &mut OutputColumns,
    ) -> Result<Option<OutputColumn<T>>, ApiError> {
        if self.data.is_null() {
            return Ok(None);
        }
        let rows = PhxRows {
            data: self.data,
            stride: self.stride,
        };
        outputs.0.push((name, rows.check::<T>(name, count)?));
        if count > 1 && self.stride < size_of::<T>() {
            let words = format!("{name} has a stride of {}: rows would overlap", self.stride);
            return Err(ApiError::argument(words));
        }
        let miss = match self.miss {
            0 => Some(misses[0]),
            1 => None,
            2 => Some(misses[1]),
            other => {
                return Err(ApiError::argument(format!(
                    "{name}.miss is {other}: 0, 1 or 2"
                )));
            }
        };
        Ok(Some(OutputColumn {
            rows,
            miss,
            is_plain: self.miss == 0,
        }))
    }
}

impl<T> OutputColumn<T> {
    /// Writes the answer of ray `k`; `None` is a miss.
    ///
    /// # Safety
    /// Row `k` was checked, is memory of the caller's, and nobody else writes it.
    #[inline(always)]
    pub unsafe fn put(&self, k: usize, answer: Option<T>)
    where
        T: Copy,
    {
        if let Some(answer) = answer.or(self.miss) {
            // SAFETY: the caller's.
            unsafe {
                self.rows
                    .data
                    .byte_add(k * self.rows.stride)
                    .cast_mut()
                    .cast::<T>()
                    .write(answer)
            }
        }
    }

    /// The rows as a slice, where they touch and misses are written as by default.
    ///
    /// # Safety
    /// As [`OutputColumn::put`], for all `count` rows.
    #[expect(clippy::mut_from_ref, reason = "the memory is the caller's")]
    pub unsafe fn slice(&self, count: usize) -> Option<&mut [T]> {
        let is_slice = self.is_plain && self.rows.stride == size_of::<T>() && count > 0;
        // SAFETY: the caller's.
        is_slice
            .then(|| unsafe { slice::from_raw_parts_mut(self.rows.data.cast_mut().cast(), count) })
    }
}

/// The outputs of a call, by name.
#[derive(Default)]
pub struct OutputColumns(Vec<(&'static str, RowSpan)>);

impl OutputColumns {
    /// Returns true if any of them shares memory with rows that are read.
    pub fn overlap(&self, rows: &RowSpan) -> bool {
        self.0.iter().any(|(_, output)| output.overlaps(rows))
    }

    /// Checks that no two of them share bytes.
    pub fn check_apart(&self) -> Result<(), ApiError> {
        for (k, (a, first)) in self.0.iter().enumerate() {
            if let Some((b, _)) = self.0[..k]
                .iter()
                .find(|(_, second)| first.collides(second))
            {
                return Err(ApiError::argument(format!(
                    "the outputs {b} and {a} overlap"
                )));
            }
        }
        Ok(())
    }
}

/// A place for an answer, which a call writes at its end.
#[derive(Clone, Copy)]
pub struct OutPointer<T>(*mut T);

impl<T> OutPointer<T> {
    /// Checks the caller's pointer, which may be null if the answer is not wanted.
    pub fn optional(what: &str, pointer: *mut T) -> Result<OutPointer<T>, ApiError> {
        match pointer.is_aligned() {
            true => Ok(OutPointer(pointer)),
            false => Err(ApiError::argument(format!("{what} is misaligned"))),
        }
    }

    /// The same, for an answer that the call is for.
    #[inline(always)]
    pub fn of(what: &str, pointer: *mut T) -> Result<OutPointer<T>, ApiError> {
        if pointer.is_null() {
            return Err(ApiError::argument(format!("{what} is null")));
        }
        OutPointer::optional(what, pointer)
    }

    /// # Safety
    /// The pointer is null or memory of the caller's for a `T`.
    #[inline(always)]
    pub unsafe fn write(self, answer: T) {
        if !self.0.is_null() {
            // SAFETY: the caller's.
            unsafe { self.0.write(answer) }
        }
    }
}

/// The `T` at a pointer.
///
/// # Safety
/// Null, or memory of a `T`.
#[inline(always)]
pub unsafe fn read<T: Copy>(what: &str, pointer: *const T) -> Result<T, ApiError> {
    if pointer.is_null() || !pointer.is_aligned() {
        return Err(ApiError::argument(format!("{what} is null or misaligned")));
    }
    // SAFETY: the caller's.
    Ok(unsafe { *pointer })
}
