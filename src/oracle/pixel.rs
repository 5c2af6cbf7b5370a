//! A pixel, and the accumulator of its camera rays.

use super::intersect::{OracleHit, OracleRay};
use glam::Vec3;
use phalanx_scene::sampling::{PixelAccumulator, PixelCoverage, SurfaceShare};

/// Radiance by the path along which it came.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RadianceParts {
    pub(super) direct: Vec3,
    pub(super) reflection: Option<Vec3>,
    pub(super) refraction: Option<Vec3>,
    /// Light that passes through the hit, where the surface is not fully opaque.
    pub(super) passed: Option<Vec3>,
}

impl RadianceParts {
    /// ((direct + reflection) + refraction) + passed, of the parts that exist.
    pub(super) fn sum(&self) -> Vec3 {
        let bounced = [self.reflection, self.refraction, self.passed];
        bounced
            .into_iter()
            .flatten()
            .fold(self.direct, |sum, part| sum + part)
    }

    /// Direct, reflected and refracted light, the last with the light that passed; black for parts
    /// that do not exist.
    pub(super) fn all(&self) -> [Vec3; 3] {
        [
            self.direct,
            self.reflection.unwrap_or_default(),
            self.refraction.unwrap_or_default() + self.passed.unwrap_or_default(),
        ]
    }
}

/// Result of a camera ray.
pub(super) struct OracleSample {
    pub(super) ray: OracleRay,
    pub(super) hit: Option<OracleHit>,
    pub(super) light: RadianceParts,
    pub(super) weight: f32,
    /// All surfaces that the ray sees, if mattes are requested.
    pub(super) surfaces: Vec<SurfaceShare>,
}

/// A finished pixel.
#[derive(Clone, Debug)]
pub struct OraclePixel {
    /// Mean radiance.
    pub radiance: Vec3,
    /// Mean direct, reflected and refracted light.
    pub light: [Vec3; 3],
    /// First camera ray, and its hit.
    pub first: Option<(OracleRay, Option<OracleHit>)>,
    /// Number of camera rays.
    pub samples: u32,
    /// Surfaces that all camera rays see; empty unless mattes are requested.
    pub coverage: PixelCoverage,
}

/// Accumulates a pixel's samples.
#[derive(Clone, Debug, Default)]
pub(super) struct OraclePixelAccumulator {
    radiance: PixelAccumulator,
    light: [PixelAccumulator; 3],
    first: Option<(OracleRay, Option<OracleHit>)>,
    samples: u32,
    coverage: PixelCoverage,
    /// Result of the first camera ray, which is the whole result of a pixel with one ray.
    first_samples: [Vec3; 4],
}

impl OraclePixelAccumulator {
    pub(super) fn add(&mut self, sample: OracleSample) {
        let OracleSample {
            ray,
            hit,
            light,
            weight,
            surfaces,
        } = sample;
        self.coverage.add(surfaces, weight, 1.0);
        let parts = light.all();
        self.radiance.add(light.sum().to_array(), weight);
        for (gathered, part) in self.light.iter_mut().zip(parts) {
            gathered.add(part.to_array(), weight);
        }
        if self.samples == 0 {
            self.first = Some((ray, hit));
            let [direct, reflection, refraction] = parts;
            self.first_samples = [light.sum(), direct, reflection, refraction];
        }
        self.samples += 1;
    }

    /// The accumulated radiance of all samples so far.
    pub(super) fn radiance(&self) -> PixelAccumulator {
        self.radiance
    }

    pub(super) fn finish(&self) -> OraclePixel {
        let [radiance, light @ ..] = match self.samples {
            1 => self.first_samples,
            _ => {
                let [direct, reflection, refraction] = &self.light;
                let all = [&self.radiance, direct, reflection, refraction];
                all.map(|gathered| gathered.mean().into())
            }
        };
        OraclePixel {
            radiance,
            light,
            first: self.first,
            samples: self.samples,
            coverage: self.coverage.clone(),
        }
    }
}
