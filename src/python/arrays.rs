//! Arrays of the caller: checked, and converted where they are not float32 side by side.

use crate::errors::value_error;
use crate::frame::Frame;
use numpy::{IntoPyArray, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use phalanx::glam::{DAffine3, DMat3, DVec3};
use phalanx::{RayRows, TMax};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An array of float32, C-contiguous: the caller's own where it is one already, else a copy.
pub(crate) struct Floats<'py> {
    array: PyReadonlyArrayDyn<'py, f32>,
}

impl<'py> Floats<'py> {
    /// Takes any array of numbers; `name` is what errors call it.
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

/// A numpy array of one type, C-contiguous, aligned and in the machine's byte order; the same array
/// if it is so already.
///
/// # Errors
/// `TypeError` for anything but real numbers, `OverflowError` or `ValueError` of numpy.
pub(crate) fn as_contiguous<'py>(
    name: &str,
    object: &Bound<'py, PyAny>,
    dtype: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let numpy = object.py().import("numpy")?;
    let array = numpy
        .call_method1("asarray", (object,))
        .map_err(|error| PyTypeError::new_err(format!("{name} is no array of numbers: {error}")))?;
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

/// A `ValueError` on an array's shape.
pub(crate) fn wrong_shape(name: &str, wanted: &str, shape: &[usize]) -> PyErr {
    let sides: Vec<String> = shape.iter().map(usize::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    PyValueError::new_err(format!(
        "{name} has the shape ({}{comma}), not {wanted}",
        sides.join(", ")
    ))
}

/// Three rows of vertices for each triangle, as 32-bit numbers.
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
                "face {k} is {row:?}: vertices are numbered from 0 on"
            ))
        })
    };
    rows.iter().enumerate().map(row).collect()
}

/// A map of (3, 4) or (4, 4) from a prototype, in its own coordinates, to the scene's.
///
/// # Errors
/// `ValueError` for any other shape, and for a last row that is not (0, 0, 0, 1).
pub(crate) fn transform(object: &Bound<'_, PyAny>, frame: &Frame) -> PyResult<DAffine3> {
    let array = as_contiguous("transform", object, "float64")?;
    let array = array.cast_into::<PyArrayDyn<f64>>()?;
    if !matches!(array.shape(), [3 | 4, 4]) {
        return Err(wrong_shape("transform", "(4, 4) or (3, 4)", array.shape()));
    }
    let numbers = array.to_vec().map_err(value_error)?;
    let rows: &[[f64; 4]] = numbers.as_chunks().0;
    if rows.get(3).is_some_and(|row| *row != [0.0, 0.0, 0.0, 1.0]) {
        return Err(value_error("the last row of transform is not (0, 0, 0, 1)"));
    }
    let column = |k: usize| DVec3::new(rows[0][k], rows[1][k], rows[2][k]);
    let [offset, _] = frame.ray(column(3).into(), [0.0; 3]);
    Ok(DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: offset.into(),
    })
}

/// Rays as the caller has them, one to a row.
pub(crate) struct Rays<'py> {
    /// Shape of the answers: that of the rays without the last side.
    pub(crate) shape: Vec<usize>,
    origins: Floats<'py>,
    /// `None` where origin and direction lie side by side.
    directions: Option<Floats<'py>>,
    tmax: Limits<'py>,
}

enum Limits<'py> {
    All(f32),
    Each(Floats<'py>),
}

