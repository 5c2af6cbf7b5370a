//! The `.test` format: one command per line, a matrix stack as in OpenGL, and state that each
//! primitive and light captures as it is declared.
//!
//! [`read`] walks the statements of `lexer`, each of which runs its row of `commands::COMMANDS` on
//! a `TestReader`. A faulty statement leaves a diagnostic. It keeps enough of its effect that
//! later statements are not reported because of it.

mod commands;
mod geometry;
mod lexer;
mod lights;
mod reader;
mod settings;
mod state;
mod transform;

pub(super) use reader::read;
pub use settings::is_bare_name;
