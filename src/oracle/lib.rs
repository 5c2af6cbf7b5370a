//! The scalar tracer: one ray at a time, recursively, as in the design document (M. Bontje,
//! "Raytracer technical design document", 2016). It is a second, plainer implementation of the same
//! arithmetic, with a tree of its own, that proves the packet engine bit by bit.
//!
//! It shares with the packet engine only the scene, tiles, the camera's scalar half and the
//! definitions in `sampling`. It uses none of the modules simd, packet, bvh, traverse and shade.

mod block;
mod instance;
mod intersect;
#[doc(hidden)]
pub mod microbench;
mod passing;
mod pixel;
mod primitives;
mod search;
mod shading;
mod shadow_cache_cursor;
mod terminator;
mod texture;
mod tree;
mod whitted;

pub use intersect::{OracleHit, OracleRay};
pub use pixel::OraclePixel;
pub use search::OracleSearch;
pub use shading::OracleSurface;
pub use tree::{OracleTree, TwoLevelBvh};

use glam::Vec3;
use phalanx_scene::camera::Camera;
use phalanx_scene::sampling::{Dimension, FilmSamples, Sampling, SurfaceShare, concentric_disk};
use phalanx_scene::{IntegratorSettings, MatteIds, RayCounts, Scene};
use pixel::{OraclePixelAccumulator, OracleSample, RadianceParts};
use search::{START, SceneSearch};
use shading::{OracleMaterial, SampleSeed};
use shadow_cache_cursor::ShadowCacheCursor;
use whitted::{PathSegment, WhittedIntegrator};

/// The scalar tracer: the reference for all other results.
///
/// ```
/// # mod phalanx { pub use {glam, phalanx_oracle as oracle, phalanx_scene::*}; }
/// use phalanx::glam::Vec3;
/// use phalanx::oracle::{Oracle, OracleRay, OracleSearch, TwoLevelBvh};
/// use phalanx::Scene;
///
/// let mut scene = Scene::new();
/// scene.add_spheres(&[[0.0; 3], [5.0, 0.0, 0.0]], &[1.0, 1.0])?;
/// let tree = TwoLevelBvh::build(&scene);
/// let ray = OracleRay::new(Vec3::new(-9.0, 0.0, 0.0), Vec3::X);
/// for search in [OracleSearch::Tree(&tree), OracleSearch::BruteForce] {
///     let oracle = Oracle::new(&scene, search);
///     let hit = oracle.closest(&ray).expect("a hit");
///     assert_eq!((hit.t, hit.prim_id), (8.0, 0));
/// }
/// # Ok::<(), phalanx::GeometryError>(())
/// ```
pub struct Oracle<'a> {
    integrator: WhittedIntegrator<'a>,
    /// Identifiers of the surfaces that camera rays see, if mattes are requested.
    mattes: Option<&'a MatteIds>,
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
    let (org, dir) = if camera.has_lens() {
        let [[u], [v]] = concentric_disk(SampleSeed::of(x, y, sample).point(Dimension::Lens));
        camera.through_lens(row, column, [u, v])
    } else {
        camera.ray(row, column)
    };
    (OracleRay::new(org, dir), weight)
}

