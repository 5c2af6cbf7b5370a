//! Scenes and files are the same for any number of threads.

use super::spec;
use phalanx::scene::Scene;
use phalanx::standard::{CATALOGUE, Family, FileFormat, scene, write};

/// Each scene: those of triangles in more pieces than there are threads.
fn names() -> impl Iterator<Item = String> {
    CATALOGUE.iter().map(|entry| match entry.family {
        Family::Spd => format!("{}:{}", entry.name, entry.sizes.start()),
        Family::Modern => format!("{}:180k", entry.name),
    })
}

fn same(a: &Scene, b: &Scene) -> bool {
    let (s, t) = (&a.triangles, &b.triangles);
    s.vertices == t.vertices
        && s.corners == t.corners
        && s.material == t.material
        && a.prims == b.prims
        && a.materials.kd == b.materials.kd
}

#[test]
fn scenes_do_not_depend_on_the_number_of_threads() {
    for name in names() {
        let [one, others @ ..] = [1, 2, 3, 16].map(|threads| scene(spec(&name), threads).unwrap());
        for other in others {
            assert!(same(&one, &other), "{name}");
        }
    }
}

#[test]
fn files_do_not_depend_on_the_number_of_threads() {
    for name in names() {
        for format in [FileFormat::Nff, FileFormat::Ply, FileFormat::Test] {
            let [one, others @ ..] = [1, 2, 3, 16].map(|threads| {
                let mut bytes = Vec::new();
                write(spec(&name), format, Some(1), threads, &mut bytes).unwrap();
                bytes
            });
            for other in others {
                assert!(one == other, "{name}, {format:?}");
            }
        }
    }
}
