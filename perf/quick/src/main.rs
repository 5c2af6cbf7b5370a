//! Rates of kernels on rays that `phalanx bench --dump-rays` wrote.
//!
//! `quick KERNEL,… SCENE.phx RAYS [SCENE.phx RAYS]…`; `PASSES=7` says how many. Kernels take turns; each 1,024 rays count with their
//! fastest pass, in millions of rays a second on one thread. A kernel whose answers are not those of the file is told on.
//! `WORK=1` counts instead: nodes, boxes, leaves and primitives for sixteen rays.

use bumpalo::Bump;
use phalanx::bvh::{BuildSettings, Bvh, Quality};
use phalanx::cache;
use phalanx::lanes::LANES;
use phalanx::packet::{HitPacket, NO_PRIM, RayQueue};
use phalanx::trace::{Kernel, Tally, Traversal, Work};
use std::error::Error;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

/// Rays that are timed, about.
const TIMED: usize = 1 << 16;

/// Packets that are timed together.
const CHUNK: usize = 128;

/// The rest of a ray file; see `src/bench/dump.rs`.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self
            .0
            .split_at_checked(count)
            .ok_or("the ray file is cut off")?;
        self.0 = rest;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32, String> {
        let bytes = self.take(4)?;
        Ok(u32::from_le_bytes(bytes.try_into().expect("four of them")))
    }

    fn words(&mut self, count: usize) -> Result<Vec<u32>, String> {
        (0..count).map(|_| self.word()).collect()
    }
}

/// One set of rays, and what they hit.
struct Set {
    kind: String,
    occlusion: bool,
    tmax: f32,
    rays: Vec<u32>,
    prim_id: Vec<u32>,
    t: Vec<u32>,
}

fn set(bytes: &mut Bytes) -> Result<Set, String> {
    let kind = String::from_utf8_lossy(bytes.take(16)?);
    let kind = kind.trim_end_matches('\0').to_string();
    let (occlusion, tmax) = (bytes.word()? == 1, f32::from_bits(bytes.word()?));
    let count = (u64::from(bytes.word()?) | u64::from(bytes.word()?) << 32) as usize;
    Ok(Set {
        kind,
        occlusion,
        tmax,
        rays: bytes.words(count * 6)?,
        prim_id: bytes.words(count)?,
        t: bytes.words(count)?,
    })
}

/// Traces some packets, and counts rays whose answer is wrong, if it is asked to look.
fn trace<T: Tally>(
    kernel: &mut Traversal<T>,
    set: &Set,
    rays: &RayQueue,
    packets: Range<usize>,
    look: bool,
) -> (f64, usize) {
    let mut hits = [HitPacket::miss(); CHUNK];
    let mut blocked = [0u8; CHUNK];
    let (first, count) = (packets.start, packets.len());
    let start = Instant::now();
    if set.occlusion {
        kernel.unoccluded(rays, packets, set.tmax, |k, seen| {
            blocked[k - first] = !seen
        });
    } else {
        kernel.closest(rays, packets, &mut hits[..count]);
    }
    let seconds = start.elapsed().as_secs_f64();
    let all = first * LANES..rays.len().min((first + count) * LANES);
    let wrong = all.filter(|&ray| {
        let (k, lane) = (ray / LANES - first, ray % LANES);
        let (id, t) = (hits[k].prim_id.lane(lane), hits[k].t.lane(lane).to_bits());
        match set.occlusion {
            true => u32::from(blocked[k] >> lane & 1) != set.prim_id[ray],
            false => id != set.prim_id[ray] || id != NO_PRIM && t != set.t[ray],
        }
    });
    (seconds, if look { wrong.count() } else { 0 })
}

fn queue<'a>(arena: &'a Bump, set: &Set) -> RayQueue<'a> {
    let mut rays = RayQueue::with_capacity(arena, set.prim_id.len());
    for ray in set.rays.as_chunks::<6>().0 {
        let [a, b, c, d, e, f] = ray.map(f32::from_bits);
        rays.push_ray([a, b, c], [d, e, f]);
    }
    rays
}

