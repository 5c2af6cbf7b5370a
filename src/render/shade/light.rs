//! One light on eight surface points: attenuation (design document, "Lighting model") and the
//! Blinn-Phong terms ("Shading model"), before visibility. Each point may have its own position on
//! an area light.

use super::material::ShadeMaterial;
use super::pow::pow;
use super::surface::Surface;
use super::wide;
use glam::Vec3;
use phalanx_scene::sampling::{self, Dimension};
use phalanx_scene::{LightShape, Scene};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};

/// Unoccluded contribution of one light to eight points, and the shadow rays that test its
/// visibility.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Lanes where the light adds something: it faces the surface and its term is not zero.
    pub needed: Mask8,
    /// L_i (Kd max(l·n, 0) + Ks max(h·n, 0)^s).
    pub radiance: Vec3x8,
    /// Shadow ray origin: the hit point, offset toward the viewer.
    pub org: Vec3x8,
    /// Shadow ray direction toward the light: L − P for a point light, the unit direction for a
    /// directional one.
    pub dir: Vec3x8,
}

impl LightSample {
    /// A light that none of the points sees.
    fn none() -> LightSample {
        LightSample {
            needed: Mask8::none(),
            radiance: Vec3x8::ZERO,
            org: Vec3x8::ZERO,
            dir: Vec3x8::ZERO,
        }
    }

    /// Weighs the light by the coverage of the surfaces that it falls on.
    pub fn weigh(&mut self, share: F32x8) {
        self.radiance = self.radiance.scale(share);
        self.needed = self.needed & is_nonzero(self.radiance);
    }
}

/// Position of a light, for points reached by rays of these seeds. All points get the same
/// position, except on an area light.
pub fn sample_light_position(
    scene: &Scene,
    light: usize,
    seeds: [u32; LANES],
    sample: u32,
) -> Vec3x8 {
    let lights = &scene.lights;
    let position = wide(lights.position.get(light));
    let square = || sampling::points(seeds, sample, Dimension::Light(light as u32));
    match lights.shape(light) {
        LightShape::Point | LightShape::Directional => position,
        LightShape::Sphere(radius) => {
            let [x, y, z] = sampling::uniform_sphere(square()).map(F32x8::new);
            position + Vec3x8::new(x, y, z).scale(F32x8::splat(radius))
        }
        LightShape::Rectangle([e, f]) => {
            let [u, v] = square().map(F32x8::new);
            (position + wide(e).scale(u)) + wide(f).scale(v)
        }
    }
}

/// Evaluates light `light` at position `position` for a batch. `tint` is the colour that the
/// material's is multiplied with, if there is one.
pub fn sample_light(
    scene: &Scene,
    light: usize,
    position: Vec3x8,
    material: &ShadeMaterial,
    tint: Option<&Vec3x8>,
    at: &Surface,
) -> LightSample {
    let lights = &scene.lights;
    let color = wide(lights.color.get(light));
    let (dir, to_light, radiance, lit) = if lights.directional[light] {
        (position, position, color, at.active)
    } else {
        let to = position - at.point;
        let squared = to.dot(to);
        let distance = squared.sqrt();
        let a = wide(lights.attenuation.get(light));
        let loss = (a.x + a.y * distance) + a.z * squared;
        let mut seen = Vec3x8::new(color.x / loss, color.y / loss, color.z / loss);
        let to_light = to.scale(F32x8::ONE / distance);
        if lights.is_spot(light) {
            seen = seen.scale(spot(scene, light, to_light));
        }
        // The light adds nothing if the denominator is zero (d = 0, no constant term).
        let lit = at.active & loss.gt(F32x8::ZERO);
        (to, to_light, seen, lit)
    };
    let lit = lit & to_light.dot(at.ng).gt(F32x8::ZERO);
    if !lit.any() {
        return LightSample::none();
    }
    let diffuse = positive(to_light.dot(at.ns));
    let specular = if material.ks == Vec3::ZERO {
        F32x8::ZERO
    } else {
        let half = (to_light - at.dir).normalized();
        pow(positive(half.dot(at.ns)), material.shininess)
    };
    let kd = wide(material.kd);
    let kd = tint.map_or(kd, |tint| kd.mul_elementwise(*tint));
    let lobe = kd.scale(diffuse) + wide(material.ks).scale(specular);
    let radiance = radiance.mul_elementwise(lobe);
    LightSample {
        needed: lit & is_nonzero(radiance),
        radiance,
        org: at.point + at.ng.scale(at.offset),
        dir,
    }
}

/// Part of a spot light's light at points from which it is seen along unit vectors `to_light`:
/// [`Lights::add_spot`](phalanx_scene::Lights::add_spot).
fn spot(scene: &Scene, light: usize, to_light: Vec3x8) -> F32x8 {
    let axis = wide(scene.lights.axis.get(light));
    let cone = scene.lights.cone.get(light);
    let cos = -to_light.dot(axis);
    let part = cos * F32x8::splat(cone.x) + F32x8::splat(cone.y);
    let part = positive(part).min(F32x8::ONE);
    part * part
}

/// Lanes that have a component other than zero, and no NaN component.
fn is_nonzero(v: Vec3x8) -> Mask8 {
    let any = |c: F32x8| c.lt(F32x8::ZERO) | c.gt(F32x8::ZERO);
    let number = v.x.eq(v.x) & v.y.eq(v.y) & v.z.eq(v.z);
    number & (any(v.x) | any(v.y) | any(v.z))
}

/// max(x, 0), with 0 for NaN.
fn positive(x: F32x8) -> F32x8 {
    x.max(F32x8::ZERO)
}
