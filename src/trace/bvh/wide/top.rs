//! The top of a wide tree whose parts have changed: a copy of the world's root, the tree over the
//! instances that were added, shown or moved, and nodes that join all roots.

use super::layout::widen;
use super::rows::{ChildRef, TopRows, WideBvh, WideNode};
use crate::bvh::Bvh;
use crate::bvh::top::divide;
use crate::bvh::tree_parts::TreeParts;
use crate::simd::NATIVE;
use phalanx_scene::Bounds;

/// The root of a part, and its box.
type Root = (ChildRef, Bounds);

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
        self.nodes.push(self.nodes[0]);
        let own = self.own.values().map(|part| part.nodes.start);
        let mut roots: Vec<usize> = own.chain([world]).collect();
        let mut below = self
            .own
            .values()
            .fold(self.depth, |most, part| most.max(part.depth));
        if let Some(root) = parts.instances {
            let rows = widen(bvh, root);
            below = below.max(rows.depth);
            roots.push(self.append(rows));
        }
        let rooted = |root: usize| (ChildRef::Node(root as u32), self.nodes[root].child_bounds());
        let mut roots: Vec<Root> = roots.into_iter().map(rooted).collect();
        roots.retain(|(_, bounds)| !bounds.is_empty());
        let depth = self.join(&mut roots, 0);
        self.depth = depth + below;
    }

    /// Makes the node `place` that joins roots; returns the number of nodes on the longest path to
    /// one of them.
    fn join(&mut self, roots: &mut [Root], place: usize) -> usize {
        let mut depth = 0;
        let mut children: Vec<Root> = Vec::with_capacity(NATIVE);
        for group in groups(roots) {
            children.push(match group {
                [only] => *only,
                more => {
                    let below = self.nodes.len();
                    self.nodes.push(WideNode::EMPTY);
                    depth = depth.max(self.join(more, below));
                    (
                        ChildRef::Node(below as u32),
                        self.nodes[below].child_bounds(),
                    )
                }
            });
        }
        let mut node = WideNode::over(&mut children, |child| child.1);
        for (code, child) in node.children.iter_mut().zip(children) {
            *code = child.0.code();
        }
        self.nodes[place] = node;
        depth + 1
    }
}

/// Roots in as many groups as a node has children, or one each.
fn groups(roots: &mut [Root]) -> Vec<&mut [Root]> {
    let mut groups = vec![roots];
    while groups.len() < NATIVE {
        let large = groups
            .iter()
            .enumerate()
            .filter(|(_, group)| group.len() > 1);
        let Some((largest, _)) = large.max_by_key(|(_, group)| group.len()) else {
            break;
        };
        let group = groups.swap_remove(largest);
        let middle = divide(group, |root| root.1);
        let (left, right) = group.split_at_mut(middle);
        groups.extend([left, right]);
    }
    groups.retain(|group| !group.is_empty());
    groups
}
