//! Errors of a benchmark: a wrong result, or a scene that yields no rays.

use phalanx_scene::ViewError;

/// The reason why a scene was not measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BenchError {
    /// One of our kernels, or the oracle, gives a wrong result.
    #[error("{scene}: {kind} ray {ray}: {kernel} says {found}, and it should be {expected}")]
    Kernel {
        /// The scene.
        scene: String,
        /// Kind of rays.
        kind: &'static str,
        /// The kernel, or `oracle`.
        kernel: String,
        /// Index of the first such ray in its set.
        ray: usize,
        /// The result that was found.
        found: String,
        /// The oracle's result, or the suite's.
        expected: String,
    },
    /// Kernels and oracle agree, but the suite expects another result.
    #[error("{scene}: {kind} rays: the suite expects {expected}, but there are {found}")]
    Suite {
        /// The scene.
        scene: String,
        /// Kind of rays.
        kind: &'static str,
        /// The suite's result.
        expected: String,
        /// The result that was found.
        found: String,
    },
    /// The frames of packet engine and oracle differ.
    #[error("{scene}: the frame of kernel {kernel} differs from the oracle's in pixel {x}, {y}")]
    Frame {
        /// The scene.
        scene: String,
        /// The kernel.
        kernel: String,
        /// Column of the first such pixel.
        x: u32,
        /// Row of that pixel.
        y: u32,
    },
    /// The listener stopped the run before the scene had rates.
    #[error("stopped")]
    Stopped,
    /// The scene was not validated.
    #[error("{scene}: {source}")]
    View {
        /// The scene.
        scene: String,
        /// The reason: the camera has no frame.
        source: ViewError,
    },
}
