//! The top of a tree whose parts have changed: a tree that joins the parts' roots, and the
//! instances that were added, shown or moved.
//!
//! | nodes | |
//! |---|---|
//! | 0 | root of everything |
//! | from 1 on | the rest of the world's tree, and of the other parts' |
//! | top | a copy of the root of the world's tree, whose place the root of everything takes |
//! | behind it | the tree over the instances, and the one that joins all roots |

use super::braid::{Braid, BraidItem, braid};
use super::build_input::BuildInput;
use super::offsets::Offsets;
use super::subtree::{build_subtree, cost};
use super::tree_parts::{TreeParts, TreePlace};
use super::{Bvh, Child, LeafKind, Node};
use phalanx_scene::{Bounds, GeomId, Geometry, Scene};

impl Bvh {
    /// Removes the top, and puts the world's root back to its place.
    pub(super) fn remove_top(&mut self, parts: &mut TreeParts) {
        parts.instances = None;
        if let Some(top) = parts.top.take() {
            let nodes = self.nodes.make_mut();
            nodes[0] = nodes[top];
            nodes.truncate(top);
            let rows = parts.world.slots[LeafKind::Instance.number()].len();
            self.slots.instances.make_mut().truncate(rows);
        }
    }

    /// Joins all parts below one root, and adds up their costs.
    pub(super) fn add_top(&mut self, scene: &Scene, parts: &mut TreeParts) {
        let world = Child::Node(self.nodes.len() as u32);
        let mut roots = vec![(world, self.bounds_of(&parts.world.nodes))];
        roots.extend(parts.own().map(|part| {
            let root = Child::Node(part.nodes.start as u32);
            (root, self.bounds_of(&part.nodes))
        }));
        let placed = |(id, place): (usize, &TreePlace)| match (
            place,
            scene.geometries.visible(id as GeomId),
        ) {
            (TreePlace::Top, Some(Geometry::Instance(k))) => Some(scene.prim_count() as u32 + k),
            _ => None,
        };
        let placed: Vec<u32> = (parts.geometries.iter().enumerate())
            .filter_map(placed)
            .collect();
        let mut weighted = parts.world.weighted_cost;
        weighted += parts.own().map(|part| part.weighted_cost).sum::<f64>();
        let depths = parts.own().map(|part| part.depth);
        let mut depth = depths.fold(parts.world.depth, usize::max);
        if roots.len() > 1 || !placed.is_empty() {
            parts.top = Some(self.nodes.len());
            let root = [self.nodes[0]];
            self.nodes.write(self.nodes.len(), &root);
            let (instances, own_depth, own_cost) = self.add_instances(scene, parts, &placed);
            parts.instances = instances.map(|(root, _)| (root, own_cost));
            roots.extend(instances.map(|(root, bounds)| (Child::Node(root), bounds)));
            let join = braid(roots, 2, |child| self.children(child));
            let opened = join.opened.iter().map(|&child| self.cost_of(child));
            weighted += own_cost - opened.sum::<f64>() + self.write_join(&join);
            depth = join.depth + depth.max(own_depth);
        }
        let deepest = parts.prototypes.iter().map(|mesh| mesh.depth).max();
        self.depth = depth + deepest.unwrap_or(0);
        self.sah = cost(weighted, self.nodes[0].child_bounds());
    }

    /// Adds the tree over instances; returns its root, its depth and its cost.
    fn add_instances(
        &mut self,
        scene: &Scene,
        parts: &TreeParts,
        placed: &[u32],
    ) -> (Option<(u32, Bounds)>, usize, f64) {
        let bounds = parts.prototypes.iter();
        let bounds = bounds.map(|mesh| self.bounds_of(&mesh.nodes)).collect();
        let input = BuildInput::new(scene, bounds);
        let runs = placed.chunk_by(|a, b| a + 1 == *b);
        let runs: Vec<_> = runs.map(|run| run[0]..run[0] + run.len() as u32).collect();
        let objects = input.objects(&runs);
        let Some(built) = build_subtree(&input, objects, parts.settings.quality) else {
            return (None, 0, 0.0);
        };
        let mut offsets = Offsets::of_nodes(self.nodes.len());
        offsets.slot[LeafKind::Instance.number()] = self.slots.instances.len() as u32;
        let mut nodes = built.tree.nodes;
        offsets.rebase_nodes(&mut nodes);
        self.nodes.write(self.nodes.len(), &nodes);
        let mut rows = built.slots.instances;
        parts.lead_to_prototypes(&mut rows);
        self.slots.instances.extend_from(&rows);
        let root = (offsets.node, built.tree.bounds);
        (Some(root), built.tree.depth, built.tree.weighted_cost)
    }

    /// The children of a node with their boxes; none of a leaf.
    fn children(&self, child: Child) -> Vec<BraidItem<Child>> {
        let Child::Node(index) = child else {
            return Vec::new();
        };
        let node = &self.nodes[index as usize];
        let all = [0, 1].map(|k| (node.child(k), node.bounds(k)));
        let is_there = |child: &BraidItem<Child>| !matches!(child.0, Child::Leaf { count: 0, .. });
        all.into_iter().filter(is_there).collect()
    }

    /// Σ area · cost over the children of a node.
    fn cost_of(&self, child: Child) -> f64 {
        match child {
            Child::Node(index) => self.nodes[index as usize].weighted_cost(),
            Child::Leaf { .. } => 0.0,
        }
    }

    /// Writes joining nodes: the root of everything, and the others behind all nodes. Returns their
    /// Σ area · cost.
    fn write_join(&mut self, join: &Braid<Child>) -> f64 {
        let first = self.nodes.len() - 1;
        let nodes = join.nodes.iter().map(|children| {
            let mut both = [(Child::EMPTY, Bounds::EMPTY); 2];
            for (place, &(child, bounds)) in both.iter_mut().zip(children) {
                let node = |number| Child::Node((first + number) as u32);
                *place = (child.subtree_or(node), bounds);
            }
            Node::new(both)
        });
        let nodes: Vec<Node> = nodes.collect();
        self.nodes.make_mut()[0] = nodes[0];
        self.nodes.write(self.nodes.len(), &nodes[1..]);
        nodes.iter().map(Node::weighted_cost).sum()
    }
}
