//! Options shared by several commands, and the scene that they open.

mod auto_exposure;
mod budget;
#[allow(unsafe_code, reason = "a signal handler has no safe name")]
mod bus_error;
mod deferred;
mod format_args;
mod frames;
#[allow(unsafe_code, reason = "the allocator's settings have no safe name")]
mod heap;
mod other_names;
mod parsers;
mod picture_output;
mod scene_args;
mod scene_input;
mod tolerance;
mod work_args;

pub use auto_exposure::{exposure_row, resolve_exposure};
pub use budget::film_bytes;
pub use deferred::Deferred;
pub use format_args::ending_of;
pub use frames::{FrameArgs, Sequence, read_keys};
pub use other_names::suggest;
pub use parsers::name_parser;
pub use phalanx::jobs::spec::headings::{LONG_RENDERS, MACHINE, OUTPUT};
pub use phalanx::jobs::spec::{parse_number, parse_size};
pub use picture_output::picture_file;
pub use scene_args::{SceneArgs, WantedPicture};
pub use scene_input::{SceneInput, stem};
pub use tolerance::{MaxDiffering, parse_max_differing, parse_tolerance};
pub use work_args::{KernelSet, TileArgs, TreeArgs, WorkArgs, kernels_parser, parse_thread_count};
