//! Mirror and refracted rays (design document, "Recursive shading model": … + Ks I_R + K_T I_T).

use super::surface::{Material, Surface};
use super::wide;
use crate::lanes::{F32x8, LaneMask, Lanes, Mask8, Vec3x8};
use glam::Vec3;

/// The secondary rays of eight points. A ray whose weight is exactly zero is not among them.
#[derive(Clone, Copy, Debug)]
pub struct Bounces {
    /// Lanes that send a mirror ray.
    pub reflect: Mask8,
    /// Its origin, unit direction and weight: Ks, or Ks + Kt on total internal reflection.
    pub reflect_org: Vec3x8,
    /// Unit direction.
    pub reflect_dir: Vec3x8,
    /// RGB weight.
    pub reflect_weight: Vec3x8,
    /// Lanes that send a refracted ray, of weight Kt.
    pub refract: Mask8,
    /// Its origin.
    pub refract_org: Vec3x8,
    /// Unit direction.
    pub refract_dir: Vec3x8,
}

/// Mirror direction d − 2(d·n)n, and Snell's law with η = 1/ior entering and ior leaving (Glassner, "An Introduction
/// to Ray Tracing", 1989): k = 1 − η²(1 − cos²); below zero the reflection is total.
pub fn bounces(material: &Material, at: &Surface) -> Bounces {
    let (d, n) = (at.dir, at.ns);
    let along = d.dot(n);
    let mirror = d - n.scale(F32x8::splat(2.0) * along);
    let reflect_dir = mirror.normalized();
    let cos = -along;
    let eta = at
        .entering
        .select(F32x8::splat(1.0 / material.ior), F32x8::splat(material.ior));
    let k = F32x8::ONE - (eta * eta) * (F32x8::ONE - cos * cos);
    let transmits = material.kt != Vec3::ZERO;
    let total = if transmits {
        k.lt(F32x8::ZERO)
    } else {
        Mask8::none()
    };
    let bent = d.scale(eta) + n.scale(eta * cos - k.sqrt());
    let refract_dir = bent.normalized();
    let both = material.ks + material.kt;
    let (ks, both_wide) = (wide(material.ks), wide(both));
    let reflects = |weight: Vec3| {
        if weight != Vec3::ZERO {
            !Mask8::none()
        } else {
            Mask8::none()
        }
    };
    let reflect = (total & reflects(both)) | (!total & reflects(material.ks));
    Bounces {
        reflect: at.active & reflect,
        reflect_org: leave(at, reflect_dir),
        reflect_dir,
        reflect_weight: Vec3x8::select(total, both_wide, ks),
        refract: if transmits {
            at.active & !total
        } else {
            Mask8::none()
        },
        refract_org: leave(at, refract_dir),
        refract_dir,
    }
}

/// The offset origin, on the side of the surface the direction points to.
fn leave(at: &Surface, dir: Vec3x8) -> Vec3x8 {
    let outward = dir.dot(at.ng).ge(F32x8::ZERO);
    at.point + at.ng.scale(outward.select(at.offset, -at.offset))
}
