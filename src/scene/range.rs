//! Keeps coordinates where products of four of them neither overflow nor vanish in f32.

use super::{Scene, Vec3s};

/// Largest coordinate (as a power of two) that is left alone; beyond it, or below its inverse, the scene is scaled.
const COMFORT: f32 = 268_435_456.0; // 2^28

impl Scene {
    /// Scales the scene by an exact power of two where its largest coordinate lies outside \[2⁻²⁸, 2²⁸\], so that
    /// the largest becomes about 1. [`Scene::unit`] records the factor; the picture is the same picture.
    pub fn fit_range(&mut self) {
        let largest = self.largest_coordinate();
        if largest == 0.0 || (1.0 / COMFORT..=COMFORT).contains(&largest) {
            return;
        }
        let scale = libm::exp2(-(libm::log2(largest as f64)).round()) as f32;
        if !scale.is_normal() {
            return;
        }
        self.scale_by(scale);
    }

    fn largest_coordinate(&self) -> f32 {
        let bounds = self.bounds();
        let prims = if bounds.is_empty() {
            0.0
        } else {
            bounds.lo.abs().max(bounds.hi.abs()).max_element()
        };
        let eye = self
            .view
            .eye
            .abs()
            .max(self.view.center.abs())
            .max_element();
        let lights = (0..self.lights.len())
            .filter(|&i| !self.lights.directional[i])
            .map(|i| self.lights.place.get(i).abs().max_element());
        lights.fold(prims.max(eye), f32::max)
    }

    fn scale_by(&mut self, scale: f32) {
        self.unit *= scale;
        self.view.eye *= scale;
        self.view.center *= scale;
        let t = &mut self.triangles;
        for v in [&mut t.a, &mut t.b, &mut t.c, &mut self.spheres.center] {
            scale_all(v, scale);
        }
        self.spheres.radius.iter_mut().for_each(|r| *r *= scale);
        for column in &mut self.ellipsoids.to_world {
            scale_all(column, scale);
        }
        // Back from the scaled world: the matrix divides by the factor, the translation stays in object units.
        for column in &mut self.ellipsoids.to_object[..3] {
            scale_all(column, 1.0 / scale);
        }
        for i in 0..self.lights.len() {
            if !self.lights.directional[i] {
                let place = self.lights.place.get(i) * scale;
                self.lights.place.set(i, place);
                // The same attenuation at the scaled distance.
                let a = self.lights.attenuation.get(i);
                let per = |value: f32, factor: f64| ((value as f64 / factor) as f32).min(f32::MAX);
                let s = scale as f64;
                let scaled = glam::Vec3::new(a.x, per(a.y, s), per(a.z, s * s));
                self.lights.attenuation.set(i, scaled);
            }
        }
    }
}

fn scale_all(v: &mut Vec3s, scale: f32) {
    for part in [&mut v.x, &mut v.y, &mut v.z] {
        part.iter_mut().for_each(|c| *c *= scale);
    }
}
