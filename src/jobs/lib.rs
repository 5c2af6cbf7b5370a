//! Long renders. Pictures are rendered in bands of rows, so that they need not fit into memory, and
//! stored tile by tile in a file, so that an interrupted render resumes where it stopped. They can
//! be rendered on many machines, each of which stores its share of the tiles.
//!
//! | file | content |
//! |---|---|
//! | `render_key` | everything that the pixels of a picture depend on |
//! | `spec/` | the options of a picture, as the command line has them |
//! | `field_error` | fields of plans and keys that hold what they may not hold |
//! | `tile_file` | finished tiles in a file, each with its checksum |
//! | `file_header` | the header of such a file |
//! | `tile_record` | one tile of it, as bytes |
//! | `recovery` | reading such a file, damaged or not |
//! | `finished_pixels` | the set of finished pixels |
//! | `auto_exposure` | the exposure that suits a picture |
//! | `bands` | a window of the picture, band by band |
//! | `open_bands` | bands that workers fill while those above them are taken |
//! | `stored_tiles` | finished tiles on their way into the file and the thumbnail |
//! | `plan` | assignment of tiles to machines |
//! | `sequence_plan` | the frames of a plan, and the camera's path |
//! | `planned_frames` | their views, keys, shards and files |
//! | `finished_frames` | the list of a shard's finished frames |
//! | `frame_view`, `frame_name` | the check of a view, names of the files |
//! | `kept_file` | files that one process at a time adds to, and their errors |
//! | `kept_header` | whose work such a file holds |
//! | `output_path` | the paths that a plan's picture may have |
//!
//! One kind of file serves both purposes: the checkpoint of a render on one machine is a tile file,
//! and so is the share of each of many machines. So an interrupted share resumes like any render,
//! and merging is rendering with nothing left to do.
//!
//! A sequence is cut into whole frames or into the tiles of each. A shard of whole frames writes
//! pictures, and a list of them with a checksum of each; the current frame has a tile file until
//! its picture is written.
//!
//! Plans and tile files may come from others, and are treated as data. Every number that is read
//! from one is checked against the file's length and the picture's size before memory or time is
//! spent on it. A plan cannot choose which files are written.

mod auto_exposure;
mod bands;

mod field_error;
mod file_header;
mod finished_frames;
mod finished_pixels;
mod frame_name;
mod frame_view;
mod kept_file;
mod kept_header;
mod open_bands;
mod output_path;
mod plan;
mod planned_frames;
mod recovery;
mod render_key;
mod sequence_plan;
pub mod spec;
mod stored_tiles;
mod tile_file;
mod tile_record;

pub use auto_exposure::measure_exposure;
pub use bands::{BandStats, BandsError, bands, merge_bands, render_bands, render_to_file};
pub use field_error::FieldError;
pub use finished_frames::{FinishedFrames, FrameIdentity, FrameState};
pub use frame_name::{VIDEO_RATE, frame_name, video_command};
pub use kept_file::KeptFileError;
pub use open_bands::open_bands;
pub use output_path::kept_output;
pub use plan::{MAX_SHARDS, PlanError, PlannedWork, RenderPlan};
pub use planned_frames::PlannedFrames;
pub use render_key::{KeyDifference, RenderKey, SceneStamp};
pub use sequence_plan::{MAX_FRAME, MAX_KEYFRAMES, PlannedCamera, SequencePlan, ShardBy};
pub use spec::{EncodingSpec, ExposureSpec, PictureSpec, PixelSpec, SceneOverrides, ToneSpec};
pub use stored_tiles::TileOutputs;
pub use tile_file::TileFile;
