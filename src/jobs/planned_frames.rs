//! The frames of a plan: their views, keys, shards and files.

use super::finished_frames::FrameIdentity;
use super::frame_name::{frame_digits, frame_name};
use super::plan::{PlanError, RenderPlan};
use super::render_key::RenderKey;
use super::sequence_plan::{PlannedCamera, SequencePlan, ShardBy};
use phalanx_scene::{CameraPath, View};
use std::path::{Path, PathBuf};

/// The frames of a plan: those of its sequence, or its one picture, as frame 0.
#[derive(Clone, Debug)]
pub struct PlannedFrames<'a> {
    /// The plan that they are of.
    pub plan: &'a RenderPlan,
    /// The sequence, if it is one.
    pub sequence: Option<&'a SequencePlan>,
    path: Option<CameraPath>,
    /// The first and the last.
    ends: [u32; 2],
}

impl<'a> PlannedFrames<'a> {
    /// The frames of a plan.
    pub fn of(plan: &'a RenderPlan) -> PlannedFrames<'a> {
        let sequence = plan.sequence.as_ref();
        PlannedFrames {
            plan,
            sequence,
            path: sequence.map(|sequence| sequence.camera.path()),
            ends: sequence.map_or([0; 2], |sequence| sequence.frames),
        }
    }

    /// Returns true if a shard has whole frames.
    pub fn is_by_frame(&self) -> bool {
        let shard_by = self.sequence.map(|sequence| sequence.shard_by);
        shard_by == Some(ShardBy::Frame)
    }

    /// All frames, in order.
    pub fn all(&self) -> impl Iterator<Item = u32> + use<> {
        let [first, last] = self.ends;
        first..=last
    }

    /// The frames of a shard, in order: some of them, or all where a shard has tiles of each.
    pub fn of_shard(&self, shard: u32) -> impl Iterator<Item = u32> + use<> {
        let [first, last] = self.ends;
        let (skipped, step) =
            if self.is_by_frame() { (shard, self.plan.shards.max(1)) } else { (0, 1) };
        (first.saturating_add(skipped)..=last).step_by(step as usize)
    }

    /// The view of a frame of a sequence; `None` for the scene's own.
    ///
    /// # Errors
    /// [`PlanError::Frame`]: a path may lead through a point that it looks at.
    pub fn view(&self, frame: u32) -> Result<Option<View>, PlanError> {
        let (Some(path), Some(sequence)) = (&self.path, self.sequence) else {
            return Ok(None);
        };
        let view = path.view(frame, &sequence.view);
        match view.basis() {
            Ok(_) => Ok(Some(view)),
            Err(error) => Err(PlanError::Frame { frame, error }),
        }
    }

    /// The key of a frame's picture.
    ///
    /// # Errors
    /// [`PlanError::Frame`].
    pub fn key(&self, frame: u32) -> Result<RenderKey, PlanError> {
        Ok(RenderKey {
            view: self.view(frame)?,
            ..self.plan.key()
        })
    }

    /// The identity of a frame's file, which depends on its pixels, their encoding and its format.
    ///
    /// # Errors
    /// [`PlanError::Frame`].
    pub fn identity(&self, frame: u32) -> Result<FrameIdentity, PlanError> {
        let key = self.key(frame)?;
        let ending = self.plan.output.extension().unwrap_or_default();
        let parts = (key, &self.plan.spec.encoding, ending.to_string_lossy());
        let text = serde_json::to_string(&parts).unwrap_or_default();
        Ok(FrameIdentity {
            frame,
            checksum: crc32fast::hash(text.as_bytes()),
        })
    }

    /// The camera's path as a number that tells it from others, wherever it was read from.
    pub fn path_checksum(&self) -> String {
        let text = self.sequence.map(|sequence| match &sequence.camera {
            PlannedCamera::Turntable { frames } => serde_json::to_string(&(sequence.view, frames)),
            PlannedCamera::Keyframes { keys, .. } => serde_json::to_string(&(sequence.view, keys)),
        });
        let text = text.and_then(Result::ok).unwrap_or_default();
        format!("{:08x}", crc32fast::hash(text.as_bytes()))
    }

    /// The path of a frame's picture where the plan's goes to `output`.
    pub fn name(&self, output: &Path, frame: u32) -> PathBuf {
        match self.sequence {
            Some(_) => frame_name(output, self.ends[1], frame),
            None => output.into(),
        }
    }

    /// The path of a frame's picture, for a plan in the file `plan`.
    ///
    /// # Errors
    /// [`PlanError::Output`], as for [`RenderPlan::picture_path`].
    pub fn picture_path(&self, plan: &Path, frame: u32) -> Result<PathBuf, PlanError> {
        RenderPlan::path_in_folder(plan, &self.name(&self.plan.output, frame))
    }

    /// The list of a shard's finished frames, beside the plan.
    ///
    /// # Errors
    /// [`PlanError::Stray`].
    pub fn list_file(&self, plan: &Path, shard: u32) -> Result<PathBuf, PlanError> {
        self.plan.shard_path(plan, shard, "frames")
    }

    /// The file of a frame's tiles, as far as a shard has rendered them, beside the plan.
    ///
    /// # Errors
    /// [`PlanError::Stray`].
    pub fn tile_file(&self, plan: &Path, shard: u32, frame: u32) -> Result<PathBuf, PlanError> {
        let ending = match self.sequence {
            Some(_) => format!("frame-{}.tiles", frame_digits(self.ends[1], frame)),
            None => "tiles".to_owned(),
        };
        self.plan.shard_path(plan, shard, &ending)
    }
}
