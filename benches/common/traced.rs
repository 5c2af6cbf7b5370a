//! Scenes with both trees, sets of rays, and whoever traces them.

use super::standard_scene;
use bumpalo::Bump;
use phalanx::bench::{Answer, KernelContender, Kind, OracleContender, RaySet};
use phalanx::bench::{primary, secondary};
use phalanx::bvh::{BuildSettings, Bvh};
use phalanx::oracle::Forest;
use phalanx::peers::{Contender, Rays, Runner};
use phalanx::scene::Scene;
use phalanx::trace::Kernel;

/// A standard scene and both trees.
pub struct Traced {
    pub scene: Scene,
    pub bvh: Bvh,
    pub forest: Forest,
}

impl Traced {
    /// By the scene's whole name.
    pub fn new(name: &str) -> Traced {
        let scene = standard_scene(name);
        let settings = BuildSettings {
            threads: 1,
            ..BuildSettings::default()
        };
        Traced {
            bvh: Bvh::build_with(&scene, &settings),
            forest: Forest::build(&scene),
            scene,
        }
    }

    /// The rays of a kind for a picture of some size.
    pub fn rays<'a>(&self, arena: &'a Bump, kind: Kind, size: [u32; 2]) -> RaySet<'a> {
        let first = primary(arena, &self.scene, size).expect("a valid scene");
        if kind == Kind::Primary {
            return first;
        }
        let seen = answer(&self.oracle(first.rays()), &first);
        secondary(arena, &self.scene, kind, &first, &seen)
    }

    /// The packet engine with one kernel.
    pub fn packets<'a>(&'a self, kernel: Kernel, rays: Rays<'a>) -> KernelContender<'a> {
        KernelContender {
            bvh: &self.bvh,
            kernel,
            rays,
        }
    }

    /// The oracle.
    pub fn oracle<'a>(&'a self, rays: Rays<'a>) -> OracleContender<'a> {
        OracleContender {
            scene: &self.scene,
            forest: &self.forest,
            rays,
        }
    }
}

/// Room for the answer to a set of rays.
pub fn room(set: &RaySet) -> Answer {
    Answer::room(set.kind.question(), set.queue.packets())
}

/// What a contender says to a set of rays.
pub fn answer(contender: &dyn Contender, set: &RaySet) -> Answer {
    let mut answer = room(set);
    trace(&mut *contender.runner(), &mut answer);
    answer
}

/// Traces all packets that `answer` has room for.
pub fn trace(runner: &mut dyn Runner, answer: &mut Answer) {
    match answer {
        Answer::Closest(hits) => runner.closest(0..hits.len(), hits),
        Answer::Occluded(blocked) => runner.occluded(0..blocked.len(), blocked),
    }
}

/// Whether two answers to a set of rays are the same bits.
pub fn same(a: &Answer, b: &Answer, set: &RaySet) -> bool {
    a.first_difference(b, 0..set.queue.len()).is_none()
}
