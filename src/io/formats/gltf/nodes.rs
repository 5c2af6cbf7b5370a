//! The node hierarchy, flattened: nodes with their maps to the world.

use super::document::{GltfDocument, GltfNode};
use super::source::GltfSource;
use crate::formats::diagnostics::DiagnosticSink;
use crate::formats::origin::Origin;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// A node of the shown scene, and its map to the world.
pub(super) struct PlacedNode {
    pub(super) node: usize,
    pub(super) to_world: DAffine3,
}

/// The nodes of the default scene (or of the first one, or of all roots), parents before their
/// children, in file order.
///
/// Every node is visited once, so that neither a cycle nor a node with two parents takes more time
/// than the file has nodes. Both are errors. All maps subtract the scene's origin.
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
    let mut waiting: Vec<(usize, DAffine3)> = Vec::new();
    let push = |waiting: &mut Vec<_>, nodes: &[usize], map: DAffine3| {
        waiting.extend(nodes.iter().rev().map(|&node| (node, map)));
    };
    let world = DAffine3::from_translation(DVec3::ZERO - origin.position());
    push(&mut waiting, &roots, world);
    while let Some((row, parent)) = waiting.pop() {
        let Some(node) = document.nodes.get(row) else {
            source.error(
                report,
                "nodes",
                row,
                "named as a child or root, but not there",
            );
            return placed;
        };
        if std::mem::replace(&mut seen[row], true) {
            let message = "reached twice: nodes must form trees, without cycles or shared children";
            source.error(report, "nodes", row, message);
            return placed;
        }
        let to_world = parent * local(node);
        push(&mut waiting, &node.children, to_world);
        placed.push(PlacedNode {
            node: row,
            to_world,
        });
    }
    placed
}

type MissingReference = (&'static str, usize, &'static str);

fn roots(document: &GltfDocument) -> Result<Vec<usize>, MissingReference> {
    let chosen = document.scene.unwrap_or(0);
    if let Some(scene) = document.scenes.get(chosen) {
        return Ok(scene.nodes.clone());
    }
    if document.scene.is_some() {
        return Err(("scenes", chosen, "the default scene, but not there"));
    }
    let mut is_child = vec![false; document.nodes.len()];
    for &child in document.nodes.iter().flat_map(|node| &node.children) {
        if let Some(mark) = is_child.get_mut(child) {
            *mark = true;
        }
    }
    let roots: Vec<usize> = (0..document.nodes.len())
        .filter(|&node| !is_child[node])
        .collect();
    match roots.is_empty() && !document.nodes.is_empty() {
        true => Err((
            "nodes",
            0,
            "every node is a child of another: the hierarchy has a cycle",
        )),
        false => Ok(roots),
    }
}

fn local(node: &GltfNode) -> DAffine3 {
    if let Some(m) = node.matrix {
        let column = |k: usize| DVec3::new(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
        return DAffine3 {
            matrix3: DMat3::from_cols(column(0), column(1), column(2)),
            translation: column(3),
        };
    }
    let turn = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let turn = match turn.length_squared() {
        // Single precision in the file leaves it a little off unit length, which would scale the
        // node.
        squared if squared > 0.0 && squared.is_finite() => turn * (1.0 / squared.sqrt()),
        _ => DQuat::IDENTITY,
    };
    let scale = DVec3::from_array(node.scale.unwrap_or([1.0; 3]));
    DAffine3 {
        matrix3: DMat3::from_quat(turn) * DMat3::from_diagonal(scale),
        translation: DVec3::from_array(node.translation.unwrap_or_default()),
    }
}
