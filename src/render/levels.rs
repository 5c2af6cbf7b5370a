//! Bounces of bounces: the order in which waves are traced, and how large waves may be.
//!
//! The bounces of a wave wait in the queue of its level. They are traced slice by slice as waves of
//! the next level. Each slice is accumulated into the wave before the next is traced, mirror rays
//! before refracted ones. That gives the sum the order of the recursion: (local + Ks I_R) + Kt I_T.
//! The levels are a stack of their own, so that no depth overflows the thread's.
//!
//! | memory of a thread | at most |
//! |---|---|
//! | what a wave needs while it is shaded | that of [`WAVE_RAYS`] rays; all waves share it |
//! | bounces and radiance of all levels | [`BOUNCE_BYTES`] beside the first level's (see below) |
//!
//! Each level has room for at least one packet, even where that exceeds [`BOUNCE_BYTES`].
//!
//! No level's wave is larger than the wave above it. Where all levels would not fit at that size,
//! waves below the first are smaller: every level gets the same share of [`BOUNCE_BYTES`].

use super::aov_buffer::AovBuffer;
use super::shadow_cache::ShadowCache;
use super::wavefront::{QueueSlice, RadianceX8, WavefrontContext, accumulate, trace_wavefront};
use crate::shade::ShadeMaterial;
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_trace::packet::{QueueColumns, QueueStorage, RayQueue};
use phalanx_trace::simd::LANES;
use std::ops::Range;

/// Bytes of all levels but the first, unless one packet a level needs more. They are enough to
/// trace the rays of a tile of the default side together down to a depth of 40.
const BOUNCE_BYTES: usize = 5 << 20;

/// Most rays of a wave.
const WAVE_RAYS: usize = 4096;

/// Camera rays that are traced together whatever the depth: those of a tile of the default side.
pub(super) const CAMERA_RAYS: usize = 1024;

/// Maximum sizes of waves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WaveSizes {
    /// Most packets of a wave of camera rays.
    camera: usize,
    /// Most packets of a wave of bounces.
    bounced: usize,
    /// Bounces that a ray may take, as limited by the settings and by its weight.
    depth: usize,
    /// Bounces that a hit may send.
    ways: usize,
    columns: QueueColumns,
}

/// Bounds on the factors that the shares of camera rays are multiplied with.
struct BounceWeights {
    /// The smallest component.
    least: f64,
    /// The largest component.
    most: f64,
    /// Bounces that a hit may send.
    ways: usize,
}

impl BounceWeights {
    fn of(scene: &Scene) -> BounceWeights {
        let m = &scene.materials;
        let mut all = BounceWeights {
            least: f64::INFINITY,
            most: 0.0,
            ways: 0,
        };
        for i in 0..m.len() {
            let (ks, kt) = (m.ks.get(i), m.kt.get(i));
            let black = |c: &glam::Vec3| *c == glam::Vec3::ZERO;
            let ways = [ks, kt].iter().filter(|c| !black(c)).count();
            all.ways = all.ways.max(ways);
            let total = if black(&kt) { kt } else { ks + kt };
            let whole = ShadeMaterial::of(scene, i as u32).secondary_weight();
            for weight in [ks, kt, total].into_iter().filter(|c| !black(c)) {
                let weight = weight / whole;
                all.least = all.least.min(f64::from(weight.abs().min_element()));
                all.most = all.most.max(f64::from(weight.abs().max_element()));
            }
        }
        all
    }

    /// Tests if a share may be less than `min_weight` after `depth` bounces or fewer. If in doubt,
    /// returns true.
    fn may_fall_below(&self, min_weight: f32, depth: u32) -> bool {
        // The margin exceeds the rounding of up to [`MAX_TRIED_BOUNCES`] products.
        let least = self.least.min(1.0) * (1.0 - 1e-6);
        let sure = min_weight >= f32::MIN_POSITIVE && depth <= MAX_TRIED_BOUNCES;
        min_weight > 0.0 && !(sure && bounces_until_below(least, min_weight, depth).is_none())
    }

    /// Approximate number of bounces after which every share is less than `min_weight`; no more
    /// than `depth`.
    fn reach(&self, min_weight: f32, depth: u32) -> u32 {
        match self.ways {
            0 => 0,
            _ => bounces_until_below(self.most, min_weight, depth).unwrap_or(depth),
        }
    }
}

/// Bounces that are tried one by one.
const MAX_TRIED_BOUNCES: u32 = 10_000;

/// Number of multiplications by `factor` that take 1 below `least`; `None` if that is more than
/// `most` or [`MAX_TRIED_BOUNCES`].
fn bounces_until_below(factor: f64, least: f32, most: u32) -> Option<u32> {
    let mut product = 1.0;
    (1..=most.min(MAX_TRIED_BOUNCES)).find(|_| {
        product *= factor;
        product < f64::from(least)
    })
}

