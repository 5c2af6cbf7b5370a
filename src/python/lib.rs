//! The Python module `phalanx`: a scene, and rays through it.
//!
//! ```text
//!  numpy arrays ── arrays ──> rays in rows ── scene ──> columns of hits ── hits ──> numpy arrays
//! ```
//!
//! Everything visible to Python is documented for Python users: shapes, units, errors. Each query
//! releases the interpreter's lock while it traces.
#![allow(
    rustdoc::broken_intra_doc_links,
    reason = "comments are docstrings of Python, where brackets are indices"
)]

mod arrays;
mod bench;
mod coordinates;
mod environment;
mod errors;
mod hits;
mod interrupt;
mod pictures;
mod queries;
mod rays;
mod scene;

use pyo3::prelude::*;

/// The instruction set that this module was built for, such as 'x86-64-v3'
/// or 'aarch64'.
///
/// The wheel contains a build for each of three levels of x86-64. Importing
/// it loads the highest that this CPU supports, or the one named by the
/// environment variable PHALANX_LEVEL. Answers are the same bits in all.
#[pyfunction]
fn isa() -> &'static str {
    phalanx::isa::compiled_level()
}

/// The highest level that this CPU supports, such as 'x86-64-v4'.
#[pyfunction]
fn cpu_level() -> &'static str {
    phalanx::isa::cpu_level()
}

#[pymodule]
fn _phalanx(module: &Bound<'_, PyModule>) -> PyResult<()> {
    errors::refuse_lesser_cpu()?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(isa, module)?)?;
    module.add_function(wrap_pyfunction!(cpu_level, module)?)?;
    module.add_class::<scene::PyScene>()?;
    module.add_class::<hits::PyHits>()?;
    module.add_class::<hits::PyAllHits>()
}
