//! The frames of a plan: their views, keys, shards and files.

use super::finished_frames::FrameIdentity;
use super::frame_name::{frame_digits, frame_name};
use super::plan::{PlanError, RenderPlan};
use super::render_key::RenderKey;
use super::sequence_plan::{PlannedCamera, SequencePlan, ShardBy};
use phalanx_scene::{CameraPath, View};
use std::path::{Path, PathBuf};

/// The frames of a plan for a sequence.
#[derive(Clone, Debug)]
pub struct PlannedFrames<'a> {
    plan: &'a RenderPlan,
    sequence: &'a SequencePlan,
    path: CameraPath,
}

impl<'a> PlannedFrames<'a> {
    /// The frames of a plan; `None` where it is for one picture.
    pub fn of(plan: &'a RenderPlan) -> Option<PlannedFrames<'a>> {
        let sequence = plan.sequence.as_ref()?;
        Some(PlannedFrames {
            plan,
            sequence,
            path: sequence.camera.path(),
        })
    }

    /// The plan that they are of.
    pub fn plan(&self) -> &'a RenderPlan {
        self.plan
    }

    /// The sequence.
    pub fn sequence(&self) -> &'a SequencePlan {
        self.sequence
    }

    /// Returns true if a shard has whole frames.
    pub fn is_by_frame(&self) -> bool {
        self.sequence.shard_by == ShardBy::Frame
    }

    /// All frames, in order.
    pub fn all(&self) -> impl Iterator<Item = u32> + use<> {
        let [first, last] = self.sequence.frames;
        first..=last
    }

    /// The frames of a shard, in order: some of them, or all where a shard has tiles of each.
    pub fn of_shard(&self, shard: u32) -> impl Iterator<Item = u32> + use<> {
        let [first, last] = self.sequence.frames;
        let (skipped, step) = match self.sequence.shard_by {
            ShardBy::Frame => (shard, self.plan.shards.max(1)),
            ShardBy::Tile => (0, 1),
        };
        (first.saturating_add(skipped)..=last).step_by(step as usize)
    }

    /// The shard of a whole frame.
    pub fn shard_of(&self, frame: u32) -> u32 {
        (frame - self.sequence.frames[0]) % self.plan.shards.max(1)
    }

    /// The view of a frame.
    ///
    /// # Errors
    /// [`PlanError::Frame`]: a path may lead through a point that it looks at.
    pub fn view(&self, frame: u32) -> Result<View, PlanError> {
        let view = self.path.view(frame, &self.sequence.scene_view());
        match view.basis() {
            Ok(_) => Ok(view),
            Err(error) => Err(PlanError::Frame { frame, error }),
        }
    }

    /// The key of a frame's picture.
    ///
    /// # Errors
    /// [`PlanError::Frame`].
    pub fn key(&self, frame: u32) -> Result<RenderKey, PlanError> {
        Ok(self.plan.picture.with_view(self.view(frame)?))
    }

    /// The identity of a frame's file, which depends on its pixels, their encoding and its format.
    ///
    /// # Errors
    /// [`PlanError::Frame`].
    pub fn identity(&self, frame: u32) -> Result<FrameIdentity, PlanError> {
        let key = self.key(frame)?;
        let ending = self.plan.output.extension().unwrap_or_default();
        let parts = (key, self.plan.developing, ending.to_string_lossy());
        let text = serde_json::to_string(&parts).unwrap_or_default();
        Ok(FrameIdentity {
            frame,
            checksum: crc32fast::hash(text.as_bytes()),
        })
    }

    /// The camera's path as a number that tells it from others, wherever it was read from.
    pub fn path_checksum(&self) -> String {
        let view = self.sequence.view;
        let text = match &self.sequence.camera {
            PlannedCamera::Turntable { frames } => serde_json::to_string(&(view, frames)),
            PlannedCamera::Keyframes { keys, .. } => serde_json::to_string(&(view, keys)),
        };
        format!(
            "{:08x}",
            crc32fast::hash(text.unwrap_or_default().as_bytes())
        )
    }

    /// The path of a frame's picture where the sequence goes to `output`.
    pub fn name(&self, output: &Path, frame: u32) -> PathBuf {
        frame_name(output, self.sequence.frames[1], frame)
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
        let number = frame_digits(self.sequence.frames[1], frame);
        let ending = format!("frame-{number}.tiles");
        self.plan.shard_path(plan, shard, &ending)
    }
}
