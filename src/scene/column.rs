//! One attribute of many rows: a vector, or a part of a mapped file that is never written to.

use crate::huge_pages::{room, write_rows};
use bytemuck::Pod;
use std::any::Any;
use std::fmt;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// A growable column. It reads like a slice, wherever its rows are. The first change copies rows
/// that it does not own.
pub struct Column<T: 'static>(Storage<T>);

enum Storage<T: 'static> {
    Owned(Vec<T>),
    Mapped {
        rows: &'static [T],
        /// Owner of the memory of `rows`: keeps it alive.
        keeper: Arc<dyn Any + Send + Sync>,
    },
}

impl<T> Column<T> {
    /// A column without rows.
    #[inline]
    pub const fn new() -> Column<T> {
        Column(Storage::Owned(Vec::new()))
    }

    /// A column of rows that live elsewhere; `keeper` keeps them alive. No reference from the
    /// column outlives the column itself.
    #[inline]
    pub fn mapped(rows: &'static [T], keeper: Arc<dyn Any + Send + Sync>) -> Column<T> {
        Column(Storage::Mapped { rows, keeper })
    }

    /// Bytes of memory that the column owns; mapped rows belong to the file.
    #[inline]
    pub fn memory_bytes(&self) -> usize {
        match &self.0 {
            Storage::Owned(rows) => rows.capacity() * size_of::<T>(),
            Storage::Mapped { .. } => 0,
        }
    }

    /// Bytes of the rows, wherever they are.
    #[inline]
    pub fn row_bytes(&self) -> usize {
        size_of_val::<[T]>(self)
    }
}

/// A column of rows of any type, as bytes.
pub trait AnyColumn {
    /// All rows.
    fn bytes(&self) -> &[u8];
    /// Number of rows.
    fn rows(&self) -> usize;
    /// Bytes of one row.
    fn row_size(&self) -> usize;
    /// Replaces the rows by those in `bytes`, which `keeper` keeps alive. If the bytes are not a
    /// whole number of aligned rows, the column is left empty; then this returns false.
    fn map(&mut self, bytes: &'static [u8], keeper: Arc<dyn Any + Send + Sync>) -> bool;
    /// Writes rows of a column of the same type, given as bytes: see [`Column::write`].
    fn write_bytes(&mut self, first: usize, bytes: &[u8]);
    /// Makes room for more rows.
    fn make_room(&mut self, more: usize);
}

impl<T: Pod> AnyColumn for Column<T> {
    fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(self)
    }

    fn rows(&self) -> usize {
        self.len()
    }

    fn row_size(&self) -> usize {
        size_of::<T>()
    }

    fn map(&mut self, bytes: &'static [u8], keeper: Arc<dyn Any + Send + Sync>) -> bool {
        let rows = bytemuck::try_cast_slice(bytes);
        *self = match rows {
            Ok(rows) if !rows.is_empty() => Column::mapped(rows, keeper),
            _ => Column::new(),
        };
        rows.is_ok()
    }

    fn write_bytes(&mut self, first: usize, bytes: &[u8]) {
        self.write(first, bytemuck::cast_slice(bytes));
    }

    fn make_room(&mut self, more: usize) {
        self.reserve(more);
    }
}

/// An attribute of the rows of a table: one column, or one for each component.
pub trait Attribute {
    /// The columns, in the order of scene caches.
    fn columns(&self) -> Vec<&dyn AnyColumn>;
    /// The same columns, to be mapped.
    fn columns_mut(&mut self) -> Vec<&mut dyn AnyColumn>;
}

impl<T: Pod> Attribute for Column<T> {
    fn columns(&self) -> Vec<&dyn AnyColumn> {
        vec![self]
    }

    fn columns_mut(&mut self) -> Vec<&mut dyn AnyColumn> {
        vec![self]
    }
}

impl<A: Attribute, const N: usize> Attribute for [A; N] {
    fn columns(&self) -> Vec<&dyn AnyColumn> {
        self.iter().flat_map(A::columns).collect()
    }

    fn columns_mut(&mut self) -> Vec<&mut dyn AnyColumn> {
        self.iter_mut().flat_map(A::columns_mut).collect()
    }
}

impl<T: Clone> Column<T> {
    /// The rows as a vector that can be changed.
    #[inline]
    pub fn make_mut(&mut self) -> &mut Vec<T> {
        if let Storage::Mapped { rows, .. } = &self.0 {
            self.0 = Storage::Owned(rows.to_vec());
        }
        match &mut self.0 {
            Storage::Owned(rows) => rows,
            Storage::Mapped { .. } => unreachable!("replaced above"),
        }
    }

    /// The row `i`.
    #[inline]
    pub(crate) fn row(&self, i: usize) -> T {
        self[i].clone()
    }

