//! The mesh readers: meaning of files, messages about bad ones, and agreement with other readers.

mod clouds;
mod framing;
mod names;
mod obj;
mod obj_exporters;
mod obj_others;
mod origin;
mod ply;
mod ply_textures;
mod stl;

use phalanx::formats::{Diagnostic, Loaded, Options, read_bytes};
use phalanx::scene::Scene;

/// Reads bytes as a file with this extension, which must be a scene.
fn read(ending: &str, bytes: &[u8]) -> Loaded {
    let read = read_bytes(ending, bytes, &Options::default()).expect("a known ending");
    read.unwrap_or_else(|errors| panic!("{errors:#?}"))
}

fn errors(ending: &str, bytes: &[u8]) -> Vec<Diagnostic> {
    let read = read_bytes(ending, bytes, &Options::default()).expect("a known ending");
    read.map(|loaded| loaded.warnings).expect_err("a bad file")
}

fn messages(diagnostics: &[Diagnostic]) -> Vec<String> {
    diagnostics.iter().map(|d| d.message.clone()).collect()
}

/// The triangles' vertices.
fn triangles(scene: &Scene) -> Vec<[[f32; 3]; 3]> {
    let corners = |i| scene.triangles.corners(i).map(|c| c.to_array());
    (0..scene.triangles.len()).map(corners).collect()
}

/// Twice the area of all triangles, seen from +z.
fn area_from_z(scene: &Scene) -> f32 {
    let area =
        |[a, b, c]: [[f32; 3]; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    triangles(scene).into_iter().map(area).sum()
}

const FLAT: [[[f32; 3]; 3]; 1] = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
