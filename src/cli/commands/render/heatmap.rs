//! `render --heat`: a picture of the cost of each pixel.

use crate::cli::output::{CliError, ProgressOptions, interrupt, progress};
use phalanx::frame::{Accel, AccelRef, RayCost, Settings, render_heatmap};
use phalanx::image::{false_color, save_png};
use phalanx::scene::Scene;
use std::path::PathBuf;

/// The cost to count, and the file to write.
pub struct HeatmapOutput {
    cost: RayCost,
    path: PathBuf,
}

/// Maximum number of pixels.
const PIXELS: u64 = 1 << 28;

/// The heat map requested by `--heat`.
pub fn from_args(
    heat: Option<&[String]>,
    settings: &Settings,
) -> Result<Option<HeatmapOutput>, CliError> {
    let Some([name, path]) = heat else {
        return Ok(None);
    };
    let Some((_, cost)) = RayCost::ALL.iter().find(|(known, _)| known == name) else {
        return Err(CliError::Usage(format!(
            "--heat {name}: expected nodes, prims or time, and then a file name"
        )));
    };
    if settings.engine != phalanx::frame::Engine::Simd {
        return Err(CliError::Usage("--heat needs --engine simd".to_owned()));
    }
    if settings.pixels() > PIXELS {
        return Err(CliError::Usage(format!(
            "--heat keeps the whole picture in memory, at most {PIXELS} pixels, not {}: choose a part with --region",
            settings.pixels()
        )));
    }
    let path = PathBuf::from(path);
    Ok(Some(HeatmapOutput { cost: *cost, path }))
}

/// Traces the camera rays once more, and writes their cost.
pub fn write(
    heatmap: &HeatmapOutput,
    scene: &Scene,
    prepared: &Accel,
    settings: &Settings,
) -> Result<(), CliError> {
    let AccelRef::Packets(bvh) = prepared.accel() else {
        return Ok(());
    };
    let costs = progress::with_progress(ProgressOptions::of(settings.pixels()), |control| {
        render_heatmap(scene, bvh, settings, heatmap.cost, control)
    })?;
    let picture = false_color(&costs, settings.window().width, heatmap.cost.title());
    Ok(interrupt::block_signals(&heatmap.path, || {
        save_png(&heatmap.path, &picture)
    })??)
}
