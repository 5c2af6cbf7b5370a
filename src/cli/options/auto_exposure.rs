//! `--exposure auto`: stops measured before the picture is rendered.

use super::frames::Sequence;
use super::scene_input::SceneInput;
use super::work_args::TreeArgs;
use crate::cli::output::{self, CliError, ProgressMode, ProgressOptions, progress};
use phalanx::formats::DefaultLights;
use phalanx::frame::{AccelRef, Integrator, Settings};
use phalanx::jobs::{EncodingSpec, ExposureSpec, measure_exposure};

/// Replaces an automatic exposure by the stops that suit the picture, or the first frame of the
/// sequence's path, so that frames rendered separately match. Builds a tree if none is given.
pub fn resolve_exposure(
    encoding: &mut EncodingSpec,
    input: &mut SceneInput,
    sequence: Option<&Sequence>,
    tree: Option<AccelRef>,
    settings: &Settings,
) -> Result<(), CliError> {
    if encoding.exposure != Some(ExposureSpec::Auto) {
        return Ok(());
    }
    if matches!(settings.integrator, Integrator::Occlusion { .. }) {
        output::note("--exposure auto has no effect with --integrator ao");
    }
    let built;
    let tree = match tree {
        Some(tree) => tree,
        None => {
            built = input.prepare(settings.engine, &TreeArgs::default(), 0)?;
            built.accel()
        }
    };
    let (view, scene) = (input.scene.view, &mut input.scene);
    let lights = sequence.map(|_| DefaultLights::of(scene, settings.threads));
    if let (Some(sequence), Some(lights)) = (sequence, &lights) {
        lights.move_camera(scene, sequence.view(sequence.first, &view)?);
    }
    let silent = ProgressOptions {
        mode: ProgressMode::None,
        ..ProgressOptions::default()
    };
    let measure = |control: &_| measure_exposure(scene, tree, settings, control);
    let stops = progress::with_progress(silent, measure);
    if let Some(lights) = lights {
        lights.move_camera(scene, view);
    }
    encoding.exposure = Some(ExposureSpec::Stops(stops?));
    Ok(())
}

/// The row of an exposure in reports, if there is one.
pub fn exposure_row(exposure: Option<ExposureSpec>) -> Option<(&'static str, String)> {
    exposure.map(|exposure| ("exposure", format!("{} stops", exposure.stops())))
}
