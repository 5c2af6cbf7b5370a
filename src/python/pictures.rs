//! Pictures of a scene: arrays of pixels.

use crate::arrays::shaped;
use crate::coordinates::{Coordinates, transform};
use crate::errors::{frame_error, value_error};
use crate::interrupt::stoppable;
use crate::scene::{PyScene, Snapshot};
use phalanx::Scene;
use phalanx::film::{Aov, Aovs, Film};
use phalanx::formats::{Overrides, override_scene};
use phalanx::frame::{AccelRef, Control, Frame, Settings, render_with};
use phalanx::glam::DVec3;
use phalanx::image::Exposure;
use phalanx::jobs::spec::AsText;
use phalanx::jobs::{ExposureSpec, measure_exposure};
use phalanx::scene::{FileView, OutputEncoding, ViewError, check_image_size};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Largest distance of a camera's axis, of length 1, from where the other two put it: 0.2 degrees,
/// which three decimals of a matrix need.
const MAX_SKEW: f64 = 1.0 / 256.0;

/// A camera as passed from Python, with its vertical field of view in degrees.
#[derive(FromPyObject)]
pub(crate) enum PyCamera<'py> {
    #[pyo3(annotation = "(from, at, up, fov)")]
    LookAt([f64; 3], [f64; 3], [f32; 3], f32),
    #[pyo3(annotation = "(from, at, up, fov, height)")]
    Parallel([f64; 3], [f64; 3], [f32; 3], f32, f64),
    #[pyo3(annotation = "(c2w, fov)")]
    Pose(Bound<'py, PyAny>, f32),
}

type LookAt = ([f64; 3], [f64; 3], [f32; 3], f32);

