//! `phalanx render --plan --shard`: one shard of a plan, into a file beside it.

use super::args::{RenderArgs, Shard};
use super::kept_tiles::{keep_tiles, warn_damaged};
use super::{shard_frames, shard_index};
use crate::cli::commands::plan;
use crate::cli::output::{
    self, CliError, Output, ProgressOptions, grouped, interrupt, lines, mrays_per_s, progress,
};
use phalanx::files::shown_path;
use phalanx::jobs::{BandStats, PlannedFrames, TileFile, render_to_file};
use serde::Serialize;
use std::path::Path;

#[derive(Debug, Serialize)]
struct ShardDocument<'a> {
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
    let plan = plan::read(path)?;
    let asked = args.keep.shard.unwrap_or(Shard::Auto);
    let (shard, found) = shard_index::resolve(asked, plan.shards, |name| std::env::var(name).ok())?;
    plan.check_shard(shard)?;
    if let Some(name) = found {
        output::status(&format!("shard {shard} of {}, by {name}", plan.shards));
    }
    interrupt::listen()?;
    output::advise();
    if let Some(frames) = PlannedFrames::of(&plan) {
        return shard_frames::run(args, path, &frames, shard);
    }
    let picture = plan::reopen(path, &plan, args.work.threads.unwrap_or(0))?;
    let (mut scene_input, settings) = (picture.scene_input, args.work.apply(picture.settings));
    let name = plan.shard_file(path, shard)?;
    let file = TileFile::open(&name, &plan.picture)?;
    warn_damaged(&file, &name);
    let prepared = scene_input.prepare_render(&settings, &args.tree, 0)?;
    let scene = &scene_input.scene;
    let share = plan.share(shard)?;
    let tiles = share.len();
    let kept = share.iter().filter(|tile| file.has(**tile)).count();
    let pixels = share.iter().map(|tile| tile.pixels()).sum();
    let options = ProgressOptions {
        mode: args.progress,
        ..ProgressOptions::of(pixels)
    };
    let done = progress::with_progress(None, options, |control| {
        let tree = prepared.accel();
        render_to_file(scene, tree, &settings, control, share, &file)
    });
    let BandStats { stats, seconds } = keep_tiles(&file, done)?;
    let rays = stats.rays.total();
    let document = ShardDocument {
        shard,
        shards: plan.shards,
        tiles,
        kept,
        rays,
        seconds,
        mrays_per_s: mrays_per_s(rays, seconds),
        path: &name,
    };
    output::print_output(&document, args.json)
}

impl Output for ShardDocument<'_> {
    fn table(&self) -> String {
        let before = match self.kept {
            0 => String::new(),
            kept => format!(", {} of them earlier", grouped(kept as u64)),
        };
        let tiles = grouped(self.tiles as u64);
        let shard = format!("{} of {}: {tiles} tiles{before}", self.shard, self.shards);
        let (rays, speed, seconds) = (grouped(self.rays), self.mrays_per_s, self.seconds);
        let rays = format!("{rays}, {speed:.3} Mrays/s, {seconds:.3} seconds");
        let path = shown_path(self.path);
        lines(&[("shard", shard), ("rays", rays), ("written", path)])
    }
}
