//! The scene of a file that is a mesh, or a cloud of points.

use super::defaults::{GREY, WHITE, empty_scene};
use super::faces::VERTEX;
use super::point_cloud;
use super::polygon_mesh::MergedMesh;
use super::vertex_colors::MeshColors;
use crate::diagnostics::DiagnosticSink;
use crate::memory::MemoryLedger;
use crate::options::ReadOptions;
use crate::origin::{self, ReadStop};
use crate::read_scene::{self, ReadScene};
use phalanx_scene::{MaterialTable, Mesh, Prim, Scene};

/// A scene of a mesh alone, whose row 0 is the material of triangles for which the file names none.
/// Colours are the surface's own, so a default material beneath them is white.
pub(crate) fn scene_for(
    colors: &MeshColors,
    options: &ReadOptions,
    table: &mut MaterialTable,
) -> Scene {
    let default = if colors.rgb.is_empty() { GREY } else { WHITE };
    let mut scene = empty_scene();
    table.intern(&options.material.unwrap_or(default), &mut scene.materials);
    scene
}

/// Puts a mesh into its scene, and ends the reading. One without faces is a cloud of points.
pub(crate) fn finish(
    mut scene: Scene,
    mut joined: MergedMesh,
    options: &ReadOptions,
    memory: &MemoryLedger,
    mut report: DiagnosticSink,
) -> Result<ReadScene, ReadStop> {
    if joined.faces[VERTEX].is_empty() && joined.vertices.len() > joined.lost.len() {
        return finish_cloud(scene, joined, options, memory, report);
    }
    if let Some(origin) = options.origin.offset() {
        let (vertices, corners) = (&mut joined.vertices, &joined.faces[VERTEX]);
        origin::move_exactly(vertices, corners, joined.single, origin)?;
    }
    let [corners, uvs, normals] = joined.faces;
    let end = report.end_of_content();
    let most = Prim::MAX_INDEX as usize;
    if corners.len() > most || joined.vertices.len() > most {
        report.error(end, format!("more than {most} triangles or vertices"));
    } else if report.is_clean() {
        if corners.is_empty() {
            report.warning(end, "the file has no faces: the picture will be empty");
        }
        let colors = joined.colors.rows(&corners);
        scene.append_mesh(Mesh {
            vertices: joined.vertices,
            corners: corners.into(),
            normals: normals.into(),
            vertex_normals: joined.vertex_normals,
            uvs: uvs.into(),
            vertex_uvs: joined.vertex_uvs,
            colors: colors.into(),
            vertex_colors: joined.colors.rgb,
            vertex_opacity: joined.colors.opacity,
            material: joined.material,
            ..Mesh::default()
        });
    }
    Ok(ReadScene {
        up_is_assumed: true,
        ..read_scene::finish(scene, options, report)?
    })
}

/// As [`finish`], for vertices without faces.
fn finish_cloud(
    mut scene: Scene,
    joined: MergedMesh,
    options: &ReadOptions,
    memory: &MemoryLedger,
    mut report: DiagnosticSink,
) -> Result<ReadScene, ReadStop> {
    let end = report.end_of_content();
    let count = joined.vertices.len() - joined.lost.len();
    let most = Prim::MAX_INDEX as usize;
    let mut notes = Vec::new();
    if count > most {
        report.error(end, format!("more than {most} points"));
    } else if report.is_clean() {
        match point_cloud::add(&mut scene, joined, options, memory)? {
            Some(radius) => notes.push(format!(
                "the file has no faces: its {count} points are spheres of radius {radius} (see --point-radius)"
            )),
            None => {
                let message = "the file has no faces, and its points have no spacing to derive a radius from";
                report.error_with_help(end, message, "add --point-radius R");
            }
        }
    }
    Ok(ReadScene {
        up_is_assumed: true,
        is_cloud: true,
        notes,
        ..read_scene::finish(scene, options, report)?
    })
}
