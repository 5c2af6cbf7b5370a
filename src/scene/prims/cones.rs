//! Truncated cones and cylinders.

use super::columns::{ColumnInfo, PrimColumns, RowScale, column_infos, column_list};
use super::row_check::RowCheck;
use crate::bounds::Bounds;
use crate::column::{AnyColumn, Attribute, Column};
use crate::vectors::Vec3s;
use glam::{DVec3, Vec3};

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
    pub(crate) fn push(&mut self, cone: Cone, material: u32) {
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

impl PrimColumns for Cones {
    fn material(&self) -> &Column<u32> {
        &self.material
    }

    column_list! {
        fn columns(cones, materials), columns_mut;
        "cone", cones.len() => {
            base: ["cones", "base"], RowCheck::Finite;
            apex: ["cones", "apex"], RowCheck::Finite;
            base_radius: ["cone radii", "radius"], RowCheck::Color;
            apex_radius: ["cone radii", "radius"], RowCheck::Color;
            inside: ["cone sides", "side"], RowCheck::Any;
            material: ["cone materials", "material"], RowCheck::Below(materials);
        }
    }

    fn first_degenerate(&self) -> Option<(usize, [&'static str; 2])> {
        let is_degenerate = |&i: &usize| {
            let cone = self.get(i);
            cone.base == cone.apex || (cone.base_radius == 0.0 && cone.apex_radius == 0.0)
        };
        let row = (0..self.len()).find(is_degenerate)?;
        Some((row, ["extent", "zero"]))
    }

    /// Bounds of the two end discs. A disc of radius r across the unit axis a reaches r·√(1 − a_k²)
    /// along axis k.
    fn bounds(&self, i: usize) -> Bounds {
        let cone = self.get(i);
        let axis = ConeSides::of(&cone).axis;
        let across = |k: f64| (1.0 - k * k).max(0.0).sqrt() as f32;
        let reach = Vec3::new(across(axis.x), across(axis.y), across(axis.z));
        let disc = |center: Vec3, radius: f32| {
            Bounds::new(center - reach * radius, center + reach * radius)
        };
        disc(cone.base, cone.base_radius).union(disc(cone.apex, cone.apex_radius))
    }

    fn largest_coordinate(&self, i: usize) -> f64 {
        let cone = self.get(i);
        let ends = cone.base.abs().max(cone.apex.abs()).max_element();
        f64::from(ends) + f64::from(cone.base_radius.max(cone.apex_radius))
    }

    fn largest_of_all(&self) -> f64 {
        let ends = self
            .base
            .largest_magnitude()
            .max(self.apex.largest_magnitude());
        let radii = self.base_radius.iter().chain(&self.apex_radius);
        f64::from(ends) + f64::from(radii.fold(0.0f32, |most, r| most.max(*r)))
    }

    fn rescale(&mut self, scale: &RowScale) {
        scale.apply_to_vectors(&mut self.base);
        scale.apply_to_vectors(&mut self.apex);
        scale.apply(&mut self.base_radius);
        scale.apply(&mut self.apex_radius);
    }

    fn enclosing_spheres(&self, i: usize, add: &mut dyn FnMut(Vec3, f32)) {
        add(self.base.get(i), self.base_radius[i]);
        add(self.apex.get(i), self.apex_radius[i]);
    }

    fn shape_numbers(&self, i: usize, take: &mut dyn FnMut(&[f32])) {
        take(&self.base.get(i).to_array());
        take(&self.apex.get(i).to_array());
        take(&[self.base_radius[i], self.apex_radius[i]]);
    }

    /// The distance stays that of the hit.
    fn refine(&self, i: usize, origin: DVec3, direction: DVec3, t: f64) -> (f64, DVec3) {
        let profile = self.profile(i);
        let from_base = origin + t * direction - self.get(i).base.as_dvec3();
        let axis = profile.axis.as_dvec3();
        let outward = (from_base - from_base.dot(axis) * axis).normalize_or_zero();
        let (cos, sin) = (f64::from(profile.cos), f64::from(profile.sin));
        (t, cos * outward - sin * axis)
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
