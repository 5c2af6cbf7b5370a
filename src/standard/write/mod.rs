//! Standard scenes to files, streamed: no more than a few sections of a scene are in memory.

mod decimal;
mod file_format;
mod latched;
mod nff;
mod outcome;
mod ply;
mod test_file;

pub use file_format::{FileFormat, write};
pub use nff::NffWriter;
pub use outcome::{DroppedFeatures, SceneWriteError};
pub use ply::PlyWriter;
pub use test_file::TestWriter;
