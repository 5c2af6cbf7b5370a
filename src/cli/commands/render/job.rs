//! Renders the pictures of a scene one after the other, and writes each while it is rendered.

use super::args::RenderArgs;
use super::kept_tiles::{keep_tiles, open_tiles};
use super::report::RenderSeconds;
use crate::cli::options::Sequence;
use crate::cli::output::{
    self, CliError, EvenColor, LivePreview, OutputFile, ProgressOptions, mrays_per_s, progress,
};
use phalanx::files::shown_path;
use phalanx::formats::DefaultLights;
use phalanx::frame::{Accel, Settings};
use phalanx::jobs::{
    BandStats, PictureSpec, RenderKey, TileFile, TileOutputs, bands, open_bands, render_bands,
};
use phalanx::render::RenderStats;
use phalanx::scene::Scene;
use std::path::Path;
use std::time::Instant;

/// Inputs shared by all frames of a sequence.
pub struct Job<'a> {
    pub args: &'a RenderArgs,
    pub prepared: &'a Accel,
    pub settings: &'a Settings,
}

/// Totals of rendering and writing.
#[derive(Default)]
pub struct RenderTotals {
    pub stats: RenderStats,
    pub seconds: RenderSeconds,
    /// Bytes of finished tiles that are kept in files.
    pub kept_bytes: u64,
}

impl RenderTotals {
    /// Adds those of another frame.
    pub fn add(&mut self, frame: &RenderTotals) {
        self.stats.add(&frame.stats);
        self.seconds.render += frame.seconds.render;
        self.seconds.write += frame.seconds.write;
        self.kept_bytes += frame.kept_bytes;
    }
}

/// Prints the time, the rate and the file of a frame.
pub fn print_frame(
    frame: u32,
    stats: &RenderStats,
    seconds: f64,
    path: &Path,
) -> Result<(), CliError> {
    output::print(&format!(
        "frame {frame}: {seconds:.3} seconds, {:.3} Mrays/s, {}\n",
        mrays_per_s(stats.rays.total(), seconds),
        shown_path(path)
    ))
}

impl Job<'_> {
    /// Renders the frames of a sequence one after the other.
    pub fn sequence(
        &self,
        spec: &PictureSpec,
        sequence: &Sequence,
        scene: &mut Scene,
        output: &OutputFile,
    ) -> Result<RenderTotals, CliError> {
        let start = scene.view;
        let lights = DefaultLights::of(scene, self.settings.threads);
        let mut all = RenderTotals::default();
        for frame in sequence.frames.clone() {
            lights.move_camera(scene, sequence.view(frame, &start)?);
            let path = sequence.name(&output.path, frame);
            let output = output.with_path(path);
            let checkpoint = self.args.kept.checkpoint.as_deref();
            let checkpoint = checkpoint.map(|path| sequence.name(path, frame));
            let tiles = self.checkpoint(scene, checkpoint.as_deref())?;
            let is_moved = scene.view != start || scene.defaulted.view;
            let output = output.with_header(spec.header(scene, is_moved));
            let work = self.render(scene, &output, tiles.as_ref())?;
            if !self.args.json {
                print_frame(frame, &work.stats, work.seconds.render, &output.path)?;
            }
            all.add(&work);
        }
        Ok(all)
    }

    /// Opens the checkpoint file, if one was requested.
    pub fn checkpoint(
        &self,
        scene: &Scene,
        path: Option<&Path>,
    ) -> Result<Option<TileFile>, CliError> {
        let open = |path| {
            let key = RenderKey::of(scene, self.settings);
            open_tiles(path, &key, self.settings.pixels())
        };
        path.map(open).transpose()
    }

    /// Renders a picture and writes it at the same time. Finished tiles are kept in a file, if one
    /// is given.
    pub fn render(
        &self,
        scene: &Scene,
        output: &OutputFile,
        tiles: Option<&TileFile>,
    ) -> Result<RenderTotals, CliError> {
        let (args, settings) = (self.args, self.settings);
        let preview = LivePreview::of(
            args.preview.preview,
            args.preview.snapshot.as_deref(),
            output.file.exposure,
            settings.window(),
        )?;
        let outputs = TileOutputs {
            file: tiles,
            thumbnail: preview.as_ref().map(|preview| &preview.thumbnail),
        };
        let options = ProgressOptions {
            pixels: settings.pixels(),
            mode: args.progress,
            live_preview: preview.as_ref(),
        };
        let start = Instant::now();
        let mut color = EvenColor::default();
        let written = progress::with_progress(options, |control| {
            let tree = self.prepared.accel();
            output.write_while(control, |take| {
                render_bands(scene, tree, settings, control, outputs, |band| {
                    color.add(&output.file, &band);
                    take(band)
                })
            })
        });
        let BandStats { stats, seconds } = match tiles {
            Some(tiles) => keep_tiles(tiles, written)?,
            None => written?,
        };
        let size = (settings.width, settings.height);
        if let Some(reason) = color.explain(&output.file, scene, size) {
            output::warning(&reason);
        }
        let seconds = RenderSeconds {
            render: seconds,
            write: start.elapsed().as_secs_f64() - seconds,
            ..RenderSeconds::default()
        };
        let metadata = tiles.and_then(|tiles| tiles.path().metadata().ok());
        Ok(RenderTotals {
            stats,
            seconds,
            kept_bytes: metadata.map_or(0, |file| file.len()),
        })
    }
}

/// Number of films in memory at a time: those that are rendered, one that waits, and one that is
/// written. A file that is put together in memory takes the space of all bands on top.
pub fn films_in_memory(settings: &Settings, output: &OutputFile) -> u64 {
    let bands = bands(settings.window(), settings.tile_side());
    let file = if output.is_in_memory() { bands.len() } else { 0 };
    (bands.len().min(open_bands(&bands) + 2) + file) as u64
}
