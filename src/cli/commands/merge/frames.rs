//! `phalanx merge` for a sequence: whole frames are checked, tiles are put together frame by frame.

use super::args::MergeArgs;
use super::shard_files::{MAX_NAMED, describe_missing, whole};
use crate::cli::commands::plan;
use crate::cli::output::{
    self, CliError, Output, OutputFile, ProgressOptions, format_of, interrupt, lines, progress,
};
use phalanx::files::shown_path;
use phalanx::frame::Tile;
use phalanx::jobs::{
    FinishedFrames, FrameState, KeptFileError, PlannedFrames, TileFile, merge_bands,
};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

#[derive(Debug, Serialize)]
struct MergedFramesDocument<'a> {
    plan: &'a Path,
    shards: u32,
    shard_by: &'static str,
    frames: [u32; 2],
    width: u32,
    height: u32,
    /// The file of the first frame.
    path: PathBuf,
    /// The file of the last frame.
    last_path: PathBuf,
}

/// A part of a frame that a shard has not rendered yet, and the reason.
struct MissingFrame {
    frame: u32,
    shard: u32,
    why: String,
}

/// Parts of frames that are missing: their number, the first few, and all their shards.
#[derive(Default)]
pub struct MissingFrames {
    count: u64,
    first: Vec<MissingFrame>,
    shards: BTreeSet<u32>,
}

impl MissingFrames {
    fn add(&mut self, frame: u32, shard: u32, why: String) {
        self.count += 1;
        self.shards.insert(shard);
        let last = self.first.last().map_or(0, |last| last.frame);
        if self.first.len() < MAX_NAMED || frame < last {
            self.first.push(MissingFrame { frame, shard, why });
            self.first.sort_by_key(|missing| missing.frame);
            self.first.truncate(MAX_NAMED);
        }
    }

    /// Shards that something is missing of, in order.
    pub fn shards(&self) -> Vec<u32> {
        self.shards.iter().copied().collect()
    }
}

/// Checks the frames of a plan, or puts them together; exit code 6 if there is something missing.
pub fn run(args: &MergeArgs, frames: &PlannedFrames) -> Result<(), CliError> {
    let plan = frames.plan();
    let output = output_path(args, frames)?;
    interrupt::listen()?;
    let missing = missing(&args.plan, frames)?;
    if missing.count > 0 {
        return Err(CliError::Missing(describe(args, frames, &missing)));
    }
    if !frames.is_by_frame() {
        put_together(args, frames, &output)?;
    }
    let window = plan.picture.window();
    let [first, last] = frames.sequence().frames;
    let document = MergedFramesDocument {
        plan: &args.plan,
        shards: plan.shards,
        shard_by: frames.sequence().shard_by.name(),
        frames: [first, last],
        width: window.width,
        height: window.height,
        path: frames.name(&output, first),
        last_path: frames.name(&output, last),
    };
    output::print_output(&document, args.json)
}

/// The path that frames get their numbers in.
fn output_path(args: &MergeArgs, frames: &PlannedFrames) -> Result<PathBuf, CliError> {
    let plan = frames.plan();
    if frames.is_by_frame() {
        if args.output.is_some() || args.format.is_some() {
            return Err(CliError::Usage(
                "the shards of this plan have written its frames, and merge checks them: leave out -o and --format"
                    .to_owned(),
            ));
        }
        return Ok(args.plan.with_file_name(&plan.output));
    }
    match &args.output {
        Some(path) if output::is_dash(path) => Err(CliError::Usage(
            "a sequence is a file for each frame, and stdout is one: name files".to_owned(),
        )),
        Some(path) => Ok(path.clone()),
        None => Ok(plan.picture_path(&args.plan)?),
    }
}

/// Everything that is missing of a plan's frames.
pub fn missing(path: &Path, frames: &PlannedFrames) -> Result<MissingFrames, CliError> {
    match frames.is_by_frame() {
        true => missing_frames(path, frames),
        false => missing_tiles(path, frames),
    }
}

fn missing_frames(path: &Path, frames: &PlannedFrames) -> Result<MissingFrames, CliError> {
    let plan = frames.plan();
    let mut missing = MissingFrames::default();
    for shard in 0..plan.shards {
        let name = frames.list_file(path, shard)?;
        let list = FinishedFrames::read(&name, &plan.picture, &frames.path_checksum());
        let list = match list {
            Ok(list) => Ok(list),
            Err(KeptFileError::Io { source, .. })
                if source.kind() == std::io::ErrorKind::NotFound =>
            {
                Err(format!("there is no {}", shown_path(&name)))
            }
            Err(KeptFileError::Other { .. }) => {
                Err(format!("{} lists no frames", shown_path(&name)))
            }
            Err(error) => return Err(error.into()),
        };
        for frame in frames.of_shard(shard) {
            let why = match &list {
                Ok(list) => unfinished(path, frames, list, frame)?,
                Err(why) => Some(why.clone()),
            };
            if let Some(why) = why {
                missing.add(frame, shard, why);
            }
        }
    }
    Ok(missing)
}

