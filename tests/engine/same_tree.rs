//! The tree of a scene is the same on every build: the same boxes, the same leaves, in the same
//! order.
//!
//! The hashes below were taken once; `.ci/run` runs this test on every instruction set that it
//! builds for.

use phalanx::bvh::{Bvh, Child};
use phalanx::formats::{Options, load};
use std::path::Path;

/// FNV-1a over 32-bit words.
fn hash(words: impl Iterator<Item = u32>) -> u64 {
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| {
        (hash ^ u64::from(word)).wrapping_mul(0x0100_0000_01b3)
    })
}

fn tree_hash(bvh: &Bvh) -> u64 {
    let nodes = bvh.nodes().iter().flat_map(|node| {
        let boxes = node.boxes.as_flattened().as_flattened().iter();
        let mut words: Vec<u32> = boxes.map(|c| c.to_bits()).collect();
        for k in 0..2 {
            words.extend(match node.child(k) {
                Child::Node(index) => [0, index, 0],
                Child::Leaf { kind, first, count } => [1 + kind.number() as u32, first, count],
            });
        }
        words
    });
    let triangles = bvh.triangles().iter().map(|slot| slot.prim_id);
    let spheres = bvh.spheres().iter().map(|slot| slot.prim_id);
    let ellipsoids = bvh.ellipsoids().iter().map(|slot| slot.prim_id);
    hash(nodes.chain(triangles).chain(spheres).chain(ellipsoids))
}

#[test]
fn every_build_makes_the_same_tree() {
    let expected = [
        ("phalanx", 0xd37da20706be2f70),
        ("spheres", 0x55c32acfb80dfaa9),
        ("mirrors", 0x13107acb7be5c828),
    ];
    let found = expected.map(|(name, _)| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.test"));
        let scene = load(&path, &Options::default())
            .expect("a scene of ours")
            .scene;
        let bvh = Bvh::build(&scene);
        assert_eq!(
            tree_hash(&bvh),
            tree_hash(&Bvh::build(&scene)),
            "{name}, built twice"
        );
        (name, tree_hash(&bvh))
    });
    assert_eq!(found, expected, "{found:#x?}");
}
