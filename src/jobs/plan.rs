//! A plan for rendering a picture or a sequence on several machines: the assignment of tiles and
//! frames, written down once for all of them.

use super::field_error::FieldError;
use super::output_path;
use super::render_key::{RenderKey, SceneStamp};
use super::sequence_plan::SequencePlan;
use super::spec::{OptionRow, PictureSpec};
use phalanx_files::{quoted_text, shown_path, shown_text};
use phalanx_image::PictureHeader;
use phalanx_render::frame::Tile;
use phalanx_scene::ViewError;
use phalanx_scene::film::tiles;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Version of the layout of plans. Version 1 had its settings as one text, and an output of any
/// name; versions 2 and 3, of pictures and of sequences, had the arguments of a command line. In
/// version 4, default lights stayed where the first frame had them.
const SCHEMA_VERSION: u32 = 5;

/// Longest plan that is read: several times the longest command line that systems take.
const MAX_BYTES: u64 = 16 << 20;

/// Most shards of a plan: at least as many as the tasks that schedulers take in one array.
pub const MAX_SHARDS: u32 = 100_000;

/// Default side of the tiles that are dealt out, in pixels, where the picture is large enough.
const DEFAULT_TILE_SIDE: u32 = 64;

/// Least number of tiles a shard: that many even out the hard tiles among them.
const MIN_TILES_PER_SHARD: u64 = 16;

/// A plan: what is rendered, into how many shards it is cut, and where the picture goes.
///
/// The tiles of the window are cells of a grid of [`RenderPlan::tile`] pixels. They are dealt out
/// like cards, in the order of [`tiles`]: tile k belongs to shard k modulo [`RenderPlan::shards`].
/// So every shard has some of the easy tiles and some of the hard ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderPlan {
    schema_version: u32,
    /// The picture, all of whose options are given.
    pub spec: PictureSpec,
    /// The scene that is meant.
    pub stamp: SceneStamp,
    /// How shards are rendered.
    pub work: PlannedWork,
    /// Path of the output picture, relative to the plan's folder; see [`RenderPlan::picture_path`].
    pub output: PathBuf,
    /// Number of shards.
    pub shards: u32,
    /// Side in pixels of the tiles that are dealt out.
    pub tile: u32,
    /// Header of the output picture's file.
    pub header: PictureHeader,
    /// The frames of a sequence; `None` for one picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sequence: Option<SequencePlan>,
}

/// Options for the rendering of shards, which no picture depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedWork {
    /// Side in pixels of the tiles that a thread renders at a time; `None` for the default.
    pub tile: Option<u32>,
    /// Memory in bytes that may be used; `None` for no limit.
    pub max_memory: Option<u64>,
}

/// The reason why a plan cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", shown_path(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is no plan.
    #[error("{}: not a plan: {reason}", shown_path(path))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Description of the mistake.
        reason: String,
    },
    /// A program with another layout made the file.
    #[error(
        "{}: made by another version of phalanx: its layout has version {found}, this program reads version {SCHEMA_VERSION}",
        shown_path(path)
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Version of the file's layout.
        found: u64,
    },
    /// A field holds a value that it may not have.
    #[error("{}: {error}", shown_path(path))]
    Field {
        /// The file.
        path: PathBuf,
        /// The field, and the values that it may have.
        error: FieldError,
    },
    /// The picture would go where a plan may not send it.
    #[error(
        "{}: the plan's picture {} {reason}",
        shown_path(path),
        shown_path(output)
    )]
    Output {
        /// The file.
        path: PathBuf,
        /// The picture, as the plan names it.
        output: PathBuf,
        /// The reason why it may not go there.
        reason: &'static str,
    },
    /// A file beside the plan is none that a plan reads or writes.
    #[error("{} {reason}", shown_path(path))]
    Stray {
        /// The file.
        path: PathBuf,
        /// The reason why it may not be used.
        reason: &'static str,
    },
    /// A frame has no view.
    #[error("frame {frame}: {error}")]
    Frame {
        /// Number of the frame.
        frame: u32,
        /// The reason why it has none.
        error: ViewError,
    },
    /// The plan has no such shard.
    #[error("there is no shard {shard}: the plan has {shards}, from 0 to {}", shards - 1)]
    NoShard {
        /// The requested number.
        shard: u32,
        /// The number of shards.
        shards: u32,
    },
}

