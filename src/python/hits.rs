//! Answers: columns as numpy arrays.

use crate::arrays::{as_contiguous, asarray, get_or_make, halves, shaped};
use crate::coordinates::Coordinates;
use crate::errors::value_error;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use phalanx::{Hit, HitLists, NO_PRIM, RefinedHit, Scene, refine};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyTuple;
use std::fmt::Display;
use std::sync::Arc;

/// The closest hits of rays, as returned by Scene.intersect(). Each
/// attribute is an array of the rays' shape without its last dimension.
#[pyclass(name = "Hits", frozen, module = "phalanx")]
pub(crate) struct PyHits {
    /// float32: the distance in units of the ray's direction; inf for a miss.
    #[pyo3(get)]
    t: Py<PyArrayDyn<f32>>,
    /// float32: the weight of a triangle's second vertex; 0 for anything else.
    #[pyo3(get)]
    u: Py<PyArrayDyn<f32>>,
    /// float32: the weight of a triangle's third vertex; 0 for anything else.
    #[pyo3(get)]
    v: Py<PyArrayDyn<f32>>,
    /// int32: the primitive, counted over the whole scene; -1 for a miss.
    /// Scene.first_prim(geom_id) is the first of a geometry.
    #[pyo3(get)]
    prim_id: Py<PyArrayDyn<i32>>,
    /// int32: the number returned by add_mesh(), add_spheres() or
    /// add_instance(); -1 for a miss. save() keeps it. In scenes from files,
    /// only instances have one.
    #[pyo3(get)]
    geom_id: Py<PyArrayDyn<i32>>,
    shape: Vec<usize>,
    /// None of pickled hits, which have the next two.
    from: Option<RaySource>,
    normal: PyOnceLock<Py<PyArrayDyn<f32>>>,
    refined: PyOnceLock<RefinedArrays>,
}

/// Distances and points in double precision.
type RefinedArrays = (Py<PyArrayDyn<f64>>, Py<PyArrayDyn<f64>>);

/// The rays and the scene to which hits belong.
pub(crate) struct RaySource {
    scene: Arc<Scene>,
    coordinates: Coordinates,
    origins: Py<PyAny>,
    directions: Option<Py<PyAny>>,
}

/// Columns of hits, before Python owns them.
pub(crate) struct HitVectors {
    pub(crate) t: Vec<f32>,
    pub(crate) u: Vec<f32>,
    pub(crate) v: Vec<f32>,
    pub(crate) prim_id: Vec<u32>,
    pub(crate) geom_id: Vec<u32>,
}

impl HitVectors {
    /// Zeros, from memory that the system provides zeroed.
    pub(crate) fn new(rays: usize) -> HitVectors {
        HitVectors {
            t: vec![0.0; rays],
            u: vec![0.0; rays],
            v: vec![0.0; rays],
            prim_id: vec![0; rays],
            geom_id: vec![0; rays],
        }
    }
}

/// An array of double precision.
type Doubles<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Numbers as Python uses them: 2³² − 1 becomes −1.
fn signed(ids: Vec<u32>) -> Vec<i32> {
    bytemuck::cast_vec(ids)
}

/// A value that may be known already.
fn known<T>(py: Python<'_>, value: Option<T>) -> PyOnceLock<T> {
    let cell = PyOnceLock::new();
    // Nobody else has the cell yet.
    let _ = value.map(|value| cell.set(py, value));
    cell
}

/// Some rows of an array of answers, each of which has the shape `inner`.
fn picked<T: numpy::Element>(
    array: &Py<PyArrayDyn<T>>,
    rows: &Bound<'_, PyAny>,
    inner: &[usize],
) -> PyResult<Py<PyArrayDyn<T>>> {
    let array = array.bind(rows.py());
    let count = array.len() / inner.iter().product::<usize>();
    let flat = array.reshape([&[count], inner].concat())?;
    // A single row is no array yet.
    let picked = asarray(rows.py())?.call1((flat.as_any().get_item(rows)?,))?;
    Ok(picked.cast_into()?.unbind())
}

