//! The light along a ray, with its bounces: the recursion of the design document ("Recursive
//! shading model"). It uses a stack of its own, because the thread's stack would not hold bounces
//! of any depth.

use super::Oracle;
use super::intersect::{OracleHit, OracleRay};
use super::pixel::RadianceParts;
use super::shading::{self, OracleBounce, OracleMaterial, OracleSurface, SampleSeed};
use super::shadow_cache_cursor::ShadowCacheCursor;
use glam::Vec3;
use phalanx_scene::sampling::BounceKind;

/// A ray to be traced, and the weight of its light.
pub(super) struct PathSegment {
    ray: OracleRay,
    way: BounceKind,
    chance: SampleSeed,
    /// Weight given by the hit that sends the ray.
    throughput: Vec3,
    /// Share of its camera ray that the ray carries: the product of all weights since the camera,
    /// each as a part of all that its hit sends.
    share: Vec3,
    /// Bounces before this ray.
    depth: u32,
}

impl PathSegment {
    /// A camera ray.
    pub(super) fn from_camera(ray: OracleRay, seed: SampleSeed) -> PathSegment {
        PathSegment {
            ray,
            way: BounceKind::Mirror,
            chance: seed,
            throughput: Vec3::ONE,
            share: Vec3::ONE,
            depth: 0,
        }
    }
}

/// The rays that a hit sends on: a mirror ray and a refracted one.
type SegmentPair = [Option<PathSegment>; 2];

/// A hit whose bounces are being traced.
pub(super) struct PathLevel {
    /// Light of the hit, as far as it is known.
    parts: RadianceParts,
    /// Kind of the bounce that is being traced, and its weight.
    traced: (BounceKind, Vec3),
    /// The bounce that is traced after it.
    pending: Option<PathSegment>,
}

impl RadianceParts {
    fn add_weighted(&mut self, (way, weight): (BounceKind, Vec3), light: Vec3) {
        let part = Some(weight * light);
        match way {
            BounceKind::Mirror => self.reflection = part,
            BounceKind::Refracted => self.refraction = part,
        }
    }
}

impl Oracle<'_> {
    /// I = Ka + Ke + Σ V_i L_i (Kd max(l·n, 0) + Ks max(h·n, 0)^s) + Ks I_R + Kt I_T, for a camera
    /// ray.
    pub(super) fn light(
        &mut self,
        camera: &PathSegment,
        hit: Option<OracleHit>,
        mut cursor: Option<ShadowCacheCursor>,
    ) -> RadianceParts {
        let (mut parts, ways) = self.shade(camera, hit, cursor.as_mut());
        for segment in ways.into_iter().flatten() {
            let traced = (segment.way, segment.throughput);
            let mirror = matches!(segment.way, BounceKind::Mirror);
            let cursor = cursor.as_mut().and_then(|cursor| cursor.child(mirror));
            parts.add_weighted(traced, self.follow(segment, cursor));
        }
        parts
    }

    /// The light of a bounce of a camera ray. The sums are those of the recursion: each hit's
    /// mirror ray is followed to its end, and then its refracted one.
    fn follow(&mut self, first: PathSegment, mut cursor: Option<ShadowCacheCursor>) -> Vec3 {
        let mut path = std::mem::take(&mut self.path);
        let mut next = Some(first);
        let light = loop {
            let Some(segment) = next.take() else {
                // The hit on top has all its light: return to the one that sent the ray there.
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
            let (parts, ways) = self.shade(&segment, hit, cursor.as_mut());
            // No visibility is recorded for later hits.
            cursor = None;
            let [mirror, refracted] = ways;
            let mut level = PathLevel {
                parts,
                traced: (BounceKind::Mirror, Vec3::ZERO),
                pending: None,
            };
            (next, level.pending) = match mirror {
                Some(mirror) => (Some(mirror), refracted),
                None => (refracted, None),
            };
            if let Some(next) = &next {
                level.traced = (next.way, next.throughput);
            }
            path.push(level);
        };
        self.path = path;
        light
    }

    fn trace_segment(&mut self, segment: &PathSegment) -> Option<OracleHit> {
        match segment.way {
            BounceKind::Mirror => self.ray_counts.reflection += 1,
            BounceKind::Refracted => self.ray_counts.refraction += 1,
        }
        self.closest(&segment.ray)
    }

    /// The light of a hit without its bounces, and the bounces that are worth tracing.
    fn shade(
        &mut self,
        segment: &PathSegment,
        hit: Option<OracleHit>,
        mut cursor: Option<&mut ShadowCacheCursor>,
    ) -> (RadianceParts, SegmentPair) {
        let mut parts = RadianceParts::default();
        let Some(hit) = hit else {
            parts.direct = self.scene.background;
            return (parts, [None, None]);
        };
        let at = OracleSurface::new(self.scene, &segment.ray, &hit);
        let prim = self.scene.resolve(hit.prim_id).prim;
        let material = OracleMaterial::of(self.scene, prim, &hit);
        parts.direct = material.own;
        if let Some(cursor) = &mut cursor {
            cursor.begin_hit(hit.prim_id);
        }
        for light in 0..self.scene.lights.len() {
            let sample = shading::sample_light(self.scene, light, segment.chance, &material, &at);
            let Some(sample) = sample else {
                continue;
            };
            let known = cursor.as_ref();
            let known = known.and_then(|cursor| cursor.known_visibility(light, sample.radiance));
            let seen = known.unwrap_or_else(|| {
                self.ray_counts.shadow += 1;
                !self.occluded(&sample.ray, sample.tmax)
            });
            if let Some(cursor) = &mut cursor {
                cursor.record_visible(light, seen);
            }
            if seen {
                parts.direct += sample.radiance;
            }
        }
        if segment.depth >= self.max_depth {
            return (parts, [None, None]);
        }
        let (mirror, refracted) = shading::bounces(&material, segment.chance, &at);
        let whole = material.secondary_weight();
        let mirror = mirror
            .and_then(|bounce| self.secondary_segment(segment, whole, bounce, BounceKind::Mirror));
        let refracted = refracted.and_then(|bounce| {
            self.secondary_segment(segment, whole, bounce, BounceKind::Refracted)
        });
        (parts, [mirror, refracted])
    }

    /// A bounce of a ray, one of those that share `whole`; `None` if its own share is less than the
    /// minimum in every component.
    fn secondary_segment(
        &self,
        from: &PathSegment,
        whole: Vec3,
        bounce: OracleBounce,
        way: BounceKind,
    ) -> Option<PathSegment> {
        let share = from.share * (bounce.weight / whole);
        let counts = share.abs().cmpge(Vec3::splat(self.min_weight)).any();
        (counts || self.min_weight == 0.0).then(|| PathSegment {
            ray: bounce.ray,
            way,
            chance: from.chance.child(way),
            throughput: bounce.weight,
            share,
            depth: from.depth + 1,
        })
    }
}

impl PathLevel {
    /// Takes the pending bounce, if there is one, to be traced now.
    fn take_pending(&mut self) -> Option<PathSegment> {
        let later = self.pending.take()?;
        self.traced = (later.way, later.throughput);
        Some(later)
    }
}