impl RenderPlan {
    /// A plan of a picture with this key in the given number of shards.
    pub fn new(spec: PictureSpec, key: RenderKey, output: PathBuf, shards: u32) -> RenderPlan {
        RenderPlan {
            schema_version: SCHEMA_VERSION,
            tile: side(key.pixels.window(), shards),
            spec: PictureSpec {
                pixels: key.pixels,
                ..spec
            },
            stamp: key.stamp,
            work: PlannedWork::default(),
            output,
            shards,
            header: PictureHeader::NONE,
            sequence: None,
        }
    }

    /// The key of the picture; of a sequence, the key that frames add their views to.
    pub fn key(&self) -> RenderKey {
        RenderKey {
            stamp: self.stamp.clone(),
            pixels: self.spec.pixels.clone(),
            view: None,
        }
    }

    /// The part of the picture that is rendered.
    pub fn window(&self) -> Tile {
        self.spec.pixels.window()
    }

    /// Reads a plan, which may come from anybody.
    ///
    /// # Errors
    /// [`PlanError`]: a plan of another version of this layout is refused.
    pub fn read(path: &Path) -> Result<RenderPlan, PlanError> {
        let io = |source| PlanError::Io {
            path: path.into(),
            source,
        };
        let malformed = |reason: &str| PlanError::Malformed {
            path: path.into(),
            reason: shown_text(reason),
        };
        let mut bytes = Vec::new();
        let file = File::open(path).map_err(io)?;
        let read = file.take(MAX_BYTES + 1).read_to_end(&mut bytes);
        if read.map_err(io)? as u64 > MAX_BYTES {
            return Err(malformed(&format!(
                "it is longer than any plan can be ({MAX_BYTES} bytes)"
            )));
        }
        let version: Version =
            serde_json::from_slice(&bytes).map_err(|error| malformed(&error.to_string()))?;
        let number = version.schema_version;
        if number != u64::from(SCHEMA_VERSION) {
            let path = path.into();
            return Err(PlanError::Version {
                path,
                found: number,
            });
        }
        let mut json = serde_json::Deserializer::from_slice(&bytes);
        // With the name of the field.
        let plan: RenderPlan = serde_path_to_error::deserialize(&mut json)
            .map_err(|error| malformed(&error.to_string()))?;
        let options = plan.spec.overrides.options();
        options.map_err(|reason| malformed(&reason))?;
        let checked = plan.check().map(|()| plan);
        let path = path.into();
        checked.map_err(|error| PlanError::Field { path, error })
    }

    /// Checks every field that is not free to hold anything.
    ///
    /// # Errors
    /// The first field that holds a value that it may not have.
    pub fn check(&self) -> Result<(), FieldError> {
        let wrong = |field: &str, value: String, expected: &str| {
            Err(FieldError::new(field, value, expected))
        };
        self.key().check()?;
        self.spec.encoding.check()?;
        let output = self.output.to_str().unwrap_or("\0").to_owned();
        let keyframes = self.sequence.as_ref().and_then(SequencePlan::keyframes);
        let keyframes = keyframes.unwrap_or("none").to_owned();
        let named = [
            ("output", output),
            ("header.scene", self.header.scene.clone()),
            ("header.command", self.header.command.clone()),
            ("sequence.camera.keyframes", keyframes),
            ("scene", self.spec.scene.clone()),
            (
                "format",
                self.spec.format.clone().unwrap_or("none".to_owned()),
            ),
        ];
        let options = self.spec.overrides.rows();
        let options = options.iter().flat_map(OptionRow::texts);
        for (field, text) in named.into_iter().chain(options) {
            // Plans are quoted in scripts and messages.
            let may_be_empty = field.starts_with("header.");
            if text.contains(char::is_control) || text.is_empty() && !may_be_empty {
                let value = quoted_text(&text);
                return wrong(field, value, "a text without control characters");
            }
        }
        if !(1..=MAX_SHARDS).contains(&self.shards) {
            let range = format!("1 to {MAX_SHARDS}");
            return wrong("shards", self.shards.to_string(), &range);
        }
        if let Some(sequence) = &self.sequence {
            sequence.check(self.shards)?;
        }
        // No more tiles than this program would have dealt out: smaller tiles could be more than
        // memory has room for.
        let side = side(self.window(), self.shards);
        if self.tile != side {
            let shards = self.shards;
            let picture = format!("{side} for a picture of this size in {shards} shards");
            return wrong("tile", self.tile.to_string(), &picture);
        }
        Ok(())
    }