    /// Appends one row.
    #[inline]
    pub fn push(&mut self, row: T) {
        self.make_mut().push(row);
    }

    /// Makes room for more rows.
    pub fn reserve(&mut self, more: usize) {
        let rows = self.make_mut();
        if rows.is_empty() { *rows = room(more) } else { rows.reserve(more) }
    }

    /// Frees reserved memory that is not used.
    #[inline]
    pub fn shrink_to_fit(&mut self) {
        if let Storage::Owned(rows) = &mut self.0 {
            rows.shrink_to_fit();
        }
    }

    /// Appends copies of rows, within the reserved memory.
    #[inline]
    pub fn extend_from(&mut self, rows: &[T]) {
        self.make_mut().extend_from_slice(rows);
    }

    /// Writes copies of rows from row `first` on, in place of those that are there; the column
    /// grows where it ends.
    pub fn write(&mut self, first: usize, rows: &[T])
    where
        T: Copy,
    {
        write_rows(self.make_mut(), first, rows);
    }

    /// Appends the rows of another column, or takes it over if this one is empty and has no room.
    #[inline]
    pub fn append(&mut self, other: Column<T>) {
        match (self.is_empty() && self.memory_bytes() == 0, other.0) {
            (true, storage) => self.0 = storage,
            (false, Storage::Owned(mut rows)) => self.make_mut().append(&mut rows),
            (false, Storage::Mapped { rows, .. }) => self.make_mut().extend_from_slice(rows),
        }
    }
}

impl<T> Deref for Column<T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Storage::Owned(rows) => rows,
            Storage::Mapped { rows, .. } => rows,
        }
    }
}

impl<T: Clone> DerefMut for Column<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        self.make_mut()
    }
}

impl<T> Default for Column<T> {
    fn default() -> Self {
        Column::new()
    }
}

impl<T: Clone> Clone for Column<T> {
    fn clone(&self) -> Self {
        Column(match &self.0 {
            Storage::Owned(rows) => Storage::Owned(rows.clone()),
            Storage::Mapped { rows, keeper } => Storage::Mapped {
                rows,
                keeper: Arc::clone(keeper),
            },
        })
    }
}

impl<T: fmt::Debug> fmt::Debug for Column<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

impl<T: PartialEq> PartialEq for Column<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: PartialEq, const N: usize> PartialEq<[T; N]> for Column<T> {
    fn eq(&self, other: &[T; N]) -> bool {
        **self == *other
    }
}

impl<T> From<Vec<T>> for Column<T> {
    fn from(rows: Vec<T>) -> Self {
        Column(Storage::Owned(rows))
    }
}

impl<T> FromIterator<T> for Column<T> {
    fn from_iter<I: IntoIterator<Item = T>>(rows: I) -> Self {
        Column(Storage::Owned(Vec::from_iter(rows)))
    }
}

impl<T: Clone> Extend<T> for Column<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, rows: I) {
        self.make_mut().extend(rows);
    }
}

impl<'a, T> IntoIterator for &'a Column<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mapped(rows: &'static [u32]) -> (Column<u32>, Arc<u8>) {
        let keeper = Arc::new(0u8);
        (
            Column::mapped(rows, Arc::clone(&keeper) as Arc<dyn Any + Send + Sync>),
            keeper,
        )
    }

    #[test]
    fn a_column_with_room_is_not_replaced() {
        let mut column = Column::new();
        column.reserve(100);
        let reserved = column.memory_bytes();
        column.append(vec![1u32, 2].into());
        assert_eq!(
            (&column[..], column.memory_bytes()),
            (&[1, 2][..], reserved)
        );
    }

    #[test]
    fn a_mapped_column_is_copied_when_it_is_first_changed() {
        let (mut column, keeper) = mapped(&[1, 2, 3]);
        let copy = column.clone();
        assert_eq!((column.len(), column.memory_bytes()), (3, 0));
        assert_eq!(Arc::strong_count(&keeper), 3);
        column.push(4);
        column[0] = 9;
        assert_eq!(
            (&column[..], &copy[..]),
            (&[9, 2, 3, 4][..], &[1, 2, 3][..])
        );
        assert_eq!(Arc::strong_count(&keeper), 2, "the changed one let go");
        drop(copy);
        assert_eq!(Arc::strong_count(&keeper), 1);
    }

    #[test]
    fn an_empty_column_takes_another_over() {
        let mut column = Column::new();
        let rows = vec![1u32, 2];
        let place = rows.as_ptr();
        column.append(rows.into());
        assert_eq!(column.as_ptr(), place, "not copied");
        column.append(mapped(&[3]).0);
        assert_eq!(*column, [1, 2, 3]);
    }
}
