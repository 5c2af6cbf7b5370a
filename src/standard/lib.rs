//! Generators of the standard scenes, with which other tracers are measured, too. They need no
//! files.
//!
//! [`CATALOGUE`] lists them. A generator passes its scene to a [`SceneBuilder`], which decides
//! whether the result is a [`Scene`](phalanx_scene::Scene), a file or a table of counts. Every
//! number comes from + − × ÷ √ in f64 and the `libm` crate, so that a scene is the same, bit for
//! bit, on every platform.

mod builder;
mod catalogue;
mod count;
mod memory_builder;
mod mesh_slice;
mod modern;
mod spd;
mod spec;
mod tessellate;
mod write;

pub use builder::{
    DocumentMaterial, MaterialDesc, NffMaterial, SceneBuilder, StandardLight, StandardView,
};
pub use catalogue::{CATALOGUE, Family, Generator, StandardScene};
pub use count::{ShapeCounter, ShapeCounts};
pub use memory_builder::MemoryBuilder;
pub use mesh_slice::{MeshSlice, Prepare, PreparedMesh};
#[doc(inline)]
pub use phalanx_formats::nff_level;
pub use spec::{
    PREFIX, Spec, StandardError, counts, find, generate, parse_size, parse_spec, scene,
};
pub use tessellate::Tessellate;
pub use write::{
    DroppedFeatures, FileFormat, NffWriter, PlyWriter, SceneWriteError, TestWriter, write,
};
