//! Settings of a render that decide what a camera ray returns, as both tracers take them.

/// Limits of a camera ray's bounces, and what the ray returns where it ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IntegratorSettings {
    /// Bounces after the primary ray.
    pub max_depth: u32,
    /// Minimum share of its camera ray that a bounce must have in some component to be traced; at
    /// 0, all are traced. The share is the product of the weights along the path, each divided by
    /// max(|Ks| + |Kt|, 1) at its hit.
    pub min_weight: f32,
    /// Length of ambient occlusion rays, in units of the scene, if ambient occlusion replaces
    /// shading: a hit is white if a single ray from it hits nothing within that distance, and black
    /// otherwise.
    pub ao_distance: Option<f32>,
    /// True if the background is black to camera rays.
    pub hides_background: bool,
}

impl IntegratorSettings {
    /// Returns true if camera rays may see an environment.
    pub fn shows_environment(&self) -> bool {
        !self.hides_background && self.ao_distance.is_none()
    }
}
