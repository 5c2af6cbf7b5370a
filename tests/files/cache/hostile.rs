//! Forged files with valid checksums and hostile rows: refused, or rendered like any scene.

use super::{CacheFolder, bytes_of, frame, scene};
use crate::common::full_or;
use crate::common::rng::Rng;
use glam::Vec3;
use phalanx::bvh::Bvh;
use phalanx::cache::{CacheError, CacheFault, Cached};
use phalanx::frame::{Accel, Engine, Kernel};
use phalanx::scene::{DefaultedParts, Material, OrthoHeight, OutputEncoding, Scene, UpAxis};
use phalanx::scene::{Environment, EnvironmentLight};
use std::ops::Range;
use std::time::{Duration, Instant};

const HEADER: usize = 64;
const ENTRY: usize = 24;

fn word(bytes: &[u8], offset: usize) -> u32 {
    u32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap())
}

fn long(bytes: &[u8], offset: usize) -> usize {
    u64::from_le_bytes(bytes[offset..offset + 8].try_into().unwrap()) as usize
}

/// Byte ranges of the sections, as documented for the header.
fn sections(bytes: &[u8]) -> Vec<Range<usize>> {
    let count = word(bytes, 20) as usize;
    let entries = (0..count).map(|k| HEADER + ENTRY * k);
    let range = |entry| {
        let offset = long(bytes, entry);
        offset..offset + long(bytes, entry + 8) * word(bytes, entry + 16) as usize
    };
    entries.map(range).collect()
}

/// Recomputes all checksums.
pub fn fix(bytes: &mut [u8]) {
    for (k, range) in sections(bytes).into_iter().enumerate() {
        let sum = crc32fast::hash(&bytes[range]);
        let position = HEADER + ENTRY * k + 20;
        bytes[position..position + 4].copy_from_slice(&sum.to_le_bytes());
    }
    let table = HEADER + ENTRY * word(bytes, 20) as usize;
    bytes[32..36].fill(0);
    let sum = crc32fast::hash(&bytes[..table]);
    bytes[32..36].copy_from_slice(&sum.to_le_bytes());
}

/// Numbers that break code that trusts them.
const NASTY: [u32; 12] = [
    0,
    1,
    2,
    7,
    255,
    0x7fff_ffff,
    0x8000_0000,
    0x8fff_a000,
    0x3f80_0000,
    0x7f80_0000,
    0x7fc0_0000,
    u32::MAX,
];

fn spoil(bytes: &mut [u8], sections: &[Range<usize>], rng: &mut Rng) {
    for _ in 0..1 + rng.below(3) {
        let full: Vec<_> = sections.iter().filter(|s| s.len() >= 4).collect();
        let section = full[rng.below(full.len())].clone();
        let offset = section.start + rng.below(section.len() - 3);
        let aligned = section.start + (offset - section.start) / 4 * 4;
        match rng.below(4) {
            0 => bytes[offset] ^= 1 << rng.below(8),
            1 => bytes[offset] = rng.below(256) as u8,
            2 => bytes[aligned..aligned + 4].copy_from_slice(&NASTY[rng.below(12)].to_le_bytes()),
            _ => {
                let from = section.start + rng.below(section.len() / 4) * 4;
                bytes.copy_within(from..from + 4, aligned);
            }
        }
    }
}

/// Duration of the test: PHALANX_FUZZ_SECONDS, else a second, or five at full size.
fn patience() -> Duration {
    let seconds = std::env::var("PHALANX_FUZZ_SECONDS");
    Duration::from_secs(
        seconds
            .ok()
            .and_then(|s| s.parse().ok())
            .unwrap_or(full_or(5, 1)),
    )
}

#[test]
fn spoiled_rows_never_break_an_engine() {
    let room = CacheFolder::new();
    let mut rng = Rng::new(11);
    let originals = [scene(21, 60), scene(22, 6), plain(23)];
    let originals = originals.map(|(scene, bvh)| bytes_of(&scene, &bvh));
    let (start, mut taken, mut refused) = (Instant::now(), 0u64, 0u64);
    while start.elapsed() < patience() || taken < 20 || refused < 20 {
        let mut bytes = originals[rng.below(3)].clone();
        let sections = sections(&bytes);
        spoil(&mut bytes, &sections, &mut rng);
        fix(&mut bytes);
        let cached = match room.open(&bytes) {
            Ok(cached) => cached,
            Err(CacheError::Refused { .. }) => {
                refused += 1;
                continue;
            }
            Err(other) => panic!("{other}"),
        };
        taken += 1;
        rendered(cached);
    }
    println!("{taken} rendered, {refused} refused");
}

