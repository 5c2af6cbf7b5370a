//! The library for C and C++. `include/phalanx.h` documents what it has; the names of functions and
//! of structures' fields are the same here.
//!
//! | file | contents |
//! |---|---|
//! | `status` | refusals and panics become statuses, and words of the thread |
//! | `table` | handles of objects |
//! | `rows` | the caller's memory, checked |
//! | `scene`, `tree` | scenes and trees |
//! | `ray`, `batch` | one ray a call, and many |
//! | `files` | scenes out of files |
#![allow(unsafe_code, reason = "C's pointers")]
#![allow(missing_docs, clippy::missing_safety_doc, reason = "the header has it")]

pub mod batch;
#[cfg(feature = "render")]
pub mod files;
pub mod ray;
pub mod rows;
pub mod scene;
pub mod status;
pub mod table;
pub mod tree;
