//! The columns themselves: one vector per attribute, all of a kind the same length.

use glam::{Affine3A, Vec3};

/// Three float columns: a vector attribute stored as structure of arrays.
#[derive(Clone, Debug, Default)]
pub struct Vec3s {
    /// x components.
    pub x: Vec<f32>,
    /// y components.
    pub y: Vec<f32>,
    /// z components.
    pub z: Vec<f32>,
}

impl Vec3s {
    /// Number of vectors.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Appends one vector.
    pub fn push(&mut self, v: Vec3) {
        self.x.push(v.x);
        self.y.push(v.y);
        self.z.push(v.z);
    }

    /// The vector at `i`.
    #[inline]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Replaces the vector at `i`.
    pub fn set(&mut self, i: usize, v: Vec3) {
        (self.x[i], self.y[i], self.z[i]) = (v.x, v.y, v.z);
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        (self.x.capacity() + self.y.capacity() + self.z.capacity()) * 4
    }
}

/// The kinds of primitive a scene can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PrimKind {
    /// Sphere by centre and radius.
    Sphere = 0,
    /// Unit sphere under an affine map.
    Ellipsoid = 1,
    /// Triangle.
    Triangle = 2,
}

impl PrimKind {
    /// The kind whose number (`kind as u32`) this is.
    #[inline(always)]
    pub fn from_number(number: u32) -> PrimKind {
        match number {
            0 => PrimKind::Sphere,
            1 => PrimKind::Ellipsoid,
            _ => PrimKind::Triangle,
        }
    }
}

/// One entry of the primitive list: kind in the upper two bits, index into that kind's columns below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Prim(u32);

impl Prim {
    /// Most primitives of one kind.
    pub const MAX_INDEX: u32 = (1 << 30) - 1;

    /// Packs a kind and an index.
    pub fn new(kind: PrimKind, index: u32) -> Self {
        assert!(index <= Self::MAX_INDEX, "more than 2^30 primitives");
        Prim((kind as u32) << 30 | index)
    }

    /// The kind.
    #[inline]
    pub fn kind(self) -> PrimKind {
        PrimKind::from_number(self.0 >> 30)
    }

    /// Index into the columns of [`Prim::kind`].
    #[inline]
    pub fn index(self) -> usize {
        (self.0 & Self::MAX_INDEX) as usize
    }
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub lo: Vec3,
    /// Upper corner.
    pub hi: Vec3,
}

impl Bounds {
    /// The box of nothing: the neutral element of [`Bounds::union`].
    pub const EMPTY: Bounds = Bounds {
        lo: Vec3::INFINITY,
        hi: Vec3::NEG_INFINITY,
    };

    /// A box from its corners.
    pub fn new(lo: Vec3, hi: Vec3) -> Self {
        Bounds { lo, hi }
    }

    /// Whether it holds nothing.
    pub fn is_empty(self) -> bool {
        !self.lo.cmple(self.hi).all()
    }

    /// The smallest box around both.
    pub fn union(self, other: Bounds) -> Bounds {
        Bounds::new(self.lo.min(other.lo), self.hi.max(other.hi))
    }

    /// Half the surface area, the measure of the surface area heuristic; 0 for the empty box.
    pub fn half_area(self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        let d = self.hi - self.lo;
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// The box that a hit on the boxed primitive must pass, and from which every node of every tree is made.
    ///
    /// Grown on all sides by [`PAD`] times its largest coordinate, which covers the rounding error of the hit point:
    /// see [`crate::trace`], "Why no tree can lose a hit".
    pub fn padded(self) -> Bounds {
        let pad = Vec3::splat(PAD * self.lo.abs().max(self.hi.abs()).max_element());
        Bounds::new(self.lo - pad, self.hi + pad)
    }
}

/// Relative outward padding of boxes and of ray origins in the slab test: 2⁻¹⁹ ≈ 1.9e-6, 32 units in the last place.
///
/// A hit's computed place is within about 8 units in the last place of |vertex − origin| of the primitive; the box
/// carries 32 of its own largest coordinate and the origin 32 of its own.
pub const PAD: f32 = 1.0 / 524_288.0;

/// Spheres by centre and radius.
#[derive(Clone, Debug, Default)]
pub struct Spheres {
    /// Centres.
    pub center: Vec3s,
    /// Radii, positive.
    pub radius: Vec<f32>,
    /// Index into the materials.
    pub material: Vec<u32>,
}

impl Spheres {
    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.radius.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.radius.is_empty()
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.center.memory_bytes() + (self.radius.capacity() + self.material.capacity()) * 4
    }
}

/// Unit spheres under affine maps. Each map is stored as three columns of its matrix and its translation.
#[derive(Clone, Debug, Default)]
pub struct Ellipsoids {
    /// Object to world: columns 0 to 2 of the matrix, then the translation.
    pub to_world: [Vec3s; 4],
    /// World to object: columns 0 to 2 of the matrix, then the translation.
    pub to_object: [Vec3s; 4],
    /// Index into the materials.
    pub material: Vec<u32>,
}

impl Ellipsoids {
    /// Number of ellipsoids.
    pub fn len(&self) -> usize {
        self.material.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.material.is_empty()
    }

    pub(super) fn push(&mut self, to_world: Affine3A, to_object: Affine3A, material: u32) {
        for (columns, map) in [
            (&mut self.to_world, to_world),
            (&mut self.to_object, to_object),
        ] {
            columns[0].push(map.matrix3.x_axis.into());
            columns[1].push(map.matrix3.y_axis.into());
            columns[2].push(map.matrix3.z_axis.into());
            columns[3].push(map.translation.into());
        }
        self.material.push(material);
    }

