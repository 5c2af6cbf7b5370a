//! One light on eight surface points: attenuation (design document, "Lighting model") and the
//! Blinn-Phong terms ("Shading model"), before visibility. Each point may have its own position on
//! an area light.

use super::material::ShadeMaterial;
use super::pow::pow;
use super::surface::{Surface, may_point_along};
use super::terminator::TerminatorShift;
use super::wide;
use glam::{Vec2, Vec3};
use phalanx_scene::sampling::{self, Dimension};
use phalanx_scene::{LightShape, Scene};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};

/// Unoccluded contribution of one light to eight points, and the shadow rays that test its
/// visibility.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Lanes in which the light contributes: it faces the surface and its term is not zero.
    pub needed: Mask8,
    /// L_i (Kd max(l·n, 0) + Ks max(h·n, 0)^s), and the highlight without a mirror:
    /// [`Material::highlight`](phalanx_scene::Material::highlight).
    pub radiance: Vec3x8,
    /// Lanes whose facet faces away from a light that the smooth surface faces.
    pub beneath: Mask8,
    /// Shadow ray origin: the hit point, offset toward the viewer, or away from it in lanes of
    /// `beneath`.
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
            beneath: Mask8::none(),
            org: Vec3x8::ZERO,
            dir: Vec3x8::ZERO,
        }
    }

    /// Weights the light by the coverage of the surfaces that it falls on.
    pub fn weigh(&mut self, share: F32x8) {
        self.radiance = self.radiance.scale(share);
        self.needed = self.needed & is_nonzero(self.radiance);
    }
}

/// One light, read once for all points at which it is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct ShadeLight {
    index: usize,
    shape: LightShape,
    /// Position, or the unit vector toward a directional light.
    position: Vec3,
    color: Vec3,
    attenuation: Vec3,
    /// The cone of a spot light: see [`Lights::add_spot`](phalanx_scene::Lights::add_spot).
    spot: Option<(Vec3, Vec2)>,
}

impl ShadeLight {
    /// Reads one row of the columns.
    pub fn of(scene: &Scene, index: usize) -> ShadeLight {
        let lights = &scene.lights;
        let spot = (lights.axis.get(index), lights.cone.get(index));
        ShadeLight {
            index,
            shape: lights.shape(index),
            position: lights.position.get(index),
            color: lights.color.get(index),
            attenuation: lights.attenuation.get(index),
            spot: lights.is_spot(index).then_some(spot),
        }
    }

    /// Returns true if each point may get a position of its own.
    pub fn is_area(&self) -> bool {
        self.shape.is_area()
    }

    /// Positions for points reached by rays of these seeds. All points get the same position,
    /// except on an area light.
    pub fn sample_position(&self, seeds: [u32; LANES], sample: u32) -> Vec3x8 {
        let position = wide(self.position);
        let square = || sampling::points(seeds, sample, Dimension::Light(self.index as u32));
        match self.shape {
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

    /// Lanes that may face the light by the geometric or the interpolated normal: all of them if
    /// the light is an area light or a normal map hides the latter.
    pub(crate) fn may_face(&self, surface: &Surface) -> Mask8 {
        let toward = match self.shape {
            LightShape::Directional if !surface.bumped => wide(self.position),
            LightShape::Point if !surface.bumped => wide(self.position) - surface.point,
            _ => return surface.active,
        };
        may_point_along(surface.ng, toward) | may_point_along(surface.ns, toward)
    }

    /// Evaluates the light at position `position` for a batch. Hits beneath the smooth surface
    /// `above` face the light by its normal.
    ///
    /// Inlined by force: it has one caller, the loop over surfaces.
    #[inline(always)]
    pub fn sample(
        &self,
        position: Vec3x8,
        material: &ShadeMaterial,
        surface: &Surface,
        above: Option<&TerminatorShift>,
    ) -> LightSample {
        let (dir, to_light, radiance, lit) = self.radiance_at(position, surface);
        let faces = |normal: Vec3x8| to_light.dot(normal).gt(F32x8::ZERO);
        let facet = faces(surface.ng);
        let smooth = above.map(|above| (above.smooth, faces(above.normal)));
        let (facing, beneath) = match smooth {
            Some((smooth, faces)) => ((smooth & faces) | (!smooth & facet), smooth & !facet),
            None => (facet, Mask8::none()),
        };
        let lit = lit & facing;
        if !lit.any() {
            return LightSample::none();
        }
        let diffuse = positive(to_light.dot(surface.ns));
        let highlight = material.highlight();
        let specular = if highlight.is_some() || material.shines().any() {
            let half = (to_light - surface.dir).normalized();
            pow(positive(half.dot(surface.ns)), material.shininess())
        } else {
            F32x8::ZERO
        };
        let mut lobe = material.kd().scale(diffuse) + material.ks().scale(specular);
        if let Some((highlight, lanes)) = highlight {
            let both = lobe + highlight.scale(specular * diffuse);
            lobe = Vec3x8::select(lanes, both, lobe);
        }
        let radiance = radiance.mul_elementwise(lobe);
        LightSample {
            needed: lit & is_nonzero(radiance),
            radiance,
            beneath,
            org: surface.point
                + surface
                    .ng
                    .scale(beneath.select(-surface.offset, surface.offset)),
            dir,
        }
    }

    /// The direction of the shadow rays, the unit vectors toward the light, its unoccluded
    /// radiance, and the lanes that it reaches.
    #[inline(always)]
    fn radiance_at(&self, position: Vec3x8, surface: &Surface) -> (Vec3x8, Vec3x8, Vec3x8, Mask8) {
        let color = wide(self.color);
        if self.shape == LightShape::Directional {
            return (position, position, color, surface.active);
        }
        let to = position - surface.point;
        let squared = to.dot(to);
        let distance = squared.sqrt();
        let a = wide(self.attenuation);
        let loss = (a.x + a.y * distance) + a.z * squared;
        let mut seen = Vec3x8::new(color.x / loss, color.y / loss, color.z / loss);
        let to_light = to.scale(F32x8::ONE / distance);
        if let Some(cone) = self.spot {
            seen = seen.scale(share_of_spot(cone, to_light));
        }
        // The light adds nothing if the denominator is zero (d = 0, no constant term).
        (to, to_light, seen, surface.active & loss.gt(F32x8::ZERO))
    }
}

/// Share of a spot light's light at points with unit vectors `to_light` toward it:
/// [`Lights::add_spot`](phalanx_scene::Lights::add_spot).
fn share_of_spot((axis, cone): (Vec3, Vec2), to_light: Vec3x8) -> F32x8 {
    let cos = -to_light.dot(wide(axis));
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
