//! Morph targets: displacements of the vertices of a primitive, by the weights of its mesh's pose.

use super::accessor::Accessor;
use super::document::Primitive;
use super::source::GltfSource;
use glam::DVec3;

/// A morph target whose weight is not zero.
pub(super) struct MorphTarget<'a> {
    weight: f64,
    pub(super) position: Option<Accessor<'a>>,
    pub(super) normal: Option<Accessor<'a>>,
    uv: Option<Accessor<'a>>,
    color: Option<Accessor<'a>>,
}

/// Returns true if these weights of a pose leave the mesh's own vertices unchanged.
pub(super) fn is_rest(weights: &[f64]) -> bool {
    weights.iter().all(|&weight| weight == 0.0)
}

impl<'a> MorphTarget<'a> {
    /// Opens the targets of a primitive that a pose uses. `uv` is the attribute of its texture
    /// coordinates. Targets without a weight, and weights without a target, have no effect.
    pub(super) fn all(
        source: &'a GltfSource,
        primitive: &Primitive,
        weights: &[f64],
        uv: Option<&str>,
    ) -> Result<Vec<MorphTarget<'a>>, String> {
        let weighted = primitive.targets.iter().zip(weights).enumerate();
        let used = weighted.filter(|(_, (_, weight))| **weight != 0.0);
        let opened = used.map(|(k, (attributes, &weight))| {
            let named = |reason: String| format!("targets[{k}]: {reason}");
            let vectors = |name: &str, width: usize| {
                Accessor::of_attribute(source, attributes, name, width).map_err(named)
            };
            let color = attributes.get("COLOR_0");
            Ok(MorphTarget {
                weight,
                position: vectors("POSITION", 3)?,
                normal: vectors("NORMAL", 3)?,
                uv: match uv {
                    Some(name) => vectors(name, 2)?,
                    None => None,
                },
                color: color
                    .map(|&row| Accessor::open_colors(source, row).map_err(named))
                    .transpose()?,
            })
        });
        opened.collect()
    }

    /// Number of rows that all its accessors have.
    pub(super) fn rows(&self) -> usize {
        let all = [self.position, self.normal, self.uv, self.color];
        let rows = all.iter().flatten().map(|accessor| accessor.count);
        rows.min().unwrap_or(usize::MAX)
    }
}

/// A vector, such as a position, after the displacements in one attribute of the targets.
#[inline]
pub(super) fn vector<'a>(
    targets: &[MorphTarget<'a>],
    attribute: impl Fn(&MorphTarget<'a>) -> Option<Accessor<'a>>,
    row: usize,
    start: DVec3,
) -> DVec3 {
    targets.iter().fold(start, |sum, target| {
        let rows = attribute(target);
        let moved = rows.map(|rows| DVec3::from_array(rows.get(row).map(f64::from)));
        sum + target.weight * moved.unwrap_or_default()
    })
}

/// Texture coordinates after all displacements.
#[inline]
pub(super) fn uv(targets: &[MorphTarget], row: usize, start: [f32; 2]) -> [f32; 2] {
    targets.iter().fold(start, |sum, target| {
        let moved = target.uv.map_or([0.0; 2], |rows| rows.get(row));
        std::array::from_fn(|k| sum[k] + target.weight as f32 * moved[k])
    })
}

/// A colour and its alpha after all displacements.
#[inline]
pub(super) fn color(targets: &[MorphTarget], row: usize, start: [f32; 4]) -> [f32; 4] {
    targets.iter().fold(start, |sum, target| {
        let moved = target.color.map_or([0.0; 4], |rows| rows.color(row, 0.0));
        std::array::from_fn(|k| sum[k] + target.weight as f32 * moved[k])
    })
}
