//! The caller's coordinates and the scene's: a scene may have an origin and a scale of its own.

use crate::arrays::{Floats, as_contiguous};
use phalanx::Scene;
use pyo3::prelude::*;

/// The map from the caller's coordinates to the scene's, (p − origin) · scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) origin: [f64; 3],
    pub(crate) scale: f64,
}

impl Frame {
    pub(crate) fn of(scene: &Scene) -> Frame {
        Frame {
            origin: scene.origin,
            scale: f64::from(scene.scale),
        }
    }

    pub(crate) fn is_identity(&self) -> bool {
        self.origin == [0.0; 3] && self.scale == 1.0
    }

    /// Points of the caller in the scene's coordinates. The difference is taken in double
    /// precision and rounded once.
    pub(crate) fn points<'py>(
        &self,
        name: &str,
        object: &Bound<'py, PyAny>,
    ) -> PyResult<Floats<'py>> {
        if self.is_identity() {
            return Floats::of(name, object);
        }
        let points = as_contiguous(name, object, "float64")?;
        let numpy = object.py().import("numpy")?;
        let moved = numpy.call_method1("subtract", (points, self.origin.to_vec()))?;
        Floats::of(name, &numpy.call_method1("multiply", (moved, self.scale))?)
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
        let differences = as_contiguous(name, object, "float64")?;
        let numpy = object.py().import("numpy")?;
        Floats::of(
            name,
            &numpy.call_method1("multiply", (differences, self.scale))?,
        )
    }

    /// A ray of the caller in the scene's coordinates, in double precision.
    pub(crate) fn ray(&self, origin: [f64; 3], direction: [f64; 3]) -> [[f64; 3]; 2] {
        [
            std::array::from_fn(|axis| (origin[axis] - self.origin[axis]) * self.scale),
            direction.map(|c| c * self.scale),
        ]
    }

    /// A point of the scene in the caller's coordinates.
    pub(crate) fn outside(&self, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| point[axis] / self.scale + self.origin[axis])
    }
}
