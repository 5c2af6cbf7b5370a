//! phalanx: a data-oriented SIMD packet ray tracer built for throughput.
#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod bvh;
pub mod camera;
pub mod formats;
pub mod frame;
pub mod image;
pub mod isa;
pub mod lanes;
pub mod oracle;
pub mod packet;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod shade;
pub mod trace;
