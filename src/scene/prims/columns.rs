//! The interface of the kinds of primitive: what validation, rescaling, caches and cameras ask of a
//! kind's columns. Rays do not come here: each engine has tests and surfaces of its own.

use super::row_check::RowCheck;
use crate::bounds::Bounds;
use crate::column::{AnyColumn, Attribute, Column};
use crate::vectors::Vec3s;
use glam::{DVec3, Vec3};

/// The columns of one kind of primitive.
pub trait PrimColumns {
    /// Index of the material of each primitive.
    fn material(&self) -> &Column<u32>;
    /// Every column, in the order of scene caches. Rows refer to `materials` materials.
    fn columns(&self, materials: usize) -> Vec<ColumnInfo<'_>>;
    /// The columns of [`PrimColumns::columns`], in the same order, to be mapped.
    fn columns_mut(&mut self) -> Vec<&mut dyn AnyColumn>;
    /// The first primitive that is degenerate though each of its columns is valid: its row, the
    /// attribute, and the fault.
    fn first_degenerate(&self) -> Option<(usize, [&'static str; 2])> {
        None
    }
    /// Exact bounds, unpadded, in the space where the primitive is stored.
    fn bounds(&self, i: usize) -> Bounds;
    /// Largest coordinate of a primitive, in f64, where neither a sphere's bounds nor the square of
    /// an ellipsoid's axis overflows.
    fn largest_coordinate(&self, i: usize) -> f64;
    /// An upper bound on [`PrimColumns::largest_coordinate`] of all rows.
    fn largest_of_all(&self) -> f64 {
        let all = (0..self.material().len()).map(|i| self.largest_coordinate(i));
        all.fold(0.0, f64::max)
    }
    /// Scales every row.
    fn rescale(&mut self, scale: &RowScale);
    /// Passes spheres, as centre and radius, whose convex hull contains the primitive.
    fn enclosing_spheres(&self, i: usize, add: &mut dyn FnMut(Vec3, f32));
    /// Passes the numbers that define the primitive to a ray, in the order of benchmark
    /// fingerprints.
    fn shape_numbers(&self, i: usize, take: &mut dyn FnMut(&[f32]));
    /// The hit at distance `t` in double precision, in the space where the primitive is stored: its
    /// distance and normal.
    fn refine(&self, i: usize, origin: DVec3, direction: DVec3, t: f64) -> (f64, DVec3);
}

/// A column, and what must hold for its rows.
pub struct ColumnInfo<'a> {
    /// Name of the section in a scene cache.
    pub section: &'static str,
    /// Kind of row, as error messages name it: "sphere", "vertex", …
    pub row_kind: &'static str,
    /// Attribute, as error messages name it.
    pub attribute: &'static str,
    /// The rows.
    pub column: &'a dyn AnyColumn,
    /// Number of rows that the column must have.
    pub len: usize,
    /// Condition on each row.
    pub check: RowCheck,
}

/// The columns of an attribute of `len` rows. Indices that may be missing have an empty column if
/// all are.
pub(crate) fn column_infos<'a>(
    (row_kind, len): (&'static str, usize),
    [section, attribute]: [&'static str; 2],
    rows: &'a impl Attribute,
    check: RowCheck,
) -> impl Iterator<Item = ColumnInfo<'a>> {
    let optional = matches!(check, RowCheck::CornersOrNone(_));
    rows.columns().into_iter().map(move |column| ColumnInfo {
        section,
        row_kind,
        attribute,
        column,
        len: if optional && column.rows() == 0 { 0 } else { len },
        check,
    })
}

/// Lists the columns of a table once, for the two functions that borrow them. Each attribute has
/// its section in a scene cache, its name in messages, and the condition on its rows.
macro_rules! column_list {
    (
        $(#[$doc:meta])*
        $vis:vis fn $columns:ident($table:ident $(, $count:ident)?), $columns_mut:ident;
        $($row_kind:literal, $len:expr => {
            $($($field:ident).+: $names:tt, $check:expr;)+
        })+
    ) => {
        $(#[$doc])*
        $vis fn $columns(&self $(, $count: usize)?) -> Vec<ColumnInfo<'_>> {
            let $table = self;
            let mut all = Vec::new();
            $($(
                let rows = &$table.$($field).+;
                all.extend(column_infos(($row_kind, $len), $names, rows, $check));
            )+)+
            all
        }

        $vis fn $columns_mut(&mut self) -> Vec<&mut dyn AnyColumn> {
            let mut all = Vec::new();
            $($(all.extend(self.$($field).+.columns_mut());)+)+
            all
        }
    };
}
pub(crate) use column_list;

/// Scale factors, powers of two.
#[derive(Clone, Copy)]
pub struct ScaleFactors {
    /// Factor of the world.
    pub world: f32,
    /// Factor of the contents of meshes, which lie in spaces of their own.
    pub meshes: f32,
}

/// The scale of each row of a kind.
pub struct RowScale {
    /// The factors.
    pub factors: ScaleFactors,
    /// Marks of the rows that belong to meshes; empty for a scene without meshes.
    pub in_meshes: Vec<bool>,
}

impl RowScale {
    /// Scales one number of each row.
    pub(crate) fn apply(&self, rows: &mut [f32]) {
        let ScaleFactors { world, meshes } = self.factors;
        if self.in_meshes.is_empty() {
            return rows.iter_mut().for_each(|c| *c *= world);
        }
        for (c, &in_mesh) in rows.iter_mut().zip(&self.in_meshes) {
            *c *= if in_mesh { meshes } else { world };
        }
    }

    /// Scales one vector of each row.
    pub(crate) fn apply_to_vectors(&self, vectors: &mut Vec3s) {
        vectors
            .parts_mut()
            .into_iter()
            .for_each(|part| self.apply(part));
    }
}
