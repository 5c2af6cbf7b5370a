//! Settings of a build.

use super::{best, clustering};

/// Trade of build time for tracing speed. No hit depends on it.
///
/// On two threads of one machine a million triangles took 0.06 s at [`Quality::Medium`] and 0.4 s
/// at [`Quality::Best`]: see `perf/notes/many-cores.md`.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::Quality;
///
/// assert_eq!(Quality::default(), Quality::Medium);
/// assert_eq!(Quality::Best.name(), "best");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Clusters are compared with four neighbours on each side.
    Fast,
    /// Eight neighbours on each side: best total time for a picture.
    #[default]
    Medium,
    /// obvhs's clusters, and reinsertion throughout: seven times the build time, for a cache that
    /// is rendered often, and the quality that `bench` measures.
    Best,
}

impl Quality {
    /// Every quality by name; `fastest` is another name of `fast`.
    pub const ALL: [(&'static str, Quality); 4] = [
        ("fast", Quality::Fast),
        ("fastest", Quality::Fast),
        ("medium", Quality::Medium),
        ("best", Quality::Best),
    ];

    /// The quality's name on the command line.
    pub fn name(self) -> &'static str {
        let known = Quality::ALL.iter().find(|(_, quality)| *quality == self);
        known.map_or("", |(name, _)| name)
    }

    /// Most objects of a chunk.
    pub(super) fn chunk_prims(self) -> usize {
        match self {
            Quality::Fast | Quality::Medium => clustering::CHUNK_PRIMS,
            Quality::Best => best::CHUNK_PRIMS,
        }
    }
}

/// Settings of a build: see [`Bvh::build_with`](super::Bvh::build_with).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildSettings {
    /// Trade of build time for tracing speed.
    pub quality: Quality,
    /// Threads to build with, no more than there is work for; 0 for one per CPU. They change only
    /// the time.
    pub threads: usize,
}
