//! The kinds of rays that are measured.

/// A kind of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
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

impl Kind {
    /// All of them, in the order in which they are reported.
    pub const ALL: [Kind; 6] = [
        Kind::Primary,
        Kind::Shadow,
        Kind::Reflection,
        Kind::Refraction,
        Kind::Diffuse,
        Kind::Ao,
    ];

    /// As in records and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Primary => "primary",
            Kind::Shadow => "shadow",
            Kind::Reflection => "reflection",
            Kind::Refraction => "refraction",
            Kind::Diffuse => "diffuse",
            Kind::Ao => "ao",
        }
    }

    /// What is asked of these rays.
    pub fn question(self) -> Question {
        match self {
            Kind::Shadow | Kind::Ao => Question::Occluded,
            _ => Question::Closest,
        }
    }
}

/// What is asked of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// What it hits first.
    Closest,
    /// Whether it hits anything.
    Occluded,
}
