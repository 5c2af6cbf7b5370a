//! The interface that generators of standard scenes draw to, implemented by a scene, a file and a
//! counter.

use super::mesh_slice::{MeshSlice, Prepare, PreparedMesh};
use glam::DVec3;

/// Builds a standard scene call by call. Numbers are f64 throughout; rounding to f32 happens in the
/// builder.
///
/// The order of calls is the order of an NFF file: background and view, then all lights, then
/// materials and the shapes that have them. A builder that can fail (a file) keeps its first error
/// and returns it at the end.
pub trait SceneBuilder {
    /// Sets the camera and the size of the picture. Called once.
    fn view(&mut self, view: &StandardView);

    /// Sets the radiance of a ray that misses everything, linear RGB. Called once.
    fn background(&mut self, rgb: DVec3);

    /// Adds a point light. All lights come before the first surface.
    fn light(&mut self, light: &StandardLight);

    /// Sets the material of the shapes that follow.
    fn material(&mut self, material: &MaterialDesc);

    /// Adds a sphere.
    fn sphere(&mut self, center: DVec3, radius: f64);

    /// Adds an open-ended cone; a cylinder where both radii are equal.
    fn cone(&mut self, base: DVec3, base_radius: f64, apex: DVec3, apex_radius: f64);

    /// Adds a planar polygon, possibly concave, counter-clockwise from its front.
    fn polygon(&mut self, points: &[DVec3]);

    /// Adds a convex polygon of (point, normal) pairs; the normals are of any length but zero.
    fn patch(&mut self, points: &[(DVec3, DVec3)]);

    /// Adds triangles whose corners index `vertices`, counter-clockwise from their fronts. May be
    /// called many times: a generator of millions of triangles passes them in chunks of bounded
    /// size.
    fn mesh(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]]) {
        let mesh = self.preparation()(&[MeshSlice::complete(vertices, triangles)], 0);
        self.prepared(mesh);
    }

    /// Offers the number of mesh triangles before they come. A builder for which it is enough
    /// (true) receives none of the triangles; any other receives all of them.
    fn takes_count(&mut self, _triangles: u64) -> bool {
        false
    }

    /// Number of threads on which meshes may be drawn and prepared; 0 for one per CPU.
    fn threads(&self) -> usize {
        1
    }

    /// The part of a mesh's way into this builder that any thread can do.
    fn preparation(&self) -> Box<Prepare>;

    /// Adds a mesh of [`SceneBuilder::preparation`], in the order of the calls.
    fn prepared(&mut self, mesh: PreparedMesh);
}

/// The camera of a standard scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandardView {
    /// Eye position.
    pub from: DVec3,
    /// The point looked at.
    pub at: DVec3,
    /// Up vector.
    pub up: DVec3,
    /// Vertical angle of the whole image height, in degrees. See [`StandardView::of_pixel_centres`]
    /// for NFF's angle.
    pub fovy: f64,
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
}

impl StandardView {
    /// The whole image's angle if `angle` (degrees) spans the centre of the first pixel row to that
    /// of the last, as in NFF. A picture of one row has no such angle and gets `angle` itself.
    pub fn of_pixel_centres(angle: f64, height: u32) -> f64 {
        scaled_angle(angle, f64::from(height), f64::from(height) - 1.0)
    }

    /// NFF's angle, in degrees: the inverse of [`StandardView::of_pixel_centres`].
    pub fn angle_of_pixel_centres(&self) -> f64 {
        let height = f64::from(self.height);
        scaled_angle(self.fovy, height - 1.0, height)
    }
}

/// The angle whose half has a tangent of `numerator / denominator` times that of half of `degrees`.
fn scaled_angle(degrees: f64, numerator: f64, denominator: f64) -> f64 {
    if numerator <= 0.0 || denominator <= 0.0 {
        return degrees;
    }
    let half = libm::tan(degrees.to_radians() / 2.0) * numerator / denominator;
    2.0 * libm::atan(half).to_degrees()
}

/// A point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandardLight {
    /// Position.
    pub position: DVec3,
    /// Colour, linear RGB. `None` is NFF's light without a colour: white of level √n/(2n) for a
    /// total of n lights, so that scenes are about equally bright with any number of lights. Either
    /// all lights of a scene have a colour or none.
    pub color: Option<DVec3>,
    /// Attenuation (const, lin, quad); (1, 0, 0) is none.
    pub attenuation: DVec3,
}

impl StandardLight {
    /// A light of NFF's level, without attenuation.
    pub fn of_level(position: DVec3) -> Self {
        StandardLight {
            position,
            color: None,
            attenuation: DVec3::X,
        }
    }

    /// A light of this colour, without attenuation.
    pub fn colored(position: DVec3, color: DVec3) -> Self {
        StandardLight {
            color: Some(color),
            ..Self::of_level(position)
        }
    }
}

/// A material, in the terms of NFF or of the design document.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaterialDesc {
    /// Parameters of NFF.
    Nff(NffMaterial),
    /// Parameters of the design document, which [`phalanx_scene::Materials`] holds.
    Document(DocumentMaterial),
}

impl MaterialDesc {
    /// The document's parameters, in a scene of this ambient level:
    /// [`nff_level`](crate::nff_level).
    pub fn to_document(&self, level: f64) -> DocumentMaterial {
        match self {
            MaterialDesc::Nff(material) => material.to_document(level),
            MaterialDesc::Document(material) => *material,
        }
    }
}

/// A material in the terms of NFF's `f` record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NffMaterial {
    /// Colour, linear RGB.
    pub rgb: DVec3,
    /// Diffuse part of `rgb`.
    pub kd: f64,
    /// Specular part, white.
    pub ks: f64,
    /// Phong exponent, taken as Blinn's.
    pub shine: f64,
    /// Transmittance, white.
    pub transmittance: f64,
    /// Index of refraction; 0 if the original databases leave it open (treated as 1).
    pub ior: f64,
}

/// A material by the document's parameters, linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DocumentMaterial {
    /// Ambient.
    pub ka: DVec3,
    /// Emission.
    pub ke: DVec3,
    /// Diffuse.
    pub kd: DVec3,
    /// Specular and mirror.
    pub ks: DVec3,
    /// Transmission.
    pub kt: DVec3,
    /// Blinn exponent.
    pub shininess: f64,
    /// Index of refraction, positive.
    pub ior: f64,
}

impl Default for DocumentMaterial {
    /// Black, dull and opaque.
    fn default() -> Self {
        DocumentMaterial {
            ka: DVec3::ZERO,
            ke: DVec3::ZERO,
            kd: DVec3::ZERO,
            ks: DVec3::ZERO,
            kt: DVec3::ZERO,
            shininess: 1.0,
            ior: 1.0,
        }
    }
}

impl NffMaterial {
    /// The document's parameters in a scene of this ambient level: Ka = level·Kd·rgb, diffuse
    /// Kd·rgb, the rest white.
    ///
    /// The product is that of the numbers rounded to single precision, so that it is the same for a
    /// generated material and for one that was read from a generated file.
    pub fn to_document(&self, level: f64) -> DocumentMaterial {
        let kd = self.rgb.as_vec3().as_dvec3() * f64::from(self.kd as f32);
        DocumentMaterial {
            ka: kd * level,
            ke: DVec3::ZERO,
            kd,
            ks: DVec3::splat(self.ks),
            kt: DVec3::splat(self.transmittance),
            shininess: self.shine,
            ior: if self.ior > 0.0 { self.ior } else { 1.0 },
        }
    }
}
