//! Columns of the curved primitives: spheres, ellipsoids, cones.

use super::{Bounds, Column, Vec3s};
use glam::{Affine3A, DVec3, Vec3};

/// Spheres by centre and radius.
#[derive(Clone, Debug, Default)]
pub struct Spheres {
    /// Centres.
    pub center: Vec3s,
    /// Radii, positive.
    pub radius: Column<f32>,
    /// Indices of the materials.
    pub material: Column<u32>,
}

impl Spheres {
    /// Number of spheres.
    #[inline]
    pub fn len(&self) -> usize {
        self.radius.len()
    }

    /// Returns true if there are no spheres.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.radius.is_empty()
    }
}

/// Unit spheres under affine maps. Each map is stored as the three columns of its matrix and its
/// translation.
#[derive(Clone, Debug, Default)]
pub struct Ellipsoids {
    /// Object-to-world map: columns 0 to 2 of the matrix, then the translation.
    pub to_world: [Vec3s; 4],
    /// World-to-object map: columns 0 to 2 of the matrix, then the translation.
    pub to_object: [Vec3s; 4],
    /// Indices of the materials.
    pub material: Column<u32>,
}

impl Ellipsoids {
    /// Number of ellipsoids.
    #[inline]
    pub fn len(&self) -> usize {
        self.material.len()
    }

    /// Returns true if there are no ellipsoids.
    #[inline]
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

    /// World bounds: centre ± the length of each row of the matrix (the support function of an
    /// ellipsoid).
    #[inline]
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

/// A truncated cone without its end discs; a cylinder if the radii are equal, pointed if one is
/// zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Centre of the first end.
    pub base: Vec3,
    /// Radius at the first end, not negative.
    pub base_radius: f32,
    /// Centre of the other end; differs from `base`.
    pub apex: Vec3,
    /// Radius at the other end, not negative; not both radii are zero.
    pub apex_radius: f32,
    /// True if only the inside is visible (a negative radius in NFF).
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
    /// 1 if only the inside is visible, else 0.
    pub inside: Column<u8>,
    /// Indices of the materials.
    pub material: Column<u32>,
}

impl Cones {
    /// Number of cones.
    #[inline]
    pub fn len(&self) -> usize {
        self.material.len()
    }

    /// Returns true if there are no cones.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.material.is_empty()
    }

    #[inline]
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

    /// Bounds of the two end discs. A disc of radius r across the unit axis a reaches r·√(1 − a_k²)
    /// along axis k.
    pub fn bounds(&self, i: usize) -> Bounds {
        let cone = self.get(i);
        let axis = ConeSides::of(&cone).axis;
        let across = |k: f64| (1.0 - k * k).max(0.0).sqrt() as f32;
        let reach = Vec3::new(across(axis.x), across(axis.y), across(axis.z));
        let disc = |center: Vec3, radius: f32| {
            Bounds::new(center - reach * radius, center + reach * radius)
        };
        disc(cone.base, cone.base_radius).union(disc(cone.apex, cone.apex_radius))
    }

    /// The cone's profile, for the point and the normal of a hit.
    #[inline]
    pub fn profile(&self, i: usize) -> ConeProfile {
        let sides = ConeSides::of(&self.get(i));
        ConeProfile {
            axis: sides.axis.as_vec3(),
            cos: sides.cos as f32,
            sin: sides.sin as f32,
            slant: sides.slant as f32,
        }
    }

    /// The cone's own coordinates, for a ray's test.
    #[inline]
    pub fn frame(&self, i: usize) -> ConeFrame {
        let cone = self.get(i);
        let sides = ConeSides::of(&cone);
        let across = perpendicular(sides.axis);
        ConeFrame {
            base: cone.base,
            axes: [across[0], across[1], sides.axis].map(|a| a.as_vec3()),
            length: sides.length as f32,
            radius: (sides.cos * f64::from(cone.base_radius)) as f32,
            sin: sides.sin as f32,
            cos_squared: (sides.cos * sides.cos) as f32,
        }
    }
}

/// The profile of a cone in the half-plane (distance from the axis, height above the base): one
/// straight line, which starts at (base radius, 0) and runs along (`sin`, `cos`).
#[derive(Clone, Copy, Debug)]
pub struct ConeProfile {
    /// Unit vector from the base to the apex.
    pub axis: Vec3,
    /// Cosine of the angle between axis and line: 1 for a cylinder.
    pub cos: f32,
    /// Sine of that angle, negative where the apex is the smaller end. The outward normal is
    /// (`cos`, −`sin`).
    pub sin: f32,
    /// Length of the line.
    pub slant: f32,
}

/// A cone in coordinates of its own, in which it is cos²·(x² + y²) = (`radius` + `sin`·z)², 0 ≤ z ≤
/// `length`. This is the cone's equation times cos², so that no term grows without bounds if a cone
/// is nearly a disc.
#[derive(Clone, Copy, Debug)]
pub struct ConeFrame {
    /// Centre of the first end, which is the origin.
    pub base: Vec3,
    /// The three orthogonal unit axes; the last is the cone's axis.
    pub axes: [Vec3; 3],
    /// Distance between the two ends.
    pub length: f32,
    /// Radius of the first end times [`ConeProfile::cos`].
    pub radius: f32,
    /// Sine of the profile, as [`ConeProfile::sin`].
    pub sin: f32,
    /// Square of [`ConeProfile::cos`].
    pub cos_squared: f32,
}

/// Lengths and angles from which both the profile and the frame of a cone are made, in f64.
struct ConeSides {
    axis: DVec3,
    length: f64,
    slant: f64,
    cos: f64,
    sin: f64,
}

impl ConeSides {
    #[inline]
    fn of(cone: &Cone) -> ConeSides {
        let along = cone.apex.as_dvec3() - cone.base.as_dvec3();
        let length = along.dot(along).sqrt();
        let wider = f64::from(cone.apex_radius) - f64::from(cone.base_radius);
        let slant = (length * length + wider * wider).sqrt();
        ConeSides {
            axis: along / length,
            length,
            slant,
            cos: length / slant,
            sin: wider / slant,
        }
    }
}

/// Two unit vectors that make a right-handed frame with the unit vector `n` (Duff et al., "Building
/// an Orthonormal Basis, Revisited", JCGT 2017).
#[inline]
fn perpendicular(n: DVec3) -> [DVec3; 2] {
    let sign = 1.0f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [
        DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        DVec3::new(b, sign + n.y * n.y * a, -n.y),
    ]
}
