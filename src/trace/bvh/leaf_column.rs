//! Columns of primitives in leaf order, of any kind: each chunk of a tree writes its own rows, in
//! their final memory.

use super::build_input::BuildInput;
use super::clustering::LeafObjects;
use super::leaving::{Leaving, RowKey};
use super::node::LeafKind;
use super::prim_ref::PrimIndex;
use bytemuck::Pod;
use phalanx_scene::huge_pages::write_parts;
use phalanx_scene::{AnyColumn, Bounds, Column};
use std::ops::Range;

/// A primitive, or an instance, in leaf order.
pub(super) trait LeafRow: Pod + Send + Sync {
    /// The kind of all rows of this type.
    const KIND: LeafKind;
    /// Name of the column in scene caches.
    const NAME: &'static str;
    /// The row of an object.
    fn of(input: &BuildInput, object: PrimIndex) -> Self;
    /// The primitive or the instance that the row stands for.
    fn key(&self) -> RowKey;
    /// The padded box.
    fn padded_box(&self) -> Bounds;
}

/// A column of rows of one kind.
pub(super) trait LeafColumn: AnyColumn {
    /// Name of the column in scene caches.
    fn name(&self) -> &'static str;
    /// Fills the column with the rows of all objects of chunks, chunk by chunk.
    fn fill(&mut self, input: &BuildInput, chunks: &[LeafObjects]);
    /// Returns true if all of these rows are primitives of numbers below `count`.
    fn are_prims_below(&self, rows: Range<usize>, count: u32) -> bool;
    /// The numbers of the primitives in these rows; none of instances.
    fn stored_prims(&self, rows: Range<usize>) -> Vec<u32>;
    /// Moves what stays to the front of these rows; returns how many that are, and their box.
    /// `None` if all of them stay.
    fn retain(&mut self, rows: Range<usize>, leaving: &Leaving) -> Option<(u32, Bounds)>;
    /// The same of rows where what stays is at the front already.
    fn staying(&self, rows: Range<usize>, leaving: &Leaving) -> Option<(u32, Bounds)>;
}

impl<T: LeafRow> LeafColumn for Column<T> {
    fn name(&self) -> &'static str {
        T::NAME
    }

    fn fill(&mut self, input: &BuildInput, chunks: &[LeafObjects]) {
        let own = |chunk: &LeafObjects| chunk.slots[T::KIND.number()] as usize;
        let lens: Vec<usize> = chunks.iter().map(own).collect();
        let (column, _) = write_parts(&lens, |k, part| {
            let objects = &chunks[k].objects;
            let all_one = part.capacity() == objects.len();
            let of_kind = |object: PrimIndex| all_one || input.kind(object) == T::KIND;
            for &object in objects.iter().filter(|object| of_kind(**object)) {
                part.push(T::of(input, object));
            }
        });
        *self = column.into();
    }

    fn are_prims_below(&self, rows: Range<usize>, count: u32) -> bool {
        let mut prims = self[rows].iter().map(|row| row.key().prim());
        prims.all(|prim| prim.is_some_and(|prim| prim < count))
    }

    fn stored_prims(&self, rows: Range<usize>) -> Vec<u32> {
        let prims = self[rows].iter().map(|row| row.key().prim());
        prims.flatten().collect()
    }

    fn retain(&mut self, rows: Range<usize>, leaving: &Leaving) -> Option<(u32, Bounds)> {
        let all = &self[rows.clone()];
        let mut next = all.iter().position(|row| !leaving.spares(row.key()))?;
        let own = &mut self[rows.clone()];
        for k in next + 1..own.len() {
            if leaving.spares(own[k].key()) {
                own.swap(next, k);
                next += 1;
            }
        }
        self.staying(rows, leaving)
    }

    fn staying(&self, rows: Range<usize>, leaving: &Leaving) -> Option<(u32, Bounds)> {
        let all = &self[rows];
        let count = all.iter().position(|row| !leaving.spares(row.key()))?;
        let boxes = all[..count].iter().map(T::padded_box);
        Some((count as u32, boxes.fold(Bounds::EMPTY, Bounds::union)))
    }
}
