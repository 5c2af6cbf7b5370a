//! Memory that is asked for: how much a tile takes, and how much a hostile file can make a reader
//! ask for. A test binary of its own, because it replaces the allocator.

mod allocator;
#[path = "../common/mod.rs"]
mod common;

mod fuzz_jobs;
mod fuzz_readers;
mod mutate;
mod steady;
