//! Measures a scene, and makes the record of a run.

use super::bar::BenchProgressBar;
use super::program::this_program;
use super::table;
use crate::cli::options::{SceneArgs, SceneInput, WantedPicture};
use crate::cli::output::{self, CliError};
use phalanx::bench::{BenchPlan, Measured, SceneInfo, measure};
use phalanx::frame::Engine;
use phalanx::report::BenchRecord;
use std::ffi::OsString;
use std::path::{PathBuf, is_separator};
use std::time::Instant;

/// A scene to measure.
pub struct BenchScene {
    pub path: PathBuf,
    /// Its options, with its own camera.
    pub args: SceneArgs,
    pub info: SceneInfo,
}

/// Opens a scene, measures it, and prints its table. `BenchError::Stopped` if the run ends before
/// the scene has rates.
pub fn measure_scene(
    plan: &BenchPlan,
    scene: &BenchScene,
    bar: &mut BenchProgressBar,
) -> Result<(Measured, SceneInput), CliError> {
    bar.scene(&scene.info.name).map_err(CliError::Bench)?;
    let start = Instant::now();
    let scene_input = SceneInput::load(&scene.path, &scene.args, picture(plan), 0)?;
    let settings = plan.build_settings();
    (scene_input.budget).for_tree(&scene_input.scene, Engine::Simd, &settings)?;
    let info = SceneInfo {
        load_seconds: start.elapsed().as_secs_f64(),
        ..scene.info.clone()
    };
    let measured = measure(&scene_input.scene, &info, plan, bar).map_err(CliError::Bench)?;
    bar.hidden(|| {
        for note in &measured.notes {
            output::note(note);
        }
        output::print(&table::scene(&measured, output::stdout_columns()))
    })?;
    Ok((measured, scene_input))
}

/// The picture whose rays a plan measures.
pub fn picture(plan: &BenchPlan) -> WantedPicture {
    WantedPicture {
        size: Some(plan.size.into()),
        turntable: false,
    }
}

/// The record of a run.
pub fn record(plan: &BenchPlan, all: Vec<Measured>, started: String, seconds: f64) -> BenchRecord {
    let arguments = std::env::args_os().skip(1).map(without_folder).collect();
    let run = plan.run_info(started, arguments, seconds);
    phalanx::bench::record(this_program(), run, all)
}

/// An argument with the names of files only: records travel, folders of a machine do not.
fn without_folder(argument: OsString) -> String {
    let text = argument.to_string_lossy();
    let sign = text.find('=').filter(|_| text.starts_with("--"));
    let (option, value) = text.split_at(sign.map_or(0, |separator| separator + 1));
    option.to_owned() + value.rsplit(is_separator).next().unwrap_or(value)
}
