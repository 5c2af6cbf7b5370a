//! The scalar tracer: one ray at a time, recursively, as the design document writes it. A second, plainer
//! implementation of the same arithmetic, with a tree of its own, that proves the packet engine bit by bit.
//!
//! It shares with the packet engine only the scene, the camera's scalar half and the definitions in `sampling`; it uses none
//! of the rooms lanes, packet, bvh, trace and shade.

pub mod alone;
mod cone;
mod instance;
mod intersect;
mod shading;
mod texture;
mod tree;

pub use intersect::{Hit, Ray};
pub use shading::Surface;
pub use tree::{Forest, Tree};

use crate::camera::Camera;
use crate::sampling::{Gathered, Places, Purpose, Sampling, Way, disc};
use crate::scene::{Bounds, Scene};
use glam::Vec3;
use intersect::Probe;
use shading::{Bounce, Chance, Material};
use std::borrow::Cow;

/// Rays cast by the oracle, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cast {
    /// Camera rays.
    pub primary: u64,
    /// Rays toward lights.
    pub shadow: u64,
    /// Mirror rays.
    pub reflection: u64,
    /// Refracted rays.
    pub refraction: u64,
}

/// How the oracle looks for hits.
#[derive(Clone, Copy, Debug)]
pub enum Search<'a> {
    /// Through trees.
    Tree(&'a Forest),
    /// Every primitive, for tests on small scenes: what any tree must agree with.
    BruteForce,
}

/// The scalar tracer.
pub struct Oracle<'a> {
    scene: &'a Scene,
    search: Search<'a>,
    /// Own boxes of the instances, padded.
    instance_boxes: Cow<'a, [Bounds]>,
    max_depth: u32,
    /// How far the sky is, where nothing but that is to be seen.
    sky: Option<f32>,
    /// Rays cast since it was made.
    pub cast: Cast,
}

/// A camera ray of a pixel, and what it counts.
pub fn camera_ray(camera: &Camera, sampling: &Sampling, x: u32, y: u32, sample: u32) -> (Ray, f32) {
    let Places {
        row: [row],
        column: [column],
        weight: [weight],
    } = sampling.places([x], [y], sample);
    let ray = match camera.has_lens() {
        true => {
            let [[u], [v]] = disc(Chance::of(x, y, sample).point(Purpose::Lens));
            let (org, dir) = camera.through_lens(row, column, [u, v]);
            Ray::new(org, dir)
        }
        false => Ray::new(camera.eye, camera.direction(row, column)),
    };
    (ray, weight)
}

impl<'a> Oracle<'a> {
    /// An oracle for a validated scene. `max_depth` counts bounces after the primary ray.
    pub fn new(scene: &'a Scene, search: Search<'a>, max_depth: u32) -> Oracle<'a> {
        Oracle {
            scene,
            search,
            instance_boxes: match search {
                Search::Tree(forest) => Cow::Borrowed(forest.instance_boxes()),
                Search::BruteForce => Cow::Owned(instance::boxes(scene)),
            },
            max_depth,
            sky: None,
            cast: Cast::default(),
        }
    }

    /// With ambient occlusion in place of shading: a hit is white if one ray from it meets nothing within `reach`, and else black.
    pub fn with_occlusion(self, reach: f32) -> Oracle<'a> {
        Oracle {
            sky: Some(reach),
            ..self
        }
    }

    /// Radiance of a pixel, and what its first camera ray hit.
    pub fn pixel(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        x: u32,
        y: u32,
    ) -> (Vec3, Option<Hit>) {
        let (first, hit, weight) = self.sample(camera, sampling, x, y, 0);
        if sampling.spp == 1 {
            return (first, hit);
        }
        let mut gathered = Gathered::default();
        gathered.add(first.to_array(), weight);
        for sample in 1..sampling.spp {
            let (radiance, _, weight) = self.sample(camera, sampling, x, y, sample);
            gathered.add(radiance.to_array(), weight);
        }
        (gathered.mean().into(), hit)
    }

    /// Radiance of one camera ray of a pixel, what it hit, and what it counts.
    fn sample(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        x: u32,
        y: u32,
        sample: u32,
    ) -> (Vec3, Option<Hit>, f32) {
        self.cast.primary += 1;
        let (ray, weight) = camera_ray(camera, sampling, x, y, sample);
        let hit = self.closest(&ray);
        let chance = Chance::of(x, y, sample);
        let radiance = match self.sky {
            Some(reach) => self.openness(&ray, hit, chance, reach),
            None => self.radiance(&ray, hit, chance, self.max_depth),
        };
        (radiance, hit, weight)
    }

    /// White where one ray from what was hit meets nothing within `reach`.
    fn openness(&mut self, ray: &Ray, hit: Option<Hit>, chance: Chance, reach: f32) -> Vec3 {
        let Some(hit) = hit else {
            return self.scene.background;
        };
        let at = Surface::new(self.scene, ray, &hit);
        self.cast.shadow += 1;
        match self.occluded(&shading::skyward(chance, &at), reach) {
            true => Vec3::ZERO,
            false => Vec3::ONE,
        }
    }

    /// The closest hit with 0 < t, ties going to the smaller prim_id.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let probe = Probe::new(ray);
        let mut best = None;
        match self.search {
            Search::Tree(forest) => {
                let closer = |object, best: &mut Option<Hit>| self.closer(&probe, object, best);
                forest
                    .world()
                    .closest(&probe, f32::INFINITY, &mut best, closer);
            }
            Search::BruteForce => {
                for object in instance::world(self.scene) {
                    self.closer(&probe, object, &mut best);
                }
            }
        }
        best
    }

    /// Whether anything is hit with 0 < t < `tmax`.
    pub fn occluded(&self, ray: &Ray, tmax: f32) -> bool {
        let probe = Probe::new(ray);
        let blocks = |object| self.blocks(&probe, object, tmax);
        match self.search {
            Search::Tree(forest) => forest.world().any(&probe, tmax, blocks),
            Search::BruteForce => instance::world(self.scene).any(blocks),
        }
    }

    /// I = Ka + Ke + Σ V_i L_i (Kd max(l·n, 0) + Ks max(h·n, 0)^s) + Ks I_R + Kt I_T.
    fn radiance(&mut self, ray: &Ray, hit: Option<Hit>, chance: Chance, bounces_left: u32) -> Vec3 {
        let Some(hit) = hit else {
            return self.scene.background;
        };
        let at = Surface::new(self.scene, ray, &hit);
        let prim = self.scene.placed(hit.prim_id).prim;
        let material = Material::of(self.scene, prim, &hit);
        let mut sum = material.own;
        for light in 0..self.scene.lights.len() {
            let sample = shading::sample_light(self.scene, light, chance, &material, &at);
            let Some(sample) = sample else {
                continue;
            };
            self.cast.shadow += 1;
            if !self.occluded(&sample.ray, sample.tmax) {
                sum += sample.radiance;
            }
        }
        if bounces_left == 0 {
            return sum;
        }
        let (mirror, refracted) = shading::bounces(&material, chance, &at);
        if let Some(Bounce { ray, weight }) = mirror {
            self.cast.reflection += 1;
            let hit = self.closest(&ray);
            let chance = chance.onward(Way::Mirror);
            sum += weight * self.radiance(&ray, hit, chance, bounces_left - 1);
        }
        if let Some(Bounce { ray, weight }) = refracted {
            self.cast.refraction += 1;
            let hit = self.closest(&ray);
            let chance = chance.onward(Way::Refracted);
            sum += weight * self.radiance(&ray, hit, chance, bounces_left - 1);
        }
        sum
    }
}
