//! Compatibility of two records: the reasons why they may not be compared.

use crate::report::{BenchRecord, RateRow};
use std::collections::BTreeMap;
use std::fmt::{self, Display};

/// One reason why the rates of two records do not measure the same thing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Mismatch {
    /// Another CPU.
    #[error("another CPU: {old} in the baseline, {new} here")]
    Cpu {
        /// The baseline's CPU.
        old: String,
        /// This run's CPU.
        new: String,
    },
    /// Another number of hardware threads.
    #[error("another number of hardware threads: {old} in the baseline, {new} here")]
    Threads {
        /// The baseline's number.
        old: u32,
        /// This run's number.
        new: u32,
    },
    /// Other caches.
    #[error("other caches: {old} in the baseline, {new} here")]
    Caches {
        /// The baseline's caches, as text.
        old: String,
        /// This run's caches, as text.
        new: String,
    },
    /// Another hypervisor, or one where there was none.
    #[error("another hypervisor: {old} in the baseline, {new} here")]
    Hypervisor {
        /// The baseline's hypervisor.
        old: String,
        /// This run's hypervisor.
        new: String,
    },
    /// Compiled for another instruction set.
    #[error("compiled for another instruction set: {old} in the baseline, {new} here")]
    InstructionSet {
        /// The baseline's instruction set.
        old: String,
        /// This run's instruction set.
        new: String,
    },
    /// Trees of another build quality.
    #[error("trees of another quality: {old} in the baseline, {new} here")]
    Quality {
        /// The baseline's quality.
        old: String,
        /// This run's quality.
        new: String,
    },
    /// A scene of one name that is not the same scene.
    #[error("{scene}: another scene of this name (hash {old} in the baseline, {new} here)")]
    Scene {
        /// Name of the scene.
        scene: String,
        /// The baseline's hash.
        old: String,
        /// This run's hash.
        new: String,
    },
    /// Rays of another picture size.
    #[error(
        "{scene}: rays of another size: {} in the baseline, {} here",
        size(old),
        size(new)
    )]
    Size {
        /// Name of the scene.
        scene: String,
        /// The baseline's width and height.
        old: [u32; 2],
        /// This run's width and height.
        new: [u32; 2],
    },
    /// Another number of rays.
    #[error("{scene}, {rays}: another number of rays: {old} in the baseline, {new} here")]
    RayCount {
        /// Name of the scene.
        scene: String,
        /// Kind of rays.
        rays: String,
        /// The baseline's number.
        old: u64,
        /// This run's number.
        new: u64,
    },
    /// Other results of the rays.
    #[error("{scene}, {rays}: other answers (checksum {old} in the baseline, {new} here)")]
    Answers {
        /// Name of the scene.
        scene: String,
        /// Kind of rays.
        rays: String,
        /// The baseline's checksum.
        old: String,
        /// This run's checksum.
        new: String,
    },
    /// No rate of ours occurs in both.
    #[error("no rate stands in both")]
    NothingInCommon,
}

fn size([width, height]: &[u32; 2]) -> String {
    format!("{width}×{height}")
}

impl Mismatch {
    /// Returns true if the records may be compared nevertheless. Rates of other rays measure
    /// something else, and may never be compared.
    pub fn can_be_forced(&self) -> bool {
        use Mismatch::*;
        match self {
            Cpu { .. } | Threads { .. } | Caches { .. } => true,
            Hypervisor { .. } | InstructionSet { .. } | Quality { .. } => true,
            Scene { .. } | Size { .. } | RayCount { .. } | Answers { .. } => false,
            NothingInCommon => false,
        }
    }
}

/// The reasons why two records are not compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IncompatibleRecords {
    /// Every reason, those that cannot be forced included; at least one.
    pub reasons: Vec<Mismatch>,
}

impl IncompatibleRecords {
    /// Returns true if every reason can be overridden.
    pub fn can_be_forced(&self) -> bool {
        self.reasons.iter().all(Mismatch::can_be_forced)
    }
}

/// Most reasons that are listed: one changed generator makes many.
const MAX_REASONS: usize = 5;

