//! Wide trees side by side: the world's, and those of geometries.

use super::layout::{WideRows, widen};
use super::rows::{ChildRef, OtherLeaf, WideBvh, WideNode, WidePart};
use crate::bvh::Bvh;
use crate::bvh::tree_parts::TreeParts;
use phalanx_scene::huge_pages::write_rows;
use phalanx_scene::on_pool;
use rayon::prelude::*;
use std::ops::Range;

impl WideBvh {
    /// Widens all parts of a tree; one without known parts is one.
    pub(in crate::bvh) fn of(bvh: &Bvh, parts: Option<&TreeParts>) -> WideBvh {
        let mut all = WideBvh::default();
        let world = widen(bvh, parts.map_or(0, TreeParts::world_root));
        all.world = all.place(world);
        if let Some(parts) = parts {
            let roots = parts.own().map(|part| part.nodes.start as u32);
            roots.for_each(|root| all.add_part(bvh, root));
            all.add_top(bvh, parts);
        } else {
            all.depth = all.world.depth;
        }
        all
    }

    /// Widens a part that has been added to the binary tree.
    pub(in crate::bvh) fn add_part(&mut self, bvh: &Bvh, root: u32) {
        let part = self.place(widen(bvh, root));
        self.own.insert(root, part);
    }

    /// Forgets a part.
    pub(in crate::bvh) fn drop_part(&mut self, root: u32) {
        if let Some(part) = self.own.remove(&root) {
            self.free.nodes.give(part.nodes);
            self.free.triangles.give(part.triangles);
            self.free.spheres.give(part.spheres);
            self.free.others.give(part.others);
        }
    }

    /// Puts the rows of a tree among the others.
    fn place(&mut self, rows: WideRows) -> WidePart {
        if self.others.is_empty() {
            self.others.push(OtherLeaf::EMPTY);
        }
        // The first one is the same for all.
        let others = rows.others[1..].to_vec();
        let part = WidePart {
            nodes: (self.free.nodes).run(rows.nodes.len(), self.nodes.len()),
            triangles: (self.free.triangles).run(rows.triangles.len(), self.triangles.len()),
            spheres: (self.free.spheres).run(rows.spheres.len(), self.spheres.len()),
            others: (self.free.others).run(others.len(), self.others.len()),
            depth: rows.depth,
            slots: Vec::new(),
        };
        let mut nodes = rows.nodes;
        part.rebase(&mut nodes);
        write(&mut self.nodes, &part.nodes, nodes);
        write(&mut self.triangles, &part.triangles, rows.triangles);
        write(&mut self.spheres, &part.spheres, rows.spheres);
        write(&mut self.others, &part.others, others);
        part
    }

    /// Appends the rows of a tree over instances, which have no blocks; returns its root.
    pub(super) fn append(&mut self, rows: WideRows) -> usize {
        let mut nodes = rows.nodes;
        let part = WidePart {
            nodes: self.nodes.len()..self.nodes.len() + nodes.len(),
            others: self.others.len()..self.others.len() + rows.others.len() - 1,
            ..WidePart::default()
        };
        part.rebase(&mut nodes);
        write_rows(&mut self.nodes, part.nodes.start, &nodes);
        self.others.extend(&rows.others[1..]);
        part.nodes.start
    }
}

impl WidePart {
    /// Converts nodes of a tree of their own to rows among others.
    fn rebase(&self, nodes: &mut [WideNode]) {
        let rebased = |code: u32| match ChildRef::of_code(code) {
            ChildRef::Node(k) => ChildRef::Node(k + self.nodes.start as u32),
            ChildRef::Triangles(k) => ChildRef::Triangles(k + self.triangles.start as u32),
            ChildRef::Spheres(k) => ChildRef::Spheres(k + self.spheres.start as u32),
            ChildRef::Other(0) => ChildRef::NOTHING,
            ChildRef::Other(k) => ChildRef::Other(k - 1 + self.others.start as u32),
        };
        let move_node = |node: &mut WideNode| {
            node.children = node.children.map(|code| rebased(code).code());
        };
        if self.nodes.start > 0 {
            on_pool(|| nodes.par_iter_mut().for_each(move_node));
        }
    }
}

/// Writes rows to their place; an empty column takes them over.
fn write<T: Copy>(column: &mut Vec<T>, place: &Range<usize>, rows: Vec<T>) {
    if column.is_empty() {
        *column = rows;
        return;
    }
    write_rows(column, place.start, &rows);
}
