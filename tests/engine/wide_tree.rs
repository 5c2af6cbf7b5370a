//! The wide tree contains the same primitives as the binary tree, each once and within the boxes
//! above it.

use crate::common::rng::Rng;
use crate::common::scenes;
use glam::Vec3;
use phalanx::bvh::{Bvh, ChildRef, LeafKind, WideNode};
use phalanx::lanes::NATIVE;
use phalanx::scene::{Bounds, Scene};
use phalanx::standard;

/// Walks the whole tree, and returns the visited slots of every kind, by number in the file.
fn check(bvh: &Bvh) -> Vec<u32> {
    let wide = bvh.wide();
    let mut met = Vec::new();
    let mut waiting = vec![(0u32, everything(), 1)];
    let mut deepest = 0;
    while let Some((index, around, level)) = waiting.pop() {
        deepest = deepest.max(level);
        let node = &wide.nodes()[index as usize];
        assert!(lie_in_order(node), "children of node {index}");
        for lane in 0..NATIVE {
            let bounds = column(&node.boxes, lane);
            if bounds.lo.x > bounds.hi.x {
                continue;
            }
            assert!(
                holds(around, bounds),
                "a box of node {index} is beyond its parent's"
            );
            match ChildRef::of_code(node.children[lane]) {
                ChildRef::Node(child) => waiting.push((child, bounds, level + 1)),
                ChildRef::Triangles(block) => {
                    let block = &wide.triangles()[block as usize];
                    for k in (0..NATIVE).filter(|&k| !block.vertices[0][0][k].is_nan()) {
                        let corner =
                            |c: usize| Vec3::from_array(block.vertices[c].map(|axis| axis[k]));
                        let [a, b, c] = [corner(0), corner(1), corner(2)];
                        let own = Bounds::new(a.min(b).min(c), a.max(b).max(c)).padded();
                        assert!(holds(bounds, own), "triangle {}", block.prim_id[k]);
                        met.push(block.prim_id[k]);
                    }
                }
                ChildRef::Spheres(block) => {
                    let block = &wide.spheres()[block as usize];
                    for k in (0..NATIVE).filter(|&k| !block.radius[k].is_nan()) {
                        assert!(
                            holds(bounds, column(&block.prim_aabb, k)),
                            "sphere {}",
                            block.prim_id[k]
                        );
                        met.push(block.prim_id[k]);
                    }
                }
                ChildRef::Other(leaf) => {
                    let leaf = wide.others()[leaf as usize];
                    let slots = leaf.first as usize..(leaf.first + leaf.count) as usize;
                    let prims = bvh.leaf_prims();
                    match leaf.kind {
                        LeafKind::TRIANGLE | LeafKind::SPHERE => assert!(slots.is_empty()),
                        LeafKind::Instance => {
                            met.extend(prims.instances[slots].iter().map(|slot| slot.id_offset));
                        }
                        kind => met.extend(prims.stored_prims(kind, slots)),
                    }
                }
            }
        }
    }
    assert_eq!(deepest, wide.depth(), "the longest path");
    met.sort_unstable();
    met
}

/// Returns true if the children are in order along the node's axis, and no other axis separates
/// them more.
fn lie_in_order(node: &WideNode) -> bool {
    let boxes = (0..NATIVE).map(|lane| column(&node.boxes, lane));
    let boxes: Vec<Bounds> = boxes.filter(|b| b.lo.x <= b.hi.x).collect();
    let middles = |axis: usize| boxes.iter().map(move |b| b.lo[axis] + b.hi[axis]);
    let spread = |axis: usize| {
        let (low, high) = (f32::INFINITY, f32::NEG_INFINITY);
        middles(axis).fold(high, f32::max) - middles(axis).fold(low, f32::min)
    };
    let axis = usize::from(node.axis);
    let ranked = |axis: usize| {
        let lanes = node.order[axis].map(usize::from);
        let ranks = lanes.iter().filter(|&&lane| lane < boxes.len());
        let mut seen = lanes;
        seen.sort_unstable();
        seen.is_sorted_by(|a, b| a < b)
            && ranks
                .map(|&lane| boxes[lane].lo[axis] + boxes[lane].hi[axis])
                .is_sorted()
    };
    (0..3).all(ranked)
        && middles(axis).is_sorted()
        && (0..3).all(|other| spread(axis) >= spread(other))
}

fn everything() -> Bounds {
    Bounds::new(Vec3::NEG_INFINITY, Vec3::INFINITY)
}

fn holds(outer: Bounds, inner: Bounds) -> bool {
    outer.lo.cmple(inner.lo).all() && outer.hi.cmpge(inner.hi).all()
}

fn column(boxes: &[[[f32; NATIVE]; 3]; 2], lane: usize) -> Bounds {
    let [lo, hi] = boxes.map(|corner| Vec3::from_array(corner.map(|axis| axis[lane])));
    Bounds::new(lo, hi)
}

/// The numbers of all slots that the world's own primitives have.
fn all(scene: &Scene) -> Vec<u32> {
    (0..scene.prim_count() as u32).collect()
}

#[test]
fn every_primitive_is_there_once() {
    for seed in 0..40 {
        let mut rng = Rng::new(seed);
        let count = 1 + rng.below(600);
        let scene = scenes::random(&mut rng, count, 3.0);
        assert_eq!(check(&Bvh::build(&scene)), all(&scene), "seed {seed}");
    }
}

#[test]
fn a_scene_without_primitives_has_an_empty_root() {
    let bvh = Bvh::build(&scenes::bare());
    assert!(check(&bvh).is_empty());
    assert_eq!(bvh.wide().nodes().len(), 1);
}

/// A leaf of inseparable primitives becomes a tree of blocks.
#[test]
fn a_leaf_of_many_is_parted() {
    for count in [1, 8, 9, 16, 17, 64, 65, 256, 257, 1000] {
        let mut scene = scenes::bare();
        for _ in 0..count {
            scene.add_triangle([Vec3::ZERO, Vec3::X, Vec3::Y], None, 0);
        }
        assert_eq!(
            check(&Bvh::build(&scene)),
            all(&scene),
            "{count} of the same"
        );
    }
}

/// Most lanes have a child: a wide tree with half-empty nodes is slow.
#[test]
fn nodes_and_blocks_are_well_filled() {
    let spec = standard::parse_spec("standard:terrain:20k").expect("a standard scene");
    let scene = standard::scene(spec, 0).expect("a standard scene");
    let bvh = Bvh::build(&scene);
    let wide = bvh.wide();
    let filled = |node: &WideNode| {
        (0..NATIVE)
            .filter(|&k| node.boxes[0][0][k].is_finite())
            .count()
    };
    let children: usize = wide.nodes().iter().map(filled).sum();
    let per_node = children as f64 / wide.nodes().len() as f64;
    let per_block = bvh.leaf_prims().triangles.len() as f64 / wide.triangles().len() as f64;
    let lanes = NATIVE as f64;
    assert!(
        per_node > 0.75 * lanes && per_block > 0.5 * lanes,
        "{per_node:.2} a node, {per_block:.2} a block"
    );
}
