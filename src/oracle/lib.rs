//! The scalar tracer: one ray at a time, recursively, as the design document writes it. It is a
//! second, plainer implementation of the same arithmetic, with a tree of its own, that proves the
//! packet engine bit by bit.
//!
//! It shares with the packet engine only the scene, the camera's scalar half and the definitions in
//! `sampling`. It uses none of the modules simd, packet, bvh, traverse and shade.

mod cone;
mod instance;
mod intersect;
#[doc(hidden)]
pub mod isolated;
mod path;
mod pixel;
mod shading;
mod shadow_cache_cursor;
mod texture;
mod tree;

pub use intersect::{OracleHit, OracleRay};
pub use pixel::OraclePixel;
pub use shading::OracleSurface;
pub use tree::{OracleTree, TwoLevelBvh};

use glam::Vec3;
use intersect::OracleRaySetup;
use path::{PathLevel, PathSegment};
use phalanx_scene::camera::Camera;
use phalanx_scene::sampling::{
    Adaptive, BLOCK, Cells, Dimension, FilmSamples, SampleResult, Sampling, concentric_disk,
};
use phalanx_scene::{Bounds, RayCounts, Scene};
use pixel::{OraclePixelAccumulator, OracleSample, RadianceParts};
use shading::{OracleMaterial, SampleSeed};
use shadow_cache_cursor::{SampleVisibility, ShadowCacheCursor};
use std::borrow::Cow;

/// Search method of the oracle. Both give the same bits.
#[derive(Clone, Copy, Debug)]
pub enum OracleSearch<'a> {
    /// Search through trees.
    Tree(&'a TwoLevelBvh),
    /// Test of every primitive, for small scenes: the reference for any tree.
    BruteForce,
}

/// The scalar tracer: the answer that every other is compared with.
///
/// ```
/// use glam::Vec3;
/// use phalanx_oracle::{Oracle, OracleRay, OracleSearch, TwoLevelBvh};
/// use phalanx_scene::Scene;
///
/// let mut scene = Scene::new();
/// scene.add_spheres(&[[0.0; 3], [5.0, 0.0, 0.0]], &[1.0, 1.0])?;
/// let tree = TwoLevelBvh::build(&scene);
/// let ray = OracleRay::new(Vec3::new(-9.0, 0.0, 0.0), Vec3::X);
/// for search in [OracleSearch::Tree(&tree), OracleSearch::BruteForce] {
///     let oracle = Oracle::new(&scene, search, 0);
///     let hit = oracle.closest(&ray).expect("a hit");
///     assert_eq!((hit.t, hit.prim_id), (8.0, 0));
/// }
/// # Ok::<(), phalanx_scene::GeometryError>(())
/// ```
pub struct Oracle<'a> {
    scene: &'a Scene,
    search: OracleSearch<'a>,
    /// Padded boxes of the instances.
    instance_boxes: Cow<'a, [Bounds]>,
    max_depth: u32,
    /// Least share of its camera ray that a ray must have in some component to be traced; if 0, all
    /// rays are traced.
    min_weight: f32,
    /// The bounces between a camera ray and the ray that is traced.
    path: Vec<PathLevel>,
    /// Reach of ambient occlusion rays, if it is rendered in place of shading.
    ao_distance: Option<f32>,
    /// Rays cast since the oracle was made.
    pub ray_counts: RayCounts,
}

/// A camera ray of a pixel, and its filter weight.
pub fn camera_ray(
    camera: &Camera,
    sampling: &Sampling,
    x: u32,
    y: u32,
    sample: u32,
) -> (OracleRay, f32) {
    let FilmSamples {
        row: [row],
        column: [column],
        weight: [weight],
    } = sampling.film_samples([x], [y], sample);
    let ray = match camera.has_lens() {
        true => {
            let [[u], [v]] = concentric_disk(SampleSeed::of(x, y, sample).point(Dimension::Lens));
            let (org, dir) = camera.through_lens(row, column, [u, v]);
            OracleRay::new(org, dir)
        }
        false => OracleRay::new(camera.eye, camera.direction(row, column)),
    };
    (ray, weight)
}

