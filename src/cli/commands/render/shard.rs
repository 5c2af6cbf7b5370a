//! `phalanx render --plan --shard`: one shard of a plan, into a file beside it.

use super::args::{RenderArgs, Shard};
use super::shard_index;
use crate::cli::commands::plan;
use crate::cli::output::{
    self, CliError, ProgressOptions, SCHEMA_VERSION, grouped, interrupt, lines, progress,
};
use phalanx::jobs::{BandStats, RenderPlan, TileFile, render_to_file};
use serde::Serialize;
use std::path::Path;

#[derive(Debug, Serialize)]
struct ShardDocument<'a> {
    schema_version: u32,
    shard: u32,
    shards: u32,
    /// Tiles of the shard.
    tiles: usize,
    /// Tiles of the shard that had been rendered before.
    kept: usize,
    rays: u64,
    seconds: f64,
    mrays_per_s: f64,
    path: &'a Path,
}

/// Renders a shard of a plan. Tiles that an earlier try has finished are not rendered again.
pub fn run(args: &RenderArgs, path: &Path) -> Result<(), CliError> {
    let plan = RenderPlan::read(path)?;
    let asked = args.keep.shard.unwrap_or(Shard::Auto);
    let (shard, found) = shard_index::resolve(asked, |name| std::env::var(name).ok())?;
    let share = plan.share(shard)?;
    if let Some(name) = found {
        output::note(&format!("shard {shard} of {}, by {name}", plan.shards));
    }
    interrupt::listen()?;
    output::advise();
    let (mut scene_input, settings) = plan::reopen(path, &plan, args.work.threads.unwrap_or(0))?;
    let settings = args.work.apply(settings);
    let name = plan.shard_file(path, shard);
    let file = TileFile::open(&name, &plan.picture)?;
    warn_damaged(&file, &name);
    let prepared = scene_input.prepare(settings.engine, &args.tree, settings.threads)?;
    let scene = &scene_input.scene;
    scene_input
        .budget
        .for_render(scene, &prepared, &settings, 0)?;
    prepared.build_wide_bvh(&settings);
    let tiles = share.len();
    let kept = share.iter().filter(|tile| file.has(**tile)).count();
    let pixels = share.iter().map(|tile| tile.pixels()).sum();
    let options = ProgressOptions {
        mode: args.progress,
        ..ProgressOptions::of(pixels)
    };
    let done = progress::with_progress(options, |control| {
        let tree = prepared.accel();
        render_to_file(scene, tree, &settings, control, share, &file)
    });
    // Done even after an interruption, so that finished tiles are not lost.
    file.sync()?;
    let BandStats { stats, seconds } = done.map_err(|error| match error {
        CliError::Interrupted => CliError::Resumable(format!(
            "finished tiles are kept in {}; the same command goes on from there",
            name.display()
        )),
        other => other,
    })?;
    let rays = stats.rays.total();
    let speed = if seconds > 0.0 {
        rays as f64 / 1e6 / seconds
    } else {
        0.0
    };
    if args.json {
        return output::print_json(&ShardDocument {
            schema_version: SCHEMA_VERSION,
            shard,
            shards: plan.shards,
            tiles,
            kept,
            rays,
            seconds,
            mrays_per_s: speed,
            path: &name,
        });
    }
    let before = match kept {
        0 => String::new(),
        kept => format!(", {} of them earlier", grouped(kept as u64)),
    };
    output::print(&lines(&[
        (
            "shard",
            format!(
                "{shard} of {}: {} tiles{before}",
                plan.shards,
                grouped(tiles as u64)
            ),
        ),
        (
            "rays",
            format!(
                "{}, {speed:.3} Mrays/s, {seconds:.3} seconds",
                grouped(rays)
            ),
        ),
        ("written", name.display().to_string()),
    ]))
}

/// Warns on stderr of the tiles of a file that must be rendered again.
pub fn warn_damaged(file: &TileFile, name: &Path) {
    if file.damaged() > 0 {
        output::note(&format!(
            "warning: {}: {} tiles are damaged, and are rendered again",
            name.display(),
            grouped(file.damaged() as u64)
        ));
    }
}