/// The shape of an array of vectors, one for each answer.
fn of_vectors(shape: &[usize]) -> Vec<usize> {
    [shape, &[3]].concat()
}

impl PyHits {
    pub(crate) fn new(
        py: Python<'_>,
        columns: HitVectors,
        shape: Vec<usize>,
        from: RaySource,
    ) -> PyResult<PyHits> {
        Ok(PyHits {
            t: shaped(py, columns.t, &shape)?.unbind(),
            u: shaped(py, columns.u, &shape)?.unbind(),
            v: shaped(py, columns.v, &shape)?.unbind(),
            prim_id: shaped(py, signed(columns.prim_id), &shape)?.unbind(),
            geom_id: shaped(py, signed(columns.geom_id), &shape)?.unbind(),
            shape,
            from: Some(from),
            normal: PyOnceLock::new(),
            refined: PyOnceLock::new(),
        })
    }

    fn in_double(&self, py: Python<'_>) -> PyResult<Vec<Option<RefinedHit>>> {
        let columns = (&self.t, &self.prim_id);
        self.source()?
            .in_double(py, &self.shape, columns, |row| row)
    }

    fn source(&self) -> PyResult<&RaySource> {
        let from = self.from.as_ref();
        from.ok_or_else(|| value_error("these hits have lost their rays"))
    }

    /// Rows of the flattened columns that an index picks.
    fn rows<'py>(&self, index: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let py = index.py();
        let count: usize = self.shape.iter().product();
        let rows = PyArray1::from_vec(py, (0..count as i64).collect());
        let picked = rows.reshape(self.shape.clone())?.as_any().get_item(index)?;
        Ok(as_contiguous::<i64>("an index", &picked)?.into_any())
    }
}

impl RaySource {
    /// Rays as the caller passed them to a query.
    pub(crate) fn of(
        scene: Arc<Scene>,
        origins: &Bound<'_, PyAny>,
        directions: Option<&Bound<'_, PyAny>>,
    ) -> RaySource {
        RaySource {
            coordinates: Coordinates::of(&scene),
            scene,
            origins: origins.clone().unbind(),
            directions: directions.map(|directions| directions.clone().unbind()),
        }
    }

    /// Hits in double precision; `None` for a miss. `shape` is that of the rays, `ray` maps a row
    /// of the columns to its ray.
    fn in_double(
        &self,
        py: Python<'_>,
        shape: &[usize],
        (t, prim_id): (&Py<PyArrayDyn<f32>>, &Py<PyArrayDyn<i32>>),
        ray: impl Fn(usize) -> usize + Sync,
    ) -> PyResult<Vec<Option<RefinedHit>>> {
        if shape.contains(&0) {
            return Ok(Vec::new());
        }
        let [origins, directions] = self.rays(py, shape)?;
        let t = t.bind(py).to_vec()?;
        let prim_id = prim_id.bind(py).to_vec()?;
        let (scene, coordinates) = (&self.scene, self.coordinates);
        let count = scene.id_count();
        let refined = |(row, (&t, &prim_id)): (usize, (&f32, &i32))| {
            // The caller may have written to the columns.
            let prim_id = u32::try_from(prim_id).ok()?;
            let ray = ray(row);
            let (&origin, &direction) = (origins.get(ray)?, directions.get(ray)?);
            (u64::from(prim_id) < count).then(|| {
                let [origin, direction] = coordinates.ray(origin, direction);
                let hit = Hit {
                    t,
                    u: 0.0,
                    v: 0.0,
                    prim_id,
                    geom_id: NO_PRIM,
                };
                refine(scene, origin, direction, &hit)
            })
        };
        let rows = || t.iter().zip(&prim_id).enumerate();
        Ok(py.detach(|| rows().map(refined).collect()))
    }

