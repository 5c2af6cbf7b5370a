//! The class `Scene`.

use crate::arrays::{shaped, wrong_shape};
use crate::coordinates::Coordinates;
use crate::errors::{geometry_error, open_error, value_error, write_error};
use numpy::{PyArrayDyn, PyArrayMethods};
use phalanx::bvh::Quality;
use phalanx::formats::Options;
use phalanx::scene::{GeomId, SceneCamera};
use phalanx::{BuildSettings, Bvh, ForkSafeOnce, GeometryError, NO_PRIM, Scene};
use phalanx::{UpdateError, UpdateMode, UpdateReport, UpdateWork};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{IntoPyDict, PyBytes, PyDict, PyTuple};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Geometry to cast rays at: triangles, spheres, instances of meshes, or a
/// whole scene from a file.
///
/// origin : three numbers
///     A point near the geometry, for large coordinates such as those of
///     maps. It is subtracted from every position in double precision;
///     answers are in your coordinates.
///
/// Arrays are numpy arrays, or anything that numpy converts to one. Numbers
/// are float32 inside; float64 is rounded once. Lengths are in your units.
/// The tree over the primitives is built by the first query, or by
/// build(), and rebuilt after each change.
///
/// Python threads may share a scene. A call uses the scene as it is when the
/// call begins, even if geometry is added meanwhile; while one call builds
/// the tree, others that need it wait. A forked process has its parent's
/// scenes and threads of its own; it builds trees again that were not finished.
///
/// Raises ValueError for an origin that is not finite.
///
/// >>> import numpy as np, phalanx
/// >>> scene = phalanx.Scene()
/// >>> scene.add_mesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
/// 0
/// >>> hits = scene.intersect([[1, 2, 5], [9, 9, 5]], [0, 0, -1])
/// >>> hits.t
/// array([ 5., inf], dtype=float32)
/// >>> hits.prim_id
/// array([ 0, -1], dtype=int32)
#[pyclass(name = "Scene", frozen, module = "phalanx")]
pub(crate) struct PyScene {
    /// Held only briefly, with the interpreter's lock and never while Python code runs, so that no
    /// fork sees it held.
    now: Mutex<Snapshot>,
}

/// A scene between two changes, shared by clones.
#[derive(Clone)]
pub(crate) struct Snapshot {
    pub(crate) scene: Arc<Scene>,
    tree: Arc<LazyTree>,
    settings: BuildSettings,
}

/// A tree that is made on first use.
#[derive(Default)]
struct LazyTree {
    /// The tree, or the reason why there is none.
    made: ForkSafeOnce<Result<Arc<Bvh>, String>>,
    /// The tree of the scene before its last changes, which is updated.
    before: Mutex<Option<Arc<Bvh>>>,
}

impl LazyTree {
    fn of(bvh: Arc<Bvh>) -> LazyTree {
        let tree = LazyTree::default();
        tree.made.get_or_init(|| Ok(bvh));
        tree
    }

    /// The next tree, which begins as this one, or as the one before if there is none.
    fn next(&self) -> LazyTree {
        let made = match self.made.get() {
            Some(Ok(bvh)) => Some(Arc::clone(bvh)),
            _ => self.take_before(),
        };
        LazyTree {
            made: ForkSafeOnce::new(),
            before: Mutex::new(made),
        }
    }

    /// Does not wait: in a process that was forked, the lock may be held for ever.
    fn take_before(&self) -> Option<Arc<Bvh>> {
        self.before.try_lock().ok()?.take()
    }

    /// Why a refit of the tree before the last changes would be refused.
    fn refusal(&self, scene: &Scene) -> Option<UpdateError> {
        let before = self.before.try_lock().ok()?;
        before.as_ref()?.refusal(scene)
    }
}

/// Largest number of primitives, so that each index has 31 bits.
const MAX_PRIMS: u64 = i32::MAX as u64;

impl Snapshot {
    pub(crate) fn coordinates(&self) -> Coordinates {
        Coordinates::of(&self.scene)
    }

    /// The tree, built now if there is none. The interpreter's lock is released while waiting.
    pub(crate) fn tree(&self, py: Python<'_>) -> PyResult<Arc<Bvh>> {
        if let Some(Ok(bvh)) = self.tree.made.get() {
            return Ok(Arc::clone(bvh));
        }
        let tree = py.detach(|| self.follow(UpdateMode::Auto));
        tree.map(|(bvh, _)| bvh).map_err(value_error)
    }

