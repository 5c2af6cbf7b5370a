//! Why there are no rates: a wrong answer, or a scene that gives no rays.

use phalanx_scene::ViewError;

/// Why a scene was not measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BenchError {
    /// A kernel of ours, or the oracle, does not give the right answer.
    #[error("{scene}: {kind} ray {ray}: {kernel} says {found}, and it should be {expected}")]
    Kernel {
        /// The scene.
        scene: String,
        /// Kind of rays.
        kind: &'static str,
        /// The kernel, or `oracle`.
        kernel: String,
        /// Number of the first such ray in its set.
        ray: usize,
        /// Its answer.
        found: String,
        /// The oracle's, or the suite's.
        expected: String,
    },
    /// Kernels and oracle agree, but the suite expects something else.
    #[error("{scene}: {kind} rays: the suite expects {expected}, but there are {found}")]
    Suite {
        /// The scene.
        scene: String,
        /// Kind of rays.
        kind: &'static str,
        /// As the suite says.
        expected: String,
        /// As found.
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
        /// Its row.
        y: u32,
    },
    /// The scene was not validated.
    #[error("{scene}: {source}")]
    View {
        /// The scene.
        scene: String,
        /// Its camera has no frame.
        source: ViewError,
    },
}
