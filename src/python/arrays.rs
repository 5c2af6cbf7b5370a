//! The caller's arrays: checked, and converted unless they are contiguous float32.

use crate::errors::value_error;
use numpy::{IntoPyArray, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A C-contiguous float32 array: the caller's own if it qualifies, else a copy.
pub(crate) struct Floats<'py> {
    pub(crate) array: PyReadonlyArrayDyn<'py, f32>,
}

impl<'py> Floats<'py> {
    /// Accepts any array of numbers; errors refer to it by `name`.
    ///
    /// # Errors
    /// `TypeError` for anything but real numbers.
    pub(crate) fn of(name: &str, object: &Bound<'py, PyAny>) -> PyResult<Floats<'py>> {
        let array = as_contiguous(name, object, "float32")?;
        let array = array.cast_into::<PyArrayDyn<f32>>()?;
        Ok(Floats {
            array: array.try_readonly().map_err(value_error)?,
        })
    }

    pub(crate) fn shape(&self) -> &[usize] {
        self.array.shape()
    }

    pub(crate) fn numbers(&self) -> PyResult<&[f32]> {
        self.array.as_slice().map_err(value_error)
    }

    /// The array in rows of three.
    ///
    /// # Errors
    /// `ValueError` for any shape but (n, 3).
    pub(crate) fn threes(&self, name: &str) -> PyResult<&[[f32; 3]]> {
        match self.shape() {
            [_, 3] => Ok(self.numbers()?.as_chunks().0),
            shape => Err(wrong_shape(name, "(n, 3)", shape)),
        }
    }
}

/// A numpy array of one type, C-contiguous, aligned and in native byte order; the same array if it
/// already qualifies.
///
/// # Errors
/// `TypeError` for anything but real numbers, `OverflowError` or `ValueError` from numpy.
pub(crate) fn as_contiguous<'py>(
    name: &str,
    object: &Bound<'py, PyAny>,
    dtype: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let numpy = object.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (object,)).map_err(|error| {
        PyTypeError::new_err(format!("{name} is not an array of numbers: {error}"))
    })?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    let empty = array.getattr("size")?.extract::<usize>()? == 0;
    let wanted = match dtype {
        "float32" | "float64" => "fiu",
        _ => "iu",
    };
    if !wanted.contains(&kind) && !empty {
        let given: String = array.getattr("dtype")?.str()?.extract()?;
        let words = if wanted == "iu" {
            "integers"
        } else {
            "real numbers"
        };
        return Err(PyTypeError::new_err(format!(
            "{name} holds {given}, not {words}"
        )));
    }
    let options = PyDict::new(object.py());
    options.set_item("dtype", dtype)?;
    options.set_item("requirements", ["C", "A"])?;
    numpy.call_method("require", (array,), Some(&options))
}

/// A `ValueError` about an array's shape.
pub(crate) fn wrong_shape(name: &str, wanted: &str, shape: &[usize]) -> PyErr {
    let sides: Vec<String> = shape.iter().map(usize::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    PyValueError::new_err(format!(
        "{name} has the shape ({}{comma}), not {wanted}",
        sides.join(", ")
    ))
}

/// Rows of (…, 6) split into their halves: origins and directions.
pub(crate) fn halves<'py>(rays: &Bound<'py, PyAny>) -> PyResult<[Bound<'py, PyAny>; 2]> {
    let numpy = rays.py().import("numpy")?;
    let rays = numpy.call_method1("asarray", (rays,))?;
    let halves = numpy.call_method1("split", (rays, 2, -1))?;
    Ok([halves.get_item(0)?, halves.get_item(1)?])
}

/// Three vertex rows for each triangle, as 32-bit numbers.
///
/// # Errors
/// `TypeError` for anything but integers, `ValueError` for any shape but (m, 3), `IndexError` for
/// negative numbers and those beyond 32 bits.
pub(crate) fn faces(object: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    let array = as_contiguous("faces", object, "int64")?;
    let array = array.cast_into::<PyArrayDyn<i64>>()?;
    let array = array.try_readonly().map_err(value_error)?;
    if !matches!(array.shape(), [_, 3]) && !array.shape().contains(&0) {
        return Err(wrong_shape("faces", "(m, 3)", array.shape()));
    }
    let rows = array.as_slice().map_err(value_error)?.as_chunks().0;
    let row = |(k, row): (usize, &[i64; 3])| {
        let [a, b, c] = row.map(|index| u32::try_from(index).ok());
        a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]).ok_or_else(|| {
            pyo3::exceptions::PyIndexError::new_err(format!(
                "face {k} is {row:?}: vertices are numbered from 0"
            ))
        })
    };
    rows.iter().enumerate().map(row).collect()
}

/// A column of answers as an array of the given shape. Nothing is copied.
pub(crate) fn shaped<'py, T: numpy::Element>(
    py: Python<'py>,
    column: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    column.into_pyarray(py).reshape(shape.to_vec())
}
