//! Shared parts of the benchmarks: scenes, the same rays for every engine, and criterion's
//! settings.
#![allow(dead_code, reason = "every benchmark uses its own part")]

pub mod microbench;
#[path = "../../tests/common/rng.rs"]
pub mod rng;
pub mod traced;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion};
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use phalanx::formats::{Options, load};
use phalanx::scene::Scene;
use phalanx::standard;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Image size of the ratios in `ratios`.
pub const SIZE: [u32; 2] = [1280, 960];

/// Image size for benchmarks in which criterion repeats a frame many times.
pub const SMALL: [u32; 2] = [512, 384];

/// A group that takes a second or two per function: enough to compare, short enough to wait for.
pub fn brief<'c>(c: &'c mut Criterion, name: &str) -> BenchmarkGroup<'c, WallTime> {
    let mut group = c.benchmark_group(name);
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600));
    group
}

/// The course's dragon (100,000 triangles) if its file is available, and our thousand spheres.
pub fn scenes() -> Vec<(String, Scene)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let candidates: [PathBuf; 2] = [
        root.join("../../shared/scenes/cse167/scene7.test"),
        root.join("../scenes/spheres.test"),
    ];
    let mut scenes = Vec::new();
    for path in candidates {
        match load(&path, &Options::default()) {
            Ok(loaded) => {
                let name = path.file_stem().unwrap_or_default().to_string_lossy();
                scenes.push((name.into_owned(), loaded.scene));
            }
            Err(error) => eprintln!("skipped: {error}"),
        }
    }
    scenes
}

/// Standard scenes, which are the same everywhere: only triangles, almost only spheres, cones and
/// spheres.
pub const STANDARD: [&str; 3] = [
    "standard:terrain:64k",
    "standard:balls:4",
    "standard:tree:8",
];

/// A standard scene by its full name.
pub fn standard_scene(name: &str) -> Scene {
    let spec = standard::parse_spec(name).expect("a standard scene");
    standard::scene(spec, 0).expect("a valid scene")
}

/// obvhs's own tree and triangles, used as in its examples.
pub struct ObvhsPeer {
    bvh: Bvh2,
    triangles: Vec<Triangle>,
}

impl ObvhsPeer {
    /// Builds with obvhs's medium preset.
    pub fn build(scene: &Scene) -> ObvhsPeer {
        let triangles: Vec<Triangle> = (0..scene.triangles.len())
            .map(|i| {
                let [a, b, c] = scene.triangles.corners(i);
                Triangle {
                    v0: a.into(),
                    v1: b.into(),
                    v2: c.into(),
                }
            })
            .collect();
        let mut unused = std::time::Duration::ZERO;
        let bvh = build_bvh2_from_tris(&triangles, BvhBuildParams::medium_build(), &mut unused);
        let triangles = bvh
            .primitive_indices
            .iter()
            .map(|&i| triangles[i as usize])
            .collect();
        ObvhsPeer { bvh, triangles }
    }

    /// Returns true if a ray hits anything, by `ray_traverse`.
    pub fn hits(&self, org: [f32; 3], dir: [f32; 3]) -> bool {
        let ray = Ray::new_inf(org.into(), dir.into());
        let mut hit = RayHit::none();
        self.bvh
            .ray_traverse(ray, &mut hit, |ray, i| self.triangles[i].intersect(ray));
        hit.t < f32::INFINITY
    }
}
