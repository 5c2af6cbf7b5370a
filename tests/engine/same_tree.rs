//! The tree of a scene is the same on every build: the same boxes, the same leaves, in the same
//! order.
//!
//! The hashes below were recorded once; `.ci/run --all` runs this test on every instruction set
//! that this machine has.

use phalanx::bvh::{BuildSettings, Bvh, Child};
use phalanx::formats::{Options, load};
use phalanx::scene::Scene;
use phalanx::standard;
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
    let triangles = bvh.leaf_prims().triangles.iter().map(|slot| slot.prim_id);
    let spheres = bvh.leaf_prims().spheres.iter().map(|slot| slot.prim_id);
    let ellipsoids = bvh.leaf_prims().ellipsoids.iter().map(|slot| slot.prim_id);
    hash(nodes.chain(triangles).chain(spheres).chain(ellipsoids))
}

/// A scene of ours, or a standard one of several chunks.
fn scene(name: &str) -> Scene {
    if let Ok(spec) = standard::parse_spec(name) {
        return standard::scene(spec, 0).expect("a standard scene");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.test"));
    let loaded = load(&path, &Options::default());
    loaded.expect("a scene of ours").scene
}

#[test]
fn every_build_makes_the_same_tree() {
    let expected = [
        ("phalanx", 0xa6eccdcf1ca99c0d),
        ("spheres", 0x4117e9ed81c13eef),
        ("mirrors", 0xbd39ef780e14e8bd),
        ("standard:street:60k", 0x10e8631226dfd2ee),
        ("standard:balls:5", 0x42c2318c8e9c611d),
    ];
    let actual = expected.map(|(name, _)| {
        let scene = scene(name);
        let bvh = Bvh::build(&scene);
        for threads in [1, 2, 7] {
            let settings = BuildSettings {
                threads,
                ..BuildSettings::default()
            };
            let again = Bvh::build_with(&scene, &settings);
            assert_eq!(tree_hash(&bvh), tree_hash(&again), "{name}, {threads}");
        }
        (name, tree_hash(&bvh))
    });
    assert_eq!(actual, expected, "{actual:#x?}");
}
