//! Remarks about an OBJ file as a whole.

use super::chunk::{ObjChunk, UNKNOWN};
use crate::diagnostics::{ChunkRemarks, DiagnosticSink, Span, WarningTally, counted, quoted_bytes};
use crate::mesh::MergedMesh;
use crate::mesh::faces::{NONE, NORMAL, UV, VERTEX};
use phalanx_scene::{MeshMaterial, NO_TEXTURE, Scene};

/// Reports the remarks about all chunks, which have `total` rows of each attribute, with an error
/// if the file is none of OBJ.
pub(super) fn emit(
    text: &[u8],
    chunks: &mut [ObjChunk],
    total: [i64; 3],
    report: &mut DiagnosticSink,
) {
    let mut remarks = ChunkRemarks::default();
    let mut bad_references = [WarningTally::default(); 3];
    for chunk in chunks.iter_mut() {
        remarks.merge(std::mem::take(&mut chunk.remarks));
        for (all, chunk) in bad_references.iter_mut().zip(chunk.bad_references) {
            all.merge(chunk);
        }
    }
    let nothing = total == [0; 3] && chunks.iter().all(|chunk| chunk.mesh.faces.len() == 0);
    if let (true, Some(span)) = (nothing, remarks.tally(UNKNOWN[0]).first) {
        report.error(
            span,
            "this is not an OBJ file: it has no vertices, and this is not an OBJ statement",
        );
    }
    remarks.emit(report);
    for (attribute, one, several) in [
        (UV, "texture coordinate", "texture coordinates"),
        (NORMAL, "normal", "normals"),
    ] {
        let WarningTally { count, first } = bad_references[attribute];
        let Some(span) = first else {
            continue;
        };
        let number = quoted_bytes(&text[span.range()]);
        let problem = format!("{number} is no {one}: the file has {}", total[attribute]);
        let drawn = match count {
            1 => format!("the face is drawn without {several}"),
            _ => format!(
                "{count} corners, this one first, name none, and their faces are drawn without {several}"
            ),
        };
        report.warning(span, format!("{problem}; {drawn}"));
    }
}

/// Warns of triangles with a texture but without texture coordinates.
pub(super) fn warn_unplaced(scene: &Scene, mesh: &MergedMesh, report: &mut DiagnosticSink) {
    if scene.textures.is_empty() {
        return;
    }
    let is_unplaced = |&triangle: &usize| {
        let row = match &mesh.material {
            MeshMaterial::One(row) => *row,
            MeshMaterial::Each(rows) => rows[triangle],
        };
        let placed = mesh.faces[UV].get(triangle).is_some_and(|uv| uv[0] != NONE);
        !placed && scene.materials.get(row as usize).texture != NO_TEXTURE
    };
    let count = (0..mesh.faces[VERTEX].len()).filter(is_unplaced).count();
    if count > 0 {
        let message = counted(
            count,
            "a triangle has a texture and no texture coordinates: it is not shown there",
            "triangles have a texture and no texture coordinates: it is not shown there",
        );
        report.warning(Span::START, message);
    }
}
