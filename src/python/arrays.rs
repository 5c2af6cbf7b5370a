//! The caller's arrays: checked, and converted unless they are contiguous and of the wanted type.

use crate::errors::value_error;
use numpy::{
    IntoPyArray, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;

/// Numbers that arrays are converted to.
pub(crate) trait NumpyNumber: numpy::Element {
    /// numpy's kinds of numbers that may be converted.
    const KINDS: &'static [u8];
    /// Those kinds for readers.
    const WORDS: &'static str;
}

impl NumpyNumber for f32 {
    const KINDS: &'static [u8] = b"fiu";
    const WORDS: &'static str = "real numbers";
}

impl NumpyNumber for f64 {
    const KINDS: &'static [u8] = b"fiu";
    const WORDS: &'static str = "real numbers";
}

impl NumpyNumber for i64 {
    const KINDS: &'static [u8] = b"iu";
    const WORDS: &'static str = "integers";
}

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
        let array = as_contiguous(name, object)?;
        Ok(Floats {
            array: array.try_readonly().map_err(value_error)?,
        })
    }

    /// An array of numbers that were computed here.
    pub(crate) fn made(
        py: Python<'py>,
        numbers: Vec<f32>,
        shape: &[usize],
    ) -> PyResult<Floats<'py>> {
        Ok(Floats {
            array: shaped(py, numbers, shape)?.readonly(),
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

/// The value of a cell, made if there is none. Making it takes no lock: it may let other threads
/// run, and one that forks would leave its child a cell that nobody fills. If two threads make the
/// value at once, one of them is kept.
pub(crate) fn get_or_make<'a, T>(
    py: Python<'_>,
    cell: &'a PyOnceLock<T>,
    make: impl FnOnce() -> PyResult<T>,
) -> PyResult<&'a T> {
    if cell.get(py).is_none() {
        // Sets it with the interpreter's lock.
        let _ = cell.set(py, make()?);
    }
    cell.get_or_try_init(py, || Err(value_error("there is no value")))
}

/// Imports a function of numpy once.
pub(crate) fn numpy<'py>(
    py: Python<'py>,
    known: &PyOnceLock<Py<PyAny>>,
    name: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let import = || Ok(py.import("numpy")?.getattr(name)?.unbind());
    Ok(get_or_make(py, known, import)?.bind(py).clone())
}

/// A numpy array of one type, C-contiguous, aligned and in native byte order; the same array if it
/// already qualifies.
///
/// # Errors
/// `TypeError` for anything but real numbers, `OverflowError` or `ValueError` from numpy.
pub(crate) fn as_contiguous<'py, T: NumpyNumber>(
    name: &str,
    object: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    if let Ok(array) = object.cast::<PyArrayDyn<T>>()
        && is_ready(array)
    {
        return Ok(array.clone());
    }
    let array = as_array(name, object)?;
    let dtype = array.dtype();
    if !T::KINDS.contains(&dtype.kind()) && array.len() > 0 {
        let message = format!("{name} holds {}, not {}", dtype.str()?, T::WORDS);
        return Err(PyTypeError::new_err(message));
    }
    let options = PyDict::new(object.py());
    options.set_item("dtype", numpy::dtype::<T>(object.py()))?;
    options.set_item("order", "C")?;
    let array = asarray(object.py())?.call((array,), Some(&options))?;
    let array = array.cast_into::<PyArrayDyn<T>>()?;
    if is_ready(&array) {
        Ok(array)
    } else {
        // It was of the type, but not aligned.
        Ok(array.call_method0("copy")?.cast_into()?)
    }
}

/// `numpy.asarray`.
pub(crate) fn asarray(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    static ASARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    numpy(py, &ASARRAY, "asarray")
}

/// An array of any type.
fn as_array<'py>(name: &str, object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    if let Ok(array) = object.cast::<PyUntypedArray>() {
        return Ok(array.clone());
    }
    let array = asarray(object.py())?.call1((object,)).map_err(|error| {
        PyTypeError::new_err(format!("{name} is not an array of numbers: {error}"))
    })?;
    Ok(array.cast_into()?)
}

fn is_ready<T: numpy::Element>(array: &Bound<'_, PyArrayDyn<T>>) -> bool {
    array.is_c_contiguous() && array.data().is_aligned()
}

/// A `ValueError` about an array's shape.
pub(crate) fn wrong_shape(name: &str, expected: &str, shape: &[usize]) -> PyErr {
    let sides: Vec<String> = shape.iter().map(usize::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    PyValueError::new_err(format!(
        "{name} has the shape ({}{comma}), not {expected}",
        sides.join(", ")
    ))
}

/// Rows of (…, 6) split into their halves: origins and directions.
pub(crate) fn halves<'py>(rays: &Bound<'py, PyAny>) -> PyResult<[Bound<'py, PyAny>; 2]> {
    static SPLIT: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let rays = as_array("rays", rays)?;
    let halves = numpy(rays.py(), &SPLIT, "split")?.call1((rays, 2, -1))?;
    Ok([halves.get_item(0)?, halves.get_item(1)?])
}

/// Three vertex rows for each triangle, as 32-bit numbers.
///
/// # Errors
/// `TypeError` for anything but integers, `ValueError` for any shape but (m, 3), `IndexError` for
/// negative numbers and those beyond 32 bits.
pub(crate) fn faces(object: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    let array = as_contiguous::<i64>("faces", object)?;
    let array = array.try_readonly().map_err(value_error)?;
    if !matches!(array.shape(), [_, 3]) && !array.shape().contains(&0) {
        return Err(wrong_shape("faces", "(m, 3)", array.shape()));
    }
    let rows = array.as_slice().map_err(value_error)?.as_chunks().0;
    let row = |(k, row): (usize, &[i64; 3])| {
        let [a, b, c] = row.map(|index| u32::try_from(index).ok());
        a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]).ok_or_else(|| {
            PyIndexError::new_err(format!("face {k} is {row:?}: vertices are numbered from 0"))
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
    match *shape {
        [len] if len == column.len() => Ok(column.into_pyarray(py).to_dyn().clone()),
        _ => column.into_pyarray(py).reshape(shape.to_vec()),
    }
}
