//! Embree, loaded on request: neither the build nor anything else depends on it.
//!
//! | file | content |
//! |---|---|
//! | `find` | search for its library |
//! | `api` | its C interface, versions 3 and 4 |
//! | `layout` | memory layout of the data that passes through that |
//! | `mxcsr` | the floating-point modes that it wants, and restoring ours |
//! | `scene` | our scenes in its form |
//! | `engines` | its modes of tracing rays |
//!
//! It is measured as two peers. `embree` is its fastest mode, of which its rates are published. A
//! ray through a shared edge may miss both triangles there, and coherent occlusion occasionally
//! loses whole packets (research on real scenes: 0.2 % of Sponza's); the benchmark counts the rays
//! that differ. `embree robust` sets `RTC_SCENE_FLAG_ROBUST` and promises what we promise.

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

use crate::peers::engine::{NamedEngines, ONE, PeerScene, RaySetRef, Unsupported};
use api::{Api, Device, SceneOptions};
use engines::{EmbreeEngine, RayLayout};
use mxcsr::RestoreMxcsr;
use phalanx_files::shown_path;
use phalanx_scene::{PrimKind, Scene};
use phalanx_trace::bvh::BuildSettings;
use scene::EmbreeSceneData;
use std::error::Error;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Hint for messages: how to get Embree.
const HOW_TO_GET: &str = "get it with `pip install embreex` (version 4) or `apt-get install libembree3-3` (version 3, \
    Debian), or name the library, or its folder, with `--embree PATH`";

/// The reason why Embree is not available.
#[derive(Debug, thiserror::Error)]
pub enum EmbreeError {
    /// Neither the loader nor any Python has it.
    #[error("Embree's library was not found; {HOW_TO_GET}")]
    NotFound,
    /// The given path does not lead to an Embree library.
    #[error("there is no Embree library at {}; {HOW_TO_GET}", shown_path(.0))]
    NotThere(PathBuf),
    /// The library exists, but does not load or is not Embree.
    #[error(
        "{} cannot be used as Embree: {reason}; {HOW_TO_GET}",
        shown_path(path)
    )]
    NotLoaded {
        /// Path or name that was loaded.
        path: PathBuf,
        /// The loader's message.
        reason: String,
    },
    /// The library loads, but does not work on this machine.
    #[error("Embree ({}) does not start: {fault}", shown_path(path))]
    NotStarted {
        /// Path or name that was loaded.
        path: PathBuf,
        /// Embree's message.
        fault: EmbreeFault,
    },
    /// The library's version has another interface.
    #[error(
        "Embree {version} ({}) is neither version 3 nor 4; {HOW_TO_GET}",
        shown_path(path)
    )]
    OtherVersion {
        /// Path or name that was loaded.
        path: PathBuf,
        /// Version of the library.
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
    /// Loads Embree. `path` names the library or a folder that has it. Without a path, the library
    /// is loaded by the names that the system's loader knows, or else from the `embreex` wheel of
    /// an installed Python.
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
            // Without a folder in front, the loader would search elsewhere.
            let full = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
            return EmbreeLibrary::load(full.as_os_str());
        }
        let library = find::in_folder(path).into_iter().next();
        let library = library.ok_or_else(|| EmbreeError::NotThere(path.to_owned()))?;
        EmbreeLibrary::load(std::path::absolute(&library).unwrap_or(library).as_os_str())
    }

    fn search() -> Result<EmbreeLibrary, EmbreeError> {
        for name in find::loader_names() {
            match EmbreeLibrary::load(OsStr::new(name)) {
                // The loader's message for "no such file" depends on the system, so the search
                // continues after any failure here.
                Err(EmbreeError::NotLoaded { .. }) => {}
                other => return other,
            }
        }
        let mut wheels = find::in_wheels();
        if wheels.is_empty() {
            wheels = find::by_asking_python();
        }
        let library = wheels.first().ok_or(EmbreeError::NotFound)?;
        EmbreeLibrary::load(library.as_os_str())
    }

    fn load(name: &OsStr) -> Result<EmbreeLibrary, EmbreeError> {
        let path = PathBuf::from(name);
        // A library's initialisers may change floating-point modes.
        let _restore = RestoreMxcsr::later();
        let api = Api::load(name).map_err(|error| EmbreeError::NotLoaded {
            path: path.clone(),
            // The loader's message is the source of the crate's error, which only names the failed
            // step.
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

    /// Version of the library, such as `4.4.0`.
    pub fn version(&self) -> String {
        let [major, minor, patch] = self.version;
        format!("{major}.{minor}.{patch}")
    }

    /// Path that was loaded, or its name for the system's loader.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Copies a scene and builds its trees. With `robust`, queries lose no ray at an edge. Supports
    /// triangles and spheres in the world and in meshes, and instances of meshes.
    ///
    /// # Errors
    /// [`Unsupported`]: primitives that Embree does not have, or an error that it reports.
    pub fn build(
        &self,
        scene: &Scene,
        settings: &BuildSettings,
        robust: bool,
    ) -> Result<PeerScene, Unsupported> {
        let unsupported = |reason: String| Unsupported {
            peer: "Embree",
            reason,
        };
        for kind in PrimKind::ALL {
            let lack = match kind {
                PrimKind::Sphere | PrimKind::Triangle => continue,
                PrimKind::Cone => "its cones are not open at the ends as ours are".to_owned(),
                other => format!("it has no {}s", other.name()),
            };
            if scene.count(kind) > 0 {
                return Err(unsupported(lack));
            }
        }
        // Builders may change floating-point modes.
        let _restore = RestoreMxcsr::later();
        let options = SceneOptions {
            quality: settings.quality,
            robust,
        };
        let device = Device::new(&self.api, settings.threads).map(Arc::new);
        let built = device.and_then(|device| EmbreeSceneData::build(&device, scene, options));
        let built = Arc::new(built.map_err(|fault| unsupported(fault.to_string()))?);
        Ok(Box::new(move |rays| modes(&built, rays)))
    }
}

/// The modes of tracing a set of rays, by name. Sixteen rays per call are included only if the
/// library has instructions for them.
fn modes(scene: &Arc<EmbreeSceneData>, rays: RaySetRef) -> NamedEngines {
    let mut modes = NamedEngines::new();
    let single = EmbreeEngine::new(scene, &Arc::new(RayLayout::<1>::new(rays)), false);
    modes.push((ONE.to_owned(), Box::new(single)));
    let layout = Arc::new(RayLayout::<8>::new(rays));
    for (name, coherent) in COHERENCE {
        let mode = EmbreeEngine::new(scene, &layout, coherent);
        modes.push((format!("packet8 {name}"), Box::new(mode)));
    }
    if scene.sixteen[0] {
        let layout = Arc::new(RayLayout::<16>::new(rays));
        let usable = |&(_, coherent): &(&str, bool)| scene.sixteen[usize::from(coherent)];
        for (name, coherent) in COHERENCE.into_iter().filter(usable) {
            let mode = EmbreeEngine::new(scene, &layout, coherent);
            modes.push((format!("packet16 {name}"), Box::new(mode)));
        }
    }
    modes
}

/// Coherence flags of packets. For single rays Embree has one mode only.
const COHERENCE: [(&str, bool); 2] = [("coherent", true), ("incoherent", false)];
