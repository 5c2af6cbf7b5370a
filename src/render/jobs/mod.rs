//! Pictures that take long: in bands of rows, so that they need not fit into memory; kept tile by tile in a file, so that an
//! interrupted render goes on where it was; and on many machines, each of which keeps its share of the tiles.
//!
//! | file | what |
//! |---|---|
//! | `identity` | what the pixels of a picture depend on |
//! | `picture_settings` | those of the settings that they depend on |
//! | `tile_file` | finished tiles in a file, each with its checksum |
//! | `beginning` | the beginning of such a file |
//! | `record` | one of them, as bytes |
//! | `scan` | what is left of such a file |
//! | `coverage` | which pixels are finished |
//! | `bands` | a window of the picture, band by band |
//! | `overview` | a small picture of it while it is made |
//! | `plan` | who renders which tiles |
//! | `place` | where the picture of a plan may go |
//!
//! One kind of file serves both: a checkpoint is the tile file of a render on one machine, and the share of each of many machines is
//! a tile file, too. So a share that was interrupted goes on like any render, and merging is rendering with nothing left to do.
//!
//! Plans and tile files may come from others, and are data: every number that is read from one is held against the file's length
//! and the picture's size before memory or time is spent on it, and a plan cannot choose which files are written.

mod bands;
mod beginning;
mod coverage;
mod identity;
mod overview;
mod picture_settings;
mod place;
mod plan;
mod record;
mod scan;
mod tile_file;

pub use bands::{Banded, BandsError, Beside, bands, merge_bands, render_bands, render_tiles};
pub use identity::{Difference, FieldError, Identity};
pub use overview::Overview;
pub use picture_settings::PictureSettings;
pub use place::kept_output;
pub use plan::{Developing, MAX_SHARDS, Plan, PlanError};
pub use tile_file::{TileFile, TileFileError};
