//! The rooms of the project that traversal needs, compiled by themselves: the rest takes four times as long.

#![allow(dead_code, reason = "rooms that are not here use the rest")]

#[path = "../../../src/bvh/mod.rs"]
pub mod bvh;
#[path = "../../../src/cache/mod.rs"]
pub mod cache;
#[path = "../../../src/isa.rs"]
pub mod isa;
#[path = "../../../src/lanes/mod.rs"]
pub mod lanes;
#[path = "../../../src/packet/mod.rs"]
pub mod packet;
#[path = "../../../src/scene/mod.rs"]
pub mod scene;
#[path = "../../../src/trace/mod.rs"]
pub mod trace;