impl<'a> Oracle<'a> {
    /// Makes an oracle for a valid scene. `max_depth` counts bounces after the primary ray, and
    /// matters to pictures alone. [`Oracle`] has an example.
    pub fn new(scene: &'a Scene, search: OracleSearch<'a>, max_depth: u32) -> Oracle<'a> {
        Oracle {
            scene,
            search,
            instance_boxes: match search {
                OracleSearch::Tree(bvh) => Cow::Borrowed(bvh.instance_boxes()),
                OracleSearch::BruteForce => Cow::Owned(instance::instance_boxes(scene)),
            },
            max_depth,
            min_weight: 0.0,
            path: Vec::new(),
            ao_distance: None,
            ray_counts: RayCounts::default(),
        }
    }

    /// Replaces shading by ambient occlusion: a hit is white if one ray from it hits nothing within
    /// `reach`, and else black.
    pub fn with_ambient_occlusion(self, reach: f32) -> Oracle<'a> {
        Oracle {
            ao_distance: Some(reach),
            ..self
        }
    }

    /// Limits bounces to those whose product of the weights along the path is at least this in some
    /// component.
    pub fn with_min_weight(self, min_weight: f32) -> Oracle<'a> {
        Oracle { min_weight, ..self }
    }

    /// Renders a pixel with all of its camera rays.
    pub fn pixel(&mut self, camera: &Camera, sampling: &Sampling, x: u32, y: u32) -> OraclePixel {
        let mut pixel = OraclePixelAccumulator::default();
        for sample in 0..sampling.spp {
            pixel.add(self.sample(camera, sampling, (x, y), sample, None));
        }
        pixel.finish()
    }

    /// Renders the pixels of a block, with as many samples as they need, row by row. The block
    /// begins in column `x` and row `y`, and has the given number of columns and rows in the
    /// picture, 8 at most.
    pub fn block(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        adaptive: &Adaptive,
        corner: (u32, u32),
        size: (u32, u32),
    ) -> Vec<OraclePixel> {
        let by_chance =
            self.scene.is_stochastic() || camera.has_lens() || self.ao_distance.is_some();
        match by_chance {
            true => self.block_by_pixels(camera, sampling, adaptive, corner, size),
            false => self.block_by_cells(camera, sampling, adaptive, corner, size),
        }
    }

    /// Renders a block whose only random choices are the camera rays' positions in their pixels,
    /// with as many samples as the pixels' parts need.
    fn block_by_cells(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        adaptive: &Adaptive,
        (x, y): (u32, u32),
        size: (u32, u32),
    ) -> Vec<OraclePixel> {
        let mut first = [[None; BLOCK as usize]; BLOCK as usize];
        let mut cells = Cells::default();
        cells.begin(*adaptive, sampling.spp, ((x, y), size), true);
        loop {
            for k in 0..cells.requests().len() {
                let asked = &cells.requests()[k];
                let ((column, row), number) = (asked.pixel, asked.number);
                let mut visibility = SampleVisibility::of(&cells, k);
                let place = (x + column, y + row);
                let traced =
                    self.sample(camera, sampling, place, number, Some(visibility.cursor()));
                let answer = SampleResult {
                    radiance: traced.light.sum().to_array(),
                    light: traced.light.all().map(Vec3::into),
                    weight: traced.weight,
                    visibility: visibility.visibility,
                };
                if number == 0 {
                    first[row as usize][column as usize] = Some((traced.ray, traced.hit));
                }
                cells.add_result(k, &answer);
            }
            if !cells.next_round() {
                break;
            }
        }
        let sums = cells.sums();
        let places = (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row)));
        let pixel = |(column, row): (u32, u32)| {
            let sum = &sums[(row * BLOCK + column) as usize];
            OraclePixel {
                radiance: sum.radiance.mean().into(),
                light: sum.light.map(|way| way.mean().into()),
                first: first[row as usize][column as usize],
                samples: sum.samples,
            }
        };
        places.map(pixel).collect()
    }

    /// Renders a block with other random choices than the camera rays' positions in their pixels,
    /// with as many samples as each pixel needs.
    fn block_by_pixels(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        adaptive: &Adaptive,
        (x, y): (u32, u32),
        size: (u32, u32),
    ) -> Vec<OraclePixel> {
        let mut block = [[OraclePixelAccumulator::default(); BLOCK as usize]; BLOCK as usize];
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
            open = adaptive.still_active(open, samples, &gathered, size);
        }
        places()
            .map(|(x, y)| block[y as usize][x as usize].finish())
            .collect()
    }

    /// Traces one camera ray of a pixel.
    fn sample(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        (x, y): (u32, u32),
        sample: u32,
        cursor: Option<ShadowCacheCursor>,
    ) -> OracleSample {
        self.ray_counts.primary += 1;
        let (ray, weight) = camera_ray(camera, sampling, x, y, sample);
        let hit = self.closest(&ray);
        let seed = SampleSeed::of(x, y, sample);
        let light = match self.ao_distance {
            Some(reach) => RadianceParts {
                direct: self.ao_visibility(&ray, hit, seed, reach),
                ..RadianceParts::default()
            },
            None => self.light(&PathSegment::from_camera(ray, seed), hit, cursor),
        };
        OracleSample {
            ray,
            hit,
            light,
            weight,
        }
    }

    /// The surface at a ray's hit, for callers that need more than its light: the surface point,
    /// and the diffuse reflectance and the number of its material.
    pub fn surface_at(&self, ray: &OracleRay, hit: &OracleHit) -> (OracleSurface, Vec3, u32) {
        let prim = self.scene.resolve(hit.prim_id).prim;
        let material = OracleMaterial::of(self.scene, prim, hit);
        let surface = OracleSurface::new(self.scene, ray, hit);
        (surface, material.kd, self.scene.prim_material(prim))
    }

    /// White if one ray from the hit meets nothing within `reach`.
    fn ao_visibility(
        &mut self,
        ray: &OracleRay,
        hit: Option<OracleHit>,
        seed: SampleSeed,
        reach: f32,
    ) -> Vec3 {
        let Some(hit) = hit else {
            return self.scene.background;
        };
        let at = OracleSurface::new(self.scene, ray, &hit);
        self.ray_counts.shadow += 1;
        match self.occluded(&shading::sample_ao_ray(seed, &at), reach) {
            true => Vec3::ZERO,
            false => Vec3::ONE,
        }
    }

    /// Finds the closest hit with 0 < t, ties going to the smaller prim_id; `None` is a miss. Costs
    /// one search through a tree, or a test of every primitive. [`Oracle`] has an example.
    pub fn closest(&self, ray: &OracleRay) -> Option<OracleHit> {
        let setup = OracleRaySetup::new(ray);
        let mut best = None;
        match self.search {
            OracleSearch::Tree(bvh) => {
                let closer = |object, best: &mut Option<OracleHit>| {
                    self.update_closest(&setup, object, best)
                };
                bvh.world()
                    .closest(&setup, f32::INFINITY, &mut best, closer);
            }
            OracleSearch::BruteForce => {
                for object in instance::world_objects(self.scene) {
                    self.update_closest(&setup, object, &mut best);
                }
            }
        }
        best
    }

    /// Returns true if anything is hit with 0 < t < `tmax`, in units of the direction.
    ///
    /// ```
    /// use glam::Vec3;
    /// use phalanx_oracle::{Oracle, OracleRay, OracleSearch};
    /// use phalanx_scene::Scene;
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// let oracle = Oracle::new(&scene, OracleSearch::BruteForce, 0);
    /// let ray = OracleRay::new(Vec3::new(-9.0, 0.0, 0.0), Vec3::X);
    /// assert!(oracle.occluded(&ray, 8.5));
    /// assert!(!oracle.occluded(&ray, 8.0));
    /// # Ok::<(), phalanx_scene::GeometryError>(())
    /// ```
    pub fn occluded(&self, ray: &OracleRay, tmax: f32) -> bool {
        let setup = OracleRaySetup::new(ray);
        let blocks = |object| self.is_hit(&setup, object, tmax);
        match self.search {
            OracleSearch::Tree(bvh) => bvh.world().any(&setup, tmax, blocks),
            OracleSearch::BruteForce => instance::world_objects(self.scene).any(blocks),
        }
    }
}
