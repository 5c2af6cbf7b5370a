//! The library for C and C++. `include/phalanx.h` documents what it has; the names of functions and
//! of structures' fields are the same here.
//!
//! | file | contents |
//! |---|---|
//! | `status` | refusals and panics become statuses, and words of the thread |
//! | `table` | handles of objects |
//! | `rows`, `columns` | the caller's memory that is read, and that is written; checked |
//! | `scene`, `tree` | scenes and trees |
//! | `ray` | one ray a call |
//! | `batch`, `hits` | many, and what of their hits is written |
//! | `files` | scenes out of files |
#![allow(unsafe_code, reason = "C's pointers")]
#![allow(missing_docs, clippy::missing_safety_doc, reason = "the header has it")]

pub mod batch;
pub mod columns;
#[cfg(feature = "render")]
pub mod files;
pub mod hits;
pub mod ray;
pub mod rows;
pub mod scene;
pub mod status;
pub mod table;
pub mod tree;
