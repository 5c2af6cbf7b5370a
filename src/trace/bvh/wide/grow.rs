//! The wide tree from its sketch: places in order, then all rows at once, on all threads, where they will stay.

use super::plan::{Part, Plan};
use super::sketch::{Below, Sketch, Slots, sketches};
use super::{OtherLeaf, SphereBlock, Target, TriangleBlock, Wide};
use crate::bvh::pages::on_large_pages;
use crate::bvh::{Bvh, LeafKind};
use crate::simd::NATIVE;
use rayon::prelude::*;

/// The binary tree, widened.
pub(super) fn grow(bvh: &Bvh) -> Wide {
    let plan = Plan::of(bvh);
    let (mut sketches, depth) = sketches(&plan);
    let places = Places::of(&mut sketches);
    let slots_of = |slots: &Slots| slots_of(&plan, *slots);
    let nodes = places.nodes.par_iter().map(|&k| sketches[k].row);
    let triangles = places.triangles.par_iter().map(|slots| {
        let slots = slots_of(slots).into_iter();
        TriangleBlock::of(slots.map(|s| &bvh.triangles()[s as usize]))
    });
    let spheres = places.spheres.par_iter().map(|slots| {
        let slots = slots_of(slots).into_iter();
        SphereBlock::of(slots.map(|s| &bvh.spheres()[s as usize]))
    });
    Wide {
        nodes: on_large_pages(nodes),
        triangles: on_large_pages(triangles),
        spheres: on_large_pages(spheres),
        others: places.others,
        depth,
    }
}

/// What stands in each row, in order.
struct Places {
    /// Sketches.
    nodes: Vec<usize>,
    triangles: Vec<Slots>,
    spheres: Vec<Slots>,
    others: Vec<OtherLeaf>,
}

impl Places {
    /// Gives everything its place, and tells the sketches. The children of a node lie side by side, and what is below the
    /// last of them comes first.
    fn of(sketches: &mut [Sketch]) -> Places {
        let mut places = Places {
            nodes: vec![0],
            triangles: Vec::new(),
            spheres: Vec::new(),
            others: vec![OtherLeaf::EMPTY],
        };
        let mut waiting = vec![0];
        while let Some(k) = waiting.pop() {
            let sketch = &mut sketches[k];
            let mut child = sketch.first;
            for (below, code) in sketch.below.iter().zip(&mut sketch.row.children) {
                if let Below::Node(_) = below {
                    waiting.push(child);
                }
                *code = places.next(*below, &mut child).code();
            }
        }
        places
    }

    /// The next place for a child; if it is a node, it is that of sketch `child`, which is then that of the node after.
    fn next(&mut self, below: Below, child: &mut usize) -> Target {
        match below {
            Below::Nothing => Target::NOTHING,
            Below::Node(_) => {
                *child += 1;
                Target::Node(add(&mut self.nodes, *child - 1))
            }
            Below::Block(LeafKind::Sphere, slots) => Target::Spheres(add(&mut self.spheres, slots)),
            Below::Block(_, slots) => Target::Triangles(add(&mut self.triangles, slots)),
            Below::Other(leaf) => Target::Other(add(&mut self.others, leaf)),
        }
    }
}

/// Appends a row, and tells which it is.
fn add<T>(rows: &mut Vec<T>, row: T) -> u32 {
    rows.push(row);
    rows.len() as u32 - 1
}

/// The slots of a block one by one.
fn slots_of(plan: &Plan, slots: Slots) -> Vec<u32> {
    let mut all = Vec::with_capacity(NATIVE);
    match slots {
        Slots::Row { first, count } => all.extend(first..first + count),
        Slots::Of(place) => {
            let mut waiting = vec![place];
            while let Some(place) = waiting.pop() {
                for (part, _) in plan.parts(place).into_iter().rev() {
                    match part {
                        Part::Node(child) => waiting.push(child),
                        Part::Leaf { first, count, .. } => all.extend(first..first + count),
                    }
                }
            }
        }
    }
    all
}
