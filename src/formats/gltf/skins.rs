//! Skins: vertices that follow the joints of a skeleton.

use super::accessor::Accessor;
use super::document::Primitive;
use super::nodes;
use super::source::GltfSource;
use crate::origin::Origin;
use glam::{DAffine3, DMat3, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Maps of a skin's joints: from the mesh's own space, as it was bound, to the world.
pub(super) type JointMaps = Arc<[DAffine3]>;

/// The skins of a file, each evaluated at its first use.
pub(super) struct Skins<'a> {
    source: &'a GltfSource<'a>,
    origin: Origin,
    /// Maps of all nodes to the world, in the shown scene or not.
    nodes: Option<Vec<Option<DAffine3>>>,
    evaluated: HashMap<usize, JointMaps>,
}

impl<'a> Skins<'a> {
    pub(super) fn new(source: &'a GltfSource<'a>, origin: Origin) -> Skins<'a> {
        Skins {
            source,
            origin,
            nodes: None,
            evaluated: HashMap::new(),
        }
    }

    /// The maps of a skin's joints.
    pub(super) fn joints(&mut self, skin: usize) -> Result<JointMaps, String> {
        if let Some(known) = self.evaluated.get(&skin) {
            return Ok(Arc::clone(known));
        }
        let named = |reason: String| format!("skins[{skin}]: {reason}");
        let joints = self.evaluate(skin).map_err(named)?;
        self.evaluated.insert(skin, Arc::clone(&joints));
        Ok(joints)
    }

    fn evaluate(&mut self, skin: usize) -> Result<JointMaps, String> {
        let source = self.source;
        let skin = source.document.skins.get(skin).ok_or("it is not there")?;
        if skin.joints.is_empty() {
            return Err("it has no joints".into());
        }
        let bound = skin.inverse_bind_matrices;
        let bound = bound
            .map(|row| Accessor::open(source, row, 16))
            .transpose()?;
        if let Some(rows) = bound.filter(|rows| rows.count < skin.joints.len()) {
            let joints = skin.joints.len();
            return Err(format!("{} matrices for its {joints} joints", rows.count));
        }
        let nodes = self
            .nodes
            .get_or_insert_with(|| nodes::all_maps(&source.document, self.origin));
        let maps = skin.joints.iter().enumerate().map(|(k, &joint)| {
            let node = nodes.get(joint).copied().flatten();
            let node = node.ok_or_else(|| format!("its joint nodes[{joint}] has no position"))?;
            Ok(match bound {
                Some(rows) => node * nodes::affine(rows.get::<16>(k).map(f64::from)),
                None => node,
            })
        });
        maps.collect()
    }
}

/// Maximum number of sets of four joints and weights for a vertex: as many as any exporter writes.
/// It bounds the work per vertex.
const MAX_SETS: usize = 8;

/// Joints that move the vertices of a primitive, and their weights.
pub(super) struct Influences<'a>(Vec<[Accessor<'a>; 2]>);

impl<'a> Influences<'a> {
    /// Opens the accessors of a primitive's sets; `None` if it has none.
    pub(super) fn open(
        source: &'a GltfSource,
        primitive: &Primitive,
    ) -> Result<Option<Influences<'a>>, String> {
        let mut sets = Vec::new();
        while sets.len() < MAX_SETS {
            let row = |name: &str| primitive.attributes.get(&format!("{name}_{}", sets.len()));
            let (Some(&joints), Some(&weights)) = (row("JOINTS"), row("WEIGHTS")) else {
                break;
            };
            let joints = Accessor::open_joints(source, joints)?;
            sets.push([joints, Accessor::open(source, weights, 4)?]);
        }
        Ok((!sets.is_empty()).then_some(Influences(sets)))
    }

    /// Number of rows that all accessors have.
    pub(super) fn rows(&self) -> usize {
        let rows = self.0.iter().flatten().map(|accessor| accessor.count);
        rows.min().unwrap_or(0)
    }

    /// The map of a vertex: the weighted mean of its joints' maps, and true if all of them exist.
    /// Weights need not sum to 1. A vertex without weights follows its first joint.
    pub(super) fn map(&self, row: usize, joints: &[DAffine3]) -> (DAffine3, bool) {
        let mut sum = DAffine3 {
            matrix3: DMat3::ZERO,
            translation: DVec3::ZERO,
        };
        let (mut total, mut complete) = (0.0, true);
        for [numbers, weights] in &self.0 {
            let numbers: [f32; 4] = numbers.get(row);
            let weights: [f32; 4] = weights.get(row);
            for (number, weight) in numbers.into_iter().zip(weights) {
                let weight = f64::from(weight);
                // NaN is not a weight either.
                if !(weight > 0.0 && weight.is_finite()) {
                    continue;
                }
                let Some(joint) = joints.get(number as usize) else {
                    complete = false;
                    continue;
                };
                sum.matrix3 += joint.matrix3 * weight;
                sum.translation += joint.translation * weight;
                total += weight;
            }
        }
        if total > 0.0 {
            sum.matrix3 *= 1.0 / total;
            sum.translation *= 1.0 / total;
            return (sum, complete);
        }
        let numbers: [f32; 4] = self.0[0][0].get(row);
        let first = joints.get(numbers[0] as usize).unwrap_or(&joints[0]);
        (*first, complete)
    }
}
