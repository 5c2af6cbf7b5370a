//! The kernels by name, and the choice between them.

use crate::bvh::{Bvh, LeafKind};
use crate::simd::{LANES, NATIVE};

/// Traversal kernel of the packet engine. Every kernel gives the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// The fastest known kernel for these rays, sixty-four packets at a time. Rays with a common
    /// point are traced as packets or beams, other rays in a large tree as packets or single rays,
    /// whichever was faster recently for rays of that divergence. Everything else is traced as
    /// packets. Packets have sixteen lanes if the build has AVX-512, else eight. Figures are in
    /// `perf/notes/coherence.md`, `perf/notes/beams.md`, `perf/notes/single-rays.md` and
    /// `perf/notes/packets-of-sixteen.md`.
    Auto,
    /// Packets of eight rays against the binary tree.
    Packet8,
    /// Two packets side by side against the binary tree.
    Packet16,
    /// Beams against the wide tree, in sub-beams of up to eight rays; [`Kernel::Packet8`] for rays
    /// without a common point.
    Beam8,
    /// Beams against the wide tree, in sub-beams of up to sixteen rays; [`Kernel::Packet16`] for
    /// rays without a common point.
    Beam16,
    /// Single rays against the wide tree.
    Single,
}

impl Kernel {
    /// Every kernel by name, `auto` first.
    pub const ALL: [(&'static str, Kernel); 6] = [
        ("auto", Kernel::Auto),
        ("packet8", Kernel::Packet8),
        ("packet16", Kernel::Packet16),
        ("beam8", Kernel::Beam8),
        ("beam16", Kernel::Beam16),
        ("single", Kernel::Single),
    ];

    /// The kernel's name on the command line.
    pub fn name(self) -> &'static str {
        let known = Kernel::ALL.iter().find(|(_, kernel)| *kernel == self);
        known.map_or("", |(name, _)| name)
    }

    /// The best kernel for one frame of the given number of pixels. Building the wide tree takes as
    /// long as beams save with about four pixels per primitive. So if [`Kernel::Auto`] would have
    /// to build it for less, packets are used.
    pub fn for_frame(self, bvh: &Bvh, pixels: u64) -> Kernel {
        let prims = bvh.count(LeafKind::TRIANGLE) + bvh.count(LeafKind::SPHERE);
        let pays = bvh.has_wide() || pixels >= MIN_PIXELS_PER_PRIM * prims as u64;
        match self {
            Kernel::Auto if !pays => Kernel::packets(),
            kernel => kernel,
        }
    }

    /// Returns true if the kernel traverses the wide tree.
    pub fn is_wide(self) -> bool {
        match self {
            Kernel::Auto | Kernel::Beam8 | Kernel::Beam16 | Kernel::Single => true,
            Kernel::Packet8 | Kernel::Packet16 => false,
        }
    }

    /// The best packet kernel for this build.
    pub const fn packets() -> Kernel {
        if SIXTEEN { Kernel::Packet16 } else { Kernel::Packet8 }
    }

    /// The beam kernel for those packets.
    pub(super) const fn beams() -> Kernel {
        if SIXTEEN { Kernel::Beam16 } else { Kernel::Beam8 }
    }
}

/// Minimum number of pixels per primitive for which building a wide tree for one frame pays off
/// (`perf/notes/whole-frames.md`).
const MIN_PIXELS_PER_PRIM: u64 = 4;

/// True if sixteen lanes are faster on this build.
const SIXTEEN: bool = NATIVE > LANES;
