//! `phalanx render --plan --shard`: one shard of a plan. It renders its tiles of the picture, or of
//! every frame of a sequence, into files next to the plan; or whole frames, into their pictures.

use super::args::{RenderArgs, Shard};
use super::job::{Job, films_in_memory, print_frame};
use super::kept_tiles::{keep_tiles, open_tiles, warn_damaged};
use super::shard_index;
use crate::cli::commands::plan::{self, ReopenedPicture};
use crate::cli::output::{
    self, CliError, Output, OutputFile, ProgressOptions, format_of, grouped, interrupt, lines,
    mrays_per_s, progress,
};
use phalanx::files::shown_path;
use phalanx::frame::{Accel, Tile};
use phalanx::jobs::{
    BandStats, FinishedFrames, FrameState, PlannedFrames, ShardBy, TileFile, render_to_file,
};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, Default, Serialize)]
struct ShardDocument {
    shard: u32,
    shards: u32,
    /// Meaning of a shard of a sequence: whole frames, or tiles of each.
    #[serde(skip_serializing_if = "Option::is_none")]
    shard_by: Option<ShardBy>,
    /// Frames of a sequence in this shard, whole or in part.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<usize>,
    /// Tiles of a picture in this shard.
    #[serde(skip_serializing_if = "Option::is_none")]
    tiles: Option<usize>,
    /// Frames or tiles rendered by earlier runs.
    kept: usize,
    rays: u64,
    seconds: f64,
    mrays_per_s: f64,
    /// File of the picture's tiles, or of the first frame.
    path: PathBuf,
    /// The file of the last frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    last_path: Option<PathBuf>,
}

/// A shard of a plan, with its scene.
struct PlanShard<'a> {
    args: &'a RenderArgs,
    /// File of the plan.
    path: &'a Path,
    frames: &'a PlannedFrames<'a>,
    shard: u32,
    picture: ReopenedPicture,
    /// Built for the first frame that is not finished yet.
    prepared: Option<Accel>,
    done: ShardDocument,
}

/// Renders a shard of a plan, except parts that an earlier run has finished.
pub fn run(args: &RenderArgs, path: &Path) -> Result<(), CliError> {
    let plan = plan::read(path)?;
    let shard = args.kept.shard.unwrap_or(Shard::Auto);
    let (shard, variable) =
        shard_index::resolve(shard, plan.shards, |name| std::env::var(name).ok())?;
    plan.check_shard(shard)?;
    if let Some(name) = variable {
        output::status(&format!("shard {shard} of {}, from {name}", plan.shards));
    }
    interrupt::listen()?;
    output::advise();
    let frames = &PlannedFrames::of(&plan);
    let mut picture = plan::reopen(path, &plan, args.work.threads.unwrap_or(0))?;
    picture.settings = args.work.apply(args.tiles.apply(picture.settings));
    let sequence = frames.sequence;
    let mut work = PlanShard {
        args,
        path,
        frames,
        shard,
        picture,
        prepared: None,
        done: ShardDocument {
            shard,
            shards: plan.shards,
            shard_by: sequence.map(|sequence| sequence.shard_by),
            ..ShardDocument::default()
        },
    };
    // Locked first, so that two processes do not render one shard.
    let list = sequence.map(|_| {
        let list = frames.list_file(path, shard)?;
        let checksum = frames.path_checksum();
        Ok::<_, CliError>(FinishedFrames::open(&list, &plan.key(), &checksum)?)
    });
    match list.transpose()? {
        Some(list) if frames.is_by_frame() => work.whole_frames(list)?,
        _list => work.tiles()?,
    }
    work.done.mrays_per_s = mrays_per_s(work.done.rays, work.done.seconds);
    output::print_output(&work.done, args.json)
}