impl WaveSizes {
    /// Sizes for renders of a scene with these settings.
    pub fn of(scene: &Scene, max_depth: u32, min_weight: f32) -> WaveSizes {
        let weights = BounceWeights::of(scene);
        let depth = weights.reach(min_weight, max_depth) as usize;
        let ways = weights.ways;
        let fit = BOUNCE_BYTES / (depth.max(1) * level_bytes(ways));
        let bounced = fit.clamp(1, WAVE_RAYS / LANES);
        WaveSizes {
            camera: bounced.max(CAMERA_RAYS / LANES),
            bounced,
            depth,
            ways,
            columns: QueueColumns {
                seeds: scene.is_stochastic(),
                shares: weights.may_fall_below(min_weight, max_depth),
            },
        }
    }

    /// Most rays of a wave.
    pub fn rays(&self) -> usize {
        self.camera * LANES
    }

    /// Most bytes that waiting bounces of up to `rays` camera rays take.
    pub fn bounce_bytes(&self, rays: usize) -> usize {
        let camera = self.camera.min(rays.div_ceil(LANES));
        let below = self.bounced.min(camera).saturating_mul(self.depth);
        let levels = if self.depth > 0 { camera + below } else { 0 };
        levels.saturating_mul(level_bytes(self.ways)) + self.depth * size_of::<BounceLevel>()
    }
}

/// Bytes that a packet of a wave takes in its level, for bounces and for radiance.
fn level_bytes(ways: usize) -> usize {
    ways * QueueStorage::PACKET_BYTES + size_of::<RadianceX8>()
}

/// The levels of a renderer, each with the bounces of one wave.
pub(super) struct Levels {
    sizes: WaveSizes,
    max_depth: usize,
    levels: Vec<BounceLevel>,
}

#[derive(Default)]
struct BounceLevel {
    /// Radiance of the wave's rays. The radiance of camera rays is stored elsewhere.
    radiance: Vec<RadianceX8>,
    bounces: BounceQueue,
}

/// The bounces of a wave, mirror rays first.
#[derive(Default)]
pub(super) struct BounceQueue {
    storage: QueueStorage,
    /// Number of mirror rays.
    mirrored: usize,
    /// Packets of the wave that sent the bounces.
    wave_packets: usize,
    /// Packets that are being traced; all packets before them are done.
    slice: Range<usize>,
}

impl BounceQueue {
    /// Removes all bounces.
    pub(super) fn clear(&mut self) {
        self.storage.clear();
        self.slice = 0..0;
    }

    /// Fills the queue with the bounces of a wave of `wave` packets, with room for `ways` bounces
    /// of each ray. `push` queues them, and returns how many are mirror rays.
    pub(super) fn fill(
        &mut self,
        wave: usize,
        ways: usize,
        columns: QueueColumns,
        push: impl FnOnce(&mut RayQueue) -> usize,
    ) {
        self.mirrored = self.storage.fill(wave * ways, columns, push);
        self.wave_packets = wave;
        self.slice = 0..0;
    }

    /// Takes the next slice of the queue, if there is one.
    fn next(&mut self, most: usize) -> Option<Range<usize>> {
        let (first, all) = (self.slice.end, self.storage.queue().packets());
        let end = all.min(first + self.wave_packets.min(most));
        self.slice = first..end;
        (first < all).then_some(first..end)
    }
}

impl Levels {
    pub(super) fn new(scene: &Scene, max_depth: u32, min_weight: f32) -> Levels {
        Levels {
            sizes: WaveSizes::of(scene, max_depth, min_weight),
            max_depth: max_depth as usize,
            levels: Vec::new(),
        }
    }

    /// Bounces after the primary ray.
    pub(super) fn max_depth(&self) -> u32 {
        self.max_depth as u32
    }

    /// The columns of the queues of bounces.
    pub(super) fn columns(&self) -> QueueColumns {
        self.sizes.columns
    }

    /// Most packets of a wave of camera rays.
    pub(super) fn camera_packets(&self) -> usize {
        self.sizes.camera
    }

    /// The level above a wave of the given depth, and its own.
    fn parent_and_level(&mut self, depth: usize) -> (Option<&mut BounceLevel>, &mut BounceLevel) {
        if self.levels.len() <= depth {
            self.levels.resize_with(depth + 1, BounceLevel::default);
        }
        let (above, from) = self.levels.split_at_mut(depth);
        (above.last_mut(), &mut from[0])
    }
}