fn count(bvh: &Bvh, set: &Set, kernels: &[(&'static str, Kernel)]) -> String {
    let arena = Bump::new();
    let rays = queue(&arena, set);
    let counts = kernels.iter().map(|(name, kernel)| {
        let mut kernel = Traversal::<Work>::counting(bvh, *kernel);
        for first in (0..rays.packets()).step_by(CHUNK) {
            let packets = first..rays.packets().min(first + CHUNK);
            trace(&mut kernel, set, &rays, packets, false);
        }
        let work = kernel.work();
        let [nodes, boxes, leaves, prims] =
            [work.node_visits, work.box_tests, work.leaf_visits, work.prim_tests]
                .map(|n| n as f64 / rays.len() as f64 * 16.0);
        format!(
            "\n    {name:9} nodes {nodes:6.2}  boxes {:6.2}x16  leaves {leaves:6.2}  tests {:6.2}x16",
            boxes / 16.0,
            prims / 16.0
        )
    });
    counts.collect()
}

fn measure(bvh: &Bvh, set: &Set, kernels: &[(&'static str, Kernel)], passes: usize) -> String {
    let arena = Bump::new();
    let rays = queue(&arena, set);
    // As `bench` does: chunks that are far from each other, because neighbours would leave each other the caches full.
    let stride = rays.len().div_ceil(TIMED) | 1;
    let chunks = rays.packets().div_ceil(CHUNK).div_ceil(stride);
    let packets = |chunk: usize| {
        let first = chunk * stride * CHUNK;
        first..rays.packets().min(first + CHUNK)
    };
    let rays_in =
        |packets: Range<usize>| rays.len().min(packets.end * LANES) - packets.start * LANES;
    let timed: usize = (0..chunks).map(|chunk| rays_in(packets(chunk))).sum();
    let rate = |seconds: f64| timed as f64 / seconds / 1e6;
    let mut rows: Vec<_> = kernels
        .iter()
        .map(|(_, kernel)| (*kernel, vec![f64::INFINITY; chunks], 0))
        .collect();
    for pass in 0..passes {
        for (kernel, best, wrong) in &mut rows {
            // What it learns it learns in each pass anew, as in a frame.
            let kernel = &mut Traversal::new(bvh, *kernel);
            for (chunk, best) in best.iter_mut().enumerate() {
                let (seconds, differ) = trace(kernel, set, &rays, packets(chunk), pass == 0);
                *best = best.min(seconds);
                *wrong += differ;
            }
        }
    }
    // What a choice that is always right would reach.
    let least = |chunk: usize| {
        rows.iter()
            .map(|(_, best, _)| best[chunk])
            .fold(f64::INFINITY, f64::min)
    };
    let best = rate((0..chunks).map(least).sum());
    let rates = rows
        .iter()
        .zip(kernels)
        .map(|((_, best, wrong), (name, _))| {
            let rate = rate(best.iter().sum());
            match wrong {
                0 => format!("  {name} {rate:7.2}"),
                _ => format!("  {name} {rate:7.2} ({wrong} WRONG)"),
            }
        });
    rates
        .chain([format!("  best of each {best:7.2}")])
        .collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [names, files @ ..] = &words[..] else {
        return Err("quick KERNEL,… SCENE.phx RAYS [SCENE.phx RAYS]…".into());
    };
    let passes = std::env::var("PASSES").map_or(Ok(7), |passes| passes.parse())?;
    let kernels = Kernel::ALL.into_iter();
    let kernels: Vec<_> = kernels
        .filter(|(name, _)| names.split(',').any(|n| n == *name))
        .collect();
    for pair in files.chunks_exact(2) {
        // The tree that `bench` has.
        let settings = BuildSettings {
            quality: Quality::Best,
            threads: 0,
        };
        let bvh = Bvh::build_with(&cache::open(Path::new(&pair[0]))?.scene, &settings);
        let file = std::fs::read(&pair[1])?;
        let mut bytes = Bytes(&file);
        if bytes.take(8)? != b"PHXRAYS2" {
            return Err(format!("{} is no ray file", pair[1]).into());
        }
        // The origin: the cache's scene has the same one.
        bytes.take(24)?;
        let name = Path::new(&pair[0])
            .file_stem()
            .unwrap_or_default()
            .display();
        for _ in 0..bytes.word()? {
            let set = set(&mut bytes)?;
            let rates = match std::env::var_os("WORK") {
                Some(_) => count(&bvh, &set, &kernels),
                None => measure(&bvh, &set, &kernels, passes),
            };
            println!("{name:16} {:10}{rates}", set.kind);
        }
    }
    Ok(())
}
