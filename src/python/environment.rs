//! The environment of a scene.

use crate::arrays::{Floats, shaped, wrong_shape};
use crate::errors::{open_error, value_error};
use crate::scene::PyScene;
use phalanx::formats::{EnvironmentSource, environment_scale};
use phalanx::scene::{Environment, EnvironmentLight, EnvironmentMap, EnvironmentTexels};
use pyo3::prelude::*;
use std::path::PathBuf;

/// An environment as passed from Python.
#[derive(FromPyObject)]
enum PyEnvironment<'py> {
    #[pyo3(annotation = "str or os.PathLike")]
    Named(PathBuf),
    #[pyo3(annotation = "(r, g, b)")]
    Color([f32; 3]),
    #[pyo3(annotation = "(height, width, 3)")]
    Map(Bound<'py, PyAny>),
}

impl PyEnvironment<'_> {
    fn light(self, py: Python<'_>) -> PyResult<EnvironmentLight> {
        let source = match self {
            PyEnvironment::Map(array) => return map(&array),
            PyEnvironment::Color(color) => EnvironmentSource::Color(color.into()),
            PyEnvironment::Named(name) if name.as_os_str() == "sky" => EnvironmentSource::Sky,
            PyEnvironment::Named(path) => EnvironmentSource::File(path),
        };
        let name = match &source {
            EnvironmentSource::File(path) => path.to_string_lossy().into_owned(),
            _ => String::new(),
        };
        let (light, remark) = py
            .detach(|| source.light(None))
            .map_err(|e| open_error(&name, e.into()))?;
        if let Some(remark) = remark {
            py.import("warnings")?
                .call_method1("warn", (format!("{name}: {remark}"),))?;
        }
        Ok(light)
    }
}

/// An array as a picture of all directions.
fn map(array: &Bound<'_, PyAny>) -> PyResult<EnvironmentLight> {
    let floats = Floats::of("environment", array)?;
    let shape = floats.shape();
    let &[height, width, 3] = shape else {
        return Err(wrong_shape("environment", "(height, width, 3)", shape));
    };
    let mut texels = EnvironmentTexels::Float(Default::default());
    let (rows, _) = floats.numbers()?.as_chunks();
    texels.extend(rows.iter().copied());
    let [width, height] = [width, height].map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    let map = EnvironmentMap {
        width,
        height,
        texels,
    };
    Ok(EnvironmentLight::Map(map.into()))
}

#[pymethods]
impl PyScene {
    /// Surroundings from infinitely far away, seen behind the scene, in
    /// mirrors and through glass by render(): None if there are none.
    ///
    /// Set it to the name of a file (Radiance HDR, OpenEXR or PFM), to 'sky',
    /// to a colour (r, g, b), or to an array (height, width, 3) of linear
    /// radiance in equirectangular projection, the zenith first. It reads as
    /// an array, or as two colours (2, 3), straight above and below.
    ///
    /// Raises OSError if the system cannot read the file, ValueError for its
    /// contents, for another shape, and for radiance below zero or not finite.
    #[getter]
    fn environment<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let scene = self.now(py).scene;
        let Some(environment) = &scene.environment else {
            return Ok(None);
        };
        let array = match &environment.light {
            EnvironmentLight::Gradient { nadir, zenith } => {
                let colors = [zenith.to_array(), nadir.to_array()];
                shaped(py, colors.as_flattened().to_vec(), &[2, 3])?
            }
            EnvironmentLight::Map(map) => {
                let texels = (0..map.texels.rows()).flat_map(|k| map.texels.get(k).to_array());
                let shape = [map.height as usize, map.width as usize, 3];
                shaped(py, texels.collect(), &shape)?
            }
        };
        Ok(Some(array.into_any()))
    }

    #[setter]
    fn set_environment(&self, py: Python<'_>, value: Option<PyEnvironment<'_>>) -> PyResult<()> {
        let light = value.map(|value| value.light(py)).transpose()?;
        let (scene, turn) = (self.now(py).scene, self.environment_turn(py));
        let environment = light.map(|light| {
            let scale = environment_scale(&light, &scene);
            let mut environment = Environment::new(light, scene.defaulted.up, turn);
            environment.scale = scale;
            environment
        });
        self.surround(py, environment)
    }

    /// Turn of the environment about the up axis, in degrees, counter-clockwise
    /// as seen from above; 0 without an environment.
    ///
    /// Raises ValueError for a number that is not finite, and without an
    /// environment.
    #[getter]
    fn environment_turn(&self, py: Python<'_>) -> f64 {
        let scene = self.now(py).scene;
        let placement = scene.environment.as_ref().map(Environment::placement);
        placement.unwrap_or_default().1
    }

    #[setter]
    fn set_environment_turn(&self, py: Python<'_>, degrees: f64) -> PyResult<()> {
        let environment = self.now(py).scene.environment.clone();
        let mut environment =
            environment.ok_or_else(|| value_error("there is no environment to turn"))?;
        environment.place(environment.placement().0, degrees);
        self.surround(py, Some(environment))
    }
}

impl PyScene {
    /// Replaces the environment.
    fn surround(&self, py: Python<'_>, environment: Option<Environment>) -> PyResult<()> {
        let is_wrong = |environment: &Environment| {
            !environment.is_valid() || environment.first_invalid_texel().is_some()
        };
        if environment.as_ref().is_some_and(is_wrong) {
            return Err(value_error(
                "an environment has 1 to 16384 texels a side, of finite radiance not below zero",
            ));
        }
        self.change(py, |scene| {
            scene.defaulted.sky = false;
            scene.environment = environment;
            Ok(())
        })
    }
}
