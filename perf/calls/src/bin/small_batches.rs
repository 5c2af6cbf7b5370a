//! The time of small batches over that of as many calls.
//!
//!     cargo run --release --manifest-path perf/calls/Cargo.toml --bin small_batches -- MESH [ROUNDS]
//!
//! MESH is a file of triangles, or a standard scene. One thread. Batches read rays from columns or
//! from rows, and write hits to columns; `calls` are single calls whose hits nobody keeps. All take
//! turns, on blocks of 4096 rays. Each block counts with its fastest visit, so that what else a
//! machine does hardly matters.

#[path = "../rays.rs"]
mod rays;
#[path = "../shadow.rs"]
mod shadow;

use phalanx::bvh::{BuildSettings, Quality};
use phalanx::{Bvh, HitBuffer, Ray, RayBuffer, RayColumns, RayRows, TMax};
use std::error::Error;
use std::hint::black_box;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

const SIDE: usize = 512;
const BLOCK: usize = 4096;
const SIZES: [usize; 8] = [1, 4, 8, 16, 32, 64, 128, 512];

/// Casts some of the rays.
type Case<'a> = (String, Box<dyn FnMut(Range<usize>) + 'a>);

/// Rays of a set: singly, in columns and in rows of seven numbers, all with one limit.
struct RaySet {
    rays: Vec<Ray>,
    buffer: RayBuffer,
    numbers: Vec<f32>,
    any: bool,
}

impl RaySet {
    fn new(rays: Vec<Ray>, any: bool) -> RaySet {
        let numbers = |ray: &Ray| [&ray.origin[..], &ray.direction, &[ray.tmax]].concat();
        RaySet {
            buffer: rays.iter().copied().collect(),
            numbers: rays.iter().flat_map(numbers).collect(),
            rays,
            any,
        }
    }

    fn columns(&self, Range { start, end }: Range<usize>) -> RayColumns<'_> {
        let all = self.buffer.columns();
        RayColumns {
            origin: all.origin.map(|column| &column[start..end]),
            direction: all.direction.map(|column| &column[start..end]),
            tmax: TMax::All(self.rays[0].tmax),
        }
    }

    fn rows(&self, Range { start, end }: Range<usize>) -> RayRows<'_> {
        let numbers = &self.numbers[7 * start..7 * end];
        RayRows {
            origin: &numbers[..numbers.len() - 4],
            direction: &numbers[3..numbers.len() - 1],
            stride: 7,
            tmax: TMax::All(self.rays[0].tmax),
        }
    }

    /// Single calls, and batches of each size.
    fn cases<'a>(&'a self, bvh: &'a Bvh) -> Vec<Case<'a>> {
        let calls = move |rays: Range<usize>| {
            for ray in &self.rays[rays] {
                if self.any {
                    black_box(bvh.occluded(ray));
                } else {
                    black_box(bvh.intersect(ray).is_some());
                }
            }
        };
        let mut all: Vec<Case> = vec![("calls".into(), Box::new(calls))];
        for in_rows in [false, true] {
            for size in SIZES {
                let (mut hits, mut blocked) = (HitBuffer::new(size), vec![false; size]);
                let batches = move |rays: Range<usize>| {
                    for from in rays.step_by(size) {
                        let part = from..from + size;
                        let threads = 1;
                        let done = match (self.any, in_rows) {
                            (false, false) => bvh.intersect_batch(
                                &self.columns(part),
                                &mut hits.columns(),
                                threads,
                            ),
                            (false, true) => {
                                bvh.intersect_batch(&self.rows(part), &mut hits.columns(), threads)
                            }
                            (true, false) => {
                                bvh.occluded_batch(&self.columns(part), &mut blocked, threads)
                            }
                            (true, true) => {
                                bvh.occluded_batch(&self.rows(part), &mut blocked, threads)
                            }
                        };
                        done.expect("columns of one length");
                    }
                };
                let name = if in_rows { "rows" } else { "columns" };
                all.push((format!("{size:3} in {name}"), Box::new(batches)));
            }
        }
        all
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let mesh = words.next().ok_or("give a mesh, or a standard scene")?;
    let rounds = words.next().map_or(Ok(5), |rounds| rounds.parse())?;
    let scene = phalanx::open::open(Path::new(&mesh), &Default::default())?.scene;
    let settings = BuildSettings {
        quality: Quality::Best,
        threads: 0,
    };
    let bvh = Bvh::build_with(&scene, &settings);
    bvh.build_wide(0);
    let mut sets: Vec<_> = rays::sets(&scene, &bvh, SIDE)
        .into_iter()
        .map(|(name, rays)| (name, rays, false))
        .collect();
    let shadow = shadow::shadow_rays(&scene, &bvh, &sets[0].1);
    sets.push(("shadow", shadow, true));
    for (name, mut rays, any) in sets {
        rays.truncate(rays.len() / BLOCK * BLOCK);
        println!("\n{mesh}, {name}, {} rays", rays.len());
        let set = RaySet::new(rays, any);
        measure(set.rays.len(), rounds, set.cases(&bvh));
    }
    Ok(())
}

/// Prints each case's nanoseconds a ray, and their ratio to those of the first.
fn measure(rays: usize, rounds: usize, mut cases: Vec<Case>) {
    let count = cases.len();
    let mut fastest = vec![vec![f64::INFINITY; rays / BLOCK]; count];
    // In each turn the cases have different blocks: none finds its own in the caches.
    for turn in 0..rounds * count {
        for block in 0..rays / BLOCK {
            let case = (7 * block + turn) % count;
            let start = Instant::now();
            cases[case].1(block * BLOCK..(block + 1) * BLOCK);
            let seconds = start.elapsed().as_secs_f64();
            fastest[case][block] = fastest[case][block].min(seconds);
        }
    }
    let nanoseconds = |case: usize| 1e9 * fastest[case].iter().sum::<f64>() / rays as f64;
    for (case, (name, _)) in cases.iter().enumerate() {
        let (one, calls) = (nanoseconds(case), nanoseconds(0));
        println!("{name:16} {one:7.1} ns {:6.3}", one / calls);
    }
}