impl PlanShard<'_> {
    /// Renders whole frames, each into its picture, and lists them.
    fn whole_frames(&mut self, mut list: FinishedFrames) -> Result<(), CliError> {
        let PlanShard { path, frames, .. } = *self;
        let plan = frames.plan;
        for frame in frames.of_shard(self.shard) {
            let picture = plan::frame_path(frames, path, frame)?;
            let identity = frames.identity(frame)?;
            let tiles = frames.tile_file(path, self.shard, frame)?;
            self.count(&picture);
            if is_finished(list.state(identity, &picture), &picture)? {
                self.done.kept += 1;
                // A process that was killed may have left them.
                let _ = std::fs::remove_file(tiles);
                continue;
            }
            output::check_picture_place(&picture, Some("the picture"))?;
            let format = format_of(&picture, None, "the frame")?;
            let file = plan::target(plan, picture, format)?;
            self.whole_frame(frame, &file, &tiles)?;
            list.add(identity, &file.path)?;
            std::fs::remove_file(&tiles).map_err(|e| CliError::cannot_write(&tiles, e))?;
        }
        Ok(())
    }

    /// Renders a frame into its picture; its tiles are kept in a file until the picture is written.
    fn whole_frame(&mut self, frame: u32, file: &OutputFile, tiles: &Path) -> Result<(), CliError> {
        self.set_frame(frame, films_in_memory(&self.picture.settings, file))?;
        let Some(prepared) = &self.prepared else {
            return Ok(());
        };
        let settings = &self.picture.settings;
        let tiles = open_tiles(tiles, &self.frames.key(frame)?, settings.pixels())?;
        let job = Job {
            args: self.args,
            prepared,
            settings,
        };
        let file = &self.picture.with_frame_header(self.frames.plan, file);
        let work = job.render(&self.picture.scene_input.scene, file, Some(&tiles))?;
        let seconds = work.seconds.render;
        if !self.args.json {
            print_frame(frame, &work.stats, seconds, &file.path)?;
        }
        self.done.rays += work.stats.rays.total();
        self.done.seconds += seconds;
        Ok(())
    }

    /// Renders the shard's tiles of the picture, or of every frame.
    fn tiles(&mut self) -> Result<(), CliError> {
        let share = self.frames.plan.share(self.shard)?;
        for frame in self.frames.of_shard(self.shard) {
            let name = self.frames.tile_file(self.path, self.shard, frame)?;
            let file = TileFile::open(&name, &self.frames.key(frame)?)?;
            warn_damaged(&file, &name);
            let finished = share.iter().filter(|tile| file.has(**tile)).count();
            match self.frames.sequence {
                Some(_) => {
                    self.count(&name);
                    self.done.kept += usize::from(finished == share.len());
                }
                None => {
                    self.done.path = name;
                    self.done.tiles = Some(share.len());
                    self.done.kept = finished;
                }
            }
            if finished < share.len() {
                self.tiles_of(frame, &share, &file)?;
            }
        }
        Ok(())
    }

    fn tiles_of(&mut self, frame: u32, share: &[Tile], file: &TileFile) -> Result<(), CliError> {
        self.set_frame(frame, 0)?;
        let Some(prepared) = &self.prepared else {
            return Ok(());
        };
        let options = ProgressOptions {
            mode: self.args.progress,
            ..ProgressOptions::of(share.iter().map(Tile::pixels).sum())
        };
        let (scene, settings) = (&self.picture.scene_input.scene, &self.picture.settings);
        let done = progress::with_progress(options, |control| {
            let tree = prepared.accel();
            render_to_file(scene, tree, settings, control, share.to_vec(), file)
        });
        let BandStats { stats, seconds } = keep_tiles(file, done)?;
        if !self.args.json && self.frames.sequence.is_some() {
            print_frame(frame, &stats, seconds, file.path())?;
        }
        self.done.rays += stats.rays.total();
        self.done.seconds += seconds;
        Ok(())
    }

    /// Sets the camera of a frame; builds the BVH on the first call, with memory for `films` films.
    fn set_frame(&mut self, frame: u32, films: u64) -> Result<(), CliError> {
        self.picture.set_frame(self.frames, frame)?;
        if self.prepared.is_none() {
            let (scene, settings) = (&mut self.picture.scene_input, &self.picture.settings);
            self.prepared = Some(scene.prepare_render(settings, &self.args.tree, films)?);
        }
        Ok(())
    }

    /// Counts a frame whose file is at `path`.
    fn count(&mut self, path: &Path) {
        let counted = self.done.frames.unwrap_or(0);
        if counted == 0 {
            self.done.path = path.into();
        }
        self.done.frames = Some(counted + 1);
        self.done.last_path = Some(path.into());
    }
}

/// Returns true if a picture exists as the shard wrote it. Warns of one that has changed.
fn is_finished(state: std::io::Result<FrameState>, picture: &Path) -> Result<bool, CliError> {
    let name = shown_path(picture);
    match state.map_err(|e| CliError::cannot_read(&name, e))? {
        FrameState::Finished => return Ok(true),
        FrameState::Absent => {}
        FrameState::Unlisted => output::note(&format!(
            "{name} is not listed as a frame of this plan: rendering it again"
        )),
        FrameState::Changed => output::warning(&format!(
            "{name} has changed since it was written: rendering it again"
        )),
    }
    Ok(false)
}

impl Output for ShardDocument {
    fn table(&self) -> String {
        let before = match self.kept {
            0 => String::new(),
            count => format!(", {} of them earlier", grouped(count as u64)),
        };
        let count = grouped(self.tiles.or(self.frames).unwrap_or(0) as u64);
        let parts = match self.shard_by {
            None => format!("{count} tiles{before}"),
            Some(ShardBy::Tile) => format!("its tiles of {count} frames{before}"),
            Some(ShardBy::Frame) => format!("{count} frames{before}"),
        };
        let shard = format!("{} of {}: {parts}", self.shard, self.shards);
        let (rays, speed, seconds) = (grouped(self.rays), self.mrays_per_s, self.seconds);
        let rays = format!("{rays}, {speed:.3} Mrays/s, {seconds:.3} seconds");
        let mut path = shown_path(&self.path);
        if let Some(last) = self.last_path.as_ref().filter(|last| **last != self.path) {
            path.push_str(&format!(" to {}", shown_path(last)));
        }
        lines(&[("shard", shard), ("rays", rays), ("written", path)])
    }
}
