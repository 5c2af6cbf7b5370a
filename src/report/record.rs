//! The record of a benchmark run: what was measured, on which machine, and every sample.
//! `perf/record.schema.json` is its schema.
//!
//! Rates are millions of rays per second, times seconds, sizes bytes, unless a field's name says
//! otherwise. A field whose value could not be determined is `null`, never a guess.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of this layout; a change of meaning changes it.
pub const SCHEMA_VERSION: u32 = 2;

/// Name of the packet engine in records.
pub const PHALANX: &str = "phalanx";

/// Name of the oracle in records.
pub const ORACLE: &str = "oracle";

/// A benchmark run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BenchRecord {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// The program.
    pub program: Program,
    /// The machine.
    pub machine: Machine,
    /// Settings and time of the run.
    pub run: RunInfo,
    /// The scenes that were traced.
    pub scenes: Vec<SceneRecord>,
    /// The rates.
    pub rows: Vec<RateRow>,
    /// Work, counted in runs of its own beside the timed ones.
    pub counters: Vec<CounterRow>,
}

/// The program that measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// Version of this package.
    pub version: String,
    /// Commit it was built from.
    pub git_revision: Option<String>,
    /// True if files differed from that commit.
    pub git_dirty: Option<bool>,
    /// `rustc --version` of the compiler.
    pub rustc: Option<String>,
    /// Cargo profile, such as `release`.
    pub profile: String,
    /// Instruction-set level compiled for, such as `x86-64-v3`.
    pub isa_compiled: String,
    /// Highest level this CPU has.
    pub isa_available: String,
}

/// The machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// CPU model.
    pub cpu: String,
    /// Cores, as far as the system shows them.
    pub cores: Option<u32>,
    /// Threads that can run at once.
    pub threads: u32,
    /// True if cores run more than one thread.
    pub smt: Option<bool>,
    /// Caches from the first level on.
    pub caches: Vec<Cache>,
    /// Frequency governor of the first CPU.
    pub governor: Option<String>,
    /// Hypervisor's name, or empty on bare metal.
    pub hypervisor: Option<String>,
    /// Bytes of memory.
    pub memory_bytes: Option<u64>,
    /// Operating system and kernel.
    pub kernel: Option<String>,
}

impl Machine {
    /// The hypervisor's name, or `none` on bare metal; `None` if that is unknown.
    pub(super) fn hypervisor_words(&self) -> Option<&str> {
        let name = self.hypervisor.as_deref()?;
        Some(if name.is_empty() { "none" } else { name })
    }
}

/// A cache of the CPU.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cache {
    /// Level of the cache: 1, 2 or 3.
    pub level: u8,
    /// Kind of the cache: `data`, `instruction` or `unified`.
    pub kind: String,
    /// Size of the cache.
    pub bytes: u64,
    /// Hardware threads that share it.
    pub shared_by: u32,
}

/// Settings and time of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunInfo {
    /// Start, RFC 3339, UTC.
    pub started: String,
    /// Arguments, without the program's name, and without folders.
    pub arguments: Vec<String>,
    /// Wall seconds of the whole run.
    pub seconds: f64,
    /// True if the run was ended before it had all scenes and samples.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub partial: bool,
    /// Picture size of the rays, unless a scene says otherwise.
    pub size: [u32; 2],
    /// Camera rays per pixel, of the rays and of frames.
    #[serde(default = "one")]
    pub spp: u32,
    /// Requested samples of each row.
    pub repeat: u32,
    /// Least total time of each row's samples, in seconds.
    pub min_time: f64,
    /// True if workers were bound to cores.
    pub pinned: bool,
    /// Build quality of our trees, as `--quality` names it.
    #[serde(default = "medium")]
    pub quality: String,
    /// Libraries of peers that took part, such as `embree 4.4.0`.
    pub peers: Vec<String>,
}

/// Camera rays per pixel in records from before they were named.
fn one() -> u32 {
    1
}

/// The quality in records from before `--quality` existed.
fn medium() -> String {
    "medium".to_owned()
}

