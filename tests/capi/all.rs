//! The library for C, called as C calls it: `cargo test --release -p phalanx-capi`. Not `main.rs`,
//! which Cargo would take for a test of the package `phalanx`.
#![allow(unsafe_code, reason = "the interface is C's")]

#[path = "../common/full_or.rs"]
mod full_or;
mod misuse;
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../common/rng.rs"]
mod rng;
mod same_bits;
mod world;
