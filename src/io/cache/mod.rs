//! The scene cache: columns and tree in one file, in their memory layout.
//!
//! [`write()`] stores all columns of a [`Scene`](phalanx_scene::Scene) and all arrays of its
//! [`Bvh`](phalanx_trace::bvh::Bvh). [`open`] maps the file and returns both without copying a row.
//! In between the file may have been damaged, cut off, made by another build or by an attacker. So
//! every byte is covered by a checksum, and every index that tracing relies on is checked, on all
//! threads, before [`open`] returns. Therefore a scene returned by [`open`] can be traced safely,
//! and tracing terminates, regardless of the file. Only files written by this program are certain
//! to give the picture of their original scene.
//!
//! The file must not change while it is mapped: see `mapping`, the only file here with `unsafe`.
//! The format is described in `header`. It belongs to one version of this program: caches are
//! rebuilt, never converted.

mod error;
mod file_type;
mod header;
#[allow(
    unsafe_code,
    reason = "bytes of a mapped file become rows of columns; each block says why they may"
)]
mod mapping;
mod read;
mod settings;
mod write;

pub use error::{CacheError, CacheFault};
pub use file_type::ENDING;
pub use read::{Cached, open, open_bytes};
pub use write::{CacheWriteError, fingerprint, write};
