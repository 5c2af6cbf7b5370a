//! The light along a ray, with its bounces: Whitted's recursion, as in the design document
//! ("Recursive shading model"). It uses a stack of its own, because the thread's stack would not
//! hold bounces of any depth.

use super::intersect::{OracleHit, OracleRay};
use super::pixel::RadianceParts;
use super::search::SceneSearch;
use super::shading::{self, OracleBounce, OracleMaterial, OracleSurface, SampleSeed};
use super::shadow_cache_cursor::ShadowCacheCursor;
use glam::Vec3;
use phalanx_scene::sampling::BounceKind;
use phalanx_scene::{IntegratorSettings, MAX_PASSES, RayCounts};
use std::array;
use std::iter::Flatten;

/// Follows camera rays and their bounces.
pub(super) struct WhittedIntegrator<'a> {
    pub(super) search: SceneSearch<'a>,
    pub(super) settings: IntegratorSettings,
    /// The bounces between a camera ray and the ray being traced.
    path: Vec<PathLevel>,
    /// Rays cast so far.
    pub(super) ray_counts: RayCounts,
}

/// A ray to be traced, and the weight of its light.
pub(super) struct PathSegment {
    ray: OracleRay,
    way: BounceKind,
    seed: SampleSeed,
    /// Weight from the hit that sends the ray.
    throughput: Vec3,
    /// Share of its camera ray that the ray carries: the product of all weights since the camera,
    /// each divided by max(|Ks| + |Kt|, 1) at its hit.
    share: Vec3,
    /// Bounces before this ray.
    depth: u32,
    /// Partly covered surfaces that the ray has passed since the camera.
    passed: u32,
    /// Hit after which the ray continues, if it does not begin at its origin.
    after: Option<OracleHit>,
}

impl PathSegment {
    /// A camera ray.
    pub(super) fn from_camera(ray: OracleRay, seed: SampleSeed) -> PathSegment {
        PathSegment {
            ray,
            way: BounceKind::Mirror,
            seed,
            throughput: Vec3::ONE,
            share: Vec3::ONE,
            depth: 0,
            passed: 0,
            after: None,
        }
    }
}

/// The rays that a hit sends on, in the order in which their light is added.
type SegmentQueue = Flatten<array::IntoIter<Option<PathSegment>, 3>>;

/// A hit whose bounces are being traced.
struct PathLevel {
    /// Light of the hit, as far as known.
    parts: RadianceParts,
    /// Kind of the bounce that is being traced, and its weight.
    traced: (BounceKind, Vec3),
    /// The bounces that are traced after it.
    pending: SegmentQueue,
}

impl RadianceParts {
    fn add_weighted(&mut self, (way, weight): (BounceKind, Vec3), light: Vec3) {
        let part = Some(weight * light);
        match way {
            BounceKind::Mirror => self.reflection = part,
            BounceKind::Refracted => self.refraction = part,
            BounceKind::Passed => self.passed = part,
        }
    }
}

