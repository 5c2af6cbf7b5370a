//! Keeps coordinates where products of four of them neither overflow nor vanish in f32.

use super::{Scene, Vec3s};
use glam::{DVec3, Vec3};

/// Largest coordinate (as a power of two) that is left alone; beyond it, or below its inverse, the scene is scaled.
const COMFORT: f32 = 268_435_456.0; // 2^28

/// Largest colour that a light is given to make up for a dimmer attenuation: brighter than any picture can show, and
/// sums of it stay finite.
const BRIGHTEST: f64 = 1.2676506002282294e30; // 2^100

impl Scene {
    /// Scales the scene by an exact power of two where its largest coordinate lies outside \[2⁻²⁸, 2²⁸\], so that
    /// the largest becomes about 1. [`Scene::unit`] records the factor; the picture is the same picture.
    pub fn fit_range(&mut self) {
        let largest = self.largest_coordinate();
        let comfort = f64::from(COMFORT);
        if largest == 0.0 || !largest.is_finite() || (1.0 / comfort..=comfort).contains(&largest) {
            return;
        }
        // Bounded so that the factor and its inverse are both normal numbers: at the ends of f32's range the largest
        // coordinate comes out within COMFORT, if not at 1.
        let (_, exponent) = libm::frexp(largest);
        self.scale_by(libm::scalbn(1.0, (-exponent).clamp(-126, 126)) as f32);
    }

    /// In f64, where neither a corner of a sphere nor the square of an ellipsoid's axis overflows.
    fn largest_coordinate(&self) -> f64 {
        let of = |v: &Vec3s| {
            let parts = v.parts().map(|part| largest_magnitude(part));
            parts.into_iter().fold(0.0f32, f32::max)
        };
        let t = &self.triangles;
        let view = self.view.eye.abs().max(self.view.center.abs());
        let ends = of(&self.cones.base).max(of(&self.cones.apex));
        let radii = self.cones.base_radius.iter().chain(&self.cones.apex_radius);
        let cones = f64::from(ends) + f64::from(radii.fold(0.0f32, |most, r| most.max(*r)));
        let places = of(&self.instances.to_world[3]).max(of(&t.vertices));
        let points = cones.max(f64::from(places.max(view.max_element())));
        let spheres = (0..self.spheres.len()).map(|i| {
            let center = self.spheres.center.get(i).abs().max_element();
            f64::from(center) + f64::from(self.spheres.radius[i])
        });
        let ellipsoids = (0..self.ellipsoids.len()).map(|i| {
            let [x, y, z, center] = self.ellipsoids.world_columns(i).map(|c| c.as_dvec3());
            let squares = x * x + y * y + z * z;
            (center.abs() + squares.map(f64::sqrt)).max_element()
        });
        let lights = (0..self.lights.len())
            .filter(|&i| !self.lights.directional[i])
            .map(|i| f64::from(self.lights.place.get(i).abs().max_element()));
        let rest = spheres.chain(ellipsoids).chain(lights);
        rest.fold(points, f64::max)
    }

    fn scale_by(&mut self, scale: f32) {
        self.unit *= scale;
        self.view.eye *= scale;
        self.view.center *= scale;
        let cones = &mut self.cones;
        for v in [
            &mut self.triangles.vertices,
            &mut self.spheres.center,
            &mut cones.base,
            &mut cones.apex,
            // What a mesh holds is scaled too, so of an instance's maps only the translations change.
            &mut self.instances.to_world[3],
            &mut self.instances.to_object[3],
        ] {
            scale_all(v, scale);
        }
        for radii in [
            &mut self.spheres.radius,
            &mut cones.base_radius,
            &mut cones.apex_radius,
        ] {
            radii.iter_mut().for_each(|r| *r *= scale);
        }
        for column in &mut self.ellipsoids.to_world {
            scale_all(column, scale);
        }
        // Back from the scaled world: the matrix divides by the factor, the translation stays in object units.
        for column in &mut self.ellipsoids.to_object[..3] {
            scale_all(column, 1.0 / scale);
        }
        for i in (0..self.lights.len()).filter(|&i| !self.lights.directional[i]) {
            let place = self.lights.place.get(i) * scale;
            self.lights.place.set(i, place);
            let (attenuation, color) = scaled_attenuation(
                self.lights.attenuation.get(i),
                self.lights.color.get(i),
                scale,
            );
            self.lights.attenuation.set(i, attenuation);
            self.lights.color.set(i, color);
        }
    }
}

/// The attenuation that gives the same light at the scaled distance, (const, lin/s, quad/s²), and the colour with it.
/// Where the attenuation would leave f32, it and the colour are both multiplied by the same power of two.
fn scaled_attenuation(attenuation: Vec3, color: Vec3, scale: f32) -> (Vec3, Vec3) {
    let s = f64::from(scale);
    let scaled = attenuation.as_dvec3() / DVec3::new(1.0, s, s * s);
    let (_, exponent) = libm::frexp(scaled.max_element());
    if (-100..=100).contains(&exponent) {
        return (scaled.as_vec3(), color);
    }
    let common = libm::scalbn(1.0, -exponent);
    let bounded = |c: f64| c.clamp(-BRIGHTEST, BRIGHTEST) as f32;
    let color = (color.as_dvec3() * common).to_array().map(bounded);
    ((scaled * common).as_vec3(), Vec3::from_array(color))
}

/// In eight lanes, so that one comparison need not wait for the one before.
fn largest_magnitude(column: &[f32]) -> f32 {
    let mut most = [0.0f32; 8];
    let (blocks, rest) = column.as_chunks::<8>();
    for block in blocks {
        for (most, c) in most.iter_mut().zip(block) {
            *most = most.max(c.abs());
        }
    }
    let all = most.into_iter().chain(rest.iter().map(|c| c.abs()));
    all.fold(0.0, f32::max)
}

fn scale_all(v: &mut Vec3s, scale: f32) {
    for part in v.parts_mut() {
        part.iter_mut().for_each(|c| *c *= scale);
    }
}
