//! Memory that is written: columns of answers.

use crate::rows::{PhxRows, WrittenRows, check_reserved};
use crate::status::ApiError;
use std::ffi::c_void;
use std::slice;

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
    /// True if rows touch, and a miss writes what is usual.
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
        outputs: &mut WrittenRows,
    ) -> Result<Option<OutputColumn<T>>, ApiError> {
        if self.data.is_null() {
            return Ok(None);
        }
        let (data, stride) = (self.data.cast_const(), self.stride);
        let rows = PhxRows { data, stride };
        outputs.push(name, rows.check::<T>(name, count)?);
        check_reserved(self.reserved)?;
        if count > 1 && stride == 0 {
            let words = format!("{name} has a stride of 0: rows would overlap");
            return Err(ApiError::argument(words));
        }
        let miss = match self.miss {
            0 => Some(misses[0]),
            1 => None,
            2 => Some(misses[1]),
            other => {
                let words = format!("{name}.miss is {other}: 0, 1 or 2");
                return Err(ApiError::argument(words));
            }
        };
        let is_plain = self.miss == 0 && stride == size_of::<T>() && count > 0;
        Ok(Some(OutputColumn {
            rows,
            miss,
            is_plain,
        }))
    }
}

impl<T: Copy> OutputColumn<T> {
    /// Writes the answer of ray `k`; `None` is a miss.
    ///
    /// # Safety
    /// Row `k` was checked, is memory of the caller's, and nobody else writes it.
    #[inline(always)]
    pub unsafe fn put(&self, k: usize, answer: Option<T>) {
        if let Some(answer) = answer.or(self.miss) {
            let row = self.rows.data.wrapping_byte_add(k * self.rows.stride);
            // SAFETY: the caller's.
            unsafe { row.cast_mut().cast::<T>().write(answer) }
        }
    }

    /// The rows as a slice, if they touch and misses are written as by default.
    ///
    /// # Safety
    /// As [`OutputColumn::put`], for all `count` rows.
    #[expect(clippy::mut_from_ref, reason = "the memory is the caller's")]
    pub unsafe fn slice<A>(&self, count: usize) -> Option<&mut [A]> {
        let data = self.rows.data.cast_mut().cast();
        // SAFETY: the caller's.
        (self.is_plain).then(|| unsafe { slice::from_raw_parts_mut(data, count) })
    }

    /// Lets `write` answer all rays, in place if it can, where zeros are misses and valid.
    ///
    /// # Safety
    /// As [`OutputColumn::put`], for all `count` rows, and `A` is laid out as `T`.
    pub unsafe fn fill<A: Copy + Default + PartialEq + Into<T>>(
        &self,
        count: usize,
        write: impl FnOnce(&mut [A]) -> Result<(), ApiError>,
    ) -> Result<(), ApiError> {
        // SAFETY: the caller's.
        if let Some(bytes) = unsafe { self.slice::<u8>(count * size_of::<A>()) } {
            bytes.fill(0);
            // SAFETY: the caller's, and zeros are valid.
            return write(unsafe { slice::from_raw_parts_mut(bytes.as_mut_ptr().cast(), count) });
        }
        let mut answers = vec![A::default(); count];
        write(&mut answers)?;
        for (k, &answer) in answers.iter().enumerate() {
            let answer = (answer != A::default()).then(|| answer.into());
            // SAFETY: the caller's.
            unsafe { self.put(k, answer) }
        }
        Ok(())
    }
}
