//! What the benchmarks share: scenes, and the same primary rays for every engine.

use phalanx::camera::Camera;
use phalanx::formats::{Options, load};
use phalanx::packet::RayQueue;
use phalanx::scene::Scene;
use std::path::{Path, PathBuf};

use bumpalo::Bump;
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use phalanx::lanes::{F32x8, LaneMask, Mask8, Vec3x8};

/// Image size of every benchmark.
pub const SIZE: (u32, u32) = (1280, 960);

/// The course's dragon (100,000 triangles) if it is at hand, and our thousand spheres.
pub fn scenes() -> Vec<(String, Scene)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let candidates: [PathBuf; 2] = [
        root.join("../shared/scenes/cse167/scene7.test"),
        root.join("scenes/spheres.test"),
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

/// Camera rays of a whole picture, packet by packet in 8×8 blocks, as tiles have them.
pub fn primary_rays<'a>(arena: &'a Bump, scene: &Scene) -> RayQueue<'a> {
    let (width, height) = SIZE;
    let camera = Camera::new(&scene.view, width, height).expect("a validated scene");
    let mut rays = RayQueue::with_capacity(arena, (width * height) as usize);
    let eye = Vec3x8::splat(camera.eye.x, camera.eye.y, camera.eye.z);
    for block_y in (0..height).step_by(8) {
        for block_x in (0..width).step_by(8) {
            for packet in 0..8 {
                let (x, y) = (block_x + packet % 2 * 4, block_y + packet / 2 * 2);
                let columns = std::array::from_fn(|k| (x + k as u32 % 4) as f32 + 0.5);
                let rows = std::array::from_fn(|k| (y + k as u32 / 4) as f32 + 0.5);
                let dir = camera.directions(F32x8::new(rows), F32x8::new(columns));
                rays.push(
                    Mask8::first(8),
                    eye,
                    dir,
                    Vec3x8::splat(0.0, 0.0, 0.0),
                    &[0; 8],
                );
            }
        }
    }
    rays
}

/// obvhs's own tree and triangles, as its examples use them.
pub struct Peer {
    bvh: Bvh2,
    triangles: Vec<Triangle>,
}

impl Peer {
    /// Builds with obvhs's medium preset.
    pub fn build(scene: &Scene) -> Peer {
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
        Peer { bvh, triangles }
    }

    /// Whether a ray hits anything, by `ray_traverse`.
    pub fn hits(&self, org: [f32; 3], dir: [f32; 3]) -> bool {
        let ray = Ray::new_inf(org.into(), dir.into());
        let mut hit = RayHit::none();
        self.bvh
            .ray_traverse(ray, &mut hit, |ray, i| self.triangles[i].intersect(ray));
        hit.t < f32::INFINITY
    }
}
