//! Millions of rays a second where a call takes one ray, or a few: phalanx, obvhs, parry3d, Embree.
//!
//!     cargo run --release --manifest-path perf/calls/Cargo.toml -- MESH [--embree LIBRARY]
//!
//! MESH is a file of triangles, or a standard scene; Embree is measured where its library is found.
//! One thread. Each ray is the caller's when a call begins, and its closest hit the caller's when it
//! ends. All tracers take turns; the medians of the rounds are printed, and for our batches the
//! rate by their size. `perf/notes/calls.md` has the tables.
//!
//! `rays` has the sets of rays.

mod rays;
mod turns;

use bumpalo::Bump;
use parry3d::query::RayCast;
use parry3d::shape::TriMesh;
use phalanx::bench::peers::{self, Peer, PeerScene, RaySetRef};
use phalanx::bvh::{BuildSettings, Quality};
use phalanx::lanes::LANES;
use phalanx::packet::{HitPacket, RayQueue};
use phalanx::{
    BatchFilter, Bvh, HitBuffer, PerRay, Ray, RayBuffer, RayColumns, RayFilter, Scene, TMax,
};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use turns::{NamedCast, median, take_turns};

/// Side of the camera's picture, in pixels; each set has as many rays as it has pixels.
const SIDE: usize = 512;
const ROUNDS: usize = 7;
const BATCHES: [usize; 5] = [8, 16, 64, 512, 2048];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mesh = arguments.next().ok_or("give a mesh, or a standard scene")?;
    let library = arguments.skip_while(|word| word != "--embree").nth(1);
    let scene = phalanx::open::open(Path::new(&mesh), &Default::default())?.scene;
    let settings = BuildSettings {
        quality: Quality::Best,
        threads: 0,
    };
    let bvh = Bvh::build_with(&scene, &settings);
    bvh.build_wide(0);
    let peers = peers(&scene, &settings, library.as_deref());
    let parry = parry(&scene)?;
    for (name, rays) in rays::sets(&scene, &bvh, SIDE) {
        let buffer: RayBuffer = rays.iter().copied().collect();
        let arena = Bump::new();
        let mut queue = RayQueue::with_capacity(&arena, rays.len());
        rays.iter()
            .for_each(|ray| queue.push_ray(ray.origin, ray.direction));
        let set = RaySetRef {
            queue: &queue,
            tmax: f32::INFINITY,
        };
        let mut rows: Vec<NamedCast> = vec![(
            "phalanx, one ray a call".into(),
            Box::new(|| {
                rays.iter()
                    .filter(|ray| bvh.intersect(ray).is_some())
                    .count()
            }),
        )];
        for size in BATCHES.into_iter().chain([rays.len()]) {
            let (bvh, columns) = (&bvh, buffer.columns());
            rows.push((
                format!("phalanx, batches of {size}"),
                Box::new(move || batches(bvh, &columns, size)),
            ));
        }
        rows.extend(filtered(&bvh, &rays));
        for (peer, scene) in &peers {
            for (mode, engine) in scene(set) {
                if mode == peers::ONE || peer == "obvhs" {
                    rows.push((
                        format!("{peer}, {mode}"),
                        Box::new(move || {
                            let mut hits = vec![HitPacket::miss(); rays_packets(set)];
                            engine.thread().closest(0..hits.len(), &mut hits);
                            hits.len() * LANES
                        }),
                    ));
                }
            }
        }
        let rays = &rays;
        rows.push((
            "parry3d, TriMesh".into(),
            Box::new(|| rays.iter().filter(|ray| parry_hit(&parry, ray)).count()),
        ));
        println!("\n{mesh}, {name}, {} rays", rays.len());
        measure(rays.len(), rows);
    }
    Ok(())
}