/// Checks that an accepted scene is valid, and that both kernels terminate on it.
fn rendered(cached: Cached) {
    let mut scene = cached.scene;
    scene.validate().expect("what is taken is valid");
    scene.max_depth = scene.max_depth.min(4);
    (scene.width, scene.height) = (16, 8);
    let prepared = Accel::with_tree(cached.bvh);
    for kernel in Kernel::ALL.map(|(_, kernel)| kernel) {
        frame(&scene, &prepared, Engine::Simd, kernel);
    }
}

/// A scene without instances and with a single material: columns and arrays of other scenes are
/// empty here.
fn plain(seed: u64) -> (Scene, Bvh) {
    let mut rng = Rng::new(seed);
    let mut scene = Scene {
        max_depth: 2,
        ..Scene::default()
    };
    scene.view.eye = Vec3::new(0.0, 0.0, 6.0);
    let only = scene.materials.push(&Material {
        kd: Vec3::splat(0.5),
        ks: Vec3::splat(0.5),
        shininess: 9.0,
        ..Material::default()
    });
    for _ in 0..20 {
        let corners = [rng.point(1.0), rng.point(1.0), rng.point(1.0)];
        scene.add_triangle(corners, None, only);
        scene.add_sphere(rng.point(1.0), 0.2, only);
    }
    scene.lights.add_point(Vec3::splat(6.0), Vec3::ONE, Vec3::X);
    scene.validate().expect("a valid scene");
    let bvh = Bvh::build(&scene);
    (scene, bvh)
}

/// The file with other rows in a section, and everything else moved accordingly.
fn replaced(bytes: &[u8], section: usize, rows: &[u8]) -> Vec<u8> {
    let all = sections(bytes);
    let mut out = bytes[..HEADER + ENTRY * all.len()].to_vec();
    for (k, range) in all.into_iter().enumerate() {
        out.resize(out.len().next_multiple_of(64), 0);
        let (entry, offset) = (HEADER + ENTRY * k, out.len() as u64);
        let content = if k == section { rows } else { &bytes[range] };
        let count = content.len() / word(bytes, entry + 16) as usize;
        out[entry..entry + 8].copy_from_slice(&offset.to_le_bytes());
        out[entry + 8..entry + 16].copy_from_slice(&(count as u64).to_le_bytes());
        out.extend(content);
    }
    let length = out.len() as u64;
    out[24..32].copy_from_slice(&length.to_le_bytes());
    fix(&mut out);
    out
}

/// The file without the last row of a section.
fn shortened(bytes: &[u8], short: usize) -> Option<Vec<u8>> {
    let rows = &bytes[sections(bytes)[short].clone()];
    let row = word(bytes, HEADER + ENTRY * short + 16) as usize;
    let rest = rows.len().checked_sub(row)?;
    Some(replaced(bytes, short, &rows[..rest]))
}

