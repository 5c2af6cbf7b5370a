//! Building with obvhs: PLOC with reinsertion, over the padded boxes of the primitives.

use super::flatten::flatten;
use super::{Bvh, Child, Node};
use crate::scene::{Bounds, Scene};
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;

/// Better trees cost more time than they save here: see `perf/notes/tree-preset.md`.
const PRESET: BvhBuildParams = BvhBuildParams::medium_build();

struct PaddedBox(Aabb);

impl Boundable for PaddedBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl Bvh {
    /// Builds the tree of a scene. The same scene gives the same tree on every machine.
    pub fn build(scene: &Scene) -> Bvh {
        let boxes: Vec<PaddedBox> = (0..scene.prim_count() as u32)
            .map(|id| {
                let b = scene.prim_bounds(id).padded();
                PaddedBox(Aabb::new(b.lo.into(), b.hi.into()))
            })
            .collect();
        if boxes.is_empty() {
            return Bvh::empty();
        }
        // obvhs measures its own build; we time the whole load path instead.
        let mut unused = Duration::ZERO;
        let binary = build_bvh2(&boxes, PRESET, &mut unused);
        flatten(scene, &binary)
    }

    /// The tree of a scene without primitives: a root with two empty leaves.
    fn empty() -> Bvh {
        Bvh {
            nodes: vec![Node::new([(Child::EMPTY, Bounds::EMPTY); 2])],
            triangles: Vec::new(),
            spheres: Vec::new(),
            ellipsoids: Vec::new(),
            depth: 1,
            sah: 0.0,
        }
    }
}
