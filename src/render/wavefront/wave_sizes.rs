//! Sizes of waves: the number of rays that are traced together, and the depth of bounces.
//!
//! | memory of a thread | at most |
//! |---|---|
//! | what a wave needs while it is shaded | that of [`WAVE_RAYS`] rays; all waves share it |
//! | bounces and radiance of all levels | [`BOUNCE_BYTES`] beside the first level's (see below) |
//!
//! Each level has room for at least one packet, even if that exceeds [`BOUNCE_BYTES`].
//!
//! No level's wave is larger than the wave above it. If all levels do not fit at that size, waves
//! below the first are smaller: every level gets the same share of [`BOUNCE_BYTES`].

use super::bounce_queue::BounceLevel;
use super::ray_batch::RadianceX8;
use phalanx_scene::{MAX_PASSES, Scene};
use phalanx_trace::packet::{HitPacket, QueueColumns, QueueStorage};
use phalanx_trace::simd::LANES;

/// Bytes of all levels but the first, unless one packet per level needs more. They are enough to
/// trace the rays of a tile of the default side together to a depth of 40.
const BOUNCE_BYTES: usize = 5 << 20;

/// Maximum number of rays of a wave.
const WAVE_RAYS: usize = 4096;

/// Number of camera rays that are traced together, regardless of the depth: those of a tile of the
/// default side.
pub(crate) const CAMERA_RAYS: usize = 1024;

/// Maximum sizes of waves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WaveSizes {
    /// Maximum number of packets of a wave of camera rays.
    pub(crate) camera: usize,
    /// Maximum number of packets of a wave of bounces.
    pub(super) bounced: usize,
    /// Bounces that a ray may take, as limited by the settings and by its weight, and surfaces that
    /// it may pass.
    depth: usize,
    /// Bytes that a packet of a wave takes in its level.
    level_bytes: usize,
    pub(crate) columns: QueueColumns,
}

/// Bounds on the factors of the shares of camera rays.
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
            let ways = usize::from(m.may_mirror(i)) + usize::from(!black(&kt));
            all.ways = all.ways.max(ways);
            if m.is_mapped(i) && ways > 0 {
                // Textures may say anything up to the whole.
                (all.least, all.most) = (0.0, all.most.max(1.0));
                continue;
            }
            let total = if black(&kt) { kt } else { ks + kt };
            let divisor = (ks.abs() + kt.abs()).max(glam::Vec3::ONE);
            for weight in [ks, kt, total].into_iter().filter(|c| !black(c)) {
                let weight = weight / divisor;
                all.least = all.least.min(f64::from(weight.abs().min_element()));
                all.most = all.most.max(f64::from(weight.abs().max_element()));
            }
        }
        all
    }

    /// Returns true if a share may be less than `min_weight` after `depth` bounces or fewer, or if
    /// this is uncertain.
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

/// Maximum number of bounces that are tried one by one.
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
        let bounces = weights.reach(min_weight, max_depth);
        let covered = scene.has_coverage();
        // Rays that continue through a surface wait like bounces.
        let (passes, passing) = if covered { (MAX_PASSES, 1) } else { (0, 0) };
        let depth = (bounces + passes) as usize;
        let level_bytes = level_bytes(weights.ways, passing);
        let fit = BOUNCE_BYTES / (depth.max(1) * level_bytes);
        let bounced = fit.clamp(1, WAVE_RAYS / LANES);
        WaveSizes {
            camera: bounced.max(CAMERA_RAYS / LANES),
            bounced,
            depth,
            level_bytes,
            columns: QueueColumns {
                seeds: scene.is_stochastic(),
                shares: weights.may_fall_below(min_weight, max_depth)
                    || (covered && min_weight > 0.0),
            },
        }
    }

    /// Maximum number of rays of a wave.
    pub fn rays(&self) -> usize {
        self.camera * LANES
    }

    /// Maximum number of bytes that waiting bounces of up to `rays` camera rays take.
    pub fn bounce_bytes(&self, rays: usize) -> usize {
        let camera = self.camera.min(rays.div_ceil(LANES));
        let below = self.bounced.min(camera).saturating_mul(self.depth);
        let levels = if self.depth > 0 { camera + below } else { 0 };
        levels.saturating_mul(self.level_bytes) + self.depth * size_of::<BounceLevel>()
    }
}

/// Bytes that a packet of a wave takes in its level: for bounces, for rays that continue after a
/// hit, and for radiance.
fn level_bytes(ways: usize, passing: usize) -> usize {
    (ways + passing) * QueueStorage::PACKET_BYTES
        + passing * size_of::<HitPacket>()
        + size_of::<RadianceX8>()
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
        // Weights of materials that send more than they receive count as halves.
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
        // Rays of little weight end early, and leave room for wide waves.
        let fading = scene(Vec3::splat(0.5), Vec3::ZERO);
        assert_eq!(WaveSizes::of(&fading, 1000, 0.01).depth, 7);
        assert_eq!(WaveSizes::of(&fading, 1000, 0.0).depth, 1000);
        assert_eq!(
            WaveSizes::of(&scene(Vec3::ZERO, Vec3::ZERO), 1000, 0.0).depth,
            0
        );
    }
}