/// Settings are the first section, in rows of a byte.
#[test]
fn settings_survive_and_their_prefixes_do_not() {
    let (scene, bvh) = scene(43, 30);
    let mut scene = Scene {
        width: 7,
        max_depth: 3,
        output: Some("bild-ä.png".into()),
        encoding: OutputEncoding::SRGB,
        scale: 0.25,
        light_scale: 1e-3,
        emission_lights: true,
        origin: [500_000.1, -0.0, -4e6],
        background: Vec3::new(0.1, -0.0, 3.0),
        ..scene
    };
    scene.lights.add_directional(Vec3::Y, Vec3::ONE);
    scene.view.ortho = Some(7.0);
    scene.defaulted = DefaultedParts {
        light: true,
        up: UpAxis::NegY,
        ortho: Some(OrthoHeight::Given(2.5)),
        ortho_size: Some([3.0, 0.1]),
        made_for: Some((1.5, true)),
        ..DefaultedParts::default()
    };
    let sky = EnvironmentLight::Gradient {
        nadir: Vec3::ZERO,
        zenith: Vec3::ONE,
    };
    scene.environment = Some(Environment::new(sky, UpAxis::NegX, 12.5));
    let bytes = bytes_of(&scene, &bvh);
    let room = CacheFolder::new();
    let back = room.open(&bytes).expect("settings").scene;
    assert_eq!(bytes_of(&back, &bvh), bytes);
    assert_eq!(format!("{back:?}"), format!("{scene:?}"));
    let settings = &bytes[sections(&bytes)[0].clone()];
    let prefixes = (0..settings.len()).map(|length| settings[..length].to_vec());
    for other in prefixes.chain([[settings, &[0]].concat()]) {
        assert!(
            room.open(&replaced(&bytes, 0, &other)).is_err(),
            "{other:?}"
        );
    }
    let spoiled = [
        |s: &mut Scene| s.background.y = f32::NAN,
        |s: &mut Scene| s.environment.as_mut().expect("a sky").scale = f32::NAN,
        |s: &mut Scene| {
            let nadir = Vec3::NEG_X;
            let light = EnvironmentLight::Gradient {
                nadir,
                zenith: Vec3::ONE,
            };
            s.environment.as_mut().expect("a sky").light = light;
        },
        |s: &mut Scene| s.scale = 0.75,
        |s: &mut Scene| s.light_scale = -1.0,
        |s: &mut Scene| s.light_scale = f32::INFINITY,
        |s: &mut Scene| s.scale = 0.0,
        |s: &mut Scene| s.scale = -1.0,
        |s: &mut Scene| s.origin[1] = f64::NAN,
        |s: &mut Scene| s.origin[2] = f64::INFINITY,
        |s: &mut Scene| s.defaulted.ortho_size = Some([1.0, f64::NAN]),
        |s: &mut Scene| s.defaulted.ortho = Some(OrthoHeight::Given(-1.0)),
        |s: &mut Scene| s.textures[0].width = 0,
        |s: &mut Scene| s.textures[0].height = u32::MAX,
    ];
    for (k, spoil) in spoiled.into_iter().enumerate() {
        let mut bad = back.clone();
        spoil(&mut bad);
        assert!(room.open(&bytes_of(&bad, &bvh)).is_err(), "{k}");
    }
}

/// Columns of one table must have the same length, and the list of primitives the sum of theirs.
#[test]
fn no_section_may_lack_its_last_row() {
    let room = CacheFolder::new();
    let mut refused = 0;
    for (scene, bvh) in [scene(41, 30), plain(42)] {
        let bytes = bytes_of(&scene, &bvh);
        for short in 0..sections(&bytes).len() {
            let Some(bad) = shortened(&bytes, short) else {
                continue;
            };
            match room.open(&bad) {
                Err(CacheError::Refused { .. }) => refused += 1,
                Ok(cached) => rendered(cached),
                Err(other) => panic!("{other}"),
            }
        }
    }
    assert!(refused > 60, "only {refused} were refused");
}

