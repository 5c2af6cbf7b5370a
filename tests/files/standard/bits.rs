//! The databases bit for bit: the same on every platform and in every build.
//!
//! When these were recorded, all eleven databases, at default and other sizes, agreed with the
//! files of the original programs (SPD 3.14, compiled by gcc), to the six digits that they print.

use super::{numbers, scene, spec};
use phalanx::standard::{MemoryBuilder, Tessellate};

const RECORDED: [(&str, u64); 11] = [
    ("balls", 0x87e5_7eeb_1cc7_533b),
    ("gears", 0x0e39_66c6_aae9_8d2e),
    ("jacks:3", 0x2519_324e_8327_3686),
    ("lattice", 0x62d9_a2f7_c054_e687),
    ("mount", 0x030a_00a6_5359_b855),
    ("rings", 0x8650_a9e5_f49e_f421),
    ("shells", 0x7184_fc2d_6a9a_a804),
    ("sombrero", 0x9ce7_502d_0984_af6d),
    ("teapot", 0x493e_fd88_18b8_2020),
    ("tetra", 0x72af_255f_0325_1859),
    ("tree", 0xc792_8889_7de7_4b98),
];

/// FNV-1a over the bits of numbers.
struct Fingerprint(u64);

impl Fingerprint {
    fn add(&mut self, numbers: &[f32]) {
        for byte in numbers.iter().flat_map(|n| n.to_bits().to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    fn of(scene: &phalanx::scene::Scene) -> u64 {
        let mut print = Fingerprint(0xcbf2_9ce4_8422_2325);
        for prim in 0..scene.prim_count() {
            let (_, coordinates, material) = numbers(scene, prim);
            print.add(&coordinates);
            print.add(&material);
        }
        for i in 0..scene.lights.len() {
            print.add(&scene.lights.position.get(i).to_array());
            print.add(&scene.lights.color.get(i).to_array());
        }
        let view = scene.view;
        for v in [view.eye, view.center, view.up] {
            print.add(&v.to_array());
        }
        print.add(&[view.fovy]);
        print.0
    }
}

#[test]
fn databases_are_the_same_bits_everywhere() {
    let actual = RECORDED.map(|(name, _)| (name, Fingerprint::of(&scene(name))));
    assert_eq!(actual, RECORDED);
}

#[test]
fn tessellation_is_the_same_bits_everywhere() {
    let actual = ["balls:2", "tree:4"].map(|name| {
        let spec = spec(name);
        let mut builder = MemoryBuilder::default();
        (spec.scene.generate)(spec.size, &mut Tessellate::new(5, &mut builder));
        Fingerprint::of(&builder.finish())
    });
    assert_eq!(actual, [0x4b29_326d_9715_861b, 0x8be7_4eda_9ab6_da20]);
}
