//! The caller's rays: two arrays, or one with both origins and directions; their limits, and what
//! they may hit.

use crate::arrays::{Floats, as_contiguous, halves, numpy, wrong_shape};
use crate::coordinates::Coordinates;
use crate::errors::value_error;
use numpy::{PyArrayMethods, PyUntypedArrayMethods};
use phalanx::{BatchFilter, NO_PRIM, PerRay, RayRows};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

/// Rays in the caller's layout, one per row.
pub(crate) struct Rays<'py> {
    /// Shape of the answers: that of the rays without the last dimension.
    pub(crate) shape: Vec<usize>,
    origins: Floats<'py>,
    /// `None` if each row has an origin and a direction.
    directions: Option<Floats<'py>>,
    tmax: FloatPerRay<'py>,
}

/// Filters in the caller's layout: `tnear`, `mask` and `ignore`.
pub(crate) struct RayFilters<'py> {
    tnear: FloatPerRay<'py>,
    mask: IntegerPerRay,
    ignore: IntegerPerRay,
}

/// Keyword arguments of a query that make up its filters.
pub(crate) type FilterArguments<'a, 'py> = [Option<&'a Bound<'py, PyAny>>; 3];

enum FloatPerRay<'py> {
    All(f32),
    Each(Floats<'py>),
}

enum IntegerPerRay {
    All(u32),
    Each(Vec<u32>),
}

impl<'py> Rays<'py> {
    /// Takes `origins` and `directions` of (…, 3), either of which may be one row for all, or
    /// `origins` of (…, 6) alone; `tmax` is a number, or an array with one for each ray. Arrays
    /// of (0,) are no rays.
    pub(crate) fn of(
        origins: &Bound<'py, PyAny>,
        directions: Option<&Bound<'py, PyAny>>,
        tmax: Option<&Bound<'py, PyAny>>,
        frame: &Coordinates,
    ) -> PyResult<Rays<'py>> {
        let (origins, directions) = match directions {
            None if frame.is_identity() => (side_by_side(Floats::of("rays", origins)?)?, None),
            given => {
                let [origins, directions] = match given {
                    Some(directions) => [origins.clone(), directions.clone()],
                    None => {
                        // Split before rounding: relative to a large origin, positions are small.
                        let rays = as_contiguous::<f64>("rays", origins)?;
                        check_side_by_side(rays.shape())?;
                        halves(&rays)?
                    }
                };
                let origins = frame.points("origins", &origins)?;
                let directions = frame.differences("directions", &directions)?;
                let [origins, directions] = of_one_shape(origins, directions)?;
                (origins, Some(directions))
            }
        };
        let sides = origins.shape().len();
        let shape = origins.shape()[..sides - 1].to_vec();
        let tmax = FloatPerRay::of("tmax", tmax, f32::INFINITY, &shape)?;
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
            tmax: self.tmax.rows(from, to)?,
        })
    }
}

impl<'py> RayFilters<'py> {
    /// The filters of rays of this shape; `None` if none is given.
    pub(crate) fn of(
        [tnear, mask, ignore]: FilterArguments<'_, 'py>,
        shape: &[usize],
    ) -> PyResult<Option<RayFilters<'py>>> {
        if tnear.is_none() && mask.is_none() && ignore.is_none() {
            return Ok(None);
        }
        // −1, the prim_id of a miss, is no primitive.
        let prim = |n: i64| match n {
            -1 => Some(NO_PRIM),
            n => u32::try_from(n).ok(),
        };
        Ok(Some(RayFilters {
            tnear: FloatPerRay::of("tnear", tnear, 0.0, shape)?,
            mask: IntegerPerRay::of("mask", mask, u32::MAX, shape, mask_bits)?,
            ignore: IntegerPerRay::of("ignore", ignore, NO_PRIM, shape, prim)?,
        }))
    }

    /// The filters of a range of rays.
    pub(crate) fn rows(&self, from: usize, to: usize) -> PyResult<BatchFilter<'_>> {
        Ok(BatchFilter {
            tnear: self.tnear.rows(from, to)?,
            mask: self.mask.rows(from, to),
            ignore: self.ignore.rows(from, to),
            accept: None,
        })
    }
}

