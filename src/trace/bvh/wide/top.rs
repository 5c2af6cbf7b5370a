//! The top of a wide tree whose parts have changed: a copy of the world's root, the tree over the
//! instances that were added, shown or moved, and nodes that join all roots.

use super::layout::widen;
use super::rows::{ChildRef, TopRows, WideBvh, WideNode};
use crate::bvh::Bvh;
use crate::bvh::braid::{Braid, BraidItem, braid};
use crate::bvh::tree_parts::TreeParts;
use crate::simd::NATIVE;
use phalanx_scene::huge_pages::write_rows;

impl WideBvh {
    /// Removes the top, and puts the world's root back to its place.
    pub(in crate::bvh) fn remove_top(&mut self) {
        if let Some(top) = self.top.take() {
            self.nodes[0] = self.nodes[top.nodes];
            self.nodes.truncate(top.nodes);
            self.others.truncate(top.others);
        }
    }

    /// Joins all parts below one root, if the binary tree has a top.
    pub(in crate::bvh) fn add_top(&mut self, bvh: &Bvh, parts: &TreeParts) {
        self.depth = self.world.depth;
        if parts.top.is_none() {
            return;
        }
        self.top = Some(TopRows {
            nodes: self.nodes.len(),
            others: self.others.len(),
        });
        let world = self.nodes.len();
        let root = [self.nodes[0]];
        write_rows(&mut self.nodes, world, &root);
        let own = self.own.values().map(|part| part.nodes.start);
        let mut roots: Vec<usize> = own.chain([world]).collect();
        let mut below = self
            .own
            .values()
            .fold(self.depth, |most, part| most.max(part.depth));
        if let Some((root, _)) = parts.instances {
            let rows = widen(bvh, root);
            below = below.max(rows.depth);
            roots.push(self.append(rows));
        }
        let rooted = |root: usize| (ChildRef::Node(root as u32), self.nodes[root].child_bounds());
        let roots = roots.into_iter().map(rooted).collect();
        let join = braid(roots, NATIVE, |child| self.children(child));
        self.depth = join.depth + below;
        self.write_join(&join);
    }

    /// The children of a node with their boxes; none of a leaf.
    fn children(&self, child: ChildRef) -> Vec<BraidItem<ChildRef>> {
        let ChildRef::Node(index) = child else {
            return Vec::new();
        };
        let node = &self.nodes[index as usize];
        let all =
            (0..NATIVE).map(|lane| (ChildRef::of_code(node.children[lane]), node.bounds(lane)));
        all.filter(|child| child.0 != ChildRef::NOTHING).collect()
    }

    /// Writes joining nodes: the root of everything, and the others behind all nodes.
    fn write_join(&mut self, join: &Braid<ChildRef>) {
        let first = self.nodes.len() as u32 - 1;
        for (k, children) in join.nodes.iter().enumerate() {
            let mut children = children.clone();
            let mut node = WideNode::over(&mut children, |child| child.1);
            for (code, (child, _)) in node.children.iter_mut().zip(children) {
                let node = |number| ChildRef::Node(first + number as u32);
                *code = child.subtree_or(node).code();
            }
            if k == 0 { self.nodes[0] = node } else { self.nodes.push(node) }
        }
    }
}
