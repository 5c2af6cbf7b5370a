//! Embree, loaded when it is asked for: nothing of it is needed to build or to run anything else.
//!
//! | file | what |
//! |---|---|
//! | `find` | where its library may be |
//! | `api` | its C interface, versions 3 and 4 |
//! | `layout` | what goes through that, as it lies in memory |
//! | `mxcsr` | the floating-point modes that it wants, and ours again |
//! | `scene` | our scenes as its |
//! | `engines` | the ways to ask it |
//!
//! Its robust mode is not among them. By default a ray through an edge that two triangles share may
//! miss both, and its coherent occlusion loses whole packets now and then (research on real scenes:
//! 0.2 % of Sponza's); that is how it is used and how its rates are told, so the benchmark counts
//! what differs instead.

#[allow(
    unsafe_code,
    reason = "a C interface; each call says why its arguments are what it takes"
)]
mod api;
mod engines;
mod find;
mod layout;
#[allow(
    unsafe_code,
    reason = "the control register is reached by two instructions; each says what it may change"
)]
mod mxcsr;
mod scene;

pub use api::EmbreeFault;

use crate::peers::{BenchEngine, RaySetRef, Unsupported};
use api::{Api, CommittedScene, Device};
use engines::{EmbreeEngine, RayLayout};
use mxcsr::RestoreMxcsr;
use phalanx_scene::Scene;
use std::error::Error;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How to come by Embree, for messages.
const HOW_TO_GET: &str = "get it with `pip install embreex` (version 4) or `apt-get install libembree3-3` (version 3, \
    Debian), or name the library, or its folder, with `--embree PATH`";

/// Why there is no Embree.
#[derive(Debug, thiserror::Error)]
pub enum EmbreeError {
    /// Neither the loader nor any Python has it.
    #[error("Embree's library was not found; {HOW_TO_GET}")]
    NotFound,
    /// A path was given where nothing of that kind is.
    #[error("there is no Embree library at {}; {HOW_TO_GET}", .0.display())]
    NotThere(PathBuf),
    /// The library is there, and does not load, or is another.
    #[error("{} cannot be used as Embree: {reason}; {HOW_TO_GET}", path.display())]
    NotLoaded {
        /// What was loaded.
        path: PathBuf,
        /// The loader's words.
        reason: String,
    },
    /// It loads, and does not work on this machine.
    #[error("Embree ({}) does not start: {fault}", path.display())]
    NotStarted {
        /// What was loaded.
        path: PathBuf,
        /// Embree's words.
        fault: EmbreeFault,
    },
    /// It is of a version whose interface is another.
    #[error("Embree {version} ({}) is neither version 3 nor 4; {HOW_TO_GET}", path.display())]
    OtherVersion {
        /// What was loaded.
        path: PathBuf,
        /// Its version.
        version: String,
    },
}

/// Embree's library. It stays loaded as long as the process runs.
pub struct EmbreeLibrary {
    api: Arc<Api>,
    version: [u32; 3],
    path: PathBuf,
}

impl EmbreeLibrary {
    /// Loads Embree: from a path, which names the library or a folder that has it; else as the
    /// system's loader knows it; else out of the wheel `embreex` of a Python that is installed
    /// here.
    ///
    /// # Errors
    /// [`EmbreeError`], which says how to get the library.
    pub fn open(path: Option<&Path>) -> Result<EmbreeLibrary, EmbreeError> {
        match path {
            Some(path) => EmbreeLibrary::open_given(path),
            None => EmbreeLibrary::search(),
        }
    }

    fn open_given(path: &Path) -> Result<EmbreeLibrary, EmbreeError> {
        if path.is_file() {
            // Without a folder before it the loader would look elsewhere.
            let full = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
            return EmbreeLibrary::load(full.as_os_str());
        }
        let found = find::in_folder(path).into_iter().next();
        let found = found.ok_or_else(|| EmbreeError::NotThere(path.to_owned()))?;
        EmbreeLibrary::load(std::path::absolute(&found).unwrap_or(found).as_os_str())
    }

    fn search() -> Result<EmbreeLibrary, EmbreeError> {
        for name in find::loader_names() {
            match EmbreeLibrary::load(OsStr::new(name)) {
                // The loader's words for "no such file" are its own, so every failure here means to
                // look further.
                Err(EmbreeError::NotLoaded { .. }) => {}
                other => return other,
            }
        }
        let mut wheels = find::in_wheels();
        if wheels.is_empty() {
            wheels = find::by_asking_python();
        }
        let found = wheels.first().ok_or(EmbreeError::NotFound)?;
        EmbreeLibrary::load(found.as_os_str())
    }

