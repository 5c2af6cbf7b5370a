//! Spheres.

use super::columns::{ColumnInfo, PrimColumns, RowScale, column_infos, column_list};
use super::row_check::RowCheck;
use crate::bounds::Bounds;
use crate::column::{AnyColumn, Attribute, Column};
use crate::vectors::Vec3s;
use glam::{DVec3, Vec3};

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

    pub(crate) fn push(&mut self, center: Vec3, radius: f32, material: u32) {
        self.center.push(center);
        self.radius.push(radius);
        self.material.push(material);
    }

    /// Replaces rows by spheres of material 0.
    pub(crate) fn replace(&mut self, first: usize, centers: &[[f32; 3]], radii: &[f32]) {
        for (row, center) in (first..).zip(centers) {
            self.center.set(row, Vec3::from(*center));
        }
        let rows = first..first + radii.len();
        self.radius[rows.clone()].copy_from_slice(radii);
        self.material[rows].fill(0);
    }
}

impl PrimColumns for Spheres {
    fn material(&self) -> &Column<u32> {
        &self.material
    }

    column_list! {
        fn columns(spheres, materials), columns_mut;
        "sphere", spheres.len() => {
            center: ["sphere centres", "center"], RowCheck::Finite;
            radius: ["sphere radii", "radius"], RowCheck::Positive;
            material: ["sphere materials", "material"], RowCheck::Below(materials);
        }
    }

    #[inline]
    fn bounds(&self, i: usize) -> Bounds {
        let (c, r) = (self.center.get(i), self.radius[i]);
        Bounds::new(c - Vec3::splat(r), c + Vec3::splat(r))
    }

    fn largest_coordinate(&self, i: usize) -> f64 {
        let center = self.center.get(i).abs().max_element();
        f64::from(center) + f64::from(self.radius[i])
    }

    fn rescale(&mut self, scale: &RowScale) {
        scale.apply_to_vectors(&mut self.center);
        scale.apply(&mut self.radius);
    }

    fn enclosing_spheres(&self, i: usize, add: &mut dyn FnMut(Vec3, f32)) {
        add(self.center.get(i), self.radius[i]);
    }

    fn shape_numbers(&self, i: usize, take: &mut dyn FnMut(&[f32])) {
        take(&self.center.get(i).to_array());
        take(&[self.radius[i]]);
    }

    fn refine(&self, i: usize, origin: DVec3, direction: DVec3, t: f64) -> (f64, DVec3) {
        let center = self.center.get(i).as_dvec3();
        let t = nearest_root(origin - center, direction, self.radius[i].into(), t);
        (t, origin + t * direction - center)
    }
}

/// The distance, of the two at which a line meets a sphere around the origin, that is nearer to
/// `t`. The point of the line that is closest to the centre comes first, so that nothing cancels.
pub(crate) fn nearest_root(origin: DVec3, direction: DVec3, radius: f64, t: f64) -> f64 {
    let squared = direction.dot(direction);
    let middle = -origin.dot(direction) / squared;
    let closest = origin + middle * direction;
    let half = ((radius * radius - closest.dot(closest)).max(0.0) / squared).sqrt();
    let [near, far] = [middle - half, middle + half];
    let met = if (near - t).abs() <= (far - t).abs() { near } else { far };
    if met.is_finite() { met } else { t }
}