    /// Distances and points in double precision, for columns of this shape.
    fn refined<'py>(
        &self,
        py: Python<'py>,
        refined: &[Option<RefinedHit>],
        shape: &[usize],
    ) -> PyResult<(Doubles<'py>, Doubles<'py>)> {
        let t = |hit: &Option<RefinedHit>| hit.map_or(f64::INFINITY, |hit| hit.t);
        let t = refined.iter().map(t);
        let points = refined.iter().flat_map(|hit| match hit {
            Some(hit) => self.coordinates.outside(hit.point),
            None => [f64::NAN; 3],
        });
        let points = shaped(py, points.collect(), &of_vectors(shape))?;
        Ok((shaped(py, t.collect(), shape)?, points))
    }

    /// The source of some of the rays, by rows of them all.
    fn picked(&self, shape: &[usize], rows: &Bound<'_, PyAny>) -> PyResult<RaySource> {
        let py = rows.py();
        let pick = |array: Bound<'_, PyAny>, width: usize| {
            let numpy = py.import("numpy")?;
            let broadcast =
                numpy.call_method1("broadcast_to", (array, [shape, &[width]].concat()))?;
            let flat = broadcast.call_method1("reshape", (-1, width))?;
            Ok::<_, PyErr>(flat.get_item(rows)?.unbind())
        };
        let width = if self.directions.is_some() { 3 } else { 6 };
        let directions = self.directions.as_ref();
        let directions = directions.map(|directions| pick(directions.bind(py).clone(), 3));
        Ok(RaySource {
            scene: Arc::clone(&self.scene),
            coordinates: self.coordinates,
            origins: pick(self.origins.bind(py).clone(), width)?,
            directions: directions.transpose()?,
        })
    }

    /// The rays in double precision, for answers of this shape.
    fn rays(&self, py: Python<'_>, shape: &[usize]) -> PyResult<[Vec<[f64; 3]>; 2]> {
        let numpy = py.import("numpy")?;
        let (origins, directions) = match &self.directions {
            Some(directions) => (self.origins.bind(py).clone(), directions.bind(py).clone()),
            None => halves(self.origins.bind(py))?.into(),
        };
        let shape = of_vectors(shape);
        let rows = |name, array: Bound<'_, PyAny>| {
            let broadcast = numpy.call_method1("broadcast_to", (array, shape.clone()))?;
            let numbers = as_contiguous::<f64>(name, &broadcast)?.to_vec()?;
            Ok::<_, PyErr>(numbers.as_chunks().0.to_vec())
        };
        Ok([rows("origins", origins)?, rows("directions", directions)?])
    }
}

