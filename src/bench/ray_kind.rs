//! The kinds of rays that are measured.

/// A kind of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RayKind {
    /// Camera rays.
    Primary,
    /// Rays from the primary hits toward one light, where the surface faces it.
    Shadow,
    /// Mirror rays from all primary hits, whatever the material.
    Reflection,
    /// Refracted rays from all primary hits, as if everything were glass.
    Refraction,
    /// One ray per hit into the hemisphere, cosine-distributed.
    Diffuse,
    /// Ambient occlusion rays: as diffuse rays, but short, and for occlusion only.
    Ao,
}

impl RayKind {
    /// All kinds, in the order in which they are reported.
    pub const ALL: [RayKind; 6] = [
        RayKind::Primary,
        RayKind::Shadow,
        RayKind::Reflection,
        RayKind::Refraction,
        RayKind::Diffuse,
        RayKind::Ao,
    ];

    /// Name of the kind in records and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            RayKind::Primary => "primary",
            RayKind::Shadow => "shadow",
            RayKind::Reflection => "reflection",
            RayKind::Refraction => "refraction",
            RayKind::Diffuse => "diffuse",
            RayKind::Ao => "ao",
        }
    }

    /// Query that these rays are for.
    pub fn query(self) -> QueryKind {
        match self {
            RayKind::Shadow | RayKind::Ao => QueryKind::Occluded,
            _ => QueryKind::Closest,
        }
    }
}

/// The query of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueryKind {
    /// Closest hit.
    Closest,
    /// Any hit.
    Occluded,
}
