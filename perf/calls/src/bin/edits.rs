//! Times of trees that follow a scene where things move, come and go.
//!
//!     cargo run --release --manifest-path perf/calls/Cargo.toml --bin edits -- MESH [THREADS]
//!
//! Prints medians of milliseconds of CPU time: updates of ten thousand instances of which some
//! move; of a scene of the mesh beside which a sphere, a mesh, a prototype and instances come and
//! go; sixty frames of a mesh that is bent more and more; and the rate of random rays after a
//! thousand edits, by that of a fresh build. `perf/notes/calls.md` has the table, and Embree's
//! times, by `perf/calls/embree_edits.py`.

#[path = "../cpu_time.rs"]
mod cpu_time;

use cpu_time::{middle, time};
use phalanx::bvh::{BuildSettings, Quality};
use phalanx::glam::{DAffine3, dvec3};
use phalanx::{Bvh, GeomId, HitBuffer, Ray, RayBuffer, Scene, UpdateWork};
use std::error::Error;
use std::path::Path;

const ROUNDS: usize = 15;
const INSTANCES: u32 = 10_000;
const FRAMES: usize = 60;
const EDITS: usize = 1000;
const RAYS: usize = 100_000;

type Triangles = (Vec<[f32; 3]>, Vec<[u32; 3]>);

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("give a mesh")?;
    let threads = arguments.next().map_or(Ok(0), |threads| threads.parse())?;
    let read = phalanx::open::open(Path::new(&path), &Default::default())?.scene;
    let positions = &read.triangles.vertices;
    let vertices = (0..positions.len()).map(|k| positions.get(k).to_array());
    let mesh: Triangles = (vertices.collect(), read.triangles.corners.to_vec());
    let quality = Quality::Medium;
    let settings = BuildSettings { quality, threads };
    let size = f64::from((read.bounds().hi - read.bounds().lo).length());
    println!("{path}, {} triangles, {threads} threads", mesh.1.len());
    move_instances(&settings)?;
    change_beside(&mesh, size, &settings)?;
    bend(&mesh, size as f32, &settings)?;
    trace_after_edits(&mesh, size, &settings)
}

/// A small mesh: a grid of 1,000 triangles and a few over a square of this side.
fn patch(side: f64, x: f64, y: f64, z: f64) -> Triangles {
    let n = 23u32;
    let place = |i: u32, j: u32| {
        let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(n) * side);
        let wave = (u / side * 9.0).sin() * (v / side * 7.0).cos() * side * 0.1;
        [x + u, y + v, z + wave].map(|c| c as f32)
    };
    let vertices = (0..=n).flat_map(|i| (0..=n).map(move |j| place(i, j)));
    let row = n + 1;
    let faces = (0..n).flat_map(|i| (0..n).map(move |j| i * row + j));
    let faces = faces.flat_map(|k| [[k, k + 1, k + row], [k + 1, k + row + 1, k + row]]);
    (vertices.collect(), faces.collect())
}

/// Ten thousand instances of a small mesh, of which some move.
fn move_instances(settings: &BuildSettings) -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let (vertices, faces) = patch(1.0, 0.0, 0.0, 0.0);
    let prototype = scene.add_prototype(&vertices, &faces)?;
    let place = |k: u32, round: usize| {
        let shift = (round as u32 * k % 7).into();
        DAffine3::from_translation(dvec3((k % 100).into(), (k / 100).into(), shift))
    };
    for k in 0..INSTANCES {
        scene.add_instance(prototype, place(k, 0))?;
    }
    let built = built(&scene, settings);
    for moved in [1, 100, INSTANCES] {
        let mut bvh = built.clone();
        let mut times = Vec::new();
        for round in 1..=ROUNDS {
            for k in (0..INSTANCES).step_by((INSTANCES / moved) as usize) {
                scene.set_transform(k, place(k, round))?;
            }
            times.push(time(|| bvh.update(&scene)).0);
        }
        let [[_, first], [_, next]] = [times[0], middle(&times[1..])];
        println!("{INSTANCES} instances, {moved} move: first {first:.2}, next {next:.2}");
    }
    Ok(())
}

/// The mesh, beside which other things come and go.
fn change_beside(
    (vertices, faces): &Triangles,
    size: f64,
    settings: &BuildSettings,
) -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let body = scene.add_mesh(vertices, faces)?;
    let (small, rows) = patch(size * 0.1, 0.0, 0.0, size);
    let door = scene.add_mesh(&small, &rows)?;
    let prototype = scene.add_prototype(&small, &rows)?;
    let place =
        |round: usize| DAffine3::from_translation(dvec3(0.0, size * 0.01 * round as f64, 0.0));
    let instance = scene.add_instance(prototype, place(0))?;
    let mut bvh = built(&scene, settings);
    let mut show = |scene: &Scene, words: &str| {
        let ([_, cpu], report) = time(|| bvh.update(scene));
        println!("{words:30} {cpu:8.3} {:?}", report.work);
    };
    let radius = size as f32 * 0.05;
    let mut added: Vec<GeomId> = Vec::new();
    for round in 0..3 {
        scene.set_transform(instance, place(round + 1))?;
        show(&scene, "an instance moves");
        added.push(scene.add_spheres(&[[0.0, 0.0, radius * round as f32]], &[radius])?);
        show(&scene, "a sphere comes");
        let (more, rows) = patch(size * 0.1, size * 0.1 * round as f64, 0.0, size);
        added.push(scene.add_mesh(&more, &rows)?);
        show(&scene, "a mesh comes");
        let prototype = scene.add_prototype(&more, &rows)?;
        show(&scene, "a prototype comes");
        added.push(scene.add_instance(prototype, place(round))?);
        show(&scene, "an instance comes");
        let shifted: Vec<[f32; 3]> = small.iter().map(|v| [v[0], v[1] + radius, v[2]]).collect();
        scene.set_vertices(door, &shifted)?;
        show(&scene, "a small mesh deforms");
        scene.set_mask(door, 0)?;
        show(&scene, "a small mesh is hidden");
        scene.set_mask(door, 1)?;
        show(&scene, "a small mesh is shown");
        scene.set_mask(body, 0)?;
        show(&scene, "the large mesh is hidden");
        scene.set_mask(body, 1)?;
        show(&scene, "the large mesh is shown");
        for id in added.drain(..) {
            scene.remove(id)?;
        }
        show(&scene, "three geometries go");
    }
    Ok(())
}

