//! Pictures that take long: in bands of rows, so that they need not fit into memory; kept tile by
//! tile in a file, so that an interrupted render goes on where it was; and on many machines, each
//! of which keeps its share of the tiles.
//!
//! | file | what |
//! |---|---|
//! | `render_key` | what the pixels of a picture depend on |
//! | `picture_settings` | those of the settings that they depend on |
//! | `tile_file` | finished tiles in a file, each with its checksum |
//! | `file_header` | the beginning of such a file |
//! | `tile_record` | one of them, as bytes |
//! | `recovery` | what is left of such a file |
//! | `coverage` | which pixels are finished |
//! | `bands` | a window of the picture, band by band |
//! | `thumbnail` | a small picture of it while it is made |
//! | `plan` | who renders which tiles |
//! | `output_path` | where the picture of a plan may go |
//!
//! One kind of file serves both: a checkpoint is the tile file of a render on one machine, and the
//! share of each of many machines is a tile file, too. So a share that was interrupted goes on like
//! any render, and merging is rendering with nothing left to do.
//!
//! Plans and tile files may come from others, and are data: every number that is read from one is
//! held against the file's length and the picture's size before memory or time is spent on it, and
//! a plan cannot choose which files are written.

mod bands;
mod coverage;
mod file_header;
mod output_path;
mod picture_settings;
mod plan;
mod recovery;
mod render_key;
mod thumbnail;
mod tile_file;
mod tile_record;

pub use bands::{
    BandStats, BandsError, TileOutputs, bands, merge_bands, render_bands, render_to_file,
};
pub use output_path::kept_output;
pub use picture_settings::PictureSettings;
pub use plan::{MAX_SHARDS, PlanError, RenderPlan, TileEncoding};
pub use render_key::{FieldError, KeyDifference, RenderKey};
pub use thumbnail::Thumbnail;
pub use tile_file::{TileFile, TileFileError};