/// Single calls with filters, and a batch with one.
fn filtered<'a>(bvh: &'a Bvh, rays: &'a [Ray]) -> Vec<NamedCast<'a>> {
    let any = RayFilter::default();
    let filters = [
        ("that accepts all", any),
        ("by mask", RayFilter { mask: 1, ..any }),
        ("by tnear", RayFilter { tnear: 1e-4, ..any }),
        ("that ignores one", RayFilter { ignore: 7, ..any }),
        (
            "by closure",
            RayFilter {
                accept: &|hit| hit.u + hit.v < 0.99,
                ..any
            },
        ),
    ];
    let row = |(name, filter): (&str, RayFilter<'static>)| {
        let cast: Box<dyn FnMut() -> usize> = Box::new(move || {
            let hits = rays
                .iter()
                .filter(|ray| bvh.intersect_filtered(ray, &filter).is_some());
            hits.count()
        });
        (format!("one ray, filter {name}"), cast)
    };
    let mut rows: Vec<NamedCast> = filters.into_iter().map(row).collect();
    let buffer: RayBuffer = rays.iter().copied().collect();
    rows.push((
        "batch of all, filter by mask".into(),
        Box::new(move || {
            let mut hits = HitBuffer::new(buffer.len());
            let filter = BatchFilter {
                mask: PerRay::All(1),
                ..BatchFilter::default()
            };
            let (columns, mut found) = (buffer.columns(), hits.columns());
            let batch = bvh.intersect_batch_filtered(&columns, &filter, &mut found, 1);
            batch.expect("columns of one length");
            hits.len()
        }),
    ));
    rows
}

fn rays_packets(set: RaySetRef) -> usize {
    set.queue.len().div_ceil(LANES)
}

/// The rays in batches of one size, each from the caller's columns into the caller's hits.
fn batches(bvh: &Bvh, rays: &RayColumns, size: usize) -> usize {
    let mut hits = HitBuffer::new(size);
    for from in (0..rays.len()).step_by(size) {
        let to = (from + size).min(rays.len());
        let part = RayColumns {
            origin: rays.origin.map(|column| &column[from..to]),
            direction: rays.direction.map(|column| &column[from..to]),
            tmax: TMax::All(f32::INFINITY),
        };
        if to - from < size {
            hits = HitBuffer::new(to - from);
        }
        let batch = bvh.intersect_batch(&part, &mut hits.columns(), 1);
        batch.expect("columns of one length");
    }
    hits.len()
}

/// Prints the median rate of each row.
fn measure(rays: usize, mut rows: Vec<NamedCast>) {
    let seconds = take_turns(ROUNDS, &mut rows);
    for ((name, _), seconds) in rows.into_iter().zip(seconds) {
        println!("{name:32} {:8.2}", rays as f64 / median(seconds) / 1e6);
    }
}

/// Peers that trace the scene, by name.
fn peers(
    scene: &Scene,
    settings: &BuildSettings,
    library: Option<&str>,
) -> Vec<(String, PeerScene)> {
    let mut all = vec![Peer::Obvhs];
    match peers::embree::EmbreeLibrary::open(library.map(Path::new)) {
        Ok(library) => {
            let library = Arc::new(library);
            all.extend([false, true].map(|robust| Peer::Embree {
                library: Arc::clone(&library),
                robust,
            }));
        }
        Err(error) => println!("{error}"),
    }
    let built = all.into_iter().filter_map(|peer| {
        let built = peer.build(scene, settings);
        built.ok().map(|scene| (peer.name().to_owned(), scene))
    });
    built.collect()
}

fn parry(scene: &Scene) -> Result<TriMesh, Box<dyn Error>> {
    let vertices = &scene.triangles.vertices;
    let positions = (0..vertices.len()).map(|k| vertices.get(k).to_array().into());
    let mesh = TriMesh::new(positions.collect(), scene.triangles.corners.to_vec());
    Ok(mesh?)
}

fn parry_hit(mesh: &TriMesh, ray: &Ray) -> bool {
    let ray = parry3d::query::Ray::new(ray.origin.into(), ray.direction.into());
    mesh.cast_local_ray(&ray, f32::MAX, false).is_some()
}
