//! Collection of the surfaces that the camera rays of a wave see.

use phalanx_scene::sampling::SurfaceShare;

/// A surface that a camera ray sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayFragment {
    /// Index of the ray in its queue.
    pub(crate) ray: u32,
    pub(crate) surface: SurfaceShare,
}

/// Collects the fragments of a wave.
pub(crate) struct FragmentSink<'w> {
    pub(crate) all: &'w mut Vec<RayFragment>,
    /// Index of the wave's first ray in its queue.
    pub(crate) first: u32,
}

impl FragmentSink<'_> {
    /// Adds a surface that a ray of the wave sees, after those in front of it on the ray.
    pub(super) fn push(&mut self, ray: usize, surface: SurfaceShare) {
        let ray = self.first + ray as u32;
        self.all.push(RayFragment { ray, surface });
    }
}
