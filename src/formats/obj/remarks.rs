//! Warnings about an OBJ file: each kind once, at its first occurrence.

use super::chunk::ObjChunk;
use crate::diagnostics::{DiagnosticSink, Span, quoted_bytes};
use crate::faces::{NONE, NORMAL, UV, VERTEX};
use crate::mesh::{MergedMesh, Occurrences};
use phalanx_scene::{MeshMaterial, NO_TEXTURE, Scene};

/// Adds the warnings about all chunks, which have `total` rows of each attribute, and an error if
/// the file is none of OBJ.
pub(super) fn warn(text: &[u8], chunks: &[ObjChunk], total: [i64; 3], report: &mut DiagnosticSink) {
    let unknown = all(chunks, |chunk| chunk.skipped.unknown);
    let nothing = chunks
        .iter()
        .all(|chunk| chunk.counts() == [0; 3] && chunk.faces.len() == 0);
    if let (true, Some(span)) = (nothing, unknown.first) {
        report.error(
            span,
            "this is not an OBJ file: it has no vertices, and this is none of its statements",
        );
    }
    all(chunks, |chunk| chunk.skipped.lines).warn(report, |count| match count {
        1 => "this face of two corners, line or point is skipped".into(),
        _ => format!("{count} faces of two corners, lines or points are skipped, this one first"),
    });
    all(chunks, |chunk| chunk.skipped.free_forms).warn(report, |count| {
        format!("curves and surfaces are skipped: {count} statements, this one first")
    });
    unknown.warn(report, |count| match count {
        1 => "this statement is unknown, and skipped".into(),
        _ => format!("{count} statements are unknown, this one first, and skipped"),
    });
    warn_numbers(chunks, report);
    warn_faces(text, chunks, total, report);
}

/// Occurrences in all chunks.
fn all(chunks: &[ObjChunk], of: impl Fn(&ObjChunk) -> Occurrences) -> Occurrences {
    let mut all = Occurrences::default();
    chunks.iter().for_each(|chunk| all.merge(of(chunk)));
    all
}

/// Warns of numbers that are not used.
fn warn_numbers(chunks: &[ObjChunk], report: &mut DiagnosticSink) {
    all(chunks, |chunk| chunk.bad_uvs).warn(report, |count| match count {
        1 => "this texture place is not finite: (0, 0) is used instead".into(),
        _ => {
            format!("{count} texture places are not finite, this one first: (0, 0) is used instead")
        }
    });
    all(chunks, |chunk| chunk.colors.bad).warn(report, |count| match count {
        1 => "this colour is not finite: white is used instead".into(),
        _ => format!("{count} colours are not finite, this one first: white is used instead"),
    });
    all(chunks, |chunk| chunk.surplus).warn(report, |count| match count {
        1 => "this is one operand too many: it is not used".into(),
        _ => {
            format!("{count} statements have operands too many, this one first: they are not used")
        }
    });
}

/// Warns of faces that are drawn without something.
fn warn_faces(text: &[u8], chunks: &[ObjChunk], total: [i64; 3], report: &mut DiagnosticSink) {
    for (attribute, one, several) in [
        (UV, "texture place", "texture places"),
        (NORMAL, "normal", "normals"),
    ] {
        let bad = all(chunks, |chunk| chunk.bad_references[attribute]);
        let number = bad
            .first
            .map_or_else(String::new, |span| quoted_bytes(&text[span.range()]));
        let there = format!("{number} is no {one}: the file has {}", total[attribute]);
        bad.warn(report, |count| match count {
            1 => format!("{there}; the face is drawn without {several}"),
            _ => format!(
                "{there}; {count} corners, this one first, name none, and their faces are drawn without {several}"
            ),
        });
    }
    let unlike = all(chunks, |chunk| chunk.unlike);
    let what = "a texture place or a normal at some corners only";
    unlike.warn(report, |count| match count {
        1 => format!("this face has {what}, and is drawn without it"),
        _ => format!("{count} faces, this one first, have {what}, and are drawn without it"),
    });
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
    let message = match count {
        0 => return,
        1 => "a triangle has a texture and no places in it".into(),
        _ => format!("{count} triangles have a texture and no places in it"),
    };
    report.warning(Span::START, format!("{message}: it is not shown there"));
}
