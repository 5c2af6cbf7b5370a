//! Ellipsoids.

use super::columns::{ColumnInfo, PrimColumns, RowScale, ScaleFactors, column_infos, column_list};
use super::row_check::RowCheck;
use super::spheres::nearest_root;
use crate::bounds::Bounds;
use crate::column::{AnyColumn, Attribute, Column};
use crate::vectors::Vec3s;
use glam::{Affine3A, DMat3, DVec3, Vec3};

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

    pub(crate) fn push(&mut self, to_world: Affine3A, to_object: Affine3A, material: u32) {
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
}

impl PrimColumns for Ellipsoids {
    fn material(&self) -> &Column<u32> {
        &self.material
    }

    column_list! {
        fn columns(ellipsoids, materials), columns_mut;
        "ellipsoid", ellipsoids.len() => {
            to_world: ["ellipsoid maps", "transform"], RowCheck::Finite;
            to_object: ["ellipsoid maps", "transform"], RowCheck::Finite;
            material: ["ellipsoid materials", "material"], RowCheck::Below(materials);
        }
    }

    /// Centre ± the length of each row of the matrix (the support function of an ellipsoid).
    #[inline]
    fn bounds(&self, i: usize) -> Bounds {
        let [x, y, z, center] = self.world_columns(i);
        let reach = Vec3::new(
            Vec3::new(x.x, y.x, z.x).length(),
            Vec3::new(x.y, y.y, z.y).length(),
            Vec3::new(x.z, y.z, z.z).length(),
        );
        Bounds::new(center - reach, center + reach)
    }

    fn largest_coordinate(&self, i: usize) -> f64 {
        let [x, y, z, center] = self.world_columns(i).map(|c| c.as_dvec3());
        let squares = x * x + y * y + z * z;
        (center.abs() + squares.map(f64::sqrt)).max_element()
    }

    fn rescale(&mut self, scale: &RowScale) {
        for column in &mut self.to_world {
            scale.apply_to_vectors(column);
        }
        // Back from the scaled world: the matrix divides by the factor, the translation stays in
        // object units.
        let ScaleFactors { world, meshes } = scale.factors;
        let back = RowScale {
            factors: ScaleFactors {
                world: 1.0 / world,
                meshes: 1.0 / meshes,
            },
            in_meshes: scale.in_meshes.clone(),
        };
        for column in &mut self.to_object[..3] {
            back.apply_to_vectors(column);
        }
    }

    /// The corners of the box.
    fn enclosing_spheres(&self, i: usize, add: &mut dyn FnMut(Vec3, f32)) {
        let corners = self.bounds(i).corners().into_iter();
        corners.for_each(|corner| add(corner, 0.0));
    }

    fn shape_numbers(&self, i: usize, take: &mut dyn FnMut(&[f32])) {
        let columns = self.object_columns(i).into_iter();
        columns.for_each(|column| take(&column.to_array()));
    }

    fn refine(&self, i: usize, origin: DVec3, direction: DVec3, t: f64) -> (f64, DVec3) {
        let [x, y, z, shift] = self.object_columns(i).map(|c| c.as_dvec3());
        let matrix = DMat3::from_cols(x, y, z);
        let (from, along) = (matrix * origin + shift, matrix * direction);
        let t = nearest_root(from, along, 1.0, t);
        // A normal goes to the world by the transpose of the inverse.
        (t, matrix.transpose() * (from + t * along))
    }
}
