//! Statements about a scene, its picture, its rays and its memory.
//!
//! | file | holds |
//! |---|---|
//! | `stats` | counts of primitives, nodes and rays |
//! | `render_summary` | a picture's settings |
//! | `empty_picture` | the likely reason why nothing can be seen |
//! | `file_coordinates` | origin and camera in the file's coordinates |
//! | `light_rows` | lights by power |
//! | `video` | the command that makes a video of frames |
//! | `memory_stats`, `process_status` | memory by part, and that of the process |
//! | `table` | labelled rows, and the numbers in them |

mod empty_picture;
mod file_coordinates;
mod light_rows;
mod memory_stats;
mod process_status;
mod render_summary;
mod stats;
mod table;
mod video;

pub use empty_picture::{EMPTY, EvenColor};
pub use file_coordinates::{CameraReport, origin_row};
pub use light_rows::LightRow;
pub use memory_stats::MemoryStats;
#[cfg(unix)]
pub use process_status::process_status;
pub use render_summary::{PictureWindow, RenderSummary};
pub use stats::{
    PrimitiveCounts, TreeFigures, mrays_per_s, rays_by_kind, serialize_rates, serialize_rays,
};
pub use table::{aligned, bytes, grouped, lines};
pub use video::video_rows;
