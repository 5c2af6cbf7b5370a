//! The kinds of rays that are measured.

/// A kind of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RayKind {
    /// Camera rays.
    Primary,
    /// From what the camera sees toward one light, where it faces the light.
    Shadow,
    /// Mirror rays of everything the camera sees, whatever it is made of.
    Reflection,
    /// Refracted rays of everything the camera sees, as if it were glass.
    Refraction,
    /// One ray per hit into the hemisphere, by the cosine.
    Diffuse,
    /// The same, but short, and asked for occlusion only.
    Ao,
}

impl RayKind {
    /// All of them, in the order in which they are reported.
    pub const ALL: [RayKind; 6] = [
        RayKind::Primary,
        RayKind::Shadow,
        RayKind::Reflection,
        RayKind::Refraction,
        RayKind::Diffuse,
        RayKind::Ao,
    ];

    /// As in records and on the command line.
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

    /// What is asked of these rays.
    pub fn query(self) -> QueryKind {
        match self {
            RayKind::Shadow | RayKind::Ao => QueryKind::Occluded,
            _ => QueryKind::Closest,
        }
    }
}

/// What is asked of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueryKind {
    /// What it hits first.
    Closest,
    /// Whether it hits anything.
    Occluded,
}