/// The mesh, twisted more with each frame.
fn bend(
    (vertices, faces): &Triangles,
    size: f32,
    settings: &BuildSettings,
) -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let body = scene.add_mesh(vertices, faces)?;
    let mut bvh = built(&scene, settings);
    let (mut times, mut builds, mut growth) = (Vec::new(), 0, 1.0f64);
    for frame in 1..=FRAMES {
        let turn = frame as f32 / FRAMES as f32 * 12.0;
        let twisted = vertices.iter().map(|&[x, y, z]| {
            let (sin, cos) = (turn * y / size).sin_cos();
            [x * cos - z * sin, y, x * sin + z * cos]
        });
        scene.set_vertices(body, &twisted.collect::<Vec<_>>())?;
        let (spent, report) = time(|| bvh.update(&scene));
        times.push(spent);
        builds += usize::from(report.work == UpdateWork::Rebuilt);
        growth = growth.max(bvh.cost_growth());
    }
    let most = times.iter().fold(0.0, |most: f64, [_, cpu]| most.max(*cpu));
    let [_, median] = middle(&times);
    println!("{FRAMES} frames of a twist: median {median:.1}, most {most:.1}, {builds} builds");
    println!("cost grown to {growth:.2} at most");
    Ok(())
}

/// Rays through the mesh among small ones that come, go and move, against a fresh build.
fn trace_after_edits(
    (vertices, faces): &Triangles,
    size: f64,
    settings: &BuildSettings,
) -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    scene.add_mesh(vertices, faces)?;
    let bounds = scene.bounds();
    let mut random = 1u64;
    let mut unit = move || {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (random >> 40) as f64 / (1u64 << 24) as f64
    };
    let (lo, extent) = (bounds.lo.as_dvec3(), (bounds.hi - bounds.lo).as_dvec3());
    let mut spot = move || lo + extent * dvec3(unit(), unit(), unit());
    let mut bvh = built(&scene, settings);
    let (mut present, mut builds) = (Vec::<GeomId>::new(), 0);
    for edit in 0..EDITS {
        let p = spot();
        let (vertices, faces) = patch(size * 0.03, p.x, p.y, p.z);
        match edit % 4 {
            0 | 1 => present.push(scene.add_mesh(&vertices, &faces)?),
            2 => scene.remove(present.remove(edit % present.len()))?,
            _ => scene.set_vertices(present[edit % present.len()], &vertices)?,
        }
        builds += usize::from(bvh.update(&scene).work == UpdateWork::Rebuilt);
    }
    let fresh = built(&scene, settings);
    let rays = (0..RAYS).map(|_| {
        let (from, to) = (spot(), spot());
        Ray::new(from.as_vec3(), (to - from).as_vec3())
    });
    let rays: Vec<Ray> = rays.collect();
    let (buffer, mut hits): (RayBuffer, _) = (rays.iter().copied().collect(), HitBuffer::new(RAYS));
    let [mut one, mut many] = [[f64::INFINITY; 2]; 2];
    for _ in 0..ROUNDS {
        for (k, bvh) in [&fresh, &bvh].into_iter().enumerate() {
            let hit = |ray: &Ray| bvh.intersect(ray).is_some();
            one[k] = one[k].min(time(|| rays.iter().filter(|ray| hit(ray)).count()).0[1]);
            let batch = || bvh.intersect_batch(&buffer.columns(), &mut hits.columns(), 1);
            many[k] = many[k].min(time(batch).0[1]);
        }
    }
    println!(
        "{EDITS} edits, {} small meshes, {builds} builds: rays {:.3} one by one, {:.3} in batches of a fresh build's rate; cost_growth {:.3}, SAH {:.2}, of a fresh build {:.2}",
        present.len(),
        one[0] / one[1],
        many[0] / many[1],
        bvh.cost_growth(),
        bvh.sah(),
        fresh.sah(),
    );
    Ok(())
}

/// The tree of a scene, with its wide half.
fn built(scene: &Scene, settings: &BuildSettings) -> Bvh {
    let bvh = Bvh::build_with(scene, settings);
    bvh.build_wide(settings.threads);
    bvh
}