impl<'py> Rays<'py> {
    /// Takes `origins` and `directions` of (…, 3), either of which may be one row for all, or
    /// `origins` of (…, 6) alone; `tmax` is a number, or an array with one for each ray.
    pub(crate) fn of(
        origins: &Bound<'py, PyAny>,
        directions: Option<&Bound<'py, PyAny>>,
        tmax: Option<&Bound<'py, PyAny>>,
        frame: &Frame,
    ) -> PyResult<Rays<'py>> {
        let (origins, directions) = match directions {
            None if frame.is_identity() => (side_by_side(origins)?, None),
            None => {
                let [origins, directions] = halves(&side_by_side(origins)?)?;
                let origins = frame.points("origins", &origins)?;
                (origins, Some(frame.differences("directions", &directions)?))
            }
            Some(directions) => {
                let origins = frame.points("origins", origins)?;
                let directions = frame.differences("directions", directions)?;
                let [origins, directions] = of_one_shape(origins, directions)?;
                (origins, Some(directions))
            }
        };
        let sides = origins.shape().len();
        let shape = origins.shape()[..sides - 1].to_vec();
        let tmax = Limits::of(tmax, &shape)?;
        Ok(Rays {
            shape,
            origins,
            directions,
            tmax,
        })
    }

    /// Number of rays.
    pub(crate) fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Some of the rays, one at least.
    pub(crate) fn rows(&self, from: usize, to: usize) -> PyResult<RayRows<'_>> {
        let origin = self.origins.numbers()?;
        let (stride, direction) = match &self.directions {
            Some(directions) => (3, directions.numbers()?),
            None => (6, origin.get(3..).unwrap_or_default()),
        };
        let part = |all| {
            let all: &[f32] = all;
            &all[from * stride..][..(to - from - 1) * stride + 3]
        };
        Ok(RayRows {
            origin: part(origin),
            direction: part(direction),
            stride,
            tmax: match &self.tmax {
                Limits::All(tmax) => TMax::All(*tmax),
                Limits::Each(each) => TMax::Each(&each.numbers()?[from..to]),
            },
        })
    }
}

impl<'py> Limits<'py> {
    fn of(tmax: Option<&Bound<'py, PyAny>>, shape: &[usize]) -> PyResult<Limits<'py>> {
        let Some(tmax) = tmax else {
            return Ok(Limits::All(f32::INFINITY));
        };
        let each = Floats::of("tmax", tmax)?;
        if let (true, [all]) = (each.shape().is_empty(), each.numbers()?) {
            return Ok(Limits::All(*all));
        }
        if each.shape() != shape {
            let wanted = format!("that of the rays, {shape:?}, and it is no single number");
            return Err(wrong_shape("tmax", &wanted, each.shape()));
        }
        Ok(Limits::Each(each))
    }
}

/// Rays of (…, 6): an origin and a direction to each row.
pub(crate) fn side_by_side<'py>(rays: &Bound<'py, PyAny>) -> PyResult<Floats<'py>> {
    let rays = Floats::of("rays", rays)?;
    if rays.shape().last() != Some(&6) {
        let wanted = "(…, 6): without directions, each row is an origin and a direction";
        return Err(wrong_shape("rays", wanted, rays.shape()));
    }
    Ok(rays)
}

/// The two halves of rows of six.
fn halves<'py>(rays: &Floats<'py>) -> PyResult<[Bound<'py, PyAny>; 2]> {
    let numpy = rays.array.py().import("numpy")?;
    let halves = numpy.call_method1("split", (rays.array.as_any(), 2, -1))?;
    Ok([halves.get_item(0)?, halves.get_item(1)?])
}

/// Two arrays of (…, 3), of which one may have fewer sides: numpy's rules of broadcasting.
fn of_one_shape<'py>(a: Floats<'py>, b: Floats<'py>) -> PyResult<[Floats<'py>; 2]> {
    for (name, array) in [("origins", &a), ("directions", &b)] {
        if array.shape().last() != Some(&3) {
            return Err(wrong_shape(name, "(…, 3)", array.shape()));
        }
    }
    if a.shape() == b.shape() {
        return Ok([a, b]);
    }
    let numpy = a.array.py().import("numpy")?;
    let both = numpy.call_method1("broadcast_arrays", (a.array.as_any(), b.array.as_any()));
    let both = both.map_err(|_| {
        let shapes = format!("{:?} and {:?}", a.shape(), b.shape());
        value_error(format!("origins and directions differ in shape: {shapes}"))
    })?;
    Ok([
        Floats::of("origins", &both.get_item(0)?)?,
        Floats::of("directions", &both.get_item(1)?)?,
    ])
}

/// A column of answers as an array of some shape. Nothing is copied.
pub(crate) fn shaped<'py, T: numpy::Element>(
    py: Python<'py>,
    column: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    column.into_pyarray(py).reshape(shape.to_vec())
}
