//! The scene: structure-of-arrays columns, one per attribute, and nothing that depends on how they are traced.
//!
//! A [`Scene`] is built by a reader in [`crate::formats`] (or by hand) and checked once with [`Scene::validate`]; after
//! that nothing downstream can fail. Primitives are numbered in file order: `prim_id` indexes [`Scene::prims`], which
//! says in which column the primitive lives. Units are the scene's own, angles degrees, colours linear RGB.

mod columns;
mod range;
mod validate;
mod view;

pub use columns::{
    Bounds, Ellipsoids, Lights, Materials, NO_NORMALS, PAD, Prim, PrimKind, Spheres, Triangles,
    Vec3s,
};
pub use validate::{MAX_DEPTH_LIMIT, MAX_PIXELS, MAX_SIDE, SceneError, check_image_size};
pub use view::{Basis, View, ViewError};

use glam::Vec3;

/// How linear radiance becomes sample values in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tone {
    /// Transfer curve applied after clamping to \[0, 1\].
    pub transfer: Transfer,
    /// How 255·c becomes an integer.
    pub quantize: Quantize,
}

/// Transfer curve of the written file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// Linear values are written as they are (the `.test` convention).
    None,
    /// The sRGB curve of IEC 61966-2-1.
    Srgb,
}

/// Quantisation of 255·c.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantize {
    /// `floor(255 c)`, the `.test` convention, measured against independent renderings.
    Floor,
    /// Nearest, halves up.
    Round,
}

/// Everything a picture depends on. Public columns, so that generators and readers can fill them directly.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Image width in pixels, 1 to [`MAX_SIDE`].
    pub width: u32,
    /// Image height in pixels, 1 to [`MAX_SIDE`].
    pub height: u32,
    /// Bounces after the primary ray, 0 to [`MAX_DEPTH_LIMIT`].
    pub max_depth: u32,
    /// Output name the file asks for: a bare file name, no folders.
    pub output: Option<String>,
    /// Radiance of a ray that misses everything.
    pub background: Vec3,
    /// How the format wants its pictures written.
    pub tone: Tone,
    /// Camera.
    pub view: View,
    /// Which column each `prim_id` lives in, in file order.
    pub prims: Vec<Prim>,
    /// Spheres under a similarity transform.
    pub spheres: Spheres,
    /// Spheres under any other affine transform.
    pub ellipsoids: Ellipsoids,
    /// Triangles with face or vertex normals.
    pub triangles: Triangles,
    /// Surface parameters, shared between primitives.
    pub materials: Materials,
    /// Lights in file order; their sum follows that order.
    pub lights: Lights,
    /// Scene units per file unit: a power of two, 1 unless the file's extent left f32's comfortable range.
    pub unit: f32,
}

impl Default for Scene {
    fn default() -> Self {
        Scene {
            width: 640,
            height: 480,
            max_depth: 5,
            output: None,
            background: Vec3::ZERO,
            tone: Tone {
                transfer: Transfer::None,
                quantize: Quantize::Floor,
            },
            view: View {
                eye: Vec3::new(0.0, 0.0, 1.0),
                center: Vec3::ZERO,
                up: Vec3::Y,
                fovy: 45.0,
            },
            prims: Vec::new(),
            spheres: Spheres::default(),
            ellipsoids: Ellipsoids::default(),
            triangles: Triangles::default(),
            materials: Materials::default(),
            lights: Lights::default(),
            unit: 1.0,
        }
    }
}

impl Scene {
    /// Number of primitives of all kinds.
    pub fn prim_count(&self) -> usize {
        self.prims.len()
    }

    /// Adds a sphere and returns its `prim_id`.
    pub fn add_sphere(&mut self, center: Vec3, radius: f32, material: u32) -> u32 {
        let index = self.spheres.len();
        self.spheres.center.push(center);
        self.spheres.radius.push(radius);
        self.spheres.material.push(material);
        self.add_prim(PrimKind::Sphere, index)
    }

    /// Adds the unit sphere under an affine map given both ways; returns its `prim_id`.
    ///
    /// `to_world` takes object space (where the sphere has radius 1 about the origin) to the world, `to_object` back.
    pub fn add_ellipsoid(
        &mut self,
        to_world: glam::Affine3A,
        to_object: glam::Affine3A,
        material: u32,
    ) -> u32 {
        let index = self.ellipsoids.len();
        self.ellipsoids.push(to_world, to_object, material);
        self.add_prim(PrimKind::Ellipsoid, index)
    }

    /// Adds a triangle with counter-clockwise corners; `normals` are its vertex normals, if it has any.
    /// Returns its `prim_id`.
    pub fn add_triangle(
        &mut self,
        corners: [Vec3; 3],
        normals: Option<[Vec3; 3]>,
        material: u32,
    ) -> u32 {
        let index = self.triangles.len();
        self.triangles.push(corners, normals, material);
        self.add_prim(PrimKind::Triangle, index)
    }

    fn add_prim(&mut self, kind: PrimKind, index: usize) -> u32 {
        let id = self.prims.len() as u32;
        self.prims.push(Prim::new(kind, index as u32));
        id
    }

    /// Exact bounds of one primitive, unpadded.
    pub fn prim_bounds(&self, prim_id: u32) -> Bounds {
        let prim = self.prims[prim_id as usize];
        let i = prim.index();
        match prim.kind() {
            PrimKind::Sphere => {
                let (c, r) = (self.spheres.center.get(i), self.spheres.radius[i]);
                Bounds::new(c - Vec3::splat(r), c + Vec3::splat(r))
            }
            PrimKind::Ellipsoid => self.ellipsoids.bounds(i),
            PrimKind::Triangle => {
                let [a, b, c] = self.triangles.corners(i);
                Bounds::new(a.min(b).min(c), a.max(b).max(c))
            }
        }
    }

    /// Bounds of all primitives; empty for a scene without any.
    pub fn bounds(&self) -> Bounds {
        (0..self.prims.len() as u32).fold(Bounds::EMPTY, |all, id| all.union(self.prim_bounds(id)))
    }

    /// Material of a primitive.
    pub fn prim_material(&self, prim_id: u32) -> u32 {
        let prim = self.prims[prim_id as usize];
        match prim.kind() {
            PrimKind::Sphere => self.spheres.material[prim.index()],
            PrimKind::Ellipsoid => self.ellipsoids.material[prim.index()],
            PrimKind::Triangle => self.triangles.material[prim.index()],
        }
    }

    /// Bytes held by the columns.
    pub fn memory_bytes(&self) -> usize {
        self.prims.capacity() * 4
            + self.spheres.memory_bytes()
            + self.ellipsoids.memory_bytes()
            + self.triangles.memory_bytes()
            + self.materials.memory_bytes()
            + self.lights.memory_bytes()
    }
}