impl Display for IncompatibleRecords {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the baseline cannot be compared with this run:")?;
        for reason in self.reasons.iter().take(MAX_REASONS) {
            write!(f, "\n  {reason}")?;
        }
        match self.reasons.len().saturating_sub(MAX_REASONS) {
            0 => Ok(()),
            more => write!(f, "\n  and {more} more of the like"),
        }
    }
}

impl std::error::Error for IncompatibleRecords {}

/// Differences in machine, build and trees. A fact that one record does not know differs from
/// nothing.
pub fn of_machine(old: &BenchRecord, new: &BenchRecord) -> Vec<Mismatch> {
    let (a, b) = (&old.machine, &new.machine);
    let mut found = Vec::new();
    if a.cpu != b.cpu {
        let (old, new) = (a.cpu.clone(), b.cpu.clone());
        found.push(Mismatch::Cpu { old, new });
    }
    if a.threads != b.threads {
        let (old, new) = (a.threads, b.threads);
        found.push(Mismatch::Threads { old, new });
    }
    if a.caches != b.caches && !a.caches.is_empty() && !b.caches.is_empty() {
        let (old, new) = (caches(old), caches(new));
        found.push(Mismatch::Caches { old, new });
    }
    if let (Some(a), Some(b)) = (&a.hypervisor, &b.hypervisor)
        && a != b
    {
        let name = |name: &String| match name.as_str() {
            "" => "none".to_owned(),
            name => name.to_owned(),
        };
        let (old, new) = (name(a), name(b));
        found.push(Mismatch::Hypervisor { old, new });
    }
    if old.program.isa_compiled != new.program.isa_compiled {
        let (old, new) = (&old.program.isa_compiled, &new.program.isa_compiled);
        let (old, new) = (old.clone(), new.clone());
        found.push(Mismatch::InstructionSet { old, new });
    }
    if old.run.quality != new.run.quality {
        let [old, new] = [old, new].map(|record| record.run.quality.clone());
        found.push(Mismatch::Quality { old, new });
    }
    found
}

fn caches(record: &BenchRecord) -> String {
    let one = |c: &crate::report::Cache| {
        let (level, kind, kib, by) = (c.level, &c.kind, c.bytes >> 10, c.shared_by);
        format!("L{level} {kind} {kib} KiB for {by}")
    };
    let all: Vec<String> = record.machine.caches.iter().map(one).collect();
    all.join(", ")
}

/// Differences in the scenes and rays that both records have.
pub fn of_rays(old: &BenchRecord, new: &BenchRecord) -> Vec<Mismatch> {
    let before: BTreeMap<&str, _> = old.scenes.iter().map(|s| (s.name.as_str(), s)).collect();
    let mut found = Vec::new();
    for b in &new.scenes {
        let Some(a) = before.get(b.name.as_str()) else {
            continue;
        };
        let scene = || b.name.clone();
        if a.hash != b.hash {
            let (old, new) = (a.hash.clone(), b.hash.clone());
            found.push(Mismatch::Scene {
                scene: scene(),
                old,
                new,
            });
            continue;
        }
        if a.size != b.size {
            let (old, new) = (a.size, b.size);
            found.push(Mismatch::Size {
                scene: scene(),
                old,
                new,
            });
            continue;
        }
        for (rays, b) in &b.rays {
            let Some(a) = a.rays.get(rays) else {
                continue;
            };
            let (scene, rays) = (scene(), rays.clone());
            if a.rays != b.rays {
                let (old, new) = (a.rays, b.rays);
                found.push(Mismatch::RayCount {
                    scene,
                    rays,
                    old,
                    new,
                });
            } else if a.checksum != b.checksum || a.hits != b.hits {
                let (old, new) = (a.checksum.clone(), b.checksum.clone());
                found.push(Mismatch::Answers {
                    scene,
                    rays,
                    old,
                    new,
                });
            }
        }
    }
    found
}

/// Returns the mismatch if a row of ours timed another part of its set of rays than the baseline's
/// did.
pub fn of_part(old: &RateRow, new: &RateRow) -> Option<Mismatch> {
    (old.rays_timed != new.rays_timed).then(|| Mismatch::RayCount {
        scene: new.scene.clone(),
        rays: new.rays.clone(),
        old: old.rays_timed,
        new: new.rays_timed,
    })
}
