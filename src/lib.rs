//! phalanx: a data-oriented SIMD packet ray tracer built for throughput, and the scalar tracer that
//! proves it.
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
//! use phalanx::frame::{Accel, Control, Engine, Settings, render};
//!
//! let text = "size 64 48\ncamera 0 0 4 0 0 0 0 1 0 45\n\
//!             point 4 4 4 1 1 1\ndiffuse 1 0.5 0\nsphere 0 0 0 1\n";
//! let scene = phalanx::formats::read_test(text).expect("a scene").scene;
//! let frame_of = |engine| {
//!     let settings = Settings { engine, ..Settings::of(&scene) };
//!     let accel = Accel::build(&scene, engine);
//!     render(&scene, &accel, &settings, &Control::default()).expect("nobody interrupts")
//! };
//! let (packets, oracle) = (frame_of(Engine::Simd), frame_of(Engine::Scalar));
//! assert_eq!(packets.film, oracle.film);
//! assert_eq!(packets.stats.rays.primary, 64 * 48);
//! ```
//!
//! The modules below are in the order in which data flows.

// The scene, and the arithmetic that both tracers share as a definition.
pub use phalanx_scene as scene;
pub use phalanx_scene::{GeomId, GeometryError, NO_GEOM, Scene};
pub use phalanx_scene::{camera, sampling};

// Traversal and intersection.
pub use phalanx_trace as trace;
pub use phalanx_trace::bvh::{Bvh, Quality};
pub use phalanx_trace::query::{
    BatchError, Hit, HitBuffer, HitColumns, Ray, RayBuffer, RayColumns, TMax,
};
pub use phalanx_trace::{bvh, isa, packet, simd as lanes};

// The second, plainer tracer.
pub use phalanx_oracle as oracle;

// Scenes and pictures as files.
#[cfg(feature = "render")]
pub use phalanx_io::{cache, formats, image, open, standard};

// Tiles, one frame by either tracer, and large frames band by band.
#[cfg(feature = "render")]
pub use phalanx_render as render;
#[cfg(feature = "render")]
pub use phalanx_render::{frame, jobs, shade};

// Benchmarks: speed, peers, and the record of both.
#[cfg(feature = "bench")]
pub use phalanx_bench as bench;
#[cfg(feature = "bench")]
pub use phalanx_bench::{peers, report};
