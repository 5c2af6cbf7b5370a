//! Small batches, in every form, against as many calls: the same bits.

use crate::common::rng::Rng;
use crate::front_door::{rays, soup};
use phalanx::{Bvh, Hit, HitBuffer, Ray, RayBatch, RayBuffer, RayColumns, RayRows, Scene, TMax};
use std::sync::Mutex;

/// Triangles and spheres, without instances, so that single rays trace what is small.
fn scene() -> Scene {
    let mut random = Rng::new(3);
    let mut scene = Scene::new();
    let (vertices, indices) = soup(&mut random, 400);
    scene.add_mesh(&vertices, &indices).unwrap();
    let centers = [(); 9].map(|()| random.point(1.0).to_array());
    scene.add_spheres(&centers, &[0.1; 9]).unwrap();
    scene
}

/// Checks all calls for the closest hits and for shadows of a batch.
fn check<'r>(bvh: &Bvh, batch: impl Into<RayBatch<'r>> + Copy, rays: &[Ray]) {
    let expected: Vec<Option<Hit>> = rays.iter().map(|ray| bvh.intersect(ray)).collect();
    let mut hits = HitBuffer::new(rays.len());
    bvh.intersect_batch(batch, &mut hits.columns(), 1).unwrap();
    assert!(hits.iter().eq(expected.iter().copied()));
    let passed = Mutex::new(vec![Vec::new(); rays.len()]);
    let put = |k: usize, hit| passed.lock().unwrap()[k].push(hit);
    bvh.intersect_batch_each(batch, 1, put).unwrap();
    let once = expected.iter().map(|&hit| vec![hit]);
    assert!(passed.into_inner().unwrap().into_iter().eq(once));
    let mut blocked = vec![true; rays.len()];
    bvh.occluded_batch(batch, &mut blocked, 1).unwrap();
    let dark = rays.iter().map(|ray| bvh.occluded(ray));
    assert!(blocked.into_iter().eq(dark));
}

#[test]
fn small_batches_answer_as_calls_do() {
    let bvh = Bvh::build(&scene());
    for count in (0..=40).chain([64, 100, 127, 130, 511, 512, 513]) {
        let from = count * 53 % 4000;
        let all = &rays(7, from + count)[from..];
        for common in [None, Some(f32::INFINITY), Some(0.9), Some(f32::NAN)] {
            let limited = |ray: &Ray| Ray {
                tmax: common.unwrap_or(ray.tmax),
                ..*ray
            };
            let all: Vec<Ray> = all.iter().map(limited).collect();
            let buffer: RayBuffer = all.iter().copied().collect();
            let columns = buffer.columns();
            let tmax = common.map_or(columns.tmax, TMax::All);
            check(&bvh, &RayColumns { tmax, ..columns }, &all);
            let row = |ray: &Ray| [ray.origin, ray.direction].concat();
            let numbers: Vec<f32> = all.iter().flat_map(row).collect();
            let rows = RayRows {
                origin: &numbers[..numbers.len().saturating_sub(3)],
                direction: numbers.get(3..).unwrap_or(&[]),
                stride: 6,
                tmax,
            };
            check(&bvh, &rows, &all);
        }
    }
}
