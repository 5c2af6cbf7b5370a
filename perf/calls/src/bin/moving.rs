//! Times of trees that follow a moving mesh, against building them anew.
//!
//!     cargo run --release --manifest-path perf/calls/Cargo.toml --bin moving -- MESH [THREADS]
//!
//! Prints medians of milliseconds, of the clock and of all threads' CPU time: a build of the mesh,
//! with and without the wide tree; a refit of its moved vertices; and the move of a thousand
//! instances of it. `perf/notes/calls.md` has the tables, and Embree's times, by
//! `perf/calls/embree_moving.py`.

#[path = "../cpu_time.rs"]
mod cpu_time;

use cpu_time::{Times, middle, time};
use phalanx::bvh::{BuildSettings, Quality};
use phalanx::glam::{DAffine3, DVec3};
use phalanx::{Bvh, Scene};
use std::error::Error;
use std::path::Path;

const ROUNDS: usize = 15;
const INSTANCES: usize = 1000;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mesh = arguments.next().ok_or("give a mesh")?;
    let threads = arguments.next().map_or(Ok(0), |threads| threads.parse())?;
    let read = phalanx::open::open(Path::new(&mesh), &Default::default())?.scene;
    let positions = &read.triangles.vertices;
    let mut vertices: Vec<[f32; 3]> = (0..positions.len())
        .map(|k| positions.get(k).to_array())
        .collect();
    let size = (read.bounds().hi - read.bounds().lo).length();
    let faces = read.triangles.corners.to_vec();
    let settings = BuildSettings {
        quality: Quality::Medium,
        threads,
    };

    let mut scene = Scene::new();
    let body = scene.add_mesh(&vertices, &faces)?;
    let (build, _) = median(|_| Bvh::build_with(&scene, &settings));
    let (both, mut bvh) = median(|_| {
        let bvh = Bvh::build_with(&scene, &settings);
        bvh.build_wide(threads);
        bvh
    });
    println!("{mesh}, {} triangles, {threads} threads", faces.len());
    println!(
        "build                {} ms, with the wide tree {}",
        shown(build),
        shown(both)
    );
    let mut wide_off = Bvh::build_with(&scene, &settings);
    let mut wave = |scene: &mut Scene, round: usize| {
        let rest = size * 0.002 * (round as f32).sin();
        for vertex in &mut vertices {
            vertex[1] += rest * (vertex[0] / size * 20.0).sin();
        }
        scene.set_vertices(body, &vertices).expect("the mesh");
    };
    let [mut narrow, mut wide] = [Vec::new(), Vec::new()];
    for round in 0..ROUNDS {
        wave(&mut scene, round);
        narrow.push(time(|| wide_off.update(&scene)).0);
        wide.push(time(|| bvh.update(&scene)).0);
    }
    let [narrow, wide] = [narrow, wide].map(|times| middle(&times));
    println!(
        "refit                {} ms, with the wide tree {}",
        shown(narrow),
        shown(wide)
    );
    println!(
        "refit / build, CPU   {:8.3}                      {:8.3}",
        narrow[1] / build[1],
        wide[1] / both[1]
    );

    let mut scene = Scene::new();
    let prototype = scene.add_prototype(&vertices, &faces)?;
    let place = |k: usize, round: usize| {
        let step = f64::from(size) * 1.2;
        let position = DVec3::new(
            (k % 32) as f64,
            (k / 32) as f64,
            0.1 * (round * k % 7) as f64,
        );
        DAffine3::from_translation(position * step)
    };
    let instances: Vec<u32> = (0..INSTANCES)
        .map(|k| scene.add_instance(prototype, place(k, 0)))
        .collect::<Result<_, _>>()?;
    let mut bvh = Bvh::build_with(&scene, &settings);
    bvh.build_wide(threads);
    let mut times = Vec::new();
    for round in 1..=ROUNDS {
        for (k, &instance) in instances.iter().enumerate() {
            scene.set_transform(instance, place(k, round))?;
        }
        times.push(time(|| bvh.update(&scene)).0);
    }
    println!(
        "{INSTANCES} instances moved {} ms, the first time {}",
        shown(middle(&times[1..])),
        shown(times[0])
    );
    Ok(())
}

fn median<T>(mut work: impl FnMut(usize) -> T) -> (Times, T) {
    let (times, mut made): (Vec<Times>, Vec<T>) = (0..5).map(|k| time(|| work(k))).unzip();
    (middle(&times), made.swap_remove(0))
}

fn shown([wall, cpu]: Times) -> String {
    format!("{wall:8.2} (CPU {cpu:.2})")
}
