//! Rows that leave a tree, and where they lie in it.

use glam::Vec3;
use phalanx_scene::Bounds;
use std::collections::HashSet;
use std::ops::Range;

/// The primitive or the instance that a row of a tree stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum RowKey {
    /// `prim_id` of a stored primitive.
    Prim(u32),
    /// Root of the mesh's tree, and offset of the primitives' numbers, of an instance.
    Instance(u32, u32),
}

impl RowKey {
    /// The stored primitive; `None` for an instance.
    pub(super) fn prim(self) -> Option<u32> {
        match self {
            RowKey::Prim(prim) => Some(prim),
            RowKey::Instance(..) => None,
        }
    }
}

/// Number of boxes that are looked for one by one; more are looked for as one.
const MAX_BOXES: usize = 16;

/// Primitives and instances that leave a tree.
#[derive(Default)]
pub(in crate::bvh) struct Leaving {
    /// Runs of primitives; ascending once they are looked for.
    prims: Vec<Range<u32>>,
    instances: HashSet<RowKey>,
    /// Boxes that hold all of it, as it lies in the tree.
    boxes: Vec<Bounds>,
}

impl Leaving {
    /// Adds primitives; `bounds` is their box in the tree.
    pub(super) fn add_prims(&mut self, prims: Range<u32>, bounds: Bounds) {
        let after = self.prims.partition_point(|run| run.start < prims.start);
        self.prims.insert(after, prims);
        self.add_box(bounds);
    }

    /// Adds an instance, whose box is to be found.
    pub(super) fn add_instance(&mut self, row: RowKey) {
        self.instances.insert(row);
    }

    /// Finds the boxes of the instances among those of the tree's rows.
    pub(super) fn find_instances(&mut self, rows: impl Iterator<Item = (RowKey, Bounds)>) {
        if self.instances.is_empty() {
            return;
        }
        for (row, bounds) in rows {
            if self.instances.contains(&row) {
                self.add_box(bounds);
            }
        }
    }

    fn add_box(&mut self, bounds: Bounds) {
        if self.boxes.len() == MAX_BOXES {
            let all = self.boxes.drain(..).fold(Bounds::EMPTY, Bounds::union);
            self.boxes.push(all);
        }
        self.boxes.push(bounds);
    }

    /// Forgets the boxes.
    pub(super) fn look_everywhere(&mut self) {
        self.boxes = vec![Bounds::new(Vec3::NEG_INFINITY, Vec3::INFINITY)];
    }

    pub(super) fn is_empty(&self) -> bool {
        self.prims.is_empty() && self.instances.is_empty()
    }

    /// Returns true if something that leaves may be in a box.
    #[inline]
    pub(in crate::bvh) fn may_be_in(&self, bounds: &Bounds) -> bool {
        let overlaps =
            |own: &Bounds| own.lo.cmple(bounds.hi).all() && bounds.lo.cmple(own.hi).all();
        self.boxes.iter().any(overlaps)
    }

    /// Returns true if a row stays.
    #[inline]
    pub(in crate::bvh) fn spares(&self, row: RowKey) -> bool {
        match row {
            RowKey::Prim(prim) => {
                let after = self.prims.partition_point(|run| run.start <= prim);
                after == 0 || prim >= self.prims[after - 1].end
            }
            instance @ RowKey::Instance(..) => !self.instances.contains(&instance),
        }
    }
}
