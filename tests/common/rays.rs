//! Rays in packets, and answers of both engines in one form.

use bumpalo::Bump;
use glam::Vec3;
use phalanx::bvh::Bvh;
use phalanx::lanes::{F32x8, LANES, LaneMask, Mask8, Vec3x8};
use phalanx::oracle::{Oracle, OracleHit, OracleRay, OracleSearch, TwoLevelBvh};
use phalanx::packet::{HitPacket, NO_PRIM, RayPacket, RayQueue};
use phalanx::scene::Scene;
use phalanx::trace::{Kernel, PacketTracer, Traversal};

/// The bits of a hit: t, u, v and the primitive.
pub type HitWords = (u32, u32, u32, u32);

pub fn hit_bits(hit: &OracleHit) -> HitWords {
    (
        hit.t.to_bits(),
        hit.u.to_bits(),
        hit.v.to_bits(),
        hit.prim_id,
    )
}

/// Up to eight rays as a packet; lanes without a ray hold zeros.
pub fn pack(rays: &[OracleRay], tmax: impl Fn(usize) -> f32) -> RayPacket {
    let column = |component: &dyn Fn(&OracleRay) -> f32| {
        F32x8::new(std::array::from_fn(|k| rays.get(k).map_or(0.0, component)))
    };
    RayPacket {
        org: Vec3x8::new(
            column(&|r| r.org.x),
            column(&|r| r.org.y),
            column(&|r| r.org.z),
        ),
        dir: Vec3x8::new(
            column(&|r| r.dir.x),
            column(&|r| r.dir.y),
            column(&|r| r.dir.z),
        ),
        tmax: F32x8::new(std::array::from_fn(tmax)),
    }
}

/// One lane of a packet's answer.
pub fn lane_bits(hits: &HitPacket, lane: usize) -> Option<HitWords> {
    let prim_id = hits.prim_id.to_array()[lane];
    let bits = |column: F32x8| column.to_array()[lane].to_bits();
    (prim_id != NO_PRIM).then(|| (bits(hits.t), bits(hits.u), bits(hits.v), prim_id))
}

/// Both engines over one scene.
pub struct Engines<'a> {
    pub oracle: Oracle<'a>,
    pub brute: Oracle<'a>,
    pub tracer: PacketTracer<'a>,
    /// Every kernel other than the tracer's.
    pub others: Vec<(&'static str, Traversal<'a>)>,
}

impl<'a> Engines<'a> {
    pub fn new(scene: &'a Scene, tree: &'a TwoLevelBvh, bvh: &'a Bvh) -> Engines<'a> {
        Engines {
            oracle: Oracle::new(scene, OracleSearch::Tree(tree)),
            brute: Oracle::new(scene, OracleSearch::BruteForce),
            tracer: PacketTracer::new(bvh),
            others: Kernel::ALL
                .map(|(name, kernel)| (name, Traversal::new(bvh, kernel)))
                .into(),
        }
    }

    /// The closest hit, after asserting that brute force, the oracle's tree and the packet engine
    /// agree.
    pub fn closest(&mut self, ray: &OracleRay) -> Option<OracleHit> {
        self.closest_of(std::slice::from_ref(ray))[0]
    }

    /// The closest hits of up to eight rays, after asserting that all three searches agree.
    pub fn closest_of(&mut self, rays: &[OracleRay]) -> Vec<Option<OracleHit>> {
        let truth: Vec<Option<OracleHit>> =
            rays.iter().map(|ray| self.brute.closest(ray)).collect();
        for (ray, want) in rays.iter().zip(&truth) {
            let want = want.as_ref().map(hit_bits);
            let tree = self.oracle.closest(ray);
            assert_eq!(
                tree.as_ref().map(hit_bits),
                want,
                "the oracle's tree, {ray:?}"
            );
        }
        let packet = pack(rays, |_| f32::INFINITY);
        let active = Mask8::first(rays.len());
        let hits = self.tracer.closest(&packet, active);
        for lane in 0..LANES {
            let want = truth.get(lane).copied().flatten();
            assert_eq!(
                lane_bits(&hits, lane),
                want.as_ref().map(hit_bits),
                "lane {lane} of the packet engine, {:?}",
                rays.get(lane)
            );
        }
        let arena = Bump::new();
        let queue = queue(&arena, rays);
        for (name, traversal) in &mut self.others {
            let mut answer = [HitPacket::miss()];
            traversal.closest(&queue, 0..1, &mut answer);
            for (lane, want) in truth.iter().enumerate() {
                let want = want.as_ref().map(hit_bits);
                assert_eq!(
                    lane_bits(&answer[0], lane),
                    want,
                    "{name}, {:?}",
                    rays[lane]
                );
            }
        }
        truth
    }

    /// Mask of the rays, up to eight, that are occluded before `tmax`, after asserting that all
    /// three searches agree.
    pub fn occluded_of(&mut self, rays: &[OracleRay], tmax: f32) -> u32 {
        let mut truth = 0;
        for (lane, ray) in rays.iter().enumerate() {
            let brute = self.brute.occluded(ray, tmax);
            let tree = self.oracle.occluded(ray, tmax);
            assert_eq!(tree, brute, "the oracle's tree, {ray:?} before {tmax}");
            truth |= u32::from(brute) << lane;
        }
        let blocked = self
            .tracer
            .occluded(&pack(rays, |_| tmax), Mask8::first(rays.len()));
        assert_eq!(blocked.bits(), truth, "{rays:?} before {tmax}");
        let arena = Bump::new();
        let queue = queue(&arena, rays);
        for (name, traversal) in &mut self.others {
            let mut blocked = [0];
            traversal.occluded(&queue, 0..1, tmax, &mut blocked);
            assert_eq!(
                u32::from(blocked[0]),
                truth,
                "{name}, {rays:?} before {tmax}"
            );
        }
        truth
    }
}

/// Up to eight queued rays.
fn queue<'a>(arena: &'a Bump, rays: &[OracleRay]) -> RayQueue<'a> {
    let mut queue = RayQueue::with_capacity(arena, LANES);
    for ray in rays {
        queue.push_ray(ray.org.to_array(), ray.dir.to_array());
    }
    queue
}

/// A ray from `org` toward `target`, direction not normalised.
pub fn toward(org: Vec3, target: Vec3) -> OracleRay {
    OracleRay::new(org, target - org)
}
