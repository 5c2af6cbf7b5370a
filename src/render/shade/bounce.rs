//! Mirror and refracted rays (design document, "Recursive shading model": … + Ks I_R + K_T I_T),
//! and glossy mirror rays.

use super::material::{ShadeMaterial, is_not_zero};
use super::normal_map::in_front;
use super::surface::Surface;
use super::wide;
use glam::Vec3;
use phalanx_scene::sampling::{self, Dimension};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};

/// Bounces of one kind from eight points.
#[derive(Clone, Copy, Debug)]
pub struct BounceRays {
    /// Lanes that send a ray. Rays whose weight is exactly zero are excluded.
    pub active: Mask8,
    /// Origins.
    pub org: Vec3x8,
    /// Unit directions.
    pub dir: Vec3x8,
    /// RGB weights.
    pub weight: Vec3x8,
}

/// The secondary rays of eight points.
#[derive(Clone, Copy, Debug)]
pub struct SecondaryRays {
    /// Mirror rays, of weight Ks, or Ks + Kt on total internal reflection.
    pub mirror: BounceRays,
    /// Refracted rays, of weight Kt.
    pub refracted: BounceRays,
}

/// Mirror direction d − 2(d·n)n, and Snell's law with η = 1/ior entering and ior leaving (Glassner,
/// "An Introduction to Ray Tracing", 1989): k = 1 − η²(1 − cos²); below zero the reflection is
/// total.
pub fn bounces(material: &ShadeMaterial, surface: &Surface) -> SecondaryRays {
    let (d, n) = (surface.dir, surface.ns);
    let along = d.dot(n);
    let mirror = d - n.scale(F32x8::splat(2.0) * along);
    let mut reflect_dir = mirror.normalized();
    if surface.bumped {
        // Relief that has no geometry must not send a mirror ray into the surface.
        reflect_dir = in_front(reflect_dir, surface.ng);
    }
    let cos = -along;
    let eta = surface.entering.select(
        F32x8::splat(1.0 / material.ior()),
        F32x8::splat(material.ior()),
    );
    let k = F32x8::ONE - (eta * eta) * (F32x8::ONE - cos * cos);
    let transmits = material.kt() != Vec3::ZERO;
    let total = if transmits { k.lt(F32x8::ZERO) } else { Mask8::none() };
    let bent = d.scale(eta) + n.scale(eta * cos - k.sqrt());
    let refract_dir = bent.normalized();
    let both = material.ks() + wide(material.kt());
    let reflect = (total & is_not_zero(both)) | (!total & material.shines());
    SecondaryRays {
        mirror: BounceRays {
            active: surface.active & reflect,
            org: offset_origin(surface, reflect_dir),
            dir: reflect_dir,
            weight: Vec3x8::select(total, both, material.ks()),
        },
        refracted: BounceRays {
            active: if transmits { surface.active & !total } else { Mask8::none() },
            org: offset_origin(surface, refract_dir),
            dir: refract_dir,
            weight: wide(material.kt()),
        },
    }
}

/// Samples the glossy lobe around the mirror rays of eight points, for a gloss above 0. The points
/// were reached by rays of these seeds. One ray represents the whole lobe, with its full weight. It
/// stays on the same side of the geometric surface as the mirror ray.
pub fn sample_glossy(
    rays: &mut BounceRays,
    surface: &Surface,
    gloss: f32,
    seeds: [u32; LANES],
    sample: u32,
) {
    let mirror = rays.dir;
    let lobe = sampling::phong_lobe(sampling::points(seeds, sample, Dimension::Gloss), gloss);
    let dir = mirror_into_hemisphere(surface, to_world(lobe, mirror), mirror).normalized();
    rays.dir = dir;
    rays.org = offset_origin(surface, dir);
}

/// Origins and unit directions of ambient occlusion rays, one from each of eight points, which rays
/// of these seeds reached. Directions are cosine-distributed about the shading normal, and on the
/// outside of the geometric surface.
pub fn sample_ao_ray(surface: &Surface, seeds: [u32; LANES], sample: u32) -> (Vec3x8, Vec3x8) {
    let local = sampling::cosine_hemisphere(sampling::points(seeds, sample, Dimension::Sky));
    let dir = in_front(to_world(local, surface.ns), surface.ng).normalized();
    (offset_origin(surface, dir), dir)
}

/// Rotates vectors from a frame whose z axis is `axis` into the world; axes are unit vectors.
fn to_world(local: [[f32; LANES]; 3], axis: Vec3x8) -> Vec3x8 {
    let axis = [axis.x, axis.y, axis.z].map(F32x8::to_array);
    let [x, y, z] = sampling::to_frame(local, axis).map(F32x8::new);
    Vec3x8::new(x, y, z)
}

/// Directions on the same side of the geometric surface as `inner` do not change; others are
/// mirrored at the surface.
fn mirror_into_hemisphere(surface: &Surface, dir: Vec3x8, inner: Vec3x8) -> Vec3x8 {
    let along = dir.dot(surface.ng);
    let (out, right) = (along.ge(F32x8::ZERO), inner.dot(surface.ng).ge(F32x8::ZERO));
    let turned = dir - surface.ng.scale(F32x8::splat(2.0) * along);
    Vec3x8::select((out & right) | (!out & !right), dir, turned)
}

/// The offset origin, on the side of the surface the direction points to.
fn offset_origin(surface: &Surface, dir: Vec3x8) -> Vec3x8 {
    let outward = dir.dot(surface.ng).ge(F32x8::ZERO);
    surface.point
        + surface
            .ng
            .scale(outward.select(surface.offset, -surface.offset))
}
