//! The scalar tracer: one ray at a time, recursively, as the design document writes it. A second, plainer
//! implementation of the same arithmetic, with a tree of its own, that proves the packet engine bit by bit.
//!
//! It shares with the packet engine only the scene, the camera's scalar half and the definitions in `sampling`; it uses none
//! of the rooms lanes, packet, bvh, trace and shade.

pub mod alone;
mod cone;
mod instance;
mod intersect;
mod path;
mod pixel;
mod shading;
mod texture;
mod tree;
mod watch;

pub use intersect::{Hit, Ray};
pub use pixel::Pixel;
pub use shading::Surface;
pub use tree::{Forest, Tree};

use glam::Vec3;
use intersect::Probe;
use path::{Level, Onward};
use phalanx_scene::camera::Camera;
use phalanx_scene::sampling::{Adaptive, Answer, BLOCK, Cells, Places, Purpose, Sampling, disc};
use phalanx_scene::{Bounds, Scene};
use pixel::{Gathering, Parts, Sample};
use shading::{Chance, Material};
use std::borrow::Cow;
use watch::{Sights, Watch};

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
    /// Rays whose share of their camera ray is less than this in every component are not traced;
    /// if 0, all are.
    min_weight: f32,
    /// The bounces between a camera ray and the ray that is traced.
    path: Vec<Level>,
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
            min_weight: 0.0,
            path: Vec::new(),
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

    /// With bounces only where the product of the weights along the way is at least this in some component.
    pub fn with_min_weight(self, min_weight: f32) -> Oracle<'a> {
        Oracle { min_weight, ..self }
    }

    /// A pixel, with all of its camera rays.
    pub fn pixel(&mut self, camera: &Camera, sampling: &Sampling, x: u32, y: u32) -> Pixel {
        let mut pixel = Gathering::default();
        for sample in 0..sampling.spp {
            pixel.add(self.sample(camera, sampling, (x, y), sample, None));
        }
        pixel.finish()
    }

    /// The pixels of a block that get as many samples as they need, row by row. The block begins in column `x` and row `y`, and has so
    /// many columns and rows in the picture, 8 at most.
    pub fn block(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        adaptive: &Adaptive,
        corner: (u32, u32),
        size: (u32, u32),
    ) -> Vec<Pixel> {
        let by_chance = self.scene.has_chance() || camera.has_lens() || self.sky.is_some();
        match by_chance {
            true => self.block_by_pixels(camera, sampling, adaptive, corner, size),
            false => self.block_by_cells(camera, sampling, adaptive, corner, size),
        }
    }

    /// Where a pixel's square says all: as many samples as its parts need.
    fn block_by_cells(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        adaptive: &Adaptive,
        (x, y): (u32, u32),
        size: (u32, u32),
    ) -> Vec<Pixel> {
        let mut first = [[None; BLOCK as usize]; BLOCK as usize];
        let mut cells = Cells::default();
        cells.begin(*adaptive, sampling.spp, ((x, y), size), true);
        loop {
            for k in 0..cells.asks().len() {
                let asked = &cells.asks()[k];
                let ((column, row), number) = (asked.pixel, asked.number);
                let mut sights = Sights::of(&cells, k);
                let place = (x + column, y + row);
                let traced = self.sample(camera, sampling, place, number, Some(sights.watch()));
                let answer = Answer {
                    radiance: traced.light.sum().to_array(),
                    light: traced.light.all().map(Vec3::into),
                    weight: traced.weight,
                    sights: sights.all,
                };
                if number == 0 {
                    first[row as usize][column as usize] = Some((traced.ray, traced.hit));
                }
                cells.answer(k, &answer);
            }
            if !cells.go_on() {
                break;
            }
        }
        let sums = cells.sums();
        let places = (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row)));
        let pixel = |(column, row): (u32, u32)| {
            let sum = &sums[(row * BLOCK + column) as usize];
            Pixel {
                radiance: sum.radiance.mean().into(),
                light: sum.light.map(|way| way.mean().into()),
                first: first[row as usize][column as usize],
                samples: sum.samples,
            }
        };
        places.map(pixel).collect()
    }

    /// Where more is left to chance than where a camera ray goes through its pixel: as many samples as each pixel needs.
    fn block_by_pixels(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        adaptive: &Adaptive,
        (x, y): (u32, u32),
        size: (u32, u32),
    ) -> Vec<Pixel> {
        let mut block = [[Gathering::default(); BLOCK as usize]; BLOCK as usize];
        let places = || (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row)));
        let (mut open, mut samples) = (!0, 0);
        while open != 0 && samples < sampling.spp {
            let next = adaptive.next(samples, sampling.spp);
            for (column, row) in places() {
                if open >> (row * BLOCK + column) & 1 == 0 {
                    continue;
                }
                for sample in samples..next {
                    let place = (x + column, y + row);
                    let traced = self.sample(camera, sampling, place, sample, None);
                    block[row as usize][column as usize].add(traced);
                }
            }
            samples = next;
            let gathered = block.map(|row| row.map(|pixel| pixel.radiance()));
            open = adaptive.stay_open(open, samples, &gathered, size);
        }
        places()
            .map(|(x, y)| block[y as usize][x as usize].finish())
            .collect()
    }

    /// One camera ray of a pixel.
    fn sample(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        (x, y): (u32, u32),
        sample: u32,
        watch: Option<Watch>,
    ) -> Sample {
        self.cast.primary += 1;
        let (ray, weight) = camera_ray(camera, sampling, x, y, sample);
        let hit = self.closest(&ray);
        let chance = Chance::of(x, y, sample);
        let light = match self.sky {
            Some(reach) => Parts {
                direct: self.openness(&ray, hit, chance, reach),
                ..Parts::default()
            },
            None => self.light(&Onward::from_camera(ray, chance), hit, watch),
        };
        Sample {
            ray,
            hit,
            light,
            weight,
        }
    }

    /// What a ray hit, for whoever wants to know more of it than its light: its place, and the diffuse reflectance and the number of
    /// its material.
    pub fn look(&self, ray: &Ray, hit: &Hit) -> (Surface, Vec3, u32) {
        let prim = self.scene.placed(hit.prim_id).prim;
        let material = Material::of(self.scene, prim, hit);
        let surface = Surface::new(self.scene, ray, hit);
        (surface, material.kd, self.scene.prim_material(prim))
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
}
