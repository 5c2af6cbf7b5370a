//! The caller's and the scene's coordinates: a scene may have its own origin and scale.

use crate::arrays::{Floats, NumpyNumber, as_contiguous, wrong_shape};
use crate::errors::value_error;
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use phalanx::Scene;
use phalanx::glam::{DAffine3, DMat3, DVec3};
use pyo3::prelude::*;

/// The map from the caller's coordinates to the scene's, (p − origin) · scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coordinates {
    pub(crate) origin: [f64; 3],
    pub(crate) scale: f64,
}

impl Coordinates {
    pub(crate) fn of(scene: &Scene) -> Coordinates {
        Coordinates {
            origin: scene.origin,
            scale: f64::from(scene.scale),
        }
    }

    pub(crate) fn is_identity(&self) -> bool {
        self.origin == [0.0; 3] && self.scale == 1.0
    }

    /// The caller's points in the scene's coordinates. The difference is computed in double
    /// precision and rounded once.
    pub(crate) fn points<'py>(
        &self,
        name: &str,
        object: &Bound<'py, PyAny>,
    ) -> PyResult<Floats<'py>> {
        if self.is_identity() {
            return Floats::of(name, object);
        }
        match object.cast::<PyArrayDyn<f32>>() {
            Ok(_) => self.moved(name, as_contiguous::<f32>(name, object)?),
            Err(_) => self.moved(name, as_contiguous::<f64>(name, object)?),
        }
    }

    fn moved<'py, T: NumpyNumber + Copy + Into<f64>>(
        &self,
        name: &str,
        points: Bound<'py, PyArrayDyn<T>>,
    ) -> PyResult<Floats<'py>> {
        let points = points.try_readonly().map_err(value_error)?;
        if !matches!(points.shape(), [.., 3] | [0]) {
            return Err(wrong_shape(name, "(…, 3)", points.shape()));
        }
        let [x, y, z] = self.origin;
        let mut moved = vec![0.0; points.len()];
        let rows = moved.as_chunks_mut().0.iter_mut();
        for (row, &[a, b, c]) in rows.zip(points.as_slice()?.as_chunks().0) {
            let differences = [a.into() - x, b.into() - y, c.into() - z];
            *row = differences.map(|c| (c * self.scale) as f32);
        }
        Floats::made(points.py(), moved, points.shape())
    }

    /// Directions, or other differences, in the scene's units.
    pub(crate) fn differences<'py>(
        &self,
        name: &str,
        object: &Bound<'py, PyAny>,
    ) -> PyResult<Floats<'py>> {
        if self.scale == 1.0 {
            return Floats::of(name, object);
        }
        let given = as_contiguous::<f64>(name, object)?;
        let given = given.try_readonly().map_err(value_error)?;
        let scaled = given.as_slice()?.iter().map(|c| (c * self.scale) as f32);
        Floats::made(object.py(), scaled.collect(), given.shape())
    }

    /// A caller's ray in the scene's coordinates, in double precision.
    pub(crate) fn ray(&self, origin: [f64; 3], direction: [f64; 3]) -> [[f64; 3]; 2] {
        [
            std::array::from_fn(|axis| (origin[axis] - self.origin[axis]) * self.scale),
            direction.map(|c| c * self.scale),
        ]
    }

    /// A scene point in the caller's coordinates.
    pub(crate) fn outside(&self, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| point[axis] / self.scale + self.origin[axis])
    }
}

/// A (3, 4) or (4, 4) map from a prototype's own coordinates to the scene's, or from a camera's.
///
/// # Errors
/// `ValueError` for any other shape, and for a last row that is not (0, 0, 0, 1).
pub(crate) fn transform(
    name: &str,
    object: &Bound<'_, PyAny>,
    coordinates: &Coordinates,
) -> PyResult<DAffine3> {
    let array = as_contiguous::<f64>(name, object)?;
    if !matches!(array.shape(), [3 | 4, 4]) {
        return Err(wrong_shape(name, "(4, 4) or (3, 4)", array.shape()));
    }
    let numbers = array.to_vec().map_err(value_error)?;
    let rows: &[[f64; 4]] = numbers.as_chunks().0;
    if rows.get(3).is_some_and(|row| *row != [0.0, 0.0, 0.0, 1.0]) {
        let why = format!("the last row of {name} is not (0, 0, 0, 1)");
        return Err(value_error(why));
    }
    let column = |k: usize| DVec3::new(rows[0][k], rows[1][k], rows[2][k]);
    let [offset, _] = coordinates.ray(column(3).into(), [0.0; 3]);
    Ok(DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: offset.into(),
    })
}
