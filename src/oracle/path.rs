//! The light that a ray brings, with its bounces: the recursion of the design document ("Recursive shading model"), on a
//! stack of its own, because the thread's would not hold bounces of any depth.

use super::Oracle;
use super::intersect::{Hit, Ray};
use super::pixel::Parts;
use super::shading::{self, Bounce, Chance, Material, Surface};
use super::watch::Watch;
use glam::Vec3;
use phalanx_scene::sampling::Way;

/// A ray to be traced, and what its light is multiplied with.
pub(super) struct Onward {
    ray: Ray,
    way: Way,
    chance: Chance,
    /// Weight given by the hit that sends it.
    weight: Vec3,
    /// What it carries of its camera ray: the product of all weights since the camera, each as a
    /// part of what its hit sends.
    share: Vec3,
    /// Bounces before this ray.
    depth: u32,
}

impl Onward {
    /// A camera ray.
    pub(super) fn from_camera(ray: Ray, chance: Chance) -> Onward {
        Onward {
            ray,
            way: Way::Mirror,
            chance,
            weight: Vec3::ONE,
            share: Vec3::ONE,
            depth: 0,
        }
    }
}

/// The rays that a hit sends on: a mirror ray and a refracted one.
type Ways = [Option<Onward>; 2];

/// A hit whose bounces are being traced.
pub(super) struct Level {
    /// Its light as far as it is known.
    parts: Parts,
    /// The way of the bounce that is being traced, and its weight.
    traced: (Way, Vec3),
    /// The bounce that is traced after it.
    later: Option<Onward>,
}

impl Parts {
    fn take(&mut self, (way, weight): (Way, Vec3), light: Vec3) {
        let part = Some(weight * light);
        match way {
            Way::Mirror => self.reflection = part,
            Way::Refracted => self.refraction = part,
        }
    }
}

impl Oracle<'_> {
    /// I = Ka + Ke + Σ V_i L_i (Kd max(l·n, 0) + Ks max(h·n, 0)^s) + Ks I_R + Kt I_T, for a camera ray.
    pub(super) fn light(
        &mut self,
        camera: &Onward,
        hit: Option<Hit>,
        mut watch: Option<Watch>,
    ) -> Parts {
        let (mut parts, ways) = self.shade(camera, hit, watch.as_mut());
        for onward in ways.into_iter().flatten() {
            let traced = (onward.way, onward.weight);
            let mirror = matches!(onward.way, Way::Mirror);
            let watch = watch.as_mut().and_then(|watch| watch.onward(mirror));
            parts.take(traced, self.follow(onward, watch));
        }
        parts
    }

    /// The light that a bounce of a camera ray brings. The sums are those of the recursion: each hit's mirror ray is
    /// followed to its end, and then its refracted one.
    fn follow(&mut self, first: Onward, mut watch: Option<Watch>) -> Vec3 {
        let mut path = std::mem::take(&mut self.path);
        let mut next = Some(first);
        let light = loop {
            let Some(onward) = next.take() else {
                // The hit on top has all its light: back to the one that sent the ray there.
                let Some(Level { parts, .. }) = path.pop() else {
                    break Vec3::ZERO;
                };
                let Some(above) = path.last_mut() else {
                    break parts.sum();
                };
                above.parts.take(above.traced, parts.sum());
                next = above.go_on();
                continue;
            };
            let hit = self.cast_onward(&onward);
            let (parts, ways) = self.shade(&onward, hit, watch.as_mut());
            // Nobody asks about what is hit later.
            watch = None;
            let [mirror, refracted] = ways;
            let mut level = Level {
                parts,
                traced: (Way::Mirror, Vec3::ZERO),
                later: None,
            };
            (next, level.later) = match mirror {
                Some(mirror) => (Some(mirror), refracted),
                None => (refracted, None),
            };
            if let Some(next) = &next {
                level.traced = (next.way, next.weight);
            }
            path.push(level);
        };
        self.path = path;
        light
    }

    fn cast_onward(&mut self, onward: &Onward) -> Option<Hit> {
        match onward.way {
            Way::Mirror => self.cast.reflection += 1,
            Way::Refracted => self.cast.refraction += 1,
        }
        self.closest(&onward.ray)
    }

    /// The light of a hit without its bounces, and those that are worth tracing.
    fn shade(
        &mut self,
        onward: &Onward,
        hit: Option<Hit>,
        mut watch: Option<&mut Watch>,
    ) -> (Parts, Ways) {
        let mut parts = Parts::default();
        let Some(hit) = hit else {
            parts.direct = self.scene.background;
            return (parts, [None, None]);
        };
        let at = Surface::new(self.scene, &onward.ray, &hit);
        let prim = self.scene.placed(hit.prim_id).prim;
        let material = Material::of(self.scene, prim, &hit);
        parts.direct = material.own;
        if let Some(watch) = &mut watch {
            watch.met(hit.prim_id);
        }
        for light in 0..self.scene.lights.len() {
            let sample = shading::sample_light(self.scene, light, onward.chance, &material, &at);
            let Some(sample) = sample else {
                continue;
            };
            let known = watch.as_ref();
            let known = known.and_then(|watch| watch.knows(light, sample.radiance));
            let seen = known.unwrap_or_else(|| {
                self.cast.shadow += 1;
                !self.occluded(&sample.ray, sample.tmax)
            });
            if let Some(watch) = &mut watch {
                watch.saw(light, seen);
            }
            if seen {
                parts.direct += sample.radiance;
            }
        }
        if onward.depth >= self.max_depth {
            return (parts, [None, None]);
        }
        let (mirror, refracted) = shading::bounces(&material, onward.chance, &at);
        let whole = material.sent();
        let mirror = mirror.and_then(|bounce| self.bounced(onward, whole, bounce, Way::Mirror));
        let refracted =
            refracted.and_then(|bounce| self.bounced(onward, whole, bounce, Way::Refracted));
        (parts, [mirror, refracted])
    }

    /// A bounce of a ray, one of those that share `whole`; `None` where its own share is less than
    /// the least in every component.
    fn bounced(&self, from: &Onward, whole: Vec3, bounce: Bounce, way: Way) -> Option<Onward> {
        let share = from.share * (bounce.weight / whole);
        let counts = share.abs().cmpge(Vec3::splat(self.min_weight)).any();
        (counts || self.min_weight == 0.0).then(|| Onward {
            ray: bounce.ray,
            way,
            chance: from.chance.onward(way),
            weight: bounce.weight,
            share,
            depth: from.depth + 1,
        })
    }
}

impl Level {
    /// The bounce that is left, if one is, which is traced now.
    fn go_on(&mut self) -> Option<Onward> {
        let later = self.later.take()?;
        self.traced = (later.way, later.weight);
        Some(later)
    }
}
