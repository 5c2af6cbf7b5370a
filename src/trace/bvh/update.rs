//! Trees that follow a scene: parts whose vertices moved are refitted, and the tree over the
//! instances is built anew.
//!
//! A tree is made with the instances among the world's primitives. Once an instance has moved, they
//! get a tree of their own, so that the rest stays as it is. The nodes then lie in this order:
//!
//! | nodes | |
//! |---|---|
//! | root | its children are the roots of the world's primitives and of the instances |
//! | world | the primitives outside of meshes |
//! | meshes | one tree after another |
//! | top | the instances |

use super::build::run_on_threads;
use super::build_input::BuildInput;
use super::geometry_starts::GeometryStarts;
use super::offsets::Offsets;
use super::refit::weighted_cost_of;
use super::subtree::{build_subtree, relative_cost};
use super::tree_parts::{TreePart, TreeParts};
use super::wide::{widen, widen_below};
use super::{Bvh, Child, Node};
use phalanx_scene::{Bounds, Scene, SceneChanges, on_pool};
use std::ops::Range;
use std::slice;

/// Growth of the cost of a refitted part, by the surface area heuristic, beyond which the tree is
/// built anew.
const MAX_COST_GROWTH: f64 = 1.5;

impl Bvh {
    /// Follows a scene that has been edited since the tree was built or last updated: by
    /// [`Scene::set_vertices`], [`Scene::set_transform`] and [`Scene::set_mask`], or by added
    /// geometry. Answers are those of a fresh build, bit for bit.
    ///
    /// | edit | work |
    /// |---|---|
    /// | vertices of a mesh | its boxes are refitted; everything is built anew if that makes the mesh cost 1.5 times as much as when it was built, by the surface area heuristic |
    /// | instances moved, added, hidden | the tree over the instances is built; the first time, that over the world's own primitives, too |
    /// | masks but 0 | none |
    /// | other geometry added, hidden | everything is built |
    ///
    /// The settings are those of the build. [`Bvh::wide`] follows, too, if it has been built.
    /// Columns that were changed by hand are not noticed, but for added primitives: build the tree
    /// anew. Any tree can follow any scene; the cost is that of what differs.
    ///
    /// Queries on other threads need a tree that stands still: keep two, and update one while the
    /// other is queried.
    ///
    /// ```
    /// # mod phalanx { pub use {glam, phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::glam::{DAffine3, dvec3};
    /// use phalanx::{Bvh, Ray, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let corners = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    /// let door = scene.add_prototype(&corners, &[[0, 1, 2]])?;
    /// let door = scene.add_instance(door, DAffine3::IDENTITY)?;
    /// let mut bvh = Bvh::build(&scene);
    /// let ray = Ray::new([1.0, 1.0, -5.0], [0.0, 0.0, 1.0]);
    /// assert_eq!(bvh.intersect(&ray).map(|hit| hit.t), Some(5.0));
    /// scene.set_transform(door, DAffine3::from_translation(dvec3(0.0, 0.0, 2.0)))?;
    /// bvh.update(&scene);
    /// assert_eq!(bvh.intersect(&ray).map(|hit| hit.t), Some(7.0));
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn update(&mut self, scene: &Scene) {
        let settings = self.parts.as_ref().map(|parts| parts.settings);
        let settings = settings.unwrap_or_default();
        let had_wide = self.has_wide();
        if !run_on_threads(settings.threads, scene.prims.len(), || self.follow(scene)) {
            *self = Bvh::build_with(scene, &settings);
            if had_wide {
                self.build_wide(settings.threads);
            }
        }
    }

    /// Returns true if the tree was built or updated for the scene as it is now. Trees from a cache
    /// do not know.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let bvh = Bvh::build(&scene);
    /// assert!(bvh.is_current(&scene));
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// assert!(!bvh.is_current(&scene));
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn is_current(&self, scene: &Scene) -> bool {
        match &self.parts {
            Some(parts) => parts.edits == scene.edits(),
            // Only a tree without primitives costs nothing.
            None => self.sah == 0.0 && scene.visible_count() == 0,
        }
    }

    /// Follows a scene; returns false if the tree has to be built anew.
    fn follow(&mut self, scene: &Scene) -> bool {
        let Some(mut parts) = self.parts.take() else {
            return false;
        };
        let changes = scene.changes_since(&parts.edits);
        if changes.topology || !self.refit_parts(scene, &changes, &mut parts) {
            return false;
        }
        if changes.instances || !changes.meshes.is_empty() {
            on_pool(|| self.rebuild_top(scene, &mut parts));
        }
        self.geometries = GeometryStarts::of(scene);
        parts.edits = scene.edits();
        self.parts = Some(parts);
        true
    }

