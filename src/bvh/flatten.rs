//! From obvhs's tree to ours: nodes depth first, leaves of one kind, primitives copied into leaf order.

use super::{Bvh, Child, EllipsoidSlot, Node, SphereSlot, TriangleSlot};
use crate::scene::{Bounds, PrimKind, Scene};
use obvhs::bvh2::Bvh2;

/// A child that still has to become one of ours.
enum Pending {
    /// obvhs's node at this index.
    Theirs(usize),
    /// Primitives of a leaf, sorted by kind and number.
    Leaf(Vec<u32>),
}

struct Flattener<'a> {
    scene: &'a Scene,
    theirs: &'a Bvh2,
    bvh: Bvh,
    /// Σ area · cost over children, to be divided by the root's area.
    weighted_cost: f64,
}

/// Flattens a tree with at least one primitive.
pub(super) fn flatten(scene: &Scene, theirs: &Bvh2) -> Bvh {
    let mut flattener = Flattener {
        scene,
        theirs,
        bvh: Bvh {
            nodes: Vec::with_capacity(theirs.nodes.len() / 2 + 1),
            triangles: Vec::with_capacity(scene.triangles.len()),
            spheres: Vec::with_capacity(scene.spheres.len()),
            ellipsoids: Vec::with_capacity(scene.ellipsoids.len()),
            depth: 0,
            sah: 0.0,
        },
        weighted_cost: 0.0,
    };
    flattener.run();
    flattener.bvh
}

impl Flattener<'_> {
    /// Depth first with an explicit stack: a tree may be deeper than the thread's stack allows.
    fn run(&mut self) {
        let placeholder = (Child::EMPTY, Bounds::EMPTY);
        let mut root_area = 0.0;
        // (node to make, its place in its parent, depth)
        let mut stack = vec![(Pending::Theirs(0), None, 1usize)];
        while let Some((pending, parent, depth)) = stack.pop() {
            let index = self.bvh.nodes.len() as u32;
            self.bvh.depth = self.bvh.depth.max(depth);
            let mut children = [placeholder; 2];
            let mut deferred = Vec::new();
            for (k, part) in self.split(pending).into_iter().enumerate() {
                let Some(part) = part else { continue };
                let bounds = self.bounds(&part);
                let child = match self.leaf(&part) {
                    Some(leaf) => leaf,
                    None => {
                        deferred.push((part, Some((index, k)), depth + 1));
                        Child::Node(u32::MAX)
                    }
                };
                self.weighted_cost += bounds.half_area() as f64 * cost(child);
                children[k] = (child, bounds);
            }
            if parent.is_none() {
                root_area = children[0].1.union(children[1].1).half_area() as f64;
            }
            self.bvh.nodes.push(Node::new(children));
            if let Some((parent, k)) = parent {
                let parent: &mut Node = &mut self.bvh.nodes[parent as usize];
                parent.first[k] = index;
            }
            // The first child is popped next, so that it follows its parent in memory.
            stack.extend(deferred.into_iter().rev());
        }
        // The root's own visit costs 1.
        self.bvh.sah = 1.0
            + if root_area > 0.0 {
                self.weighted_cost / root_area
            } else {
                0.0
            };
    }

    /// The (up to two) parts of a subtree that is not a leaf of one kind.
    fn split(&self, pending: Pending) -> [Option<Pending>; 2] {
        match pending {
            Pending::Theirs(index) => {
                let node = &self.theirs.nodes[index];
                if node.prim_count > 0 {
                    // Only the root comes here as a leaf.
                    let prims = self.leaf_prims(index);
                    return self.split_kinds(prims);
                }
                let first = node.first_index as usize;
                [first, first + 1].map(|child| {
                    Some(if self.theirs.nodes[child].prim_count > 0 {
                        Pending::Leaf(self.leaf_prims(child))
                    } else {
                        Pending::Theirs(child)
                    })
                })
            }
            Pending::Leaf(prims) => self.split_kinds(prims),
        }
    }

    fn leaf_prims(&self, index: usize) -> Vec<u32> {
        let node = &self.theirs.nodes[index];
        let first = node.first_index as usize;
        let mut prims =
            self.theirs.primitive_indices[first..first + node.prim_count as usize].to_vec();
        prims.sort_by_key(|&id| (self.kind(id), id));
        prims
    }

    /// The first kind's primitives, and the rest.
    fn split_kinds(&self, mut prims: Vec<u32>) -> [Option<Pending>; 2] {
        let kind = self.kind(prims[0]);
        let rest = prims.split_off(prims.partition_point(|&id| self.kind(id) == kind));
        let rest = (!rest.is_empty()).then_some(Pending::Leaf(rest));
        [Some(Pending::Leaf(prims)), rest]
    }

    fn kind(&self, prim_id: u32) -> PrimKind {
        self.scene.prims[prim_id as usize].kind()
    }

    fn bounds(&self, pending: &Pending) -> Bounds {
        match pending {
            Pending::Theirs(index) => {
                let b = self.theirs.nodes[*index].aabb();
                Bounds::new(b.min.into(), b.max.into())
            }
            Pending::Leaf(prims) => prims.iter().fold(Bounds::EMPTY, |all, &id| {
                all.union(self.scene.prim_bounds(id).padded())
            }),
        }
    }

    /// Stores a leaf of one kind; `None` if the part has to be split further.
    fn leaf(&mut self, pending: &Pending) -> Option<Child> {
        let Pending::Leaf(prims) = pending else {
            return None;
        };
        let kind = self.kind(prims[0]);
        if prims.iter().any(|&id| self.kind(id) != kind) {
            return None;
        }
        let first = match kind {
            PrimKind::Sphere => self.bvh.spheres.len(),
            PrimKind::Ellipsoid => self.bvh.ellipsoids.len(),
            PrimKind::Triangle => self.bvh.triangles.len(),
            PrimKind::Cone => todo!("cones are on their way"),
        } as u32;
        for &id in prims {
            self.store(kind, id);
        }
        let count = prims.len() as u32;
        Some(Child::Leaf { kind, first, count })
    }

    fn store(&mut self, kind: PrimKind, prim_id: u32) {
        let own = self.scene.prim_bounds(prim_id).padded();
        let own_box = [own.lo.to_array(), own.hi.to_array()];
        let i = self.scene.prims[prim_id as usize].index();
        match kind {
            PrimKind::Sphere => self.bvh.spheres.push(SphereSlot {
                center: self.scene.spheres.center.get(i).to_array(),
                radius: self.scene.spheres.radius[i],
                own_box,
                prim_id,
            }),
            PrimKind::Ellipsoid => self.bvh.ellipsoids.push(EllipsoidSlot {
                to_object: self
                    .scene
                    .ellipsoids
                    .object_columns(i)
                    .map(|c| c.to_array()),
                own_box,
                prim_id,
            }),
            PrimKind::Triangle => self.bvh.triangles.push(TriangleSlot {
                corners: self.scene.triangles.corners(i).map(|c| c.to_array()),
                own_box,
                prim_id,
            }),
            PrimKind::Cone => todo!("cones are on their way"),
        }
    }
}

fn cost(child: Child) -> f64 {
    match child {
        Child::Node(_) => 1.0,
        Child::Leaf { count, .. } => count as f64,
    }
}