    /// The tree, from the one before if there is one, and what was done.
    fn build(&self, mode: UpdateMode) -> Result<(Arc<Bvh>, UpdateReport), String> {
        let prims = self.scene.id_count();
        if prims > MAX_PRIMS {
            return Err(format!(
                "{prims} primitives, including those of instances: at most {MAX_PRIMS}"
            ));
        }
        if let Some(mut bvh) = self.tree.take_before() {
            // A copy, if a query still uses it.
            let updated = Arc::make_mut(&mut bvh).update_with(&self.scene, mode);
            return updated
                .map(|report| (bvh, report))
                .map_err(|refused| refused.to_string());
        }
        let valid = self.scene.validate().map_err(|error| error.to_string());
        valid.map(|()| {
            let report = UpdateReport {
                work: UpdateWork::Rebuilt,
                ..UpdateReport::default()
            };
            (
                Arc::new(Bvh::build_with(&self.scene, &self.settings)),
                report,
            )
        })
    }

    /// Lets the tree before the last changes follow, by these rules; returns it, and what was done.
    fn follow(&self, mode: UpdateMode) -> Result<(Arc<Bvh>, UpdateReport), String> {
        if mode == UpdateMode::RefitOnly
            && let Some(refused) = self.tree.refusal(&self.scene)
        {
            return Err(refused.to_string());
        }
        let mut done = UpdateReport::default();
        let made = self.tree.made.get_or_init(|| {
            let (bvh, report) = self.build(mode)?;
            done = report;
            Ok(bvh)
        });
        Ok((Arc::clone(made.as_ref().map_err(String::clone)?), done))
    }
}

impl PyScene {
    fn of(scene: Scene, bvh: Option<Bvh>) -> PyScene {
        let tree = bvh.map(|bvh| LazyTree::of(Arc::new(bvh)));
        let now = Snapshot {
            scene: Arc::new(scene),
            tree: Arc::new(tree.unwrap_or_default()),
            settings: BuildSettings::default(),
        };
        PyScene {
            now: Mutex::new(now),
        }
    }

    fn lock(&self, py: Python<'_>) -> MutexGuard<'_, Snapshot> {
        let now = self.now.lock_py_attached(py);
        now.unwrap_or_else(PoisonError::into_inner)
    }

    /// The current scene.
    pub(crate) fn now(&self, py: Python<'_>) -> Snapshot {
        self.lock(py).clone()
    }

    /// Changes the scene, which its tree has to follow.
    pub(crate) fn change<T>(
        &self,
        py: Python<'_>,
        change: impl FnOnce(&mut Scene) -> Result<T, GeometryError>,
    ) -> PyResult<T> {
        let mut now = self.lock(py);
        let scene = Arc::make_mut(&mut now.scene);
        let changed = change(scene).map_err(geometry_error)?;
        scene.defaulted.made_for = None;
        now.tree = Arc::new(now.tree.next());
        Ok(changed)
    }
}

/// Maximum number of threads of a call, unless there are more CPUs. The tree's builder takes
/// seconds to start thousands.
const MAX_THREADS: usize = 64;

/// `threads` of a call; 0, or none, for all CPUs.
///
/// # Errors
/// `ValueError` for less than zero.
pub(crate) fn threads(requested: Option<i64>) -> PyResult<usize> {
    match requested {
        None | Some(0) => Ok(0),
        Some(n) if n > 0 => {
            let most = phalanx::thread_count(0).max(MAX_THREADS);
            Ok(usize::try_from(n).unwrap_or(usize::MAX).min(most))
        }
        Some(n) => Err(value_error(format!(
            "threads is {n}: give 1 or more, or 0 or None for one per CPU"
        ))),
    }
}

/// `threads` of a call, as a number above zero if none is given.
pub(crate) fn thread_count(requested: Option<i64>) -> PyResult<usize> {
    threads(requested).map(phalanx::thread_count)
}

#[pymethods]
impl PyScene {
    #[new]
    #[pyo3(signature = (origin=[0.0, 0.0, 0.0]), text_signature = "(origin=(0.0, 0.0, 0.0))")]
    fn new(origin: [f64; 3]) -> PyResult<PyScene> {
        if !origin.iter().all(|c| c.is_finite()) {
            return Err(value_error(format!("the origin {origin:?} is not finite")));
        }
        let scene = Scene {
            origin,
            defaulted: phalanx::scene::DefaultedParts {
                view: true,
                light: true,
                samples: true,
                ..Default::default()
            },
            ..Scene::new()
        };
        Ok(PyScene::of(scene, None))
    }