    fn load(name: &OsStr) -> Result<EmbreeLibrary, EmbreeError> {
        let path = PathBuf::from(name);
        // Initialisers of libraries may change floating-point modes.
        let _restore = RestoreMxcsr::later();
        let api = Api::load(name).map_err(|error| EmbreeError::NotLoaded {
            path: path.clone(),
            // The loader's words are behind those of the crate, which says only what failed.
            reason: error.source().unwrap_or(&error).to_string(),
        })?;
        let api = Arc::new(api);
        let device = Device::new(&api, 1);
        let version = device.map(|device| device.version);
        let version = version.map_err(|fault| EmbreeError::NotStarted {
            path: path.clone(),
            fault,
        })?;
        let library = EmbreeLibrary { api, version, path };
        if !(3..=4).contains(&version[0]) {
            return Err(EmbreeError::OtherVersion {
                version: library.version(),
                path: library.path,
            });
        }
        Ok(library)
    }

    /// Its version, such as `4.4.0`.
    pub fn version(&self) -> String {
        let [major, minor, patch] = self.version;
        format!("{major}.{minor}.{patch}")
    }

    /// What was loaded: a path, or the name that the system's loader knows it by.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// A scene in Embree's trees.
pub struct EmbreeScene(Arc<EmbreeSceneData>);

struct EmbreeSceneData {
    built: CommittedScene,
    numbers: scene::PrimIdMap,
    /// Whether packets of sixteen are traced as such, incoherent and coherent.
    sixteen: [bool; 2],
}

impl EmbreeScene {
    /// Copies a scene and builds its trees on so many threads; 0 for one per CPU. Triangles and
    /// spheres in the world and in meshes, and instances of meshes.
    ///
    /// # Errors
    /// [`Unsupported`]: primitives that Embree has not, or what it says went wrong.
    pub fn build(
        library: &EmbreeLibrary,
        scene: &Scene,
        threads: usize,
    ) -> Result<EmbreeScene, Unsupported> {
        let unsupported = |reason: String| Unsupported {
            peer: "Embree",
            reason,
        };
        if !scene.ellipsoids.is_empty() {
            return Err(unsupported("it has no ellipsoids".to_owned()));
        }
        if !scene.cones.is_empty() {
            return Err(unsupported(
                "its cones are not open at the ends as ours are".to_owned(),
            ));
        }
        // Builders may change floating-point modes.
        let _restore = RestoreMxcsr::later();
        let device = Device::new(&library.api, threads).map(Arc::new);
        let built = device.and_then(|device| {
            let (built, prim_ids) = scene::build(&device, scene)?;
            Ok(EmbreeSceneData {
                // Debian's 3.13.5 never comes back from a coherent occlusion of sixteen rays that
                // meets instances: the compiler stores a mask of 16 bits in that kernel (not in
                // those of triangles and spheres), and reads 64.
                sixteen: [
                    device.sixteen,
                    device.sixteen && (device.version[0] > 3 || scene.instances.is_empty()),
                ],
                built,
                numbers: prim_ids,
            })
        });
        match built {
            Ok(inner) => Ok(EmbreeScene(Arc::new(inner))),
            Err(fault) => Err(unsupported(fault.to_string())),
        }
    }

    /// The ways to trace a set of rays, by name. Sixteen rays a call only where the library has
    /// instructions for it.
    pub fn engines(&self, rays: RaySetRef) -> Vec<(String, Box<dyn BenchEngine>)> {
        let mut modes: Vec<(String, Box<dyn BenchEngine>)> = Vec::new();
        let single = EmbreeEngine::new(&self.0, &Arc::new(RayLayout::<1>::new(rays)), false);
        modes.push(("single".to_owned(), Box::new(single)));
        let layout = Arc::new(RayLayout::<8>::new(rays));
        for (name, coherent) in COHERENCE {
            let mode = EmbreeEngine::new(&self.0, &layout, coherent);
            modes.push((format!("packet8 {name}"), Box::new(mode)));
        }
        if self.0.sixteen[0] {
            let layout = Arc::new(RayLayout::<16>::new(rays));
            let usable = |&(_, coherent): &(&str, bool)| self.0.sixteen[usize::from(coherent)];
            for (name, coherent) in COHERENCE.into_iter().filter(usable) {
                let mode = EmbreeEngine::new(&self.0, &layout, coherent);
                modes.push((format!("packet16 {name}"), Box::new(mode)));
            }
        }
        modes
    }
}

/// What packets are told about their rays. For single rays Embree has one way only.
const COHERENCE: [(&str, bool); 2] = [("coherent", true), ("incoherent", false)];