    /// The four columns of the object-to-world map.
    #[inline]
    pub fn world_columns(&self, i: usize) -> [Vec3; 4] {
        std::array::from_fn(|k| self.to_world[k].get(i))
    }

    /// The four columns of the world-to-object map.
    #[inline]
    pub fn object_columns(&self, i: usize) -> [Vec3; 4] {
        std::array::from_fn(|k| self.to_object[k].get(i))
    }

    /// World bounds: centre ± the length of each row of the matrix (the support function of an ellipsoid).
    pub fn bounds(&self, i: usize) -> Bounds {
        let [x, y, z, center] = self.world_columns(i);
        let reach = Vec3::new(
            Vec3::new(x.x, y.x, z.x).length(),
            Vec3::new(x.y, y.y, z.y).length(),
            Vec3::new(x.z, y.z, z.z).length(),
        );
        Bounds::new(center - reach, center + reach)
    }

    pub(super) fn memory_bytes(&self) -> usize {
        let maps = self.to_world.iter().chain(&self.to_object);
        maps.map(Vec3s::memory_bytes).sum::<usize>() + self.material.capacity() * 4
    }
}

/// Marks a triangle without vertex normals in [`Triangles::normals`].
pub const NO_NORMALS: u32 = u32::MAX;

/// Triangles, each with its own three corners.
#[derive(Clone, Debug, Default)]
pub struct Triangles {
    /// First corners.
    pub a: Vec3s,
    /// Second corners.
    pub b: Vec3s,
    /// Third corners, counter-clockwise.
    pub c: Vec3s,
    /// Index of the first of three consecutive entries of `vertex_normals`, or [`NO_NORMALS`].
    pub normals: Vec<u32>,
    /// Vertex normals, three per triangle that has them; any length but zero.
    pub vertex_normals: Vec3s,
    /// Index into the materials.
    pub material: Vec<u32>,
}

impl Triangles {
    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.material.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.material.is_empty()
    }

    pub(super) fn push(&mut self, corners: [Vec3; 3], normals: Option<[Vec3; 3]>, material: u32) {
        self.a.push(corners[0]);
        self.b.push(corners[1]);
        self.c.push(corners[2]);
        self.normals.push(match normals {
            Some(_) => self.vertex_normals.len() as u32,
            None => NO_NORMALS,
        });
        for n in normals.into_iter().flatten() {
            self.vertex_normals.push(n);
        }
        self.material.push(material);
    }

    /// The three corners.
    #[inline]
    pub fn corners(&self, i: usize) -> [Vec3; 3] {
        [self.a.get(i), self.b.get(i), self.c.get(i)]
    }

    /// The three vertex normals, if it has them.
    #[inline]
    pub fn corner_normals(&self, i: usize) -> Option<[Vec3; 3]> {
        let first = self.normals[i];
        (first != NO_NORMALS)
            .then(|| std::array::from_fn(|k| self.vertex_normals.get(first as usize + k)))
    }

    pub(super) fn memory_bytes(&self) -> usize {
        let vectors = [&self.a, &self.b, &self.c, &self.vertex_normals];
        vectors.iter().map(|v| v.memory_bytes()).sum::<usize>()
            + (self.normals.capacity() + self.material.capacity()) * 4
    }
}

/// Surface parameters (design document, "Recursive shading model"): all RGB linear and finite.
#[derive(Clone, Debug, Default)]
pub struct Materials {
    /// Ambient Ka.
    pub ka: Vec3s,
    /// Emission Ke.
    pub ke: Vec3s,
    /// Diffuse Kd.
    pub kd: Vec3s,
    /// Specular Ks, also the weight of the mirror ray.
    pub ks: Vec3s,
    /// Transmission Kt, the weight of the refracted ray.
    pub kt: Vec3s,
    /// Blinn exponent s, at least 0.
    pub shininess: Vec<f32>,
    /// Index of refraction, positive.
    pub ior: Vec<f32>,
}

impl Materials {
    /// Number of materials.
    pub fn len(&self) -> usize {
        self.ior.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.ior.is_empty()
    }

    pub(super) fn memory_bytes(&self) -> usize {
        let vectors = [&self.ka, &self.ke, &self.kd, &self.ks, &self.kt];
        vectors.iter().map(|v| v.memory_bytes()).sum::<usize>()
            + (self.shininess.capacity() + self.ior.capacity()) * 4
    }
}

/// Lights of both kinds, in file order.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Whether the light is directional (else a point light).
    pub directional: Vec<bool>,
    /// Position of a point light, or the unit direction toward a directional one.
    pub place: Vec3s,
    /// Colour L0.
    pub color: Vec3s,
    /// Attenuation const, lin and quad of point lights, as the components x, y and z.
    pub attenuation: Vec3s,
}

impl Lights {
    /// Number of lights.
    pub fn len(&self) -> usize {
        self.directional.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.directional.is_empty()
    }

    /// Adds a point light with attenuation (const, lin, quad).
    pub fn add_point(&mut self, position: Vec3, color: Vec3, attenuation: Vec3) {
        self.directional.push(false);
        self.place.push(position);
        self.color.push(color);
        self.attenuation.push(attenuation);
    }

    /// Adds a directional light; `toward` is the unit vector toward it.
    pub fn add_directional(&mut self, toward: Vec3, color: Vec3) {
        self.directional.push(true);
        self.place.push(toward);
        self.color.push(color);
        self.attenuation.push(Vec3::X);
    }

    pub(super) fn memory_bytes(&self) -> usize {
        let vectors = [&self.place, &self.color, &self.attenuation];
        vectors.iter().map(|v| v.memory_bytes()).sum::<usize>() + self.directional.capacity()
    }
}