/// The reason why a frame is not finished, if it is not.
fn unfinished(
    path: &Path,
    frames: &PlannedFrames,
    list: &FinishedFrames,
    frame: u32,
) -> Result<Option<String>, CliError> {
    let picture = plan::frame_path(frames, path, frame)?;
    let name = shown_path(&picture);
    let state = list.state(frames.identity(frame)?, &picture);
    Ok(match state.map_err(|e| CliError::cannot_read(&name, e))? {
        FrameState::Finished => None,
        FrameState::Absent => Some(format!("there is no {name}")),
        FrameState::Unlisted => Some(format!("{name} is not listed as a frame of this plan")),
        FrameState::Changed => Some(format!("{name} is not as it was written")),
    })
}

fn missing_tiles(path: &Path, frames: &PlannedFrames) -> Result<MissingFrames, CliError> {
    let shares = shares(frames);
    let mut missing = MissingFrames::default();
    for frame in frames.all() {
        for (shard, file) in (0..).zip(files(path, frames, frame, &shares)?) {
            if let Err(why) = file {
                missing.add(frame, shard, why);
            }
        }
    }
    Ok(missing)
}

/// The tiles of each shard.
fn shares(frames: &PlannedFrames) -> Vec<Vec<Tile>> {
    let (plan, tiles) = (frames.plan(), frames.plan().tiles());
    let share = |shard| plan.share_of(&tiles, shard).collect();
    (0..plan.shards).map(share).collect()
}

/// The files of a frame's tiles, one a shard, or the reasons why they cannot be merged yet.
fn files(
    path: &Path,
    frames: &PlannedFrames,
    frame: u32,
    shares: &[Vec<Tile>],
) -> Result<Vec<Result<TileFile, String>>, CliError> {
    let key = frames.key(frame)?;
    let files = (0..).zip(shares).map(|(shard, share)| {
        let name = frames.tile_file(path, shard, frame)?;
        whole(&name, &key, share)
    });
    files.collect()
}

/// Message that names the missing frames.
fn describe(args: &MergeArgs, frames: &PlannedFrames, missing: &MissingFrames) -> String {
    let row = |m: &MissingFrame| {
        (
            format!("frame {}, shard {}", m.frame, m.shard),
            m.why.clone(),
        )
    };
    let named: Vec<_> = missing.first.iter().map(row).collect();
    let count = u64::from(frames.sequence().count());
    let (of, what) = match frames.is_by_frame() {
        true => (count, "frames"),
        false => (count * u64::from(frames.plan().shards), "parts of frames"),
    };
    let count = (missing.count, of, what);
    describe_missing(&args.plan, count, &named, &missing.shards())
}

/// Puts each frame together, and writes it.
fn put_together(args: &MergeArgs, frames: &PlannedFrames, output: &Path) -> Result<(), CliError> {
    let plan = frames.plan();
    let format = format_of(output, args.format, "the picture")?;
    let target = plan::target(plan, output.into(), format)?;
    // Headers of frames tell their cameras, in the coordinates of the scene's file.
    let mut reopened = plan::reopen(&args.plan, plan, 0)?;
    let (window, shares) = (plan.picture.window(), shares(frames));
    for frame in frames.all() {
        let path = match args.output {
            Some(_) => frames.name(output, frame),
            None => frames.picture_path(&args.plan, frame)?,
        };
        output::check_picture_place(&path, Some("--output"))?;
        let file = OutputFile {
            path,
            ..target.clone()
        };
        reopened.scene_input.scene.view = frames.view(frame)?;
        let file = reopened.with_frame_header(frames, &file)?;
        let files = files(&args.plan, frames, frame, &shares)?;
        let files: Result<Vec<TileFile>, String> = files.into_iter().collect();
        let files = files.map_err(CliError::Missing)?;
        let options = ProgressOptions::of(window.pixels());
        progress::with_progress(Some(&file.path), options, |control| {
            file.write_while(control, |take| {
                merge_bands(window, plan.aovs(), &files, control, take)
            })
        })?;
    }
    Ok(())
}

impl Output for MergedFramesDocument<'_> {
    fn table(&self) -> String {
        let [first, last] = self.frames;
        let done = match self.shard_by {
            "tile" => "put together",
            _ => "checked",
        };
        let frames = format!(
            "{first} to {last}, {}x{}, from {} shards, {done}",
            self.width, self.height, self.shards
        );
        let mut path = shown_path(&self.path);
        if self.last_path != self.path {
            path.push_str(&format!(" to {}", shown_path(&self.last_path)));
        }
        lines(&[("frames", frames), ("written", path)])
    }
}