impl<'a> WhittedIntegrator<'a> {
    pub(super) fn new(search: SceneSearch<'a>) -> WhittedIntegrator<'a> {
        WhittedIntegrator {
            search,
            settings: IntegratorSettings::default(),
            path: Vec::new(),
            ray_counts: RayCounts::default(),
        }
    }

    /// Radiance of a camera ray that hits nothing.
    pub(super) fn camera_background(&self, dir: Vec3) -> Vec3 {
        match &self.search.scene.environment {
            _ if self.settings.hides_background => Vec3::ZERO,
            Some(sky) if sky.is_background && self.settings.shows_environment() => {
                sky.radiance(dir)
            }
            _ => self.search.scene.background,
        }
    }

    /// I = Ka + Ke + Σ V_i L_i (Kd max(l·n, 0) + Ks max(h·n, 0)^s) + Ks I_R + Kt I_T, for a camera
    /// ray.
    pub(super) fn light(
        &mut self,
        camera: &PathSegment,
        hit: Option<OracleHit>,
        mut cursor: ShadowCacheCursor,
    ) -> RadianceParts {
        // The cache stores lights as visible or hidden, which light through a surface is neither
        // of.
        if self.search.has_clear_shadows {
            cursor = ShadowCacheCursor::NONE;
        }
        let (mut parts, ways) = self.shade(camera, hit, &mut cursor);
        for segment in ways {
            let traced = (segment.way, segment.throughput);
            let cursor = cursor.child(segment.way);
            parts.add_weighted(traced, self.follow(segment, cursor));
        }
        parts
    }

    /// The light of a bounce of a camera ray. The sums are those of the recursion: each hit's
    /// mirror ray is followed to its end before the refracted ray.
    fn follow(&mut self, first: PathSegment, mut cursor: ShadowCacheCursor) -> Vec3 {
        let mut path = std::mem::take(&mut self.path);
        let mut next = Some(first);
        let light = loop {
            let Some(segment) = next.take() else {
                // The hit on top is complete: return to the hit that sent the ray there.
                let Some(PathLevel { parts, .. }) = path.pop() else {
                    break Vec3::ZERO;
                };
                let Some(above) = path.last_mut() else {
                    break parts.sum();
                };
                above.parts.add_weighted(above.traced, parts.sum());
                next = above.take_pending();
                continue;
            };
            let hit = self.trace_segment(&segment);
            let (parts, pending) = self.shade(&segment, hit, &mut cursor);
            // No visibility is recorded for later hits.
            cursor = ShadowCacheCursor::NONE;
            let mut level = PathLevel {
                parts,
                traced: (BounceKind::Mirror, Vec3::ZERO),
                pending,
            };
            next = level.take_pending();
            path.push(level);
        };
        self.path = path;
        light
    }

    fn trace_segment(&mut self, segment: &PathSegment) -> Option<OracleHit> {
        match segment.way {
            BounceKind::Mirror => self.ray_counts.reflection += 1,
            BounceKind::Refracted => self.ray_counts.refraction += 1,
            // The same ray continues.
            BounceKind::Passed => {}
        }
        self.search.closest_there(&segment.ray, segment.after)
    }

    /// The light of a hit without its bounces, and the bounces that are worth tracing.
    fn shade(
        &mut self,
        segment: &PathSegment,
        hit: Option<OracleHit>,
        cursor: &mut ShadowCacheCursor,
    ) -> (RadianceParts, SegmentQueue) {
        let scene = self.search.scene;
        let mut parts = RadianceParts::default();
        let Some(hit) = hit else {
            let dir = segment.ray.dir;
            parts.direct = match (segment.depth, &scene.environment) {
                (0, _) => self.camera_background(dir),
                (_, Some(environment)) => environment.radiance(dir),
                (_, None) => scene.background,
            };
            return (parts, [None, None, None].into_iter().flatten());
        };
        let surface = OracleSurface::new(scene, &segment.ray, &hit);
        let prim = scene.resolve(hit.prim_id).prim;
        let coverage = if self.search.has_coverage { scene.coverage(hit) } else { 1.0 };
        let material = OracleMaterial::of(scene, prim, &hit);
        parts.direct = material.own * coverage;
        cursor.begin_hit(hit.prim_id);
        let above = shading::OracleTerminatorShift::of(scene, &hit, &surface);
        for light in 0..scene.lights.len() {
            let lit = shading::Lit {
                seed: segment.seed,
                material: &material,
                coverage,
                above,
            };
            let Some(sample) = shading::sample_light(scene, light, &lit, &surface) else {
                continue;
            };
            if !scene.lights.casts_shadows(light) {
                parts.direct += sample.radiance;
                continue;
            }
            let mut passed = Vec3::ONE;
            let visible = cursor.is_visible(light, sample.radiance, || {
                self.ray_counts.shadow += 1;
                passed = sample.visibility(&self.search, &hit);
                passed != Vec3::ZERO
            });
            if visible {
                parts.direct += sample.radiance * passed;
            }
        }
        let [mirror, refracted] = self.bounces(segment, &material, coverage, &surface);
        let passed = self.passing_segment(segment, &hit, coverage);
        (parts, [mirror, refracted, passed].into_iter().flatten())
    }

    /// The mirror ray and the refracted ray of a hit, if allowed and worth tracing.
    fn bounces(
        &self,
        from: &PathSegment,
        material: &OracleMaterial,
        coverage: f32,
        surface: &OracleSurface,
    ) -> [Option<PathSegment>; 2] {
        if from.depth >= self.settings.max_depth {
            return [None, None];
        }
        let [mirror, refracted] = shading::bounces(material, from.seed, surface);
        let divisor = material.secondary_weight();
        let segment = |bounce: Option<OracleBounce>, way| {
            let OracleBounce { ray, weight } = bounce?;
            let weight = weight * coverage;
            let share = from.share * (weight / divisor);
            self.counts(share).then(|| PathSegment {
                ray,
                way,
                seed: from.seed.child(way),
                throughput: weight,
                share,
                depth: from.depth + 1,
                passed: from.passed,
                after: None,
            })
        };
        [
            segment(mirror, BounceKind::Mirror),
            segment(refracted, BounceKind::Refracted),
        ]
    }

    /// The ray's continuation through the surface that it hit; `None` if the surface is opaque, or
    /// the rest is not worth tracing.
    fn passing_segment(
        &self,
        from: &PathSegment,
        hit: &OracleHit,
        coverage: f32,
    ) -> Option<PathSegment> {
        let open = 1.0 - coverage;
        if open <= 0.0 || from.passed >= MAX_PASSES {
            return None;
        }
        let share = from.share * open;
        self.counts(share).then(|| PathSegment {
            ray: from.ray,
            way: BounceKind::Passed,
            seed: from.seed.child(BounceKind::Passed),
            throughput: Vec3::splat(open),
            share,
            depth: from.depth,
            passed: from.passed + 1,
            after: Some(*hit),
        })
    }

    /// Returns true if a ray of this share is worth tracing.
    fn counts(&self, share: Vec3) -> bool {
        let least = self.settings.min_weight;
        least == 0.0 || share.abs().cmpge(Vec3::splat(least)).any()
    }
}

impl PathLevel {
    /// Takes the next pending bounce, if there is one, to trace it now.
    fn take_pending(&mut self) -> Option<PathSegment> {
        let later = self.pending.next()?;
        self.traced = (later.way, later.throughput);
        Some(later)
    }
}