#[pymethods]
impl PyScene {
    /// Renders a picture: float32, (height, width, 3), linear radiance, top
    /// row first.
    ///
    /// camera : (from, at, up, fov) or (c2w, fov)
    ///     Two points, a vector, and the vertical field of view in degrees;
    ///     or a matrix, (3, 4) or (4, 4), from the camera's coordinates to the
    ///     scene's, as in NeRF's data, OpenGL and Blender: its columns are the
    ///     directions right, up and backward, of any length, and the position.
    ///     For OpenCV's and COLMAP's, negate the second and third column.
    ///     (from, at, up, fov, height) has parallel rays of that height.
    ///     None for the file's camera, or one that frames everything.
    /// size : (width, height) in pixels; None for the file's, or 640 by 480
    /// spp : int
    ///     Samples per pixel; None for 4, or for 1 if the scene is from a .test
    ///     or NFF file, or a standard scene.
    /// max_depth : int
    ///     Maximum number of bounces; None for the scene's.
    /// aovs : list of str
    ///     Additional layers, such as 'depth', 'ns', 'albedo', 'primitive'.
    ///     The answer is then a dictionary: 'color', and a layer for each
    ///     name. Layers with one number per pixel are (height, width), those
    ///     of primitives and materials are int32.
    /// threads : int; 0 or None for one per CPU
    /// exposure : float, or 'auto'
    ///     Stops: the picture, without its layers, is multiplied by two to the
    ///     power of them. 'auto' measures what suits it.
    /// tone : 'linear' or 'neutral'
    ///     Curve after the exposure, up to 1: Khronos PBR Neutral. For screens,
    ///     the transfer of sRGB comes next.
    ///
    /// Without the last two, these are the bits that `phalanx render` writes
    /// to an OpenEXR file.
    /// Raises ValueError for an invalid size or layer, and for a camera with
    /// numbers that are not finite, without a direction, or whose axes are not
    /// perpendicular or mirror the picture; TypeError for another tuple.
    #[pyo3(signature = (camera=None, size=None, spp=None, max_depth=None, aovs=None, threads=None, exposure=None, tone="linear"))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: Option<PyCamera<'_>>,
        size: Option<(u32, u32)>,
        spp: Option<u32>,
        max_depth: Option<u32>,
        aovs: Option<Vec<String>>,
        threads: Option<i64>,
        exposure: Option<Bound<'_, PyAny>>,
        tone: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let curve = AsText::parse(tone).map_err(|why| value_error(format!("tone: {why}")))?;
        let exposure = exposure.map_or(Ok(ExposureSpec::Stops(0.0)), |given| {
            ExposureSpec::parse(&given.str()?.to_cow()?)
                .map_err(|why| value_error(format!("exposure: {why}")))
        })?;
        let layered = aovs.is_some();
        let names = aovs.unwrap_or_default();
        let layers = names.iter().map(|name| layer(name));
        let layers: Vec<Aov> = layers.collect::<PyResult<_>>()?;
        let requested = layers.iter().copied().fold(Aovs::default(), Aovs::with);
        let picture = (camera, size, exposure);
        let (mut frame, stops) =
            self.frame_of(py, picture, spp, max_depth, (requested, threads))?;
        let exposure = Exposure {
            stops,
            curve: curve.0,
            ..OutputEncoding::LINEAR.into()
        };
        let (map, [red, green, blue]) = (exposure.mapping(), &mut frame.film.planes);
        for ((r, g), b) in red.iter_mut().zip(green).zip(blue) {
            [*r, *g, *b] = map([*r, *g, *b]);
        }
        let color = interleaved(py, &frame.film, &frame.film.planes)?;
        if !layered {
            return Ok(color);
        }
        let pictures = PyDict::new(py);
        pictures.set_item("color", color)?;
        for (name, aov) in names.iter().zip(layers) {
            pictures.set_item(name, plane(py, &frame.film, aov)?)?;
        }
        Ok(pictures.into_any())
    }

    /// The camera of a picture of this size where none is given, as a tuple
    /// that render() takes: (from, at, up, fov), or (from, at, up, fov,
    /// height) for parallel rays. It gives the same picture to the bit.
    #[pyo3(signature = (size=None))]
    fn camera<'py>(
        &self,
        py: Python<'py>,
        size: Option<(u32, u32)>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let scene = self.now(py).framed(None, size)?;
        let view = scene.shortest_view(&scene.view);
        let [eye, center] = [view.eye, view.center].map(|point| point.to_array());
        let (up, fov) = (view.up.to_array(), view.fovy);
        match view.ortho {
            None => (eye, center, up, fov).into_pyobject(py),
            Some(height) => (eye, center, up, fov, height).into_pyobject(py),
        }
    }

    /// Distances along the camera's rays: float32, (height, width), inf for a
    /// miss.
    ///
    /// Arguments and errors as for render().
    #[pyo3(signature = (camera=None, size=None, threads=None))]
    fn depth<'py>(
        &self,
        py: Python<'py>,
        camera: Option<PyCamera<'_>>,
        size: Option<(u32, u32)>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let requested = Aovs::default().with(Aov::Depth);
        let picture = (camera, size, ExposureSpec::Stops(0.0));
        let (frame, _) = self.frame_of(py, picture, Some(1), Some(0), (requested, threads))?;
        plane(py, &frame.film, Aov::Depth)
    }
}

impl PyScene {
    fn frame_of(
        &self,
        py: Python<'_>,
        (camera, size, exposure): (Option<PyCamera<'_>>, Option<(u32, u32)>, ExposureSpec),
        spp: Option<u32>,
        max_depth: Option<u32>,
        (aovs, threads): (Aovs, Option<i64>),
    ) -> PyResult<(Frame, f32)> {
        let threads = crate::scene::thread_count(threads)?;
        let now = self.now(py);
        let bvh = now.tree(py)?;
        let scene = now.framed(camera, size)?;
        let mut settings = Settings {
            threads,
            aovs,
            ..Settings::of(&scene)
        };
        settings.sampling.spp = spp.unwrap_or(settings.sampling.spp);
        settings.max_depth = max_depth.unwrap_or(settings.max_depth);
        let control = Control::default();
        let work = || {
            let tree = AccelRef::Packets(&bvh);
            let stops = match exposure {
                ExposureSpec::Stops(stops) => stops,
                ExposureSpec::Auto => measure_exposure(&scene, tree, &settings, &control)?,
            };
            Ok((render_with(&scene, tree, &settings, &control)?, stops))
        };
        stoppable(py, &control.stop, work)?.map_err(frame_error)
    }
}

impl Snapshot {
    /// The scene with the given camera and size, if any.
    pub(crate) fn framed(
        &self,
        camera: Option<PyCamera<'_>>,
        size: Option<(u32, u32)>,
    ) -> PyResult<Scene> {
        if let Some((width, height)) = size {
            check_image_size(width.into(), height.into()).map_err(value_error)?;
        }
        let overrides = Overrides {
            view: camera.map(|camera| self.view_of(camera)).transpose()?,
            size,
            ..Overrides::default()
        };
        // A copy shares the columns of an opened scene; other columns are copied.
        let mut scene = (*self.scene).clone();
        if let Some((width, height)) = size {
            (scene.width, scene.height) = (width, height);
        }
        override_scene(&mut scene, &overrides, 0).map_err(value_error)?;
        scene.validate().map_err(value_error)?;
        Ok(scene)
    }

