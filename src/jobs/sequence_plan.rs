//! The frames of a plan, and the camera's path through them.

use super::field_error::FieldError;
use super::frame_view::check_view;
use phalanx_scene::{CameraKey, CameraPath, View};
use serde::{Deserialize, Serialize};

/// Maximum number of a frame.
pub const MAX_FRAME: u32 = 10_000_000;

/// Maximum number of key frames: as many as fit into a plan of the maximum size.
pub const MAX_KEYFRAMES: usize = 20_000;

/// The sequence that a plan is for. It holds everything that the frames' views depend on, so that
/// no other file affects them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SequencePlan {
    /// The first and the last frame, both included.
    pub frames: [u32; 2],
    /// Meaning of a shard.
    pub shard_by: ShardBy,
    /// The scene's own view, which a turntable begins with.
    pub view: View,
    /// The camera's path.
    pub camera: PlannedCamera,
}

/// How a sequence is cut into shards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShardBy {
    /// Whole frames, dealt out to shards like cards: frame A + k belongs to shard k modulo the
    /// number of shards. A frame's cost changes slowly along a path, so that every shard gets cheap
    /// and costly ones: for 24 frames of an approach to a scene in 5 shards, the largest shard had
    /// 7 % more rays than the mean; with runs of consecutive frames, 37 %. Frames do not reuse
    /// anything of previous ones.
    Frame,
    /// The same tiles of each frame, for few frames that take long.
    Tile,
}

impl ShardBy {
    /// Names and values of both.
    pub const ALL: [(&'static str, ShardBy); 2] =
        [("frame", ShardBy::Frame), ("tile", ShardBy::Tile)];
}

/// A path of the camera, as plans store it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum PlannedCamera {
    /// A turntable.
    Turntable {
        /// Frames of a full turn.
        frames: u32,
    },
    /// Views at given frames.
    Keyframes {
        /// Absolute path of the file that they were read from.
        file: String,
        /// The views, in the order of their frames.
        keys: Vec<CameraKey>,
    },
}

impl PlannedCamera {
    /// A path, of which key frames were read from `file`.
    pub fn new(path: &CameraPath, file: String) -> PlannedCamera {
        match path {
            CameraPath::Turntable { frames } => PlannedCamera::Turntable { frames: *frames },
            CameraPath::Keys(keys) => PlannedCamera::Keyframes {
                file,
                keys: keys.clone(),
            },
        }
    }

    /// The path.
    pub fn path(&self) -> CameraPath {
        match self {
            PlannedCamera::Turntable { frames } => CameraPath::Turntable { frames: *frames },
            PlannedCamera::Keyframes { keys, .. } => CameraPath::Keys(keys.clone()),
        }
    }
}

impl SequencePlan {
    /// Number of frames.
    pub fn count(&self) -> u32 {
        let [first, last] = self.frames;
        last - first + 1
    }

    /// The file that key frames were read from, if there are any.
    pub fn keyframes(&self) -> Option<&str> {
        match &self.camera {
            PlannedCamera::Keyframes { file, .. } => Some(file),
            PlannedCamera::Turntable { .. } => None,
        }
    }

    /// Checks every field; the plan is for this number of shards.
    ///
    /// # Errors
    /// The first field with an invalid value.
    pub(super) fn check(&self, shards: u32) -> Result<(), FieldError> {
        let wrong = |field: &str, value: String, expected: String| {
            Err(FieldError::new(field, value, expected))
        };
        let [first, last] = self.frames;
        if first > last || last > MAX_FRAME {
            let expected = format!("two frames in order, of {MAX_FRAME} at most");
            return wrong("sequence.frames", format!("{first} {last}"), expected);
        }
        if self.shard_by == ShardBy::Frame && shards > self.count() {
            let count = self.count();
            let expected = format!("no more than the {count} frames, or shards by tile");
            return wrong("shards", shards.to_string(), expected);
        }
        let files = u64::from(self.count()) * u64::from(shards);
        if self.shard_by == ShardBy::Tile && files > u64::from(MAX_FRAME) {
            let value = format!("{shards} by tile of {} frames", self.count());
            let expected = format!("no more than {MAX_FRAME} files of tiles in all");
            return wrong("shards", value, expected);
        }
        check_view(&self.view, "sequence.view")?;
        let keys = match &self.camera {
            PlannedCamera::Turntable { frames: 0 } => {
                let expected = "a number of frames above 0".to_owned();
                return wrong("sequence.camera.turntable", "0".to_owned(), expected);
            }
            PlannedCamera::Turntable { .. } => return Ok(()),
            PlannedCamera::Keyframes { keys, .. } => keys,
        };
        let rise = keys.windows(2).all(|pair| pair[0].frame < pair[1].frame);
        if keys.is_empty() || keys.len() > MAX_KEYFRAMES || !rise {
            let value = format!("a list of {}", keys.len());
            let expected = format!("1 to {MAX_KEYFRAMES} views, of frames that rise");
            return wrong("sequence.camera.keyframes", value, expected);
        }
        let mut keys = keys.iter();
        keys.try_for_each(|key| check_view(&key.view, "sequence.camera.keyframes"))
    }
}