/// A scene, and the work of a run before it could trace rays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneRecord {
    /// Name of its file, without the folder, or `standard:NAME:SIZE`. Rows refer to it.
    pub name: String,
    /// Standard family, such as `terrain`.
    pub family: Option<String>,
    /// Step of the scene in the suite: `small`, `medium` or `large`.
    pub step: Option<String>,
    /// CRC-32 over the scene's primitives, 8 hexadecimal digits.
    pub hash: String,
    /// Origin of the scene in the file's coordinates; `None` for a scene that is not moved, and in
    /// older records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<[f64; 3]>,
    /// Number of primitives by kind: spheres, ellipsoids, triangles, cones, instances.
    pub primitives: BTreeMap<String, u64>,
    /// Primitives in all.
    pub primitive_count: u64,
    /// Picture size of the rays.
    pub size: [u32; 2],
    /// Time to read or generate the scene.
    pub load_seconds: f64,
    /// Time to build its trees, by engine.
    pub build_seconds: BTreeMap<String, f64>,
    /// Bytes of the packet engine's tree, primitives in leaf order included.
    pub tree_bytes: u64,
    /// Ray sets by kind.
    pub rays: BTreeMap<String, RaySetRecord>,
}

impl SceneRecord {
    /// Returns true if the scene has no primitives but triangles, and instances of them.
    pub fn is_of_triangles(&self) -> bool {
        let mut kinds = self.primitives.keys();
        kinds.all(|kind| ["triangles", "instances"].contains(&&**kind))
    }
}

/// A set of rays, and its results.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RaySetRecord {
    /// Number of rays.
    pub rays: u64,
    /// Number of rays that hit something (or are occluded).
    pub hits: u64,
    /// CRC-32 over all results, 8 hexadecimal digits: `prim_id`, `t`, `u`, `v` bits, or the
    /// occlusion bit.
    pub checksum: String,
}

impl std::fmt::Display for RaySetRecord {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let (hits, rays, checksum) = (self.hits, self.rays, &self.checksum);
        write!(f, "{hits} hits of {rays} rays (checksum {checksum})")
    }
}

/// The rate of one engine on one set of rays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RateRow {
    /// Name of the scene, [`SceneRecord::name`].
    pub scene: String,
    /// Kind of rays: one of [`RayKind::names`](crate::RayKind::names).
    pub rays: String,
    /// Name of the engine: `phalanx`, `oracle`, `embree` or `obvhs`.
    pub engine: String,
    /// Kernel or mode. `auto` is what `render` would use. There are no rows for `best`: the reader
    /// takes the maximum.
    pub kernel: String,
    /// Threads.
    pub threads: u32,
    /// Millions of rays per second.
    pub mrays_per_s: Estimate,
    /// Rays of one sample; fewer than the set's where only a part is timed.
    pub rays_timed: u64,
    /// Rays of the whole set that hit something, by this engine.
    pub hits: u64,
    /// Share of the set's rays for which a peer's result differs from ours.
    pub difference: Option<f64>,
    /// True if that difference is small enough for the row to count as a peer's best.
    pub exact: bool,
    /// The kernel whose samples these are, where this one does the same on this build.
    pub same_as: Option<String>,
    /// The rate of every sample, in the order of the rounds, as measured by the clock, with all
    /// disturbances.
    pub samples: Vec<f64>,
}

impl RateRow {
    /// Name for filters: scene, kind of rays, engine and kernel, with a blank between them.
    pub fn name(&self) -> String {
        [&*self.scene, &*self.rays, &*self.engine, &*self.kernel].join(" ")
    }

    /// Returns true if the row has a rate that can be used.
    pub fn has_rate(&self) -> bool {
        let median = self.mrays_per_s.median;
        median.is_finite() && median > 0.0
    }
}

/// A rate and its uncertainty, by a bootstrap of the rounds; each piece of the work counts with its
/// fastest visit ([`Estimate::of_fastest`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Median of the resampled rates.
    pub median: f64,
    /// Median absolute deviation from the median.
    pub mad: f64,
    /// Lower end of the interval in which another run's median would be, 9 times in 10.
    pub low: f64,
    /// Upper end of that interval.
    pub high: f64,
}

/// Work of one kernel on one set of rays; the same on every machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CounterRow {
    /// Name of the scene, [`SceneRecord::name`].
    pub scene: String,
    /// Kind of rays.
    pub rays: String,
    /// Kernel.
    pub kernel: String,
    /// Rays traced.
    pub ray_count: u64,
    /// The counts.
    pub work: CountedWork,
}

/// Counts of a kernel's work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CountedWork {
    /// Packets of eight lanes traced.
    pub packets: u64,
    /// Lanes of them that carried a ray.
    pub active_lanes: u64,
    /// Nodes visited, once for all lanes of a traversal.
    pub node_visits: u64,
    /// Lanes × boxes tested.
    pub box_tests: u64,
    /// Leaves visited, once for all lanes of a traversal; empty ones count, too.
    pub leaf_visits: u64,
    /// Lanes × primitives tested, instances among them.
    pub prim_tests: u64,
    /// Bytes of the nodes and primitives that were read, regardless of caches.
    pub bytes: u64,
}
