//! Columns of the curved primitives: spheres, ellipsoids, cones.

use super::{Bounds, Column, Vec3s};
use glam::{Affine3A, Vec3};

/// Spheres by centre and radius.
#[derive(Clone, Debug, Default)]
pub struct Spheres {
    /// Centres.
    pub center: Vec3s,
    /// Radii, positive.
    pub radius: Column<f32>,
    /// Index into the materials.
    pub material: Column<u32>,
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
}

/// Unit spheres under affine maps. Each map is stored as three columns of its matrix and its translation.
#[derive(Clone, Debug, Default)]
pub struct Ellipsoids {
    /// Object to world: columns 0 to 2 of the matrix, then the translation.
    pub to_world: [Vec3s; 4],
    /// World to object: columns 0 to 2 of the matrix, then the translation.
    pub to_object: [Vec3s; 4],
    /// Index into the materials.
    pub material: Column<u32>,
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
}

/// A truncated cone without its end discs; a cylinder where the radii are equal, pointed where one is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Centre of the first end.
    pub base: Vec3,
    /// Radius there, not negative.
    pub base_radius: f32,
    /// Centre of the other end; differs from `base`.
    pub apex: Vec3,
    /// Radius there, not negative; not both are zero.
    pub apex_radius: f32,
    /// Whether only its inside can be seen (a negative radius in NFF).
    pub inside: bool,
}

/// Truncated cones, one [`Cone`] each.
#[derive(Clone, Debug, Default)]
pub struct Cones {
    /// Centres of the first ends.
    pub base: Vec3s,
    /// Centres of the other ends.
    pub apex: Vec3s,
    /// Radii of the first ends.
    pub base_radius: Column<f32>,
    /// Radii of the other ends.
    pub apex_radius: Column<f32>,
    /// 1 where only the inside can be seen, else 0.
    pub inside: Column<u8>,
    /// Index into the materials.
    pub material: Column<u32>,
}

impl Cones {
    /// Number of cones.
    pub fn len(&self) -> usize {
        self.material.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.material.is_empty()
    }

    pub(super) fn push(&mut self, cone: Cone, material: u32) {
        self.base.push(cone.base);
        self.apex.push(cone.apex);
        self.base_radius.push(cone.base_radius);
        self.apex_radius.push(cone.apex_radius);
        self.inside.push(u8::from(cone.inside));
        self.material.push(material);
    }

    /// The cone at `i`.
    #[inline]
    pub fn get(&self, i: usize) -> Cone {
        Cone {
            base: self.base.get(i),
            base_radius: self.base_radius[i],
            apex: self.apex.get(i),
            apex_radius: self.apex_radius[i],
            inside: self.inside[i] != 0,
        }
    }

    /// Bounds of the two end discs: a disc of radius r across the unit axis a reaches r·√(1 − a_k²) along axis k.
    pub fn bounds(&self, i: usize) -> Bounds {
        let cone = self.get(i);
        let axis = (cone.apex - cone.base).as_dvec3().normalize_or_zero();
        let across = |k: f64| (1.0 - k * k).max(0.0).sqrt() as f32;
        let reach = Vec3::new(across(axis.x), across(axis.y), across(axis.z));
        let disc = |center: Vec3, radius: f32| {
            Bounds::new(center - reach * radius, center + reach * radius)
        };
        disc(cone.base, cone.base_radius).union(disc(cone.apex, cone.apex_radius))
    }
}
