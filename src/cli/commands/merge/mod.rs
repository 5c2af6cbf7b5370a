//! `phalanx merge`: merges the shards of a plan into its picture or its frames, or checks the
//! frames that shards have written.

mod args;
mod missing;
mod shard_files;

pub use args::MergeArgs;
pub use shard_files::ranges;

use super::plan;
use crate::cli::output::{
    self, CliError, EvenColor, Output, OutputFile, ProgressOptions, format_of, interrupt, lines,
    progress, video_rows,
};
use missing::{MissingShares, missing_frames, missing_tiles, shares, tile_files};
use phalanx::files::shown_path;
use phalanx::image::ImageFormat;
use phalanx::jobs::{PlannedFrames, RenderPlan, ShardBy, TileFile, merge_bands};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, Serialize)]
struct MergeDocument<'a> {
    plan: &'a Path,
    shards: u32,
    /// Meaning of a shard of a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    shard_by: Option<ShardBy>,
    /// The first and the last frame of a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<[u32; 2]>,
    width: u32,
    height: u32,
    /// The file of the picture, or of the first frame.
    path: PathBuf,
    /// The file of the last frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    last_path: Option<PathBuf>,
    /// How frames become a video.
    #[serde(skip)]
    video: Vec<(&'static str, String)>,
}

/// Merges the shards of a plan; exit code 6 if any are missing.
pub fn run(args: &MergeArgs) -> Result<(), CliError> {
    let plan = plan::read(&args.plan)?;
    let frames = PlannedFrames::of(&plan);
    let output = output_path(args, &frames)?;
    if frames.is_by_frame() {
        interrupt::listen()?;
        missing_frames(&args.plan, &frames)?.refuse(&args.plan, &frames)?;
    } else {
        join(args, &frames, &output)?;
    }
    let (window, sequence) = (plan.window(), frames.sequence);
    let ends = sequence.map(|sequence| sequence.frames);
    let format = args.format.or(ImageFormat::of(&output));
    let is_linear = format.is_some_and(ImageFormat::is_linear);
    let size = (window.width, window.height);
    let video = ends.map(|ends| video_rows(&output, ends, size, is_linear));
    let document = MergeDocument {
        plan: &args.plan,
        shards: plan.shards,
        shard_by: sequence.map(|sequence| sequence.shard_by),
        frames: ends,
        width: window.width,
        height: window.height,
        path: frames.name(&output, ends.map_or(0, |[first, _]| first)),
        last_path: ends.map(|[_, last]| frames.name(&output, last)),
        video: video.unwrap_or_default(),
    };
    output::print_output(&document, args.json)
}

/// The path of the picture, or the pattern for the names of frames.
fn output_path(args: &MergeArgs, frames: &PlannedFrames) -> Result<PathBuf, CliError> {
    let plan = frames.plan;
    if frames.is_by_frame() {
        if args.output.is_some() || args.format.is_some() {
            let message = "-o and --format cannot be used with this plan: its shards wrote the frames, and merge only checks them";
            return Err(CliError::Usage(message.to_owned()));
        }
        return Ok(args.plan.with_file_name(&plan.output));
    }
    match &args.output {
        Some(path) if frames.sequence.is_some() && output::is_dash(path) => Err(CliError::Usage(
            "a sequence cannot be written to stdout: give a file name".to_owned(),
        )),
        Some(path) => Ok(path.clone()),
        None => Ok(plan.picture_path(&args.plan)?),
    }
}

/// The shards that are not finished.
pub fn missing_shards(path: &Path, plan: &RenderPlan) -> Result<Vec<u32>, CliError> {
    let frames = PlannedFrames::of(plan);
    let missing: MissingShares = if frames.is_by_frame() {
        missing_frames(path, &frames)?
    } else {
        missing_tiles(path, &frames, &shares(&frames))?.0
    };
    Ok(missing.shards())
}

/// Merges the tiles of the picture, or of each frame, and writes it.
fn join(args: &MergeArgs, frames: &PlannedFrames, output: &Path) -> Result<(), CliError> {
    let plan = frames.plan;
    let format = format_of(output, args.format, "the picture")?;
    if frames.sequence.is_none() {
        output::check_picture_place(output, Some("--output"))?;
    }
    interrupt::listen()?;
    let target = plan::target(plan, output.into(), format)?;
    let shares = shares(frames);
    let (missing, files) = missing_tiles(&args.plan, frames, &shares)?;
    missing.refuse(&args.plan, frames)?;
    if frames.sequence.is_none() {
        return write(frames, &target, &files);
    }
    // The headers of frames contain their cameras, in the coordinates of the scene's file.
    let mut reopened = plan::reopen(&args.plan, plan, 0)?;
    for frame in frames.all() {
        let path = match args.output {
            Some(_) => frames.name(output, frame),
            None => frames.picture_path(&args.plan, frame)?,
        };
        output::check_picture_place(&path, Some("--output"))?;
        let file = target.with_path(path);
        reopened.set_frame(frames, frame)?;
        let file = reopened.with_frame_header(plan, &file);
        let files = tile_files(&args.plan, frames, frame, &shares)?;
        write(frames, &file, &files.collect::<Result<Vec<_>, _>>()?)?;
    }
    Ok(())
}

/// Writes the picture from these files of tiles.
fn write(frames: &PlannedFrames, file: &OutputFile, files: &[TileFile]) -> Result<(), CliError> {
    let (window, aovs) = (frames.plan.window(), frames.plan.spec.pixels.aovs());
    let options = ProgressOptions::of(window.pixels());
    let mut color = EvenColor::default();
    progress::with_progress(options, |control| {
        file.write_while(control, |take| {
            merge_bands(window, aovs, files, control, |band| {
                color.add(&file.file, &band);
                take(band)
            })
        })
    })?;
    if matches!(color, EvenColor::All(..)) {
        output::warning(output::EMPTY);
    }
    Ok(())
}

impl Output for MergeDocument<'_> {
    fn table(&self) -> String {
        let (width, height) = (self.width, self.height);
        let size = format!("{width}x{height}, from {} shards", self.shards);
        let mut path = shown_path(&self.path);
        if let Some(last) = self.last_path.as_ref().filter(|last| **last != self.path) {
            path.push_str(&format!(" to {}", shown_path(last)));
        }
        let Some([first, last]) = self.frames else {
            return lines(&[("picture", size), ("written", path)]);
        };
        let done = match self.shard_by {
            Some(ShardBy::Tile) => "merged",
            _ => "checked",
        };
        let frames = format!("{first} to {last}, {size}, {done}");
        let mut rows = vec![("frames", frames), ("written", path)];
        rows.extend(self.video.clone());
        lines(&rows)
    }
}
