//! The modern scenes: the requested number of valid triangles, and the same on every machine.

use super::{scene, spec};
use glam::Vec3;
use phalanx::frame::{Accel, Control, Engine, Settings, render};
use phalanx::scene::{OutputEncoding, Scene};
use phalanx::standard::{CATALOGUE, Family, StandardScene, counts};

/// Names, and a hash of each scene at 8,000 and at 200,000 triangles, which are drawn in one piece
/// and in many. A different hash means a different scene:
/// benchmarks would no longer be comparable with earlier ones.
const HASHES: [(&str, u64, u64); 7] = [
    ("cornell", 0x7e2a17423270ba62, 0xa6e118419d00bf79),
    ("terrain", 0xa1f6305671f03ca1, 0x5460c916e761c806),
    ("menger", 0x924f4d25cd0d4414, 0xc61941ef780ce61b),
    ("street", 0xebbc24de0a174e4f, 0x5f17d606901c8cb3),
    ("hair", 0xb7193c8c73d1b75f, 0x5b1fb586c7f473c9),
    ("room", 0xcb8e450ca8673307, 0x21ff84dd62c1aa7c),
    ("atrium", 0x88795b5d7c356f56, 0x45197cc582c93c5f),
];

fn modern() -> impl Iterator<Item = &'static StandardScene> {
    CATALOGUE.iter().filter(|e| e.family == Family::Modern)
}

/// FNV-1a over the bits of all numbers that a picture depends on.
fn hash(scene: &Scene) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut word = |bits: u32| {
        for byte in bits.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    };
    let vectors = |word: &mut dyn FnMut(u32), v: &phalanx::scene::Vec3s| {
        for column in [&v.x, &v.y, &v.z] {
            column.iter().for_each(|x| word(x.to_bits()));
        }
    };
    let (t, m, l) = (&scene.triangles, &scene.materials, &scene.lights);
    vectors(&mut word, &t.vertices);
    t.corners.iter().flatten().for_each(|&v| word(v));
    t.material.iter().for_each(|&row| word(row));
    for colors in [&m.ka, &m.ke, &m.kd, &m.ks, &m.kt] {
        vectors(&mut word, colors);
    }
    for row in 0..m.len() {
        word(m.shininess[row].to_bits());
        word(m.ior[row].to_bits());
    }
    for columns in [&l.position, &l.color, &l.attenuation] {
        vectors(&mut word, columns);
    }
    let view = &scene.view;
    for v in [view.eye, view.center, view.up, scene.background] {
        v.to_array().into_iter().for_each(|x| word(x.to_bits()));
    }
    word(view.fovy.to_bits());
    hash
}

#[test]
fn scenes_are_the_same_everywhere() {
    let names: Vec<_> = modern().map(|e| e.name).collect();
    assert_eq!(names, HASHES.map(|(name, ..)| name));
    let actual = HASHES.map(|(name, ..)| {
        let of_size = |size: &str| hash(&scene(&format!("{name}:{size}")));
        (name, of_size("8k"), of_size("200k"))
    });
    assert!(actual == HASHES, "{actual:#x?}");
}

#[test]
fn there_are_as_many_triangles_as_asked_for() {
    for entry in modern() {
        for size in ["6k", "10k", "70k", "200k", "1M", "3M", "20M", "100M"] {
            let name = format!("{}:{size}", entry.name);
            let spec = spec(&name);
            let counts = counts(spec);
            let share = counts.triangles as f64 / f64::from(spec.size);
            assert!((0.95..1.05).contains(&share), "{name}: {share}");
            assert_eq!((counts.spheres, counts.cones), (0, 0));
            // Numbers counted without drawing are those of the drawn scene.
            if spec.size <= 200_000 {
                let scene = scene(&name);
                assert_eq!(scene.triangles.len() as u64, counts.triangles, "{name}");
                assert_eq!(scene.lights.len() as u64, counts.lights, "{name}");
            }
        }
    }
}

#[test]
fn triangles_are_finite_and_hardly_any_has_no_area() {
    for entry in modern() {
        for size in ["8k", "300k"] {
            let name = format!("{}:{size}", entry.name);
            let scene = scene(&name);
            let vertices = &scene.triangles.vertices;
            let finite = (0..vertices.len()).all(|i| vertices.get(i).is_finite());
            assert!(finite, "{name}");
            let flat = (0..scene.triangles.len()).filter(|&i| {
                let [a, b, c] = scene.triangles.corners(i);
                (b - a).as_dvec3().cross((c - a).as_dvec3()).length() == 0.0
            });
            let flat = flat.count();
            assert!(flat * 10_000 <= scene.triangles.len(), "{name}: {flat}");
        }
    }
}

#[test]
fn views_and_tones_are_those_of_pictures() {
    for entry in modern() {
        let scene = scene(&format!("{}:8k", entry.name));
        assert_eq!(scene.encoding, OutputEncoding::SRGB);
        assert!(scene.width >= 1024 && scene.height >= 960);
        assert_eq!(scene.max_depth, entry.max_depth);
        assert!(scene.view.basis().is_ok());
    }
}

/// A surface that faces the eye shows its front: the generators wind their triangles
/// counter-clockwise.
#[test]
fn closed_things_are_wound_outward() {
    // The sponge stands on a floor of two triangles, which come last.
    let scene = scene("menger:8k");
    let middle = Vec3::new(0.0, 0.5, 0.0);
    let mut volume = 0.0;
    let floor = -0.001;
    for i in 0..scene.triangles.len() {
        let [a, b, c] = scene.triangles.corners(i).map(|p| p - middle);
        if a.y + middle.y > floor {
            volume += a.as_dvec3().dot(b.as_dvec3().cross(c.as_dvec3())) / 6.0;
        }
    }
    // (20/27)² of the cube, at level 2.
    assert!((volume - 0.548_696).abs() < 1e-4, "{volume}");
}

#[test]
fn both_engines_see_the_same() {
    for entry in modern() {
        let scene = scene(&format!("{}:8k", entry.name));
        let film = |engine| {
            let settings = Settings {
                engine,
                width: 72,
                height: 48,
                record_hits: true,
                ..Settings::of(&scene)
            };
            let prepared = Accel::build(&scene, engine);
            render(&scene, &prepared, &settings, &Control::default()).unwrap()
        };
        let (simd, scalar) = (film(Engine::Simd), film(Engine::Scalar));
        assert!(simd.film == scalar.film, "{}", entry.name);
        let lit = scalar.film.planes[1].iter().filter(|&&g| g > 0.0).count();
        assert!(lit > 72 * 48 / 2, "{}: {lit} pixels lit", entry.name);
    }
}