impl<'py> FloatPerRay<'py> {
    fn of(
        name: &str,
        given: Option<&Bound<'py, PyAny>>,
        default: f32,
        shape: &[usize],
    ) -> PyResult<FloatPerRay<'py>> {
        let Some(given) = given else {
            return Ok(FloatPerRay::All(default));
        };
        if let Ok(all) = given.extract::<f64>() {
            return Ok(FloatPerRay::All(all as f32));
        }
        let each = Floats::of(name, given)?;
        if let (true, [all]) = (each.shape().is_empty(), each.numbers()?) {
            return Ok(FloatPerRay::All(*all));
        }
        check_per_ray(name, each.shape(), shape)?;
        Ok(FloatPerRay::Each(each))
    }

    fn rows(&self, from: usize, to: usize) -> PyResult<PerRay<'_, f32>> {
        Ok(match self {
            FloatPerRay::All(all) => PerRay::All(*all),
            FloatPerRay::Each(each) => PerRay::Each(&each.numbers()?[from..to]),
        })
    }
}

impl IntegerPerRay {
    fn of(
        name: &str,
        given: Option<&Bound<'_, PyAny>>,
        default: u32,
        shape: &[usize],
        convert: impl Fn(i64) -> Option<u32>,
    ) -> PyResult<IntegerPerRay> {
        let Some(given) = given else {
            return Ok(IntegerPerRay::All(default));
        };
        let array = as_contiguous::<i64>(name, given)?;
        let array = array.try_readonly().map_err(value_error)?;
        let word = |&number: &i64| {
            let word = convert(number);
            word.ok_or_else(|| value_error(format!("{name} has {number}: 32 bits are too few")))
        };
        let each = array.as_slice()?.iter().map(word);
        let each = each.collect::<PyResult<Vec<u32>>>()?;
        if let (true, [all]) = (array.shape().is_empty(), &each[..]) {
            return Ok(IntegerPerRay::All(*all));
        }
        check_per_ray(name, array.shape(), shape)?;
        Ok(IntegerPerRay::Each(each))
    }

    fn rows(&self, from: usize, to: usize) -> PerRay<'_, u32> {
        match self {
            IntegerPerRay::All(all) => PerRay::All(*all),
            IntegerPerRay::Each(each) => PerRay::Each(&each[from..to]),
        }
    }
}

/// The 32 bits of a mask, which Python writes as negative numbers, too: `~1` is −2.
pub(crate) fn mask_bits(mask: i64) -> Option<u32> {
    let signed = i32::try_from(mask).map(|mask| mask as u32);
    signed.or_else(|_| u32::try_from(mask)).ok()
}

fn check_per_ray(name: &str, given: &[usize], shape: &[usize]) -> PyResult<()> {
    if given != shape {
        let expected = format!("that of the rays, {shape:?}, nor is it a single number");
        return Err(wrong_shape(name, &expected, given));
    }
    Ok(())
}

/// Rays of (…, 6), or none.
fn side_by_side(rays: Floats<'_>) -> PyResult<Floats<'_>> {
    if rays.shape() == [0] {
        return Floats::made(rays.array.py(), Vec::new(), &[0, 6]);
    }
    check_side_by_side(rays.shape())?;
    Ok(rays)
}

/// Refuses any shape but (…, 6).
fn check_side_by_side(shape: &[usize]) -> PyResult<()> {
    if shape.last() != Some(&6) && shape != [0] {
        let expected = "(…, 6): without directions, each row is an origin and a direction";
        return Err(wrong_shape("rays", expected, shape));
    }
    Ok(())
}

/// Two arrays of (…, 3), broadcast to each other by numpy's rules.
fn of_one_shape<'py>(a: Floats<'py>, b: Floats<'py>) -> PyResult<[Floats<'py>; 2]> {
    static BROADCAST: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let py = a.array.py();
    let no_rows = |array: Floats<'py>| match array.shape() {
        [0] => Floats::made(py, Vec::new(), &[0, 3]),
        _ => Ok(array),
    };
    let (a, b) = (no_rows(a)?, no_rows(b)?);
    for (name, array) in [("origins", &a), ("directions", &b)] {
        if array.shape().last() != Some(&3) {
            return Err(wrong_shape(name, "(…, 3)", array.shape()));
        }
    }
    if a.shape() == b.shape() {
        return Ok([a, b]);
    }
    let both = numpy(py, &BROADCAST, "broadcast_arrays")?;
    let both = both.call1((a.array.as_any(), b.array.as_any()));
    let both = both.map_err(|_| {
        let shapes = format!("{:?} and {:?}", a.shape(), b.shape());
        value_error(format!("origins and directions differ in shape: {shapes}"))
    })?;
    Ok([
        Floats::of("origins", &both.get_item(0)?)?,
        Floats::of("directions", &both.get_item(1)?)?,
    ])
}