/// Traces a wave of camera rays and all their bounces, and adds up the radiance of the camera rays
/// in `radiance`. `aovs` receives their other outputs. `cache` supplies the visibility of lights
/// where it is known, and records it.
pub(super) fn trace_waves(
    engine: &mut WavefrontContext,
    (scratch, levels): (&mut Bump, &mut Levels),
    rays: QueueSlice,
    radiance: &mut [RadianceX8],
    mut aovs: Option<&mut AovBuffer>,
    mut cache: Option<&mut ShadowCache>,
) {
    let (bounced, max_depth) = (levels.sizes.bounced, levels.max_depth);
    let (_, first) = levels.parent_and_level(0);
    let bounces = (max_depth > 0).then_some(&mut first.bounces);
    scratch.reset();
    let (of_lights, of_rays) = (cache.as_deref_mut(), aovs.as_deref_mut());
    trace_wavefront(engine, scratch, rays, radiance, of_rays, of_lights, bounces);
    let mut depth = 0;
    loop {
        let (_, level) = levels.parent_and_level(depth);
        if let Some(packets) = level.bounces.next(bounced) {
            depth += 1;
            let (above, level) = levels.parent_and_level(depth);
            let Some(BounceQueue {
                storage: room,
                mirrored,
                ..
            }) = above.map(|above| &mut above.bounces)
            else {
                return;
            };
            let queue = room.queue();
            level.radiance.clear();
            level.radiance.resize(packets.len(), RadianceX8::BLACK);
            scratch.reset();
            let arena = &*scratch;
            // The cache serves only the direct bounces of camera rays.
            let cache = cache.as_deref_mut().filter(|_| depth == 1);
            let mut onward = cache.map(|s| s.child(arena, &queue, packets.clone(), *mirrored));
            let rays = QueueSlice {
                queue: &queue,
                packets,
            };
            let bounces = (depth < max_depth).then_some(&mut level.bounces);
            let radiance = &mut level.radiance;
            trace_wavefront(
                engine,
                arena,
                rays,
                radiance,
                None,
                onward.as_mut(),
                bounces,
            );
            continue;
        }
        let (Some(above), level) = levels.parent_and_level(depth) else {
            return;
        };
        depth -= 1;
        let BounceQueue {
            storage: room,
            mirrored,
            slice: piece,
            ..
        } = &mut above.bounces;
        let (queue, answers) = (room.queue(), &level.radiance);
        if depth > 0 {
            accumulate(&queue, piece.clone(), answers, &mut above.radiance);
            continue;
        }
        if let Some(aovs) = &mut aovs {
            aovs.accumulate(&queue, piece.clone(), *mirrored, answers);
        }
        accumulate(&queue, piece.clone(), answers, radiance);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn scene(ks: Vec3, kt: Vec3) -> Scene {
        let mut scene = Scene::default();
        let surface = phalanx_scene::Material {
            ks,
            kt,
            ..Default::default()
        };
        scene.materials.push(&surface);
        scene
    }

    #[test]
    fn shares_are_carried_only_where_one_may_fall_below_the_least() {
        let carried = |ks: Vec3, depth, least| {
            let sizes = WaveSizes::of(&scene(ks, Vec3::ZERO), depth, least);
            sizes.columns.shares
        };
        let halves = Vec3::splat(0.5);
        assert!(!carried(halves, 3, 0.124) && carried(halves, 3, 0.126));
        assert!(!carried(Vec3::ONE, 1000, 0.9) && carried(Vec3::ONE, 1 << 20, 0.9));
        assert!(carried(Vec3::X, 2, 1e-30) && !carried(Vec3::X, 2, 0.0));
        assert!(!carried(Vec3::splat(2.0), 100, 0.5));
        // Weights of materials that send more than they get count as halves.
        let sizes = |depth, least| WaveSizes::of(&scene(Vec3::ONE, Vec3::ONE), depth, least);
        assert!(sizes(3, 0.126).columns.shares && !sizes(3, 0.124).columns.shares);
    }

    #[test]
    fn all_levels_fit_whatever_the_depth() {
        let two = [Vec3::splat(0.9), Vec3::splat(0.2)];
        for [ks, kt] in [[Vec3::ONE, Vec3::ZERO], two] {
            for depth in [1, 5, 40, 100, 1000] {
                let sizes = WaveSizes::of(&scene(ks, kt), depth, 0.0);
                assert!(sizes.bounce_bytes(1 << 20) < 2 * BOUNCE_BYTES, "{depth}");
                assert_eq!(sizes.camera * LANES, sizes.rays());
                assert!(sizes.rays() >= CAMERA_RAYS && sizes.rays() <= WAVE_RAYS);
                // Tiles of the default side are not split at usual depths.
                assert!(
                    depth > 40 || sizes.bounced * LANES >= CAMERA_RAYS,
                    "{depth}"
                );
            }
        }
        // Rays of little weight go no deeper, and leave room for wide waves.
        let fading = scene(Vec3::splat(0.5), Vec3::ZERO);
        assert_eq!(WaveSizes::of(&fading, 1000, 0.01).depth, 7);
        assert_eq!(WaveSizes::of(&fading, 1000, 0.0).depth, 1000);
        assert_eq!(
            WaveSizes::of(&scene(Vec3::ZERO, Vec3::ZERO), 1000, 0.0).depth,
            0
        );
    }
}
