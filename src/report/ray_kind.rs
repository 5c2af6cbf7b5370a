//! The kinds of rays that are measured, and their names.

/// Name of whole frames, where records and the command line name kinds of rays.
pub const FRAME: &str = "frame";

/// A kind of rays; `rays.rs` makes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(test, derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum RayKind {
    /// Camera rays.
    Primary,
    /// Rays from the primary hits toward one light, where the surface faces it.
    Shadow,
    /// Mirror rays from all primary hits, regardless of the material.
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

    /// Names of all kinds, in the order in which they are reported, then [`FRAME`].
    pub fn names() -> impl Iterator<Item = &'static str> {
        RayKind::ALL.map(RayKind::name).into_iter().chain([FRAME])
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Serde's message lists the variants.
    #[test]
    fn every_variant_is_listed_by_its_name() {
        let error = serde_json::from_str::<RayKind>("\"sideways\"").unwrap_err();
        let names = RayKind::ALL.map(|kind| format!("`{}`", kind.name()));
        let list = format!("expected one of {}", names.join(", "));
        assert!(error.to_string().contains(&list), "{error}, not {list}");
    }
}
