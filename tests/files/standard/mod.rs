//! The standard scenes: published facts, third-party files, and our own files.

mod agreement;
mod bits;
mod counts;
mod files;
mod meshes;
mod modern;
mod spec;
mod sphere;
mod threads;

use phalanx::scene::{PrimKind, Scene};
use phalanx::standard::{Spec, parse_spec};

fn spec(text: &str) -> Spec {
    parse_spec(&format!("standard:{text}")).expect("a standard scene")
}

fn scene(text: &str) -> Scene {
    phalanx::standard::scene(spec(text), 0).expect("a valid scene")
}

/// All numbers of a primitive, in a fixed order by kind, ending with its surface's.
fn numbers(scene: &Scene, prim: usize) -> (PrimKind, Vec<f32>, Vec<f32>) {
    let id = scene.prims[prim];
    let i = id.index();
    let mut out = Vec::new();
    match id.kind() {
        PrimKind::Sphere => {
            out.extend(scene.spheres.center.get(i).to_array());
            out.push(scene.spheres.radius[i]);
        }
        PrimKind::Cone => {
            let cone = scene.cones.get(i);
            out.extend(cone.base.to_array());
            out.push(cone.base_radius);
            out.extend(cone.apex.to_array());
            out.push(cone.apex_radius);
            assert!(!cone.inside);
        }
        PrimKind::Triangle => {
            let corners = scene.triangles.corners(i);
            let normals = scene.triangles.corner_normals(i);
            let normals = normals.into_iter().flatten();
            out.extend(
                corners
                    .into_iter()
                    .chain(normals)
                    .flat_map(|v| v.to_array()),
            );
        }
        PrimKind::Ellipsoid => panic!("no standard scene has ellipsoids"),
    }
    let surface = scene
        .materials
        .get(scene.prim_material(prim as u32) as usize);
    let colors = [surface.ka, surface.ke, surface.kd, surface.ks, surface.kt];
    let mut material: Vec<f32> = colors.iter().flat_map(|c| c.to_array()).collect();
    material.extend([surface.shininess, surface.ior]);
    (id.kind(), out, material)
}