    fn view_of(&self, camera: PyCamera<'_>) -> PyResult<FileView> {
        let mut ortho = None;
        let (eye, center, up, fovy) = match camera {
            PyCamera::LookAt(eye, center, up, fovy) => (eye, center, up, fovy),
            PyCamera::Parallel(eye, center, up, fovy, height) => {
                ortho = Some(height);
                (eye, center, up, fovy)
            }
            PyCamera::Pose(pose, fovy) => look_at(&pose, fovy, &self.coordinates())?,
        };
        Ok(FileView {
            eye: eye.into(),
            center: center.into(),
            up: up.into(),
            fovy,
            ortho,
        })
    }
}

/// A camera with this map from its own coordinates: x to the right, y up, z backward. Scales are
/// ignored, as those of a camera's node in glTF are.
fn look_at(pose: &Bound<'_, PyAny>, fovy: f32, coordinates: &Coordinates) -> PyResult<LookAt> {
    let to_world = transform("c2w", pose, coordinates)?;
    if !to_world.is_finite() {
        return Err(value_error(ViewError::NotFinite));
    }
    let (m, eye) = (to_world.matrix3, to_world.translation);
    let [right, up, back] = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::normalize_or_zero);
    let skew = [right.cross(up) - back, up.cross(back) - right];
    if skew.iter().any(|skew| skew.length() > MAX_SKEW) {
        let why = "the columns of c2w are not the perpendicular directions right, up and backward";
        return Err(value_error(why));
    }
    // As far away as the scene's origin, so that rounding the points hardly turns the view.
    let center = eye - back * eye.length().max(1.0);
    let [eye, center] = [eye, center].map(|point| coordinates.outside(point.into()));
    Ok((eye, center, up.as_vec3().into(), fovy))
}

fn layer(name: &str) -> PyResult<Aov> {
    Aov::named(name).ok_or_else(|| {
        let names: Vec<&str> = Aov::ALL.iter().map(|(name, _)| *name).collect();
        let names = names.join(", ");
        value_error(format!("there is no layer {name:?}; layers are {names}"))
    })
}

/// A layer as an array.
fn plane<'py>(py: Python<'py>, film: &Film, aov: Aov) -> PyResult<Bound<'py, PyAny>> {
    let planes = film.layer(aov);
    if aov.channels().iter().any(|(_, is_id)| *is_id) {
        let ids = planes[0].iter().map(|id| id.to_bits() as i32);
        let shape = [film.height as usize, film.width as usize];
        return Ok(shaped(py, ids.collect(), &shape)?.into_any());
    }
    interleaved(py, film, planes)
}

/// Planes as an array, pixel after pixel.
fn interleaved<'py>(
    py: Python<'py>,
    film: &Film,
    planes: &[Vec<f32>],
) -> PyResult<Bound<'py, PyAny>> {
    let pixels = film.width as usize * film.height as usize;
    let numbers = (0..pixels).flat_map(|k| planes.iter().map(move |plane| plane[k]));
    let mut shape = vec![film.height as usize, film.width as usize];
    if planes.len() > 1 {
        shape.push(planes.len());
    }
    Ok(shaped(py, numbers.collect(), &shape)?.into_any())
}