#[pymethods]
impl PyHits {
    /// bool: whether there is a hit.
    #[getter]
    fn hit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.prim_id.bind(py).as_any().call_method1("__ge__", (0,))
    }

    /// float32, with a last dimension of 3: the outward unit normal of the
    /// surface (for a triangle, that of its plane); 0 for a miss.
    ///
    /// Computed on first access, from the rays as they are then: do not change
    /// them before.
    #[getter]
    fn normal(&self, py: Python<'_>) -> PyResult<Py<PyArrayDyn<f32>>> {
        let make = || {
            let refined = self.in_double(py)?;
            let normals = refined.iter().flat_map(|hit| match hit {
                Some(hit) => hit.normal.map(|c| c as f32),
                None => [0.0; 3],
            });
            let normals = shaped(py, normals.collect(), &of_vectors(&self.shape))?;
            Ok(normals.unbind())
        };
        get_or_make(py, &self.normal, make).map(|n| n.clone_ref(py))
    }

    /// Distances and points in double precision: (t, points), float64, of the
    /// hits' shape, points with a last dimension of 3. Misses are inf and nan.
    ///
    /// Each is recomputed from the ray as it was given (in float64, if it was)
    /// and the primitive that was hit. Points are in the coordinates of the
    /// rays. Do not change the rays before.
    fn refine<'py>(&self, py: Python<'py>) -> PyResult<(Doubles<'py>, Doubles<'py>)> {
        let make = || {
            let source = self.source()?;
            let (t, points) = source.refined(py, &self.in_double(py)?, &self.shape)?;
            Ok((t.unbind(), points.unbind()))
        };
        let (t, points) = get_or_make(py, &self.refined, make)?;
        Ok((t.bind(py).clone(), points.bind(py).clone()))
    }

    /// Made by Scene.intersect(); this is for pickle.
    #[new]
    #[expect(clippy::too_many_arguments, reason = "a column each")]
    fn restored(
        py: Python<'_>,
        t: Py<PyArrayDyn<f32>>,
        u: Py<PyArrayDyn<f32>>,
        v: Py<PyArrayDyn<f32>>,
        prim_id: Py<PyArrayDyn<i32>>,
        geom_id: Py<PyArrayDyn<i32>>,
        normal: Py<PyArrayDyn<f32>>,
        refined: RefinedArrays,
    ) -> PyHits {
        PyHits {
            shape: t.bind(py).shape().to_vec(),
            t,
            u,
            v,
            prim_id,
            geom_id,
            from: None,
            normal: known(py, Some(normal)),
            refined: known(py, Some(refined)),
        }
    }

    /// Pickled hits have their normals and refined points instead of the scene.
    fn __reduce__<'py>(slf: &Bound<'py, PyHits>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, hits) = (slf.py(), slf.get());
        let (t, u, v) = (&hits.t, &hits.u, &hits.v);
        let (prim_id, geom_id) = (&hits.prim_id, &hits.geom_id);
        let (normal, refined) = (hits.normal(py)?, hits.refine(py)?);
        let state = (t, u, v, prim_id, geom_id, normal, refined);
        (slf.get_type(), state).into_pyobject(py)
    }

    fn __copy__(slf: Bound<'_, PyHits>) -> Bound<'_, PyHits> {
        slf
    }

    /// The hits of some rays, by any index of numpy into an array of the hits' shape.
    fn __getitem__(&self, index: &Bound<'_, PyAny>) -> PyResult<PyHits> {
        let py = index.py();
        let rows = self.rows(index)?;
        let from = self
            .from
            .as_ref()
            .map(|from| from.picked(&self.shape, &rows));
        let t = picked(&self.t, &rows, &[])?;
        let normal = self.normal.get(py).map(|array| picked(array, &rows, &[3]));
        let refined = self.refined.get(py).map(|(t, points)| {
            Ok::<_, PyErr>((picked(t, &rows, &[])?, picked(points, &rows, &[3])?))
        });
        Ok(PyHits {
            shape: t.bind(py).shape().to_vec(),
            t,
            u: picked(&self.u, &rows, &[])?,
            v: picked(&self.v, &rows, &[])?,
            prim_id: picked(&self.prim_id, &rows, &[])?,
            geom_id: picked(&self.geom_id, &rows, &[])?,
            from: from.transpose()?,
            normal: known(py, normal.transpose()?),
            refined: known(py, refined.transpose()?),
        })
    }

    /// The first hits as a table, for notebooks.
    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        const MOST: usize = 10;
        let floats = [&self.t, &self.u, &self.v].map(|column| column.bind(py).to_vec());
        let integers = [&self.prim_id, &self.geom_id].map(|column| column.bind(py).to_vec());
        let ([t, u, v], [prim_id, geom_id]) = (floats, integers);
        let (t, u, v, prim_id, geom_id) = (t?, u?, v?, prim_id?, geom_id?);
        let row = |k: usize| {
            let cells = [
                &t[k] as &dyn Display,
                &u[k],
                &v[k],
                &prim_id[k],
                &geom_id[k],
            ];
            let cells = cells.map(|cell| format!("<td>{cell}</td>")).concat();
            format!("<tr><th>{k}</th>{cells}</tr>")
        };
        let count = t.len();
        let rows: String = (0..count.min(MOST)).map(row).collect();
        let names = ["ray", "t", "u", "v", "prim_id", "geom_id"];
        let heads: String = names.map(|name| format!("<th>{name}</th>")).concat();
        let title = self.__repr__(py)?.replace('<', "&lt;").replace('>', "&gt;");
        let more = if count > MOST { "<p>…</p>" } else { "" };
        Ok(format!(
            "<p>{title}</p><table><tr>{heads}</tr>{rows}</table>{more}"
        ))
    }

    fn __len__(&self) -> PyResult<usize> {
        let rows = self.shape.first().copied();
        rows.ok_or_else(|| PyTypeError::new_err("hits of a single ray have no length"))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let met = self.hit(py)?.call_method0("sum")?;
        let rays: usize = self.shape.iter().product();
        Ok(format!("<phalanx.Hits: {met} of {rays} rays hit>"))
    }
}