impl<'a> Oracle<'a> {
    /// Makes an oracle for a valid scene. [`Oracle`] has an example.
    pub fn new(scene: &'a Scene, search: OracleSearch<'a>) -> Oracle<'a> {
        Oracle {
            integrator: WhittedIntegrator::new(SceneSearch::new(scene, search)),
            mattes: None,
        }
    }

    /// Replaces the settings of pictures, which trace no bounces by default.
    pub fn with_settings(mut self, settings: IntegratorSettings) -> Oracle<'a> {
        self.integrator.settings = settings;
        self
    }

    /// Collects all surfaces that camera rays see, with these identifiers.
    pub fn with_mattes(self, mattes: Option<&'a MatteIds>) -> Oracle<'a> {
        Oracle { mattes, ..self }
    }

    /// Rays cast since the oracle was made.
    pub fn ray_counts(&self) -> RayCounts {
        self.integrator.ray_counts
    }

    /// Backs of single-sided materials that rays have passed since the oracle was made.
    pub fn unseen_backs(&self) -> u64 {
        self.integrator.search.unseen_backs.get()
    }

    fn scene(&self) -> &'a Scene {
        self.integrator.search.scene
    }

    /// Renders a pixel with all of its camera rays.
    pub fn pixel(&mut self, camera: &Camera, sampling: &Sampling, x: u32, y: u32) -> OraclePixel {
        let mut pixel = OraclePixelAccumulator::default();
        for sample in 0..sampling.spp {
            pixel.add(self.sample(camera, sampling, (x, y), sample, ShadowCacheCursor::NONE));
        }
        pixel.finish()
    }

    /// Traces one camera ray of a pixel.
    fn sample(
        &mut self,
        camera: &Camera,
        sampling: &Sampling,
        (x, y): (u32, u32),
        sample: u32,
        cursor: ShadowCacheCursor,
    ) -> OracleSample {
        self.integrator.ray_counts.primary += 1;
        let (ray, weight) = camera_ray(camera, sampling, x, y, sample);
        let hit = self.integrator.search.closest_there(&ray, None);
        let seed = SampleSeed::of(x, y, sample);
        let light = match self.integrator.settings.ao_distance {
            Some(reach) => RadianceParts {
                direct: self.ao_visibility(&ray, hit, seed, reach),
                ..RadianceParts::default()
            },
            None => {
                let segment = PathSegment::from_camera(ray, seed);
                self.integrator.light(&segment, hit, cursor)
            }
        };
        OracleSample {
            ray,
            hit,
            light,
            weight,
            surfaces: self.surfaces_along(&ray, hit),
        }
    }

    /// The surfaces that a camera ray sees, from its hit on. For ambient occlusion, all are opaque.
    fn surfaces_along(&self, ray: &OracleRay, hit: Option<OracleHit>) -> Vec<SurfaceShare> {
        let Some(mattes) = self.mattes else {
            return Vec::new();
        };
        let opaque = self.integrator.settings.ao_distance.is_some();
        let shares = self.integrator.search.shares_along(ray, hit, opaque);
        let surface = |(prim_id, share)| SurfaceShare {
            ids: mattes.find(self.scene(), prim_id),
            share,
        };
        shares.into_iter().map(surface).collect()
    }

    /// The surface at a ray's hit, for callers that need more than its light: the surface point,
    /// and the diffuse reflectance and the number of its material.
    pub fn surface_at(&self, ray: &OracleRay, hit: &OracleHit) -> (OracleSurface, Vec3, u32) {
        let prim = self.scene().resolve(hit.prim_id).prim;
        let material = OracleMaterial::of(self.scene(), prim, hit);
        let surface = OracleSurface::new(self.scene(), ray, hit);
        (surface, material.kd, self.scene().prim_material(prim))
    }

    /// White if a single ray from the hit meets nothing within `reach`.
    fn ao_visibility(
        &mut self,
        ray: &OracleRay,
        hit: Option<OracleHit>,
        seed: SampleSeed,
        reach: f32,
    ) -> Vec3 {
        let Some(hit) = hit else {
            return self.integrator.camera_background(ray.dir);
        };
        let surface = OracleSurface::new(self.scene(), ray, &hit);
        self.integrator.ray_counts.shadow += 1;
        let ray = shading::sample_ao_ray(seed, &surface);
        self.integrator.search.visibility(&ray, reach)
    }

    /// Finds the closest hit with 0 < t, ties going to the smaller prim_id; `None` is a miss. Costs
    /// one search through a tree, or a test of every primitive. [`Oracle`] has an example.
    pub fn closest(&self, ray: &OracleRay) -> Option<OracleHit> {
        self.integrator.search.closest(ray)
    }

    /// Finds all hits with 0 < t, ordered by (t, prim_id).
    pub fn all_hits(&self, ray: &OracleRay) -> Vec<OracleHit> {
        self.integrator.search.all_after::<false>(ray, &START)
    }

    /// Finds all points with 0 < t at which a ray crosses surfaces, ordered by (t, prim_id): the
    /// hits of [`Oracle::all_hits`], and behind them the far sides of spheres, ellipsoids and
    /// cones. The hit of a ray with a filter is the first of a primitive's that it accepts.
    pub fn crossings(&self, ray: &OracleRay) -> Vec<OracleHit> {
        self.integrator.search.all_after::<true>(ray, &START)
    }

    /// Returns true if anything is hit with 0 < t < `tmax`, in units of the direction.
    ///
    /// ```
    /// # mod phalanx { pub use {glam, phalanx_oracle as oracle, phalanx_scene::*}; }
    /// use phalanx::glam::Vec3;
    /// use phalanx::oracle::{Oracle, OracleRay, OracleSearch};
    /// use phalanx::Scene;
    ///
    /// let mut scene = Scene::new();
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// let oracle = Oracle::new(&scene, OracleSearch::BruteForce);
    /// let ray = OracleRay::new(Vec3::new(-9.0, 0.0, 0.0), Vec3::X);
    /// assert!(oracle.occluded(&ray, 8.5));
    /// assert!(!oracle.occluded(&ray, 8.0));
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn occluded(&self, ray: &OracleRay, tmax: f32) -> bool {
        self.integrator.search.occluded(ray, tmax)
    }
}
