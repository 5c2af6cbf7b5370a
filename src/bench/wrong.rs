//! Why there are no rates: a wrong answer, or a scene that gives no rays.

use crate::scene::ViewError;

/// Why a scene was not measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Wrong {
    /// A kernel of ours does not answer as the oracle does.
    #[error("{scene}: {kind} ray {ray}: kernel {kernel} says {found}, the oracle {expected}")]
    Kernel {
        /// The scene.
        scene: String,
        /// Kind of rays.
        kind: &'static str,
        /// The kernel.
        kernel: String,
        /// Number of the first such ray in its set.
        ray: usize,
        /// The kernel's answer.
        found: String,
        /// The oracle's.
        expected: String,
    },
    /// Kernels and oracle agree, but the suite expects something else.
    #[error(
        "{scene}: {kind} rays: the suite expects {expected_hits} hits of {expected_rays} rays (checksum {expected_checksum}), but there are \
         {hits} of {rays} ({checksum})"
    )]
    Suite {
        /// The scene.
        scene: String,
        /// Kind of rays.
        kind: &'static str,
        /// As the suite says.
        expected_hits: u64,
        /// As the suite says.
        expected_rays: u64,
        /// As the suite says.
        expected_checksum: String,
        /// As found.
        hits: u64,
        /// As found.
        rays: u64,
        /// As found.
        checksum: String,
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
