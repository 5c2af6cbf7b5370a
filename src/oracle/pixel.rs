//! A pixel while its camera rays come in, and when they are all there.

use super::intersect::{Hit, Ray};
use glam::Vec3;
use phalanx_scene::sampling::Gathered;

/// Light by the way it came.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Parts {
    pub(super) direct: Vec3,
    pub(super) reflection: Option<Vec3>,
    pub(super) refraction: Option<Vec3>,
}

impl Parts {
    /// (direct + reflection) + refraction, of those that there are.
    pub(super) fn sum(&self) -> Vec3 {
        let bounced = self.reflection.into_iter().chain(self.refraction);
        bounced.fold(self.direct, |sum, part| sum + part)
    }

    /// Black where there is none.
    pub(super) fn all(&self) -> [Vec3; 3] {
        [
            self.direct,
            self.reflection.unwrap_or_default(),
            self.refraction.unwrap_or_default(),
        ]
    }
}

/// What came of a camera ray.
pub(super) struct Sample {
    pub(super) ray: Ray,
    pub(super) hit: Option<Hit>,
    pub(super) light: Parts,
    pub(super) weight: f32,
}

/// A pixel.
#[derive(Clone, Copy, Debug)]
pub struct Pixel {
    /// Its radiance.
    pub radiance: Vec3,
    /// Direct, reflected and refracted light: means of their own.
    pub light: [Vec3; 3],
    /// Its first camera ray, and what that hit.
    pub first: Option<(Ray, Option<Hit>)>,
    /// How many camera rays it has.
    pub samples: u32,
}

/// A pixel to be.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gathering {
    radiance: Gathered,
    light: [Gathered; 3],
    first: Option<(Ray, Option<Hit>)>,
    samples: u32,
    /// What the first camera ray gave, which is all there is to a pixel of one.
    only: [Vec3; 4],
}

impl Gathering {
    pub(super) fn add(&mut self, sample: Sample) {
        let Sample {
            ray,
            hit,
            light,
            weight,
        } = sample;
        let parts = light.all();
        self.radiance.add(light.sum().to_array(), weight);
        for (gathered, part) in self.light.iter_mut().zip(parts) {
            gathered.add(part.to_array(), weight);
        }
        if self.samples == 0 {
            self.first = Some((ray, hit));
            let [direct, reflection, refraction] = parts;
            self.only = [light.sum(), direct, reflection, refraction];
        }
        self.samples += 1;
    }

    /// What all samples so far have given.
    pub(super) fn radiance(&self) -> Gathered {
        self.radiance
    }

    pub(super) fn finish(&self) -> Pixel {
        let [radiance, light @ ..] = match self.samples {
            1 => self.only,
            _ => {
                let [direct, reflection, refraction] = &self.light;
                let all = [&self.radiance, direct, reflection, refraction];
                all.map(|gathered| gathered.mean().into())
            }
        };
        Pixel {
            radiance,
            light,
            first: self.first,
            samples: self.samples,
        }
    }
}