    /// Reads a scene from a file and returns it.
    ///
    /// path : str or os.PathLike
    ///     OBJ, PLY, STL, glTF, NFF, .test, a scene written by save() (.phx),
    ///     or the name of a standard scene, such as 'standard:room:50k'.
    /// threads : int; 0 or None for one per CPU
    /// camera : str or int
    ///     The camera of the file by name, or by number from 0, as in
    ///     cameras. None for the first.
    /// headlight : bool
    ///     True for a key light and a fill light beside the camera in place of
    ///     the file's lights.
    ///
    /// Includes camera, materials, lights and names. The reader's remarks
    /// become warnings. Raises OSError if the system cannot read the file,
    /// ValueError for errors in its contents and for an unknown camera.
    #[staticmethod]
    #[pyo3(signature = (path, threads=None, camera=None, headlight=false))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        threads: Option<i64>,
        camera: Option<Bound<'_, PyAny>>,
        headlight: bool,
    ) -> PyResult<PyScene> {
        let camera = camera.map(|camera| Ok::<_, PyErr>(camera.str()?.to_string()));
        let mut options = Options::default();
        options.read.threads = self::threads(threads)?;
        options.look.camera = camera.transpose()?;
        options.look.headlight = headlight;
        let opened = py.detach(|| phalanx::open::open(&path, &options));
        let opened = opened.map_err(|error| open_error(&path.to_string_lossy(), error))?;
        let warnings = py.import("warnings")?;
        for warning in &opened.warnings {
            let place = match warning.line {
                0 => format!(" byte {}", warning.offset),
                line => format!("{line}:{}", warning.column),
            };
            let words = format!("{}:{place}: {}", path.display(), warning.message);
            warnings.call_method1("warn", (words,))?;
        }
        Ok(PyScene::of(opened.scene, opened.bvh))
    }

