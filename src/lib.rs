//! phalanx: a data-oriented SIMD packet ray tracer built for throughput.
#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod formats;
pub mod frame;
pub mod image;
pub mod isa;
pub mod lanes;
pub mod render;
pub mod scene;
