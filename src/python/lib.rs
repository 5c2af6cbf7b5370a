//! The Python module `phalanx`: a scene, and rays through it.
//!
//! ```text
//!  numpy arrays ── arrays ──> rays in rows ── scene ──> columns of hits ── hits ──> numpy arrays
//! ```
//!
//! What Python sees is documented for Python: shapes, units, errors. Each query lets go of the
//! interpreter's lock while it traces.

mod arrays;
mod bench;
mod coordinates;
mod errors;
mod hits;
mod interrupt;
mod pictures;
mod queries;
mod rays;
mod scene;

use pyo3::prelude::*;

/// The instruction set that this module was built for: 'x86-64-v3', or
/// 'aarch64'.
///
/// The wheel holds a build for each of three levels of x86-64. Importing it
/// takes the highest that this CPU has, or the one that the environment's
/// variable PHALANX_LEVEL names. Answers are the same bits in all of them.
#[pyfunction]
fn isa() -> &'static str {
    phalanx::isa::compiled_level()
}

/// The highest level that this CPU has, as 'x86-64-v4'.
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
