//! NFF, Eric Haines' neutral file format: tokens, of which a record takes as many as it needs.
//!
//! [`read`] walks the records, each of which runs its row of `records::RECORDS` on a `NffReader`.
//! A faulty record leaves a diagnostic, and reading continues where the next record begins. Ambient
//! light and the intensity of lights depend on the number of lights, so both are computed at the
//! end of the file.

mod lexer;
mod materials;
mod reader;
mod records;
mod shapes;
mod view;

pub use reader::level;
pub(super) use reader::read;
