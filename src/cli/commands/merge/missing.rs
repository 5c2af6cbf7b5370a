//! The parts of a plan's picture or frames that its shards have not rendered yet.

use super::shard_files::{complete_tiles, open_shard, ranges};
use crate::cli::commands::plan;
use crate::cli::output::CliError;
use phalanx::files::{shell_path, shown_path};
use phalanx::frame::Tile;
use phalanx::jobs::{FinishedFrames, FrameState, PlannedFrames, TileFile};
use std::collections::BTreeSet;
use std::path::Path;

/// Maximum number of shards or frames that a message lists individually.
const MAX_NAMED: usize = 10;

/// A part of a frame that a shard has not rendered yet, and the reason.
struct MissingShare {
    frame: u32,
    shard: u32,
    why: String,
}

/// Missing parts of frames: their number, the first few, and all their shards.
#[derive(Default)]
pub struct MissingShares {
    count: u64,
    first: Vec<MissingShare>,
    shards: BTreeSet<u32>,
}

impl MissingShares {
    fn add(&mut self, frame: u32, shard: u32, why: String) {
        self.count += 1;
        self.shards.insert(shard);
        let last = self.first.last().map_or(0, |last| last.frame);
        if self.first.len() < MAX_NAMED || frame < last {
            self.first.push(MissingShare { frame, shard, why });
            self.first.sort_by_key(|missing| missing.frame);
            self.first.truncate(MAX_NAMED);
        }
    }

    /// Shards with missing parts, in order.
    pub fn shards(&self) -> Vec<u32> {
        self.shards.iter().copied().collect()
    }

    /// Refuses a merge with missing parts. The message lists the first ones with reasons, and the
    /// shards to render.
    pub fn refuse(&self, path: &Path, frames: &PlannedFrames) -> Result<(), CliError> {
        if self.count == 0 {
            return Ok(());
        }
        let (count, shards) = (frames.all().count() as u64, u64::from(frames.plan.shards));
        let (total, what) = match (frames.sequence, frames.is_by_frame()) {
            (None, _) => (shards, "shards"),
            (_, true) => (count, "frames"),
            (_, false) => (count * shards, "parts of frames"),
        };
        let mut text = format!("{} of {total} {what} are missing", self.count);
        for MissingShare { frame, shard, why } in &self.first {
            let name = match frames.sequence {
                None => format!("shard {shard}"),
                Some(_) => format!("frame {frame}, shard {shard}"),
            };
            text.push_str(&format!("\n  {name}: {why}"));
        }
        let more = self.count - self.first.len() as u64;
        if more > 0 {
            text.push_str(&format!("\n  and {more} more"));
        }
        text.push_str(&format!(
            "\n  help: render them with phalanx render --plan {} --shard I, or as a job array with --array={}",
            shell_path(path),
            ranges(&self.shards())
        ));
        Err(CliError::Missing(text))
    }
}

/// Whole frames that shards have not written yet.
pub fn missing_frames(path: &Path, frames: &PlannedFrames) -> Result<MissingShares, CliError> {
    let plan = frames.plan;
    let mut missing = MissingShares::default();
    for shard in 0..plan.shards {
        let name = frames.list_file(path, shard)?;
        let list = FinishedFrames::read(&name, &plan.key(), &frames.path_checksum());
        let list = match open_shard(list, &name, "is not a list of frames") {
            Ok(list) => Ok(list),
            Err(CliError::Missing(reason)) => Err(reason),
            Err(error) => return Err(error),
        };
        for frame in frames.of_shard(shard) {
            let reason = match &list {
                Ok(list) => unfinished(path, frames, list, frame)?,
                Err(reason) => Some(reason.clone()),
            };
            if let Some(reason) = reason {
                missing.add(frame, shard, reason);
            }
        }
    }
    Ok(missing)
}

/// The reason why a frame is not finished; `None` if it is.
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
        FrameState::Absent => Some(format!("{name} does not exist")),
        FrameState::Unlisted => Some(format!("{name} is not listed as a frame of this plan")),
        FrameState::Changed => Some(format!("{name} has changed since it was written")),
    })
}

/// Parts of frames with missing tiles. For a single picture, also the complete files of tiles.
pub fn missing_tiles(
    path: &Path,
    frames: &PlannedFrames,
    shares: &[Vec<Tile>],
) -> Result<(MissingShares, Vec<TileFile>), CliError> {
    let (mut missing, mut files) = (MissingShares::default(), Vec::new());
    for frame in frames.all() {
        for (shard, file) in (0..).zip(tile_files(path, frames, frame, shares)?) {
            match file {
                Ok(file) if frames.sequence.is_none() => files.push(file),
                Ok(_) => {}
                Err(CliError::Missing(reason)) => missing.add(frame, shard, reason),
                Err(error) => return Err(error),
            }
        }
    }
    Ok((missing, files))
}

/// The tiles of each shard.
pub fn shares(frames: &PlannedFrames) -> Vec<Vec<Tile>> {
    let (plan, tiles) = (frames.plan, frames.plan.tiles());
    let share = |shard| plan.share_of(&tiles, shard).collect();
    (0..plan.shards).map(share).collect()
}

/// The files of a frame's tiles, one a shard; [`CliError::Missing`] for incomplete ones.
pub fn tile_files(
    path: &Path,
    frames: &PlannedFrames,
    frame: u32,
    shares: &[Vec<Tile>],
) -> Result<impl Iterator<Item = Result<TileFile, CliError>>, CliError> {
    let key = frames.key(frame)?;
    Ok((0..).zip(shares).map(move |(shard, share)| {
        complete_tiles(&frames.tile_file(path, shard, frame)?, &key, share)
    }))
}
