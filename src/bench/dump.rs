//! Writes rays to a file, with the right results, to be replayed in other tracers.
//!
//! All numbers are little-endian; f32 and u32 take four bytes, u64 and f64 eight.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `PHXRAYS2` |
//! | 3 f64 | origin of the rays' coordinates, in the coordinates of the scene's file |
//! | u32 | number of sets |
//! | | then for each set: |
//! | 16 | its kind, ASCII, padded with zeros |
//! | u32 | query: 0 for the closest hit, 1 for occlusion |
//! | f32 | tmax: hits count for 0 < t < tmax; infinity if there is no limit |
//! | u64 | n, the number of rays |
//! | n × 6 f32 | origin and direction of each ray |
//! | n × u32 | result of each ray: primitive, or occlusion (see below) |
//! | n × f32 | t of the closest hit, 0 where there is none; 0 for occlusion |
//!
//! t and tmax are in units of the direction, which is not always of unit length. Primitives are
//! numbered as in the scene; 4294967295 stands for none. Occlusion is 1 where the ray is occluded,
//! else 0.

use super::answer::Answer;
use super::error::BenchError;
use super::plan::{BenchPlan, SceneInfo};
use super::workload::{self, BenchTrees, Workload};
use bumpalo::Bump;
use phalanx_report::QueryKind;
use phalanx_scene::Scene;
use phalanx_trace::packet::NO_PRIM;
use phalanx_trace::simd::LANES;
use std::io::{self, Write};

/// Magic bytes at the beginning of the file.
pub const MAGIC: [u8; 8] = *b"PHXRAYS2";

/// The reason why no ray file was written.
#[derive(Debug, thiserror::Error)]
pub enum DumpError {
    /// The scene yields no rays.
    #[error(transparent)]
    Scene(#[from] Box<BenchError>),
    /// The file could not be written.
    #[error("{0}")]
    Io(#[from] io::Error),
}

/// Writes the ray sets of a plan, with the oracle's results. Returns the number of rays of each
/// kind.
///
/// # Errors
/// [`DumpError`].
pub fn dump(
    scene: &Scene,
    info: &SceneInfo,
    plan: &BenchPlan,
    out: &mut dyn Write,
) -> Result<Vec<(&'static str, usize)>, DumpError> {
    let (arena, trees) = (Bump::new(), BenchTrees::build(scene, plan));
    let workloads = workload::workloads(&arena, &trees, plan, info).map_err(Box::new)?;
    out.write_all(&MAGIC)?;
    for axis in scene.origin {
        out.write_all(&axis.to_le_bytes())?;
    }
    out.write_all(&(workloads.len() as u32).to_le_bytes())?;
    for workload in &workloads {
        write_set(workload, out)?;
    }
    let counts = workloads.iter().map(|q| (q.kind().name(), q.rays()));
    Ok(counts.collect())
}

fn write_set(workload: &Workload, out: &mut dyn Write) -> io::Result<()> {
    let mut name = [0; 16];
    let kind = workload.kind().name().as_bytes();
    name[..kind.len()].copy_from_slice(kind);
    out.write_all(&name)?;
    let query = u32::from(workload.kind().query() == QueryKind::Occluded);
    out.write_all(&query.to_le_bytes())?;
    out.write_all(&workload.set.tmax.to_le_bytes())?;
    out.write_all(&(workload.rays() as u64).to_le_bytes())?;
    for ray in 0..workload.rays() {
        let (org, dir) = workload.set.queue.ray(ray / LANES, ray % LANES);
        for number in org.into_iter().chain(dir) {
            out.write_all(&number.to_le_bytes())?;
        }
    }
    let answers = || (0..workload.rays()).map(|ray| answer(&workload.expected, ray));
    for (prim_id, _) in answers() {
        out.write_all(&prim_id.to_le_bytes())?;
    }
    for (_, t) in answers() {
        out.write_all(&t.to_le_bytes())?;
    }
    Ok(())
}

fn answer(expected: &Answer, ray: usize) -> (u32, f32) {
    let (packet, lane) = (ray / LANES, ray % LANES);
    match expected {
        Answer::Closest(hits) => match hits[packet].prim_id.lane(lane) {
            NO_PRIM => (NO_PRIM, 0.0),
            prim_id => (prim_id, hits[packet].t.lane(lane)),
        },
        Answer::Occluded(blocked) => (u32::from(blocked[packet] >> lane & 1), 0.0),
    }
}