    /// Opens a scene written by save(), and returns it.
    ///
    /// The file (.phx) is mapped, not read: the tree need not be built, and
    /// several processes share its memory. It must not change while open.
    ///
    /// Raises OSError if the system cannot read the file, ValueError if it is
    /// not a saved scene, or one of another version.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<PyScene> {
        let cached = py.detach(|| phalanx::cache::open(&path));
        let cached = cached.map_err(|error| open_error(&path.to_string_lossy(), error.into()))?;
        Ok(PyScene::of(cached.scene, Some(cached.bvh)))
    }

    /// Writes the scene and its tree to a file for open(). path must end in
    /// .phx. The tree is built first, if there is none.
    ///
    /// An existing file is replaced once everything is written. Raises
    /// OSError if the system cannot write, ValueError for another extension.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        if !phalanx::open::is_cache(&path) {
            let why = format!("{}: a saved scene's name ends in .phx", path.display());
            return Err(value_error(why));
        }
        let now = self.now(py);
        let bvh = now.tree(py)?;
        let written = py.detach(|| {
            phalanx::files::replace_file(&path, |out| {
                let written = phalanx::cache::write(out, &now.scene, &bvh);
                written.map(drop).map_err(std::io::Error::other)
            })
        });
        written.map_err(|error| write_error(&path.to_string_lossy(), error))
    }

    /// A copy that shares nothing that changes.
    fn __copy__(&self, py: Python<'_>) -> PyScene {
        PyScene {
            now: Mutex::new(self.now(py)),
        }
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> PyScene {
        self.__copy__(py)
    }

    /// For pickle: what save() writes, the tree included.
    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let now = self.now(py);
        let bvh = now.tree(py)?;
        let mut bytes = Vec::new();
        let written = py.detach(|| phalanx::cache::write(&mut bytes, &now.scene, &bvh));
        written.map_err(value_error)?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn __setstate__(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<()> {
        let name = "a pickled scene";
        let cached = py.detach(|| phalanx::cache::open_bytes(name.as_ref(), bytes));
        let cached = cached.map_err(|error| open_error(name, error.into()))?;
        *self.lock(py) = PyScene::of(cached.scene, Some(cached.bvh)).now(py);
        Ok(())
    }

    fn __reduce__<'py>(slf: &Bound<'py, PyScene>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let state = slf.get().__getstate__(py)?;
        (slf.get_type(), PyTuple::empty(py), state).into_pyobject(py)
    }

    /// Adds triangles and returns the geometry's number, geom_id.
    ///
    /// vertices : (n, 3)
    ///     Positions, all of them finite.
    /// faces : (m, 3) integers
    ///     Rows of vertices, from 0. Vertices are in counter-clockwise order,
    ///     seen from outside; rays hit both sides, even for files whose
    ///     pictures show only one.
    ///
    /// Both arrays may be empty. Raises ValueError for wrong shapes and for
    /// vertices that are not finite, IndexError for faces that refer to no
    /// vertex, TypeError for non-numeric arrays.
    fn add_mesh(
        &self,
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
    ) -> PyResult<GeomId> {
        let vertices = self.now(py).coordinates().points("vertices", vertices)?;
        let faces = crate::arrays::faces(faces)?;
        let vertices = vertices.threes("vertices")?;
        self.change(py, |scene| scene.add_mesh(vertices, &faces))
    }

    /// Adds spheres and returns the geometry's number, geom_id.
    ///
    /// centers : (n, 3)
    /// radii : (n,), or one number for all
    ///
    /// Raises ValueError for wrong shapes, for centers that are not finite,
    /// and for radii that are not positive and finite; TypeError for
    /// non-numeric arrays.
    fn add_spheres(
        &self,
        py: Python<'_>,
        centers: &Bound<'_, PyAny>,
        radii: &Bound<'_, PyAny>,
    ) -> PyResult<GeomId> {
        let centers = self.now(py).coordinates().points("centers", centers)?;
        let radii = self.now(py).coordinates().differences("radii", radii)?;
        let centers = centers.threes("centers")?;
        let radii = match radii.shape() {
            [] => vec![radii.numbers()?[0]; centers.len()],
            [_] => radii.numbers()?.to_vec(),
            shape => return Err(wrong_shape("radii", "(n,)", shape)),
        };
        self.change(py, |scene| scene.add_spheres(centers, &radii))
    }

    /// Adds a mesh that is hit only through its instances, in its own
    /// coordinates, and returns its number for add_instance().
    ///
    /// Arrays and errors as for add_mesh(), with at least one face.
    fn add_prototype(
        &self,
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
    ) -> PyResult<u32> {
        let coordinates = self.now(py).coordinates();
        let vertices = coordinates.differences("vertices", vertices)?;
        let faces = crate::arrays::faces(faces)?;
        let vertices = vertices.threes("vertices")?;
        self.change(py, |scene| scene.add_prototype(vertices, &faces))
    }

    /// Places a prototype and returns the geometry's number, geom_id.
    ///
    /// prototype : int
    ///     A number returned by add_prototype().
    /// transform : (4, 4), or its first three rows, (3, 4)
    ///     Maps columns (x, y, z, 1) of the prototype to the world.
    ///
    /// Raises IndexError for an unknown prototype, ValueError for a wrong
    /// shape and for a transform without an inverse.
    fn add_instance(
        &self,
        py: Python<'_>,
        prototype: u32,
        transform: &Bound<'_, PyAny>,
    ) -> PyResult<GeomId> {
        let coordinates = self.now(py).coordinates();
        let to_world = crate::coordinates::transform("transform", transform, &coordinates)?;
        self.change(py, |scene| scene.add_instance(prototype, to_world))
    }

    /// Moves the vertices of a mesh: as many as add_mesh() was given, in the
    /// same order. The next query, or update(), lets the tree follow.
    ///
    /// Raises IndexError for a geom_id that is no mesh, ValueError for another
    /// number of vertices and for those that are not finite.
    fn set_vertices(
        &self,
        py: Python<'_>,
        geom_id: GeomId,
        vertices: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let vertices = self.now(py).coordinates().points("vertices", vertices)?;
        let vertices = vertices.threes("vertices")?;
        self.change(py, |scene| scene.set_vertices(geom_id, vertices))
    }

    /// Moves the vertices of a prototype, as set_vertices() those of a mesh.
    fn set_prototype_vertices(
        &self,
        py: Python<'_>,
        prototype: u32,
        vertices: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let coordinates = self.now(py).coordinates();
        let vertices = coordinates.differences("vertices", vertices)?;
        let vertices = vertices.threes("vertices")?;
        self.change(py, |scene| {
            scene.set_prototype_vertices(prototype, vertices)
        })
    }

    /// Moves an instance: transform as for add_instance(). Hits keep the scene
    /// as it was: drop those of a large one before, or it is copied.
    ///
    /// Raises IndexError for a geom_id that is no instance, ValueError for a
    /// wrong shape and for a transform without an inverse.
    fn set_transform(
        &self,
        py: Python<'_>,
        geom_id: GeomId,
        transform: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let coordinates = self.now(py).coordinates();
        let to_world = crate::coordinates::transform("transform", transform, &coordinates)?;
        self.change(py, |scene| scene.set_transform(geom_id, to_world))
    }

    /// Sets the mask of a geometry, 32 bits, all of them at first. Rays with a
    /// mask hit only geometries that share a bit with it; 0 hides a geometry
    /// from all rays and pictures. To let rays select a geometry, clear its
    /// bit in all others.
    ///
    /// Raises IndexError for an unknown geom_id, ValueError for more bits.
    fn set_mask(&self, py: Python<'_>, geom_id: GeomId, mask: i64) -> PyResult<()> {
        let bits = crate::rays::mask_bits(mask);
        let mask = bits.ok_or_else(|| value_error(format!("the mask {mask} has over 32 bits")))?;
        self.change(py, |scene| scene.set_mask(geom_id, mask))
    }

    /// Names a geometry. Its object in Cryptomatte layers has this name;
    /// geometries of one name are one object there. '' takes the name away.
    ///
    /// Raises IndexError for an unknown geom_id.
    fn set_name(&self, py: Python<'_>, geom_id: GeomId, name: &str) -> PyResult<()> {
        let mut now = self.lock(py);
        let scene = Arc::make_mut(&mut now.scene);
        scene.set_name(geom_id, name).map_err(geometry_error)
    }

    /// Names of the object and of the material of primitives: a flat list of
    /// pairs of str, None without a name and for a miss.
    ///
    /// prim_id : integers, such as hits.prim_id
    fn prim_names(
        &self,
        py: Python<'_>,
        prim_id: &Bound<'_, PyAny>,
    ) -> PyResult<Vec<(Option<String>, Option<String>)>> {
        let ids = crate::arrays::as_contiguous::<i64>("prim_id", prim_id)?;
        let scene = self.now(py).scene;
        let names = ids.to_vec()?.into_iter().map(|id| {
            let names = scene.prim_names(u32::try_from(id).unwrap_or(NO_PRIM));
            names.map(|name| name.map(str::to_owned)).into()
        });
        Ok(names.collect())
    }

    /// The file's names of objects and of materials: two dicts, the largest
    /// first, each name with the number of its primitives.
    #[getter]
    fn names<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyDict>; 2]> {
        let scene = self.now(py).scene;
        let [objects, materials] = scene.name_sizes();
        Ok([objects.into_py_dict(py)?, materials.into_py_dict(py)?])
    }

    /// Names of the file's cameras, in the order of their numbers: a list of
    /// str, None without a name.
    #[getter]
    fn cameras(&self, py: Python<'_>) -> Vec<Option<String>> {
        let scene = self.now(py).scene;
        let name = |camera: &SceneCamera| scene.names.get(camera.name).map(str::to_owned);
        scene.cameras.iter().map(name).collect()
    }

    /// Removes a geometry. All others keep their numbers and those of their
    /// primitives. The next geometry of this kind (mesh, spheres, instance)
    /// that is no larger takes its geom_id, its prim_ids and its memory.
    ///
    /// Raises IndexError for an unknown geom_id.
    fn remove(&self, py: Python<'_>, geom_id: GeomId) -> PyResult<()> {
        self.change(py, |scene| scene.remove(geom_id))
    }

    /// Removes a prototype that no instance shows. The next one that is no
    /// larger takes its number.
    ///
    /// Raises IndexError for an unknown number, ValueError if it is shown.
    fn remove_prototype(&self, py: Python<'_>, prototype: u32) -> PyResult<()> {
        self.change(py, |scene| scene.remove_prototype(prototype))
    }

    /// Lets the tree follow all changes now, instead of in the next query.
    /// Meshes that moved are refitted, what was added gets a tree of its own,
    /// what was removed or hidden leaves. It is built if there is none.
    ///
    /// mode : 'auto', 'refit' or 'rebuild'
    ///     'auto' builds a part anew that refits have made too slow, and
    ///     everything if the whole is. 'refit' builds no tree over
    ///     primitives, so that frames take about as long as each other.
    ///     'rebuild' builds everything.
    ///
    /// Returns a dict: 'work' is 'nothing', 'refitted' or 'rebuilt';
    /// 'refitted', 'built' and 'removed' are lists of geom_ids; and
    /// 'cost_growth' says how many times what it would cost if it were built
    /// anew the tree costs rays.
    ///
    /// Answers that you keep do not change. To build without stopping queries,
    /// let another thread update a copy, and use that from then on:
    ///
    ///     spare = copy.copy(scene)
    ///     thread = threading.Thread(target=spare.update, args=("rebuild",))
    ///
    /// Raises ValueError for 'refit' if something has to be built; the tree
    /// then follows in the next query.
    #[pyo3(signature = (mode="auto"))]
    fn update<'py>(&self, py: Python<'py>, mode: &str) -> PyResult<Bound<'py, PyDict>> {
        let mode = match mode {
            "auto" => UpdateMode::Auto,
            "refit" => UpdateMode::RefitOnly,
            "rebuild" => UpdateMode::Rebuild,
            _ => {
                let words = format!("mode is {mode:?}, not one of auto, refit, rebuild");
                return Err(value_error(words));
            }
        };
        let now = self.now(py);
        let (mut bvh, mut report) = py.detach(|| now.follow(mode)).map_err(value_error)?;
        if mode == UpdateMode::Rebuild && report.work == UpdateWork::Nothing {
            let fresh = py.detach(|| Bvh::build_with(&now.scene, &now.settings));
            (bvh, report.work) = (Arc::new(fresh), UpdateWork::Rebuilt);
            let mut current = self.lock(py);
            if Arc::ptr_eq(&current.scene, &now.scene) {
                current.tree = Arc::new(LazyTree::of(Arc::clone(&bvh)));
            }
        }
        py.detach(|| bvh.build_wide(0));
        let work = match report.work {
            UpdateWork::Nothing => "nothing",
            UpdateWork::Refitted => "refitted",
            UpdateWork::Rebuilt => "rebuilt",
        };
        let all = PyDict::new(py);
        all.set_item("work", work)?;
        all.set_item("refitted", report.refitted)?;
        all.set_item("built", report.built)?;
        all.set_item("removed", report.removed)?;
        all.set_item("cost_growth", bvh.cost_growth())?;
        Ok(all)
    }

    /// Builds the tree now instead of in the first query, or rebuilds it if
    /// it has another quality.
    ///
    /// quality : 'fastest', 'fast', 'medium' or 'best'
    ///     Trades build time for tracing speed. Answers do not depend on it.
    ///     It also applies to later trees of this scene.
    /// threads : int; 0 or None for one per CPU
    ///
    /// Raises ValueError for another quality, and for threads below 0.
    #[pyo3(signature = (quality="medium", threads=None))]
    fn build(&self, py: Python<'_>, quality: &str, threads: Option<i64>) -> PyResult<()> {
        let known = Quality::ALL.iter().find(|(name, _)| *name == quality);
        let &(_, quality) = known.ok_or_else(|| {
            let names = Quality::ALL.map(|(name, _)| name).join(", ");
            value_error(format!("quality is {quality:?}, not one of {names}"))
        })?;
        let threads = self::threads(threads)?;
        let mut now = self.lock(py);
        if now.settings.quality != quality {
            now.tree = Arc::default();
        }
        now.settings = BuildSettings { quality, threads };
        let requested = now.clone();
        drop(now);
        let bvh = requested.tree(py)?;
        py.detach(|| bvh.build_wide(threads));
        Ok(())
    }

    /// The prim_id of a geometry's first primitive; None for an unknown
    /// geometry. hits.prim_id minus this is the row of the face or sphere in
    /// the arrays that were added.
    fn first_prim(&self, py: Python<'_>, geom_id: i64) -> PyResult<Option<u32>> {
        let bvh = self.now(py).tree(py)?;
        let geom_id = u32::try_from(geom_id).ok();
        Ok(geom_id.and_then(|id| bvh.first_prim(id)))
    }

    /// Number of primitives; those of a prototype count once per instance.
    fn __len__(&self, py: Python<'_>) -> usize {
        self.now(py).scene.visible_count() as usize
    }

    /// Smallest and largest coordinates: float64, (2, 3), in your coordinates;
    /// inf and -inf if the scene is empty.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let now = self.now(py);
        let (bounds, coordinates) = (now.scene.bounds(), now.coordinates());
        let corner = |corner: phalanx::glam::Vec3| coordinates.outside(corner.as_dvec3().into());
        let both = [corner(bounds.lo), corner(bounds.hi)];
        shaped(py, both.as_flattened().to_vec(), &[2, 3])
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let now = self.now(py);
        let is_built = matches!(now.tree.made.get(), Some(Ok(_)));
        let built = if is_built { "built" } else { "not built" };
        let count = now.scene.visible_count();
        format!("<phalanx.Scene: {count} primitives, {built}>")
    }
}
