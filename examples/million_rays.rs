//! Millions of rays per second through plain slices: `cargo run --release --example million_rays`,
//! or with your own mesh, `... --example million_rays -- bunny.ply` (default features).

use phalanx::{Bvh, HitBuffer, Ray, RayBuffer, Scene};
use std::error::Error;
use std::time::Instant;

/// Pixels along each side of the picture: a million rays in all.
const SIDE: u32 = 1024;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = match std::env::args().nth(1) {
        Some(path) => read(&path)?,
        None => displaced_sphere(400)?,
    };
    let start = Instant::now();
    let bvh = Bvh::build(&scene);
    // Otherwise the first large batch would do this.
    bvh.build_wide(0);
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{} primitives, tree in {seconds:.3} s",
        scene.visible_count()
    );

    // From above and in front, toward the centre.
    let bounds = scene.bounds();
    let (center, size) = (
        (bounds.lo + bounds.hi) / 2.0,
        (bounds.hi - bounds.lo).length(),
    );
    let eye = center + 0.7 * size * phalanx::glam::Vec3::new(0.3, 0.4, 1.0);
    let ahead = (center - eye).normalize();
    let right = ahead.cross(phalanx::glam::Vec3::Y).normalize();
    let up = right.cross(ahead);
    // Neighbours in the columns are neighbours in the picture, in squares of 8×8: packets and beams
    // depend on it.
    let pixel = |k: u32| {
        let (square, inner) = (k / 64, k % 64);
        (
            square % (SIDE / 8) * 8 + inner % 8,
            square / (SIDE / 8) * 8 + inner / 8,
        )
    };
    let camera_ray = |k: u32| {
        let (x, y) = pixel(k);
        let [u, v] = [x, y].map(|c| (c as f32 + 0.5) / SIDE as f32 - 0.5);
        Ray::new(eye, ahead + u * right - v * up)
    };
    let rays: RayBuffer = (0..SIDE * SIDE).map(camera_ray).collect();

    let mut hits = HitBuffer::new(rays.len());
    let mut blocked = vec![false; rays.len()];
    for (name, threads) in [("1 thread", 1), ("all threads", 0)] {
        let start = Instant::now();
        bvh.intersect_batch(&rays.columns(), &mut hits.columns(), threads)?;
        let closest = rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6;
        let start = Instant::now();
        bvh.occluded_batch(&rays.columns(), &mut blocked, threads)?;
        let any = rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6;
        println!("{name:12} closest hit {closest:7.2} Mrays/s, occlusion {any:7.2} Mrays/s");
    }
    let met = hits.iter().flatten().count();
    println!("{met} of {} rays hit", rays.len());
    Ok(())
}

/// A wavy sphere of 2·`rings`² triangles.
fn displaced_sphere(rings: u32) -> Result<Scene, Box<dyn Error>> {
    let vertex = |i: u32| {
        let (row, column) = (i / rings, i % rings);
        let (sin, cos) = (row as f32 / rings as f32 * std::f32::consts::PI).sin_cos();
        let turn = column as f32 / rings as f32 * std::f32::consts::TAU;
        let radius = 1.0 + 0.05 * (9.0 * turn).sin() * (12.0 * cos).sin();
        [sin * turn.cos(), cos, sin * turn.sin()].map(|c| radius * c)
    };
    let vertices: Vec<[f32; 3]> = (0..(rings + 1) * rings).map(vertex).collect();
    let mut indices = Vec::new();
    for (row, column) in (0..rings).flat_map(|row| (0..rings).map(move |column| (row, column))) {
        let [a, b] = [column, (column + 1) % rings].map(|column| row * rings + column);
        indices.extend([[a, b, a + rings], [b, b + rings, a + rings]]);
    }
    let mut scene = Scene::new();
    scene.add_mesh(&vertices, &indices)?;
    Ok(scene)
}

#[cfg(feature = "render")]
fn read(path: &str) -> Result<Scene, Box<dyn Error>> {
    Ok(phalanx::formats::load(path.as_ref(), &Default::default())?.scene)
}

#[cfg(not(feature = "render"))]
fn read(_: &str) -> Result<Scene, Box<dyn Error>> {
    Err("reading files needs the feature `render`".into())
}
