//! The node hierarchy, flattened: nodes with their maps to the world.

use super::document::{GltfDocument, GltfNode};
use super::source::GltfSource;
use crate::diagnostics::DiagnosticSink;
use crate::origin::Origin;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// A node of the shown scene, and its map to the world.
pub(super) struct PlacedNode {
    pub(super) node: usize,
    pub(super) to_world: DAffine3,
    /// False if KHR_node_visibility of the node or a node above it hides its mesh and light.
    pub(super) visible: bool,
}

/// The nodes of the default scene (or of the first one, or of all roots), parents before their
/// children, in file order.
///
/// Every node is visited once, so that cycles and nodes with two parents do not increase the work
/// beyond the number of nodes. Both are errors. All maps subtract the scene's origin.
pub(super) fn flatten(
    source: &GltfSource,
    origin: Origin,
    report: &mut DiagnosticSink,
) -> Vec<PlacedNode> {
    let document = &source.document;
    let mut placed = Vec::new();
    let roots = match roots(document) {
        Ok(roots) => roots,
        Err((list, row, message)) => {
            source.error(report, list, row, message);
            return placed;
        }
    };
    let mut seen = vec![false; document.nodes.len()];
    // Nodes to visit, with the map and the visibility of the node above each.
    let below = |nodes: &[usize], map: DAffine3, visible: bool| -> Vec<_> {
        nodes.iter().rev().map(|&row| (row, map, visible)).collect()
    };
    let mut waiting = below(&roots, world_map(origin), true);
    while let Some((row, parent, shown)) = waiting.pop() {
        let Some(node) = document.nodes.get(row) else {
            let message = "named as a child or root, but not there";
            source.error(report, "nodes", row, message);
            return placed;
        };
        if std::mem::replace(&mut seen[row], true) {
            let message = "reached twice: nodes must form trees, without cycles or shared children";
            source.error(report, "nodes", row, message);
            return placed;
        }
        let to_world = parent * local(node);
        let own = node.extensions.visibility.as_ref();
        let visible = shown && own.is_none_or(|own| own.visible != Some(false));
        waiting.extend(below(&node.children, to_world, visible));
        placed.push(PlacedNode {
            node: row,
            to_world,
            visible,
        });
    }
    placed
}

/// The map of the file's coordinates to the scene's.
fn world_map(origin: Origin) -> DAffine3 {
    DAffine3::from_translation(DVec3::ZERO - origin.position())
}

/// Maps to the world of all nodes, in the shown scene or not, as joints may be in neither. `None`
/// for the nodes of a cycle. Every node is visited once.
pub(super) fn all_maps(document: &GltfDocument, origin: Origin) -> Vec<Option<DAffine3>> {
    let mut maps = vec![None; document.nodes.len()];
    let world = world_map(origin);
    let mut waiting: Vec<(usize, DAffine3)> = orphans(document).map(|row| (row, world)).collect();
    while let Some((row, parent)) = waiting.pop() {
        let (Some(node), Some(map)) = (document.nodes.get(row), maps.get_mut(row)) else {
            continue;
        };
        if map.is_none() {
            let own = parent * local(node);
            *map = Some(own);
            waiting.extend(node.children.iter().map(|&child| (child, own)));
        }
    }
    maps
}

const CYCLE: &str = "every node is a child of another: the hierarchy has a cycle";

type MissingReference = (&'static str, usize, &'static str);

fn roots(document: &GltfDocument) -> Result<Vec<usize>, MissingReference> {
    let chosen = document.scene.unwrap_or(0);
    if let Some(scene) = document.scenes.get(chosen) {
        return Ok(scene.nodes.clone());
    }
    if document.scene.is_some() {
        return Err(("scenes", chosen, "the default scene, but not there"));
    }
    let roots: Vec<usize> = orphans(document).collect();
    if roots.is_empty() && !document.nodes.is_empty() {
        Err(("nodes", 0, CYCLE))
    } else {
        Ok(roots)
    }
}

/// Nodes that are not children of others.
fn orphans(document: &GltfDocument) -> impl Iterator<Item = usize> + use<> {
    let mut is_child = vec![false; document.nodes.len()];
    for &child in document.nodes.iter().flat_map(|node| &node.children) {
        if let Some(mark) = is_child.get_mut(child) {
            *mark = true;
        }
    }
    (0..document.nodes.len()).filter(move |&node| !is_child[node])
}

/// The affine map of a matrix whose columns are given one after the other.
pub(super) fn affine(m: [f64; 16]) -> DAffine3 {
    let column = |k: usize| DVec3::new(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
    DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    }
}

fn local(node: &GltfNode) -> DAffine3 {
    match node.matrix {
        Some(matrix) => affine(matrix),
        None => transform(
            node.translation.unwrap_or_default(),
            node.rotation.unwrap_or(NO_ROTATION),
            node.scale.unwrap_or(NO_SCALE),
        ),
    }
}

/// The quaternion of no rotation.
pub(super) const NO_ROTATION: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
/// The factors of no scaling.
pub(super) const NO_SCALE: [f64; 3] = [1.0; 3];

/// The map that scales, then turns by a quaternion of any length, then moves.
pub(super) fn transform(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> DAffine3 {
    let turn = DQuat::from_array(rotation);
    let turn = match turn.length_squared() {
        // Single precision in the file leaves it a little off unit length, which would scale the
        // node.
        squared if squared > 0.0 && squared.is_finite() => turn * (1.0 / squared.sqrt()),
        _ => DQuat::IDENTITY,
    };
    DAffine3 {
        matrix3: DMat3::from_quat(turn) * DMat3::from_diagonal(DVec3::from_array(scale)),
        translation: DVec3::from_array(translation),
    }
}
