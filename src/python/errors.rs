//! The library's errors as Python's exceptions.

use phalanx::GeometryError;
use phalanx::frame::FrameError;
use phalanx::open::OpenError;
use pyo3::exceptions::{PyImportError, PyIndexError, PyKeyboardInterrupt, PyOSError, PyValueError};
use pyo3::prelude::*;
use std::fmt::Display;
use std::io;

/// An `ImportError` if this CPU lacks instructions that the build uses.
pub(crate) fn refuse_lesser_cpu() -> PyResult<()> {
    let lacking = |extension: &&phalanx::isa::Extension| extension.compiled && !extension.present;
    let extensions = phalanx::isa::extensions();
    match extensions.iter().find(lacking) {
        Some(extension) => Err(PyImportError::new_err(format!(
            "this build of phalanx is for {} and needs {}, which this CPU lacks",
            phalanx::isa::compiled_level(),
            extension.name
        ))),
        None => Ok(()),
    }
}

/// A `ValueError`.
pub(crate) fn value_error(why: impl Display) -> PyErr {
    PyValueError::new_err(why.to_string())
}

/// `IndexError` for an index beyond the vertices, the prototypes or the geometries, `ValueError`
/// for anything else.
pub(crate) fn geometry_error(error: GeometryError) -> PyErr {
    match error {
        GeometryError::IndexOutOfRange { .. }
        | GeometryError::NoPrototype(_)
        | GeometryError::NoGeometry { .. } => PyIndexError::new_err(error.to_string()),
        other => value_error(other),
    }
}

/// `OSError` with the file's name, if the error came from the system.
fn system_error(path: &str, error: &io::Error) -> Option<PyErr> {
    let code = error.raw_os_error()?;
    let (reason, path) = (error.to_string(), path.to_owned());
    Some(PyOSError::new_err((code, reason, path)))
}

/// `OSError` if the system could not write a file, `ValueError` for anything else.
pub(crate) fn write_error(path: &str, error: io::Error) -> PyErr {
    system_error(path, &error).unwrap_or_else(|| value_error(error))
}

/// `OSError` with the file's name for system errors, `ValueError` for errors in a file's contents.
pub(crate) fn open_error(path: &str, error: OpenError) -> PyErr {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(&error);
    let mut words = error.to_string();
    while let Some(inner) = cause {
        let system = inner
            .downcast_ref()
            .and_then(|error| system_error(path, error));
        if let Some(error) = system {
            return error;
        }
        cause = inner.source();
        if let Some(inner) = cause {
            let more = inner.to_string();
            if !words.contains(&more) {
                words = format!("{words}: {more}");
            }
        }
    }
    value_error(words)
}

/// `KeyboardInterrupt` if the user has interrupted the call.
pub(crate) fn frame_error(error: FrameError) -> PyErr {
    match error {
        FrameError::Interrupted(_) => PyKeyboardInterrupt::new_err(()),
        other => value_error(other),
    }
}
