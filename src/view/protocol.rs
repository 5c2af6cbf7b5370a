//! Requests and answers as JSON. Positions are in the file's coordinates, in units of the file.

use phalanx::frame::MAX_SPP;
use phalanx::image::{MAX_EXPOSURE, ToneCurve};
use phalanx::jobs::spec::AsText;
use phalanx::scene::FileView;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Most pixels of a picture: about those of a screen of 2560 by 1600.
pub const MAX_PIXELS: u64 = 1 << 22;

/// Longest side of a picture.
const MAX_SIDE: u32 = 1 << 14;

/// Quantities that a picture may show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ViewMode {
    Shaded,
    Ao,
    Normals,
    Depth,
    Albedo,
    #[serde(rename = "primitives")]
    PrimIds,
    #[serde(rename = "materials")]
    MaterialIds,
    Cost,
}

/// A picture, except for its samples.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub(super) struct Shot {
    pub(super) view: FileView,
    pub(super) size: (u32, u32),
    #[serde(default = "shaded")]
    pub(super) mode: ViewMode,
    /// Exposure in stops, and tone curve; `None` for those that the options give.
    pub(super) exposure: Option<f32>,
    pub(super) tone: Option<AsText<ToneCurve>>,
}

fn shaded() -> ViewMode {
    ViewMode::Shaded
}

/// The page that asks.
#[derive(Deserialize)]
pub(super) struct Asking {
    pub(super) page: String,
}

/// The next frame.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct FrameRequest {
    #[serde(flatten)]
    pub(super) shot: Shot,
    pub(super) moving: bool,
    /// Most pixels while the camera moves.
    pub(super) pixels: u64,
    /// Samples that the page shows, and those that it wants at most.
    pub(super) have: u32,
    pub(super) samples: u32,
    /// True for a JPEG instead of red, green, blue and 255, a byte each.
    pub(super) jpeg: bool,
}

/// A frame's account of itself.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct FrameInfo {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) samples: u32,
    pub(super) moving: bool,
    /// Bounces that were traced.
    pub(super) max_depth: u32,
    /// Wall time of the work, and the parts of tracing and of all else, a thread.
    pub(super) ms: f64,
    pub(super) trace_ms: f64,
    pub(super) shade_ms: f64,
    pub(super) encode_ms: f64,
    pub(super) rays: Value,
    pub(super) kernel: &'static str,
    /// Value of the lightest colour of a map.
    pub(super) scale: Option<f32>,
}

/// A pixel of a picture.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct PixelRequest {
    #[serde(flatten)]
    pub(super) shot: Shot,
    pub(super) x: u32,
    pub(super) y: u32,
    /// True if the bounds of what is hit are wanted.
    #[serde(default)]
    pub(super) bounds: bool,
}

/// A picture to keep, or its command.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct KeepRequest {
    #[serde(flatten)]
    pub(super) shot: Shot,
    pub(super) samples: u32,
    /// True for the command of a sequence instead.
    #[serde(default)]
    pub(super) keyframes: bool,
}

impl Shot {
    /// Returns true if both have the same film: exposure and tone come after it.
    pub(super) fn has_film_of(&self, other: &Shot) -> bool {
        (self.view, self.size, self.mode) == (other.view, other.size, other.mode)
    }

    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.size.0) * u64::from(self.size.1)
    }

    /// Refuses a picture that cannot be rendered with this many samples.
    pub(super) fn check(&self, samples: u32) -> Result<(), String> {
        let ((width, height), pixels) = (self.size, self.pixels());
        if pixels == 0 || pixels > MAX_PIXELS || width.max(height) > MAX_SIDE {
            return Err(format!(
                "a picture has 1 to {MAX_PIXELS} pixels, not {pixels}"
            ));
        }
        if !(1..=MAX_SPP).contains(&samples) {
            return Err(format!("a picture has 1 to {MAX_SPP} samples a pixel"));
        }
        if self.exposure.unwrap_or(0.0).abs() > MAX_EXPOSURE {
            let range = format!("an exposure has -{MAX_EXPOSURE} to {MAX_EXPOSURE} stops");
            return Err(range);
        }
        let checked = self.view.check();
        checked.map_err(|error| error.to_string())
    }
}
