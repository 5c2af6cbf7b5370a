//! The commands, one file or folder each, with the arguments that it alone has.

pub mod bench;
pub mod build;
pub mod compare;
pub mod generate;
pub mod info;
pub mod manual;
pub mod merge;
pub mod plan;
pub mod render;
pub mod scenes;
pub mod submit;
pub mod verify;
#[cfg(feature = "view")]
pub mod view;