/// Proof that each check is needed: without it, the file would be accepted.
#[test]
fn each_kind_of_nonsense_is_named() {
    let room = CacheFolder::new();
    let (scene, bvh) = scene(31, 60);
    let bytes = bytes_of(&scene, &bvh);
    let all = sections(&bytes);
    // Found by their contents, so that this test does not count sections.
    let offset_of = |needle: &[u8]| {
        let bytes_named = all.iter().find(|range| bytes[(*range).clone()] == *needle);
        bytes_named.expect("a section of these bytes").start
    };
    let words = |rows: &[u32]| -> Vec<u8> { rows.iter().flat_map(|w| w.to_le_bytes()).collect() };
    let triangles = &scene.triangles;
    let corners = offset_of(&words(triangles.corners.as_flattened()));
    let materials = offset_of(&words(&triangles.material));
    let heights: Vec<u32> = triangles.vertices.y.iter().map(|c| c.to_bits()).collect();
    let heights = offset_of(&words(&heights));
    let radii = offset_of(&words(
        &scene
            .lights
            .radius
            .iter()
            .map(|r| r.to_bits())
            .collect::<Vec<_>>(),
    ));
    let gloss = offset_of(&words(
        &scene
            .materials
            .gloss
            .iter()
            .map(|n| n.to_bits())
            .collect::<Vec<_>>(),
    ));
    // Spheres first, instances after them.
    let geometries = [&scene.geometries.first, &scene.geometries.count];
    let [begin, size] = geometries.map(|rows| offset_of(&words(rows)));
    let prims = (scene.prim_count() as u32).to_le_bytes();
    let levels = offset_of(
        &(bvh.depths().unwrap().iter())
            .flat_map(|l| l.to_le_bytes())
            .collect::<Vec<u8>>(),
    );
    let is_mesh_root = |&level: &u16| level == 0x8001;
    let mesh_root = (bvh.depths().unwrap().iter())
        .position(is_mesh_root)
        .unwrap();
    let nodes = offset_of(bvh.arrays()[0].bytes);
    let instances = offset_of(bvh.arrays()[5].bytes);
    let slot_bytes = bvh.arrays()[5].row_bytes;
    // A node's boxes take 48 bytes; two indices and two tags follow.
    let (first, tag) = (nodes + 48, nodes + 56);
    let with = |changes: &[(usize, &[u8])]| {
        let mut bad = bytes.clone();
        for (position, change) in changes {
            bad[*position..position + change.len()].copy_from_slice(change);
        }
        fix(&mut bad);
        room.open(&bad).err().map(|error| error.to_string())
    };
    assert_eq!(with(&[]), None);
    let beyond = u32::MAX.to_le_bytes();
    let zero = [0; 4];
    for (what, changes, part) in [
        (
            "a corner out of range",
            vec![(corners, &beyond[..])],
            "triangle corners",
        ),
        (
            "a material out of range",
            vec![(materials, &beyond)],
            "triangle materials",
        ),
        ("a NaN among vertices", vec![(heights, &beyond)], "vertices"),
        (
            "a gloss below zero",
            vec![(gloss, &(-1.0f32).to_le_bytes())],
            "gloss of material 0 is negative or not finite",
        ),
        (
            "a light's radius that is no number",
            vec![(radii, &beyond)],
            "radius of light 0 is negative or not finite",
        ),
        (
            "a sphere's radius for a directional light",
            vec![(radii + 4, &1.0f32.to_le_bytes())],
            "shape of light 1",
        ),
        (
            "a geometry beyond all primitives",
            vec![(begin, &prims[..])],
            "run of geometry 0 is out of range",
        ),
        (
            "a geometry of too many primitives",
            vec![(size, &prims)],
            "run of geometry 0 is out of range",
        ),
        (
            "a geometry of an instance that is none",
            vec![(begin + 4, &[7, 0, 0, 0])],
            "run of geometry 1 is out of range",
        ),
        (
            "a geometry of an instance before another",
            vec![(begin + 8, &zero)],
            "run of geometry 2 is out of range",
        ),
        (
            "a child out of range",
            vec![(first, &beyond)],
            "nodes of the tree",
        ),
        (
            "a child that is its parent",
            vec![(first, &zero)],
            "nodes of the tree",
        ),
        (
            "a leaf of no kind",
            vec![(tag, &[0xff, 0xff])],
            "nodes of the tree",
        ),
        (
            "a leaf too long",
            vec![(tag, &[0xff, 0xaf])],
            "nodes of the tree",
        ),
        (
            "both children the same",
            vec![(first + 4, &bytes[first..first + 4])],
            "branches meet",
        ),
        (
            "a root of a mesh",
            vec![(levels, &[1, 0x80])],
            "nodes of the tree",
        ),
        (
            "the world's root at level 0",
            vec![(levels, &zero[..2])],
            "nodes of the tree",
        ),
        (
            "a mesh's root at level 0",
            vec![(levels + 2 * mesh_root, &[0, 0x80])],
            "nodes of the tree",
        ),
        (
            "an instance of the world",
            vec![(instances + slot_bytes - 8, &zero)],
            "instances of the tree",
        ),
        (
            "an instance of another mesh",
            vec![(instances + slot_bytes - 4, &zero)],
            "another mesh",
        ),
    ] {
        let message = with(&changes).unwrap_or_else(|| panic!("{what}: taken"));
        assert!(message.contains(part), "{what}: {message}");
    }
    assert!(matches!(
        CacheFault::from(phalanx::bvh::BvhError::Row),
        CacheFault::Tree(_)
    ));
}
