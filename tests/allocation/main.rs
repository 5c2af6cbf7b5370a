//! Memory requests: how much a tile takes, and how much a hostile file can make a reader request. A
//! separate test binary, because it replaces the allocator.

mod allocator;
#[path = "../common/mod.rs"]
mod common;

mod fuzz_jobs;
mod fuzz_readers;
mod mutate;
mod steady;
