//! The command that joins the frames of a sequence into a video.

use phalanx::jobs::{VIDEO_RATE, video_command};
use std::path::Path;

/// Rows of a table for these frames of a size, whose names come from `pattern`; none for a single
/// frame. Samples are linear light if `is_linear`.
pub fn video_rows(
    pattern: &Path,
    frames: [u32; 2],
    size: (u32, u32),
    is_linear: bool,
) -> Vec<(&'static str, String)> {
    match video_command(pattern, frames, size, is_linear) {
        Some(command) if frames[0] < frames[1] => {
            let rate = format!("{VIDEO_RATE} frames per second is a guess: change -framerate");
            vec![("video", command), ("rate", rate)]
        }
        _ => Vec::new(),
    }
}
