//! The caller's rays: two arrays, or one with both origins and directions.

use crate::arrays::{Floats, as_contiguous, halves, wrong_shape};
use crate::coordinates::Coordinates;
use crate::errors::value_error;
use phalanx::{RayRows, TMax};
use pyo3::prelude::*;

/// Rays in the caller's layout, one per row.
pub(crate) struct Rays<'py> {
    /// Shape of the answers: that of the rays without the last dimension.
    pub(crate) shape: Vec<usize>,
    origins: Floats<'py>,
    /// `None` if each row has an origin and a direction.
    directions: Option<Floats<'py>>,
    tmax: TMaxArray<'py>,
}

enum TMaxArray<'py> {
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
        frame: &Coordinates,
    ) -> PyResult<Rays<'py>> {
        let (origins, directions) = match directions {
            None if frame.is_identity() => {
                let rays = Floats::of("rays", origins)?;
                check_side_by_side(rays.shape())?;
                (rays, None)
            }
            None => {
                // Split before rounding: relative to a large origin, positions are small.
                let rays = as_contiguous("rays", origins, "float64")?;
                check_side_by_side(&rays.getattr("shape")?.extract::<Vec<usize>>()?)?;
                let [origins, directions] = halves(&rays)?;
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
        let tmax = TMaxArray::of(tmax, &shape)?;
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

    /// A range of at least one ray.
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
                TMaxArray::All(tmax) => TMax::All(*tmax),
                TMaxArray::Each(each) => TMax::Each(&each.numbers()?[from..to]),
            },
        })
    }
}

impl<'py> TMaxArray<'py> {
    fn of(tmax: Option<&Bound<'py, PyAny>>, shape: &[usize]) -> PyResult<TMaxArray<'py>> {
        let Some(tmax) = tmax else {
            return Ok(TMaxArray::All(f32::INFINITY));
        };
        let each = Floats::of("tmax", tmax)?;
        if let (true, [all]) = (each.shape().is_empty(), each.numbers()?) {
            return Ok(TMaxArray::All(*all));
        }
        if each.shape() != shape {
            let wanted = format!("that of the rays, {shape:?}, nor is it a single number");
            return Err(wrong_shape("tmax", &wanted, each.shape()));
        }
        Ok(TMaxArray::Each(each))
    }
}

/// Refuses any shape but (…, 6).
fn check_side_by_side(shape: &[usize]) -> PyResult<()> {
    if shape.last() != Some(&6) {
        let wanted = "(…, 6): without directions, each row is an origin and a direction";
        return Err(wrong_shape("rays", wanted, shape));
    }
    Ok(())
}

/// Two arrays of (…, 3), broadcast to each other by numpy's rules.
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
