//! Rates of a scene's rays, as `phalanx bench` measures them.

use crate::errors::value_error;
use crate::interrupt::stoppable;
use crate::pictures::PyCamera;
use crate::scene::PyScene;
use phalanx::bench::{
    BenchError, BenchPlan, ProgressListener, RayKind, SceneInfo, measure, record,
};
use phalanx::bvh::Quality;
use phalanx::isa;
use phalanx::report::{Program, to_json};
use phalanx::trace::Kernel;
use pyo3::prelude::*;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Largest number of pixels: rays of all kinds, and each engine's answers, take some 400 bytes per
/// pixel.
const MAX_PIXELS: u64 = 1 << 22;

/// Minimum duration of a row's samples, in seconds.
const MIN_TIME: f64 = 0.2;

#[pymethods]
impl PyScene {
    /// Rays per second through this scene, as measured by `phalanx bench`. The
    /// answer is a dictionary; saved with json.dump(), it is a record that
    /// `phalanx bench compare` and `report` read.
    ///
    /// rays : list of str
    ///     'primary', 'shadow', 'reflection', 'refraction', 'diffuse', 'ao';
    ///     None for all.
    /// camera : as for render()
    /// size : (width, height) in pixels, at most 2^22 of them
    /// threads : int; 0 or None for one per CPU
    /// repeat : int
    ///     Minimum number of samples of each rate.
    /// name : str
    ///     The scene's name in the record.
    ///
    /// Entries of 'rows' have 'rays', 'engine', 'kernel', 'threads', and
    /// 'mrays_per_s' with 'median', 'low' and 'high', in millions of rays per
    /// second. 'machine', 'program' and 'scenes' describe what was measured.
    /// The tree is rebuilt with the quality 'best', and answers are checked
    /// against the oracle before anything is timed. This takes seconds; Ctrl-C
    /// takes effect when it ends.
    ///
    /// Raises ValueError for unknown names and an invalid camera or size.
    #[pyo3(
        signature = (rays=None, camera=None, size=(512, 512), threads=None, repeat=5, name="scene"),
        text_signature = "($self, rays=None, camera=None, size=(512, 512), threads=None, \
                          repeat=5, name='scene')"
    )]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
    fn bench<'py>(
        &self,
        py: Python<'py>,
        rays: Option<Vec<String>>,
        camera: Option<PyCamera<'_>>,
        size: (u32, u32),
        threads: Option<i64>,
        repeat: u32,
        name: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let kinds = match &rays {
            None => RayKind::ALL.to_vec(),
            Some(names) => names.iter().map(kind).collect::<PyResult<_>>()?,
        };
        let threads = crate::scene::thread_count(threads)?;
        let scene = self.now(py).framed(camera, Some(size))?;
        if u64::from(size.0) * u64::from(size.1) > MAX_PIXELS {
            let why =
                format!("{size:?} are more than {MAX_PIXELS} pixels, the limit for measurements");
            return Err(value_error(why));
        }
        let plan = BenchPlan {
            kinds,
            frames: false,
            kernels: vec![Kernel::packets()],
            quality: Quality::Best,
            threads: vec![threads],
            size: size.into(),
            repeat: repeat.max(1) as usize,
            min_time: MIN_TIME,
            pin: false,
            peers: &[],
            timed: true,
        };
        let info = SceneInfo {
            name: name.to_owned(),
            ..SceneInfo::default()
        };
        let (started, start) = (now(py)?, Instant::now());
        let work = || measure(&scene, &info, &plan, &mut Silence);
        let measured = stoppable(py, &AtomicBool::new(false), work)?.map_err(value_error)?;
        let seconds = start.elapsed().as_secs_f64();
        let run = plan.run_info(started, vec!["Scene.bench()".to_owned()], seconds);
        let record = record(program(), run, vec![measured]);
        py.import("json")?
            .call_method1("loads", (to_json(&record),))
    }
}

/// Receives progress and discards it.
struct Silence;

impl ProgressListener for Silence {
    fn begin_step(&mut self, _: &str) -> Result<(), BenchError> {
        Ok(())
    }
    fn progress(&mut self, _: f64) -> Result<(), BenchError> {
        Ok(())
    }
}

fn kind(name: &String) -> PyResult<RayKind> {
    let kind = RayKind::ALL.into_iter().find(|kind| kind.name() == name);
    kind.ok_or_else(|| {
        let names = RayKind::ALL.map(RayKind::name);
        value_error(format!(
            "there are no rays {name:?}; rays are {}",
            names.join(", ")
        ))
    })
}

/// Date and time in UTC, in RFC 3339 format.
fn now(py: Python<'_>) -> PyResult<String> {
    let datetime = py.import("datetime")?;
    let utc = datetime.getattr("timezone")?.getattr("utc")?;
    let now = datetime.getattr("datetime")?.call_method1("now", (utc,))?;
    now.call_method1("strftime", ("%Y-%m-%dT%H:%M:%SZ",))?
        .extract()
}

fn program() -> Program {
    let profile = if cfg!(debug_assertions) { "debug" } else { "release" };
    Program {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        git_revision: None,
        git_dirty: None,
        rustc: None,
        profile: profile.to_owned(),
        isa_compiled: isa::compiled_level().to_owned(),
        isa_available: isa::cpu_level().to_owned(),
    }
}
