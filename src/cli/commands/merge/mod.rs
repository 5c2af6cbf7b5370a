//! `phalanx merge`: joins the shards of a plan into its picture, or checks and joins its frames.

mod args;
mod frames;
mod shard_files;

pub use args::MergeArgs;
pub use shard_files::ranges;

use super::plan;
use crate::cli::output::{
    self, CliError, Output, ProgressOptions, format_of, interrupt, lines, progress,
};
use phalanx::files::shown_path;
use phalanx::frame::Tile;
use phalanx::jobs::{PlannedFrames, RenderPlan, TileFile, merge_bands};
use serde::Serialize;
use shard_files::{MAX_NAMED, describe_missing, whole};
use std::path::Path;

#[derive(Debug, Serialize)]
struct MergeDocument<'a> {
    plan: &'a Path,
    shards: u32,
    width: u32,
    height: u32,
    path: &'a Path,
}

/// Merges the rendered shards of a plan; exit code 6 if there is something missing.
pub fn run(args: &MergeArgs) -> Result<(), CliError> {
    let plan = plan::read(&args.plan)?;
    if let Some(frames) = PlannedFrames::of(&plan) {
        return frames::run(args, &frames);
    }
    let path = match &args.output {
        Some(path) => path.clone(),
        None => plan.picture_path(&args.plan)?,
    };
    let format = format_of(&path, args.format, "the picture")?;
    output::check_picture_place(&path, Some("--output"))?;
    interrupt::listen()?;
    let output = plan::target(&plan, path, format)?;
    let files = files(&args.plan, &plan)?;
    let window = plan.picture.window();
    progress::with_progress(
        Some(&output.path),
        ProgressOptions::of(window.pixels()),
        |control| {
            output.write_while(control, |take| {
                merge_bands(window, plan.aovs(), &files, control, take)
            })
        },
    )?;
    let document = MergeDocument {
        plan: &args.plan,
        shards: plan.shards,
        width: window.width,
        height: window.height,
        path: &output.path,
    };
    output::print_output(&document, args.json)
}

impl Output for MergeDocument<'_> {
    fn table(&self) -> String {
        let size = format!(
            "{}x{}, from {} shards",
            self.width, self.height, self.shards
        );
        let path = shown_path(self.path);
        lines(&[("picture", size), ("written", path)])
    }
}

/// A shard that cannot be merged yet, and the reason.
struct IncompleteShard {
    shard: u32,
    why: String,
}

/// The files of all shards, each of which has all of its tiles.
fn files(path: &Path, plan: &RenderPlan) -> Result<Vec<TileFile>, CliError> {
    let (files, missing) = shards(path, plan)?;
    match missing.is_empty() {
        true => Ok(files),
        false => {
            let numbers: Vec<u32> = missing.iter().map(|m| m.shard).collect();
            let count = (missing.len() as u64, u64::from(plan.shards), "shards");
            let named = missing.into_iter().take(MAX_NAMED);
            let named: Vec<_> = named
                .map(|m| (format!("shard {}", m.shard), m.why))
                .collect();
            let text = describe_missing(path, count, &named, &numbers);
            Err(CliError::Missing(text))
        }
    }
}

/// The numbers of the shards that have something left to render.
pub fn missing(path: &Path, plan: &RenderPlan) -> Result<Vec<u32>, CliError> {
    if let Some(frames) = PlannedFrames::of(plan) {
        return Ok(frames::missing(path, &frames)?.shards());
    }
    let (_, missing) = shards(path, plan)?;
    Ok(missing.iter().map(|missing| missing.shard).collect())
}

/// The files of the shards that can be merged, and the other shards.
fn shards(
    path: &Path,
    plan: &RenderPlan,
) -> Result<(Vec<TileFile>, Vec<IncompleteShard>), CliError> {
    let (mut files, mut missing) = (Vec::new(), Vec::new());
    let tiles = plan.tiles();
    for shard in 0..plan.shards {
        let share: Vec<Tile> = plan.share_of(&tiles, shard).collect();
        match whole(&plan.shard_file(path, shard)?, &plan.picture, &share)? {
            Ok(file) => files.push(file),
            Err(why) => missing.push(IncompleteShard { shard, why }),
        }
    }
    Ok((files, missing))
}