    /// Refits what has moved; returns false if a part has become too slow.
    fn refit_parts(
        &mut self,
        scene: &Scene,
        changes: &SceneChanges,
        parts: &mut TreeParts,
    ) -> bool {
        let input = BuildInput::new(scene, Vec::new());
        for &mesh in &changes.meshes {
            if !self.refit_part(&input, &mut parts.meshes[mesh]) {
                return false;
            }
        }
        if !changes.world {
            return true;
        }
        if !self.refit_part(&input, &mut parts.world) {
            return false;
        }
        if let Some(wide) = self.wide.get_mut() {
            wide.refit(&self.slots.triangles);
        }
        match parts.top {
            Some(_) => self.set_root(parts),
            None => {
                let bounds = self.bounds_of(&parts.world.nodes);
                self.sah = 1.0 + relative_cost(parts.world.weighted_cost, bounds);
            }
        }
        true
    }

    /// Refits a part; returns false if it has become too slow.
    fn refit_part(&mut self, input: &BuildInput, part: &mut TreePart) -> bool {
        part.weighted_cost = self.refit(input, part);
        let cost = relative_cost(part.weighted_cost, self.bounds_of(&part.nodes));
        cost <= MAX_COST_GROWTH * part.built_cost
    }

    /// Builds the tree over the instances, and once that over the world's primitives without them.
    fn rebuild_top(&mut self, scene: &Scene, parts: &mut TreeParts) {
        let meshes = parts.meshes.iter();
        let input = BuildInput::new(
            scene,
            meshes.map(|mesh| self.bounds_of(&mesh.nodes)).collect(),
        );
        let mut wide = std::mem::take(&mut self.wide);
        let first = match parts.top {
            Some(first) => first,
            None => self.separate(&input, parts),
        };
        self.nodes.make_mut().truncate(first);
        let top = build_subtree(&input, input.instances(), parts.settings.quality);
        let top = top.unwrap_or_default();
        self.push_nodes(top.tree.nodes, Offsets::of_nodes(first));
        self.slots.instances = top.slots.instances;
        for slot in self.slots.instances.iter_mut() {
            slot.root = parts.meshes[slot.root as usize].nodes.start as u32;
        }
        let deepest = parts.meshes.iter().map(|mesh| mesh.depth).max();
        self.depth = 1 + top.tree.depth.max(parts.world.depth) + deepest.unwrap_or(0);
        self.set_root(parts);
        if let Some(wide) = wide.get_mut() {
            match parts.roots(self.nodes.len()) {
                Some([_, top]) if wide.has_top() => wide.replace_top(widen_below(self, top)),
                roots => **wide = widen(self, roots),
            }
        }
        self.wide = wide;
    }

    /// Builds a tree over the world's primitives without the instances, and leaves the place behind
    /// the meshes' nodes to those. Returns that place.
    fn separate(&mut self, input: &BuildInput, parts: &mut TreeParts) -> usize {
        let old = std::mem::replace(&mut self.nodes, vec![Node::EMPTY].into());
        let world = build_subtree(input, input.world_prims(), parts.settings.quality);
        let mut world = world.unwrap_or_default();
        parts.world = TreePart::at(1, 0, &world);
        self.push_nodes(world.tree.nodes, Offsets::of_nodes(1));
        world.slots.append_after(&self.slots);
        self.slots = world.slots;
        for mesh in &mut parts.meshes {
            let to = self.nodes.len();
            let moved = Offsets::of_nodes(to.wrapping_sub(mesh.nodes.start));
            self.push_nodes(old[mesh.nodes.clone()].to_vec(), moved);
            mesh.nodes = to..self.nodes.len();
        }
        parts.top = Some(self.nodes.len());
        self.nodes.len()
    }

    fn push_nodes(&mut self, mut nodes: Vec<Node>, offsets: Offsets) {
        offsets.rebase_nodes(&mut nodes);
        self.nodes.make_mut().extend(nodes);
    }

    /// Lets the root lead to the world's primitives and to the instances.
    fn set_root(&mut self, parts: &TreeParts) {
        let top = parts.top.unwrap_or(self.nodes.len())..self.nodes.len();
        let child = |nodes: &Range<usize>| {
            if nodes.is_empty() {
                (Child::EMPTY, Bounds::EMPTY)
            } else {
                (Child::Node(nodes.start as u32), self.bounds_of(nodes))
            }
        };
        let root = Node::new([child(&parts.world.nodes), child(&top)]);
        let weighted = [slice::from_ref(&root), &self.nodes[top]].map(weighted_cost_of);
        let weighted = weighted.iter().sum::<f64>() + parts.world.weighted_cost;
        self.sah = 1.0 + relative_cost(weighted, root.child_bounds());
        self.nodes.make_mut()[0] = root;
    }

    /// The box around a tree among all; empty for no nodes.
    fn bounds_of(&self, nodes: &Range<usize>) -> Bounds {
        if nodes.is_empty() {
            Bounds::EMPTY
        } else {
            self.nodes[nodes.start].child_bounds()
        }
    }
}