    /// All tiles, in the order in which they are dealt out.
    pub fn tiles(&self) -> Vec<Tile> {
        tiles(self.window(), self.tile)
    }

    /// The tiles of a shard, chosen from all of them.
    pub fn share_of<'a>(&self, tiles: &'a [Tile], shard: u32) -> impl Iterator<Item = Tile> + 'a {
        let from = tiles.get(shard as usize..).unwrap_or_default();
        from.iter().step_by(self.shards.max(1) as usize).copied()
    }

    /// The tiles of a shard.
    ///
    /// # Errors
    /// [`PlanError::NoShard`].
    pub fn share(&self, shard: u32) -> Result<Vec<Tile>, PlanError> {
        self.check_shard(shard)?;
        Ok(self.share_of(&self.tiles(), shard).collect())
    }

    /// The path of the picture, for a plan in the file `plan`.
    ///
    /// # Errors
    /// [`PlanError::Output`] where it does not lie in the folder of that file, links followed. A
    /// plan may come from anybody, and must not choose which files are replaced. The user who
    /// merges it may name any path instead.
    pub fn picture_path(&self, plan: &Path) -> Result<PathBuf, PlanError> {
        RenderPlan::path_in_folder(plan, &self.output)
    }

    /// The path of a picture `output` of a plan in the file `plan`.
    pub(super) fn path_in_folder(plan: &Path, output: &Path) -> Result<PathBuf, PlanError> {
        output_path::allowed(plan, output).map_err(|reason| PlanError::Output {
            path: plan.into(),
            output: output.into(),
            reason,
        })
    }

    /// A file of a shard, beside the plan, whose name ends so.
    pub(super) fn shard_path(
        &self,
        plan: &Path,
        shard: u32,
        ending: &str,
    ) -> Result<PathBuf, PlanError> {
        let digits = (self.shards - 1).to_string().len();
        RenderPlan::file_beside(plan, &format!("shard-{shard:0digits$}.{ending}"))
    }

    /// The file that has the name of `plan` with this ending, beside it.
    ///
    /// # Errors
    /// [`PlanError::Stray`] where that is a link out of the folder, or no regular file.
    pub fn file_beside(plan: &Path, ending: &str) -> Result<PathBuf, PlanError> {
        let mut name = plan.file_stem().unwrap_or(plan.as_os_str()).to_os_string();
        name.push(format!(".{ending}"));
        output_path::allowed(plan, name.as_ref()).map_err(|reason| PlanError::Stray {
            path: plan.with_file_name(name),
            reason,
        })
    }

    /// Refuses a shard that the plan does not have.
    ///
    /// # Errors
    /// [`PlanError::NoShard`].
    pub fn check_shard(&self, shard: u32) -> Result<(), PlanError> {
        let shards = self.shards;
        if shard < shards { Ok(()) } else { Err(PlanError::NoShard { shard, shards }) }
    }
}

/// The version alone, of a plan whose other fields may have any names.
#[derive(Deserialize)]
struct Version {
    schema_version: u64,
}

/// Side of the tiles that a window is dealt out in.
fn side(window: Tile, shards: u32) -> u32 {
    let enough = |side: u32| {
        let Tile { width, height, .. } = window;
        let cells = u64::from(width.div_ceil(side)) * u64::from(height.div_ceil(side));
        cells >= MIN_TILES_PER_SHARD * u64::from(shards)
    };
    let sides = [1, 2, 4].map(|part| DEFAULT_TILE_SIDE / part);
    sides.into_iter().find(|&side| enough(side)).unwrap_or(8)
}

#[cfg(test)]
mod sequence_tests;
#[cfg(test)]
mod tests;
