//! phalanx: a data-oriented SIMD packet ray tracer built for throughput, and the scalar tracer that proves it.
//!
//! ```text
//!  bytes ── formats ──> Scene ── bvh ──> Bvh
//!                         │               │
//!         camera: 8 rays ─┴─> trace <─────┘   a tile at a time, in one worker (render)
//!                    ^          │ hits
//!                    │        shade ──> radiance
//!                    └─ queues ─┘ shadow, mirror and refracted rays, compacted into packets again
//!
//!                       Film ── image ──> PNG, JPEG, OpenEXR, HDR, PFM
//!                         └── jobs ──> tiles kept, resumed, merged
//! ```
//!
//! [`frame::render`] is the front door. Both engines give the same bits:
//!
//! ```
//! use phalanx::frame::{Control, Engine, Prepared, Settings, render};
//!
//! let text = "size 64 48\ncamera 0 0 4 0 0 0 0 1 0 45\npoint 4 4 4 1 1 1\ndiffuse 1 0.5 0\nsphere 0 0 0 1\n";
//! let scene = phalanx::formats::read_test(text).expect("a scene").scene;
//! let frame_of = |engine| {
//!     let settings = Settings { engine, ..Settings::of(&scene) };
//!     let prepared = Prepared::build(&scene, engine);
//!     render(&scene, &prepared, &settings, &Control::default()).expect("nobody interrupts")
//! };
//! let (packets, oracle) = (frame_of(Engine::Simd), frame_of(Engine::Scalar));
//! assert_eq!(packets.film, oracle.film);
//! assert_eq!(packets.stats.rays.primary, 64 * 48);
//! ```
//!
//! The rooms below stand in the order in which data flows.
#![deny(unsafe_code)]
#![warn(missing_docs)]

// What there is to see.
pub mod scene;

// Bytes to a scene, or a scene without any.
pub mod formats;
pub mod standard;

// The tree over it.
pub mod bvh;

// Both in a file, as they lie in memory.
pub mod cache;

// Whatever it came from.
pub mod open;

// Numbers side by side, and the arithmetic both engines share as a definition.
pub mod lanes;
pub mod sampling;

// Rays, where they come from, and how they wait.
pub mod camera;
pub mod packet;

// What they hit, what that looks like, and the order of it all.
pub mod trace;

pub mod shade;

pub mod render;

// The second, plainer tracer.
pub mod oracle;

// One frame by either, and the picture of it.
pub mod frame;
pub mod image;

// Large ones: piece by piece, and on many machines.
pub mod jobs;

// How fast all that is, beside others, and the record of it.
pub mod peers;
pub mod report;

pub mod bench;

// What the build may ask of the CPU.
pub mod isa;
