//! The top of a tree whose parts have changed: a tree that joins the parts' roots, and the
//! instances that were added, shown or moved.
//!
//! | nodes | |
//! |---|---|
//! | 0 | root of everything |
//! | from 1 on | the rest of the world's tree, and of the other parts' |
//! | top | a copy of the root of the world's tree, whose place the root of everything takes |
//! | behind it | the tree over the instances, and the one that joins all roots |

use super::build_input::BuildInput;
use super::offsets::Offsets;
use super::subtree::{build_subtree, relative_cost};
use super::tree_parts::{Place, TreeParts};
use super::{Bvh, Child, LeafKind, Node};
use phalanx_scene::{Bounds, GeomId, Geometry, Scene};

/// Depth from which roots are halved by count, which bounds the depth for any distribution.
const MAX_SWEEPS: usize = 48;

/// The root of a part, and its box.
type Root = (Child, Bounds);

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
        let placed =
            |(id, place): (usize, &Place)| match (place, scene.geometries.visible(id as GeomId)) {
                (Place::Top, Some(Geometry::Instance(k))) => Some(scene.prim_count() as u32 + k),
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
            let root = self.nodes[0];
            self.nodes.push(root);
            let (instances, own_depth, cost) = self.add_instances(scene, parts, &placed);
            parts.instances = instances.map(|(root, _)| root);
            roots.extend(instances.map(|(root, bounds)| (Child::Node(root), bounds)));
            roots.retain(|(_, bounds)| !bounds.is_empty());
            let mut join = Join {
                first: self.nodes.len(),
                ..Join::default()
            };
            self.nodes[0] = join.root(&mut roots);
            self.nodes.extend_from(&join.nodes);
            weighted += cost + join.nodes.iter().map(Node::weighted_cost).sum::<f64>();
            weighted += self.nodes[0].weighted_cost();
            depth = 1 + join.depth + depth.max(own_depth);
        }
        let deepest = parts.prototypes.iter().map(|mesh| mesh.depth).max();
        self.depth = depth + deepest.unwrap_or(0);
        let bounds = self.nodes[0].child_bounds();
        self.sah = match bounds.is_empty() {
            true => 0.0,
            false => 1.0 + relative_cost(weighted, bounds),
        };
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
        self.nodes.extend_from(&nodes);
        let mut rows = built.slots.instances;
        for row in rows.iter_mut() {
            row.root = parts.prototypes[row.root as usize].nodes.start as u32;
        }
        self.slots.instances.extend_from(&rows);
        let root = (offsets.node, built.tree.bounds);
        (Some(root), built.tree.depth, built.tree.weighted_cost)
    }
}

/// A tree over the roots of parts: divided by the surface area heuristic along the longest axis.
#[derive(Default)]
struct Join {
    nodes: Vec<Node>,
    /// Index of the first of its nodes among all.
    first: usize,
    depth: usize,
}

impl Join {
    /// The root of everything.
    fn root(&mut self, roots: &mut [Root]) -> Node {
        match roots {
            [] => Node::EMPTY,
            [only] => Node::new([*only, (Child::EMPTY, Bounds::EMPTY)]),
            _ => self.node(roots, 0),
        }
    }

    /// The node over two roots or more.
    fn node(&mut self, roots: &mut [Root], depth: usize) -> Node {
        self.depth = self.depth.max(depth);
        let middle =
            if depth < MAX_SWEEPS { divide(roots, |root| root.1) } else { roots.len() / 2 };
        let (left, right) = roots.split_at_mut(middle);
        Node::new([left, right].map(|part| match part {
            [only] => *only,
            more => {
                let place = self.nodes.len();
                self.nodes.push(Node::EMPTY);
                let node = self.node(more, depth + 1);
                self.nodes[place] = node;
                let child = Child::Node((self.first + place) as u32);
                (child, node.child_bounds())
            }
        }))
    }
}

/// Sorts two roots or more along the axis where they are farthest apart; returns the number of
/// those that go to the left.
pub(super) fn divide<T>(roots: &mut [T], bounds: impl Fn(&T) -> Bounds) -> usize {
    let center = |root: &T| bounds(root).lo + bounds(root).hi;
    let centers = roots
        .iter()
        .map(|root| Bounds::new(center(root), center(root)));
    let extent = centers.fold(Bounds::EMPTY, Bounds::union);
    let axis = (extent.hi - extent.lo).max_position();
    roots.sort_by(|a, b| center(a)[axis].total_cmp(&center(b)[axis]));
    let union = |all: &mut Bounds, root: &T| {
        *all = all.union(bounds(root));
        Some(all.half_area())
    };
    let mut right: Vec<f32> = roots.iter().rev().scan(Bounds::EMPTY, union).collect();
    right.reverse();
    let left = roots.iter().scan(Bounds::EMPTY, union).zip(1..roots.len());
    let costs = left.map(|(area, count)| {
        let rest = (roots.len() - count) as f32;
        (area * count as f32 + right[count] * rest, count)
    });
    let best = costs.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(1, |(_, count)| count)
}