/// All hits of each ray, list after list, as returned by Scene.all_hits().
/// Ray i has the rows starts[i] to starts[i + 1] of all other attributes.
/// Each list is ordered by (t, prim_id) and contains a primitive at most
/// once.
#[pyclass(name = "AllHits", frozen, module = "phalanx")]
pub(crate) struct PyAllHits {
    /// int64, with one more row than rays: where each ray's list begins.
    #[pyo3(get)]
    starts: Py<PyArrayDyn<i64>>,
    /// int64: the ray of each hit.
    #[pyo3(get)]
    ray_id: Py<PyArrayDyn<i64>>,
    /// float32: the distance in units of the ray's direction.
    #[pyo3(get)]
    t: Py<PyArrayDyn<f32>>,
    /// float32: the weight of a triangle's second vertex; 0 for anything else.
    #[pyo3(get)]
    u: Py<PyArrayDyn<f32>>,
    /// float32: the weight of a triangle's third vertex; 0 for anything else.
    #[pyo3(get)]
    v: Py<PyArrayDyn<f32>>,
    /// int32: the primitive, counted over the whole scene.
    /// Scene.first_prim(geom_id) is the first of a geometry.
    #[pyo3(get)]
    prim_id: Py<PyArrayDyn<i32>>,
    /// int32: the number returned by add_mesh(), add_spheres() or
    /// add_instance(), as in Hits.
    #[pyo3(get)]
    geom_id: Py<PyArrayDyn<i32>>,
    /// A copy of `starts`, to which the caller may write.
    first_rows: Vec<usize>,
    /// Shape of the rays.
    shape: Vec<usize>,
    from: RaySource,
}

impl PyAllHits {
    pub(crate) fn new(
        py: Python<'_>,
        lists: HitLists,
        shape: Vec<usize>,
        from: RaySource,
    ) -> PyResult<PyAllHits> {
        let (hits, rays) = (lists.t.len(), lists.starts.len() - 1);
        let of_ray = |ray: usize| std::iter::repeat_n(ray as i64, lists.rows(ray).len());
        let ray_id: Vec<i64> = (0..rays).flat_map(of_ray).collect();
        let starts: Vec<i64> = lists.starts.iter().map(|&row| row as i64).collect();
        Ok(PyAllHits {
            starts: shaped(py, starts, &[rays + 1])?.unbind(),
            ray_id: shaped(py, ray_id, &[hits])?.unbind(),
            t: shaped(py, lists.t, &[hits])?.unbind(),
            u: shaped(py, lists.u, &[hits])?.unbind(),
            v: shaped(py, lists.v, &[hits])?.unbind(),
            prim_id: shaped(py, signed(lists.prim_id), &[hits])?.unbind(),
            geom_id: shaped(py, signed(lists.geom_id), &[hits])?.unbind(),
            first_rows: lists.starts,
            shape,
            from,
        })
    }
}

#[pymethods]
impl PyAllHits {
    /// Distances and points in double precision: (t, points), float64, (n,)
    /// and (n, 3), one row per hit, as in Hits.refine().
    fn refine<'py>(&self, py: Python<'py>) -> PyResult<(Doubles<'py>, Doubles<'py>)> {
        let columns = (&self.t, &self.prim_id);
        let ray = |row| self.first_rows.partition_point(|&first| first <= row) - 1;
        let refined = self.from.in_double(py, &self.shape, columns, ray)?;
        self.from.refined(py, &refined, &[refined.len()])
    }

    fn __len__(&self) -> usize {
        self.first_rows[self.first_rows.len() - 1]
    }

    fn __repr__(&self) -> String {
        let (hits, rays) = (self.__len__(), self.first_rows.len() - 1);
        format!("<phalanx.AllHits: {hits} hits of {rays} rays>")
    }
}
