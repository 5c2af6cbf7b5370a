//! Our readers against those of others, and on several threads, on the files in `../shared/scenes`
//! if there are any: `cargo test --release --features phalanx-units/readers --test readers`.

use phalanx::formats::{Options, ReadOptions, load};
use phalanx::scene::Scene;
use ply_rs_bw::{parser::Parser, ply};
use std::path::{Path, PathBuf};

/// All files with this extension below a folder of the shared scenes.
fn files(ending: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let shared = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/scenes");
    let mut folders = vec![Path::new(shared).join(ending)];
    folders.retain(|folder| folder.is_dir());
    if folders.is_empty() {
        println!("skipped: {shared} has no folder {ending}");
    }
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(folder).unwrap();
        for path in entries.flatten().map(|entry| entry.path()) {
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.retain(|file| file.extension().is_some_and(|e| e == ending));
    files
}

fn scene(path: &Path, threads: usize) -> Scene {
    let options = Options {
        read: ReadOptions {
            threads,
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    load(path, &options).unwrap_or_else(|e| panic!("{e}")).scene
}

/// The triangles' vertices.
fn triangles(scene: &Scene) -> Vec<[[f32; 3]; 3]> {
    let corners = |i| scene.triangles.corners(i).map(|c| c.to_array());
    (0..scene.triangles.len()).map(corners).collect()
}

/// Triangles regardless of their order and first vertex; polygons may be triangulated differently.
fn sorted(triangles: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Vec<[[u32; 3]; 3]> {
    let turned = |t: [[f32; 3]; 3]| {
        let [a, b, c] = t.map(|corner| corner.map(f32::to_bits));
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap()
    };
    let mut all: Vec<_> = triangles.into_iter().map(turned).collect();
    all.sort_unstable();
    all
}

#[test]
fn obj_files_hold_what_tobj_finds_in_them() {
    for file in files("obj") {
        let ours = scene(&file, 2);
        let (models, _) = tobj::load_obj(&file, &tobj::LoadOptions::default()).unwrap();
        let (mut theirs, mut polygons) = (Vec::new(), 0);
        for mesh in models.iter().map(|model| &model.mesh) {
            let position =
                |&i: &u32| <[f32; 3]>::try_from(&mesh.positions[i as usize * 3..][..3]).unwrap();
            let mut rest = &mesh.indices[..];
            let threes = vec![3; rest.len() / 3];
            let counts = if mesh.face_arities.is_empty() { &threes } else { &mesh.face_arities };
            for &count in counts {
                let (corners, behind) = rest.split_at(count as usize);
                rest = behind;
                polygons += usize::from(count > 3);
                theirs.extend(
                    (2..corners.len()).map(|k| [0, k - 1, k].map(|k| position(&corners[k]))),
                );
            }
        }
        assert_eq!(ours.triangles.len(), theirs.len(), "{}", file.display());
        if polygons == 0 {
            assert!(
                sorted(triangles(&ours)) == sorted(theirs),
                "{}",
                file.display()
            );
        }
    }
}

#[test]
fn ply_files_hold_what_ply_rs_finds_in_them() {
    for file in files("ply") {
        let ours = scene(&file, 2);
        let mut reader = std::io::BufReader::new(std::fs::File::open(&file).unwrap());
        let Ok(ply) = Parser::<ply::DefaultElement>::new().read_ply(&mut reader) else {
            println!("skipped: ply-rs-bw cannot read {}", file.display());
            continue;
        };
        let number = |row: &ply::DefaultElement, name: &str| match row[name] {
            ply::Property::Float(n) => n,
            ref other => panic!("{other:?}"),
        };
        let positions: Vec<[f32; 3]> = ply.payload["vertex"]
            .iter()
            .map(|row| ["x", "y", "z"].map(|name| number(row, name)))
            .collect();
        let corners = |row: &ply::DefaultElement| -> Vec<usize> {
            match &row["vertex_indices"] {
                ply::Property::ListInt(list) => list.iter().map(|&i| i as usize).collect(),
                ply::Property::ListUInt(list) => list.iter().map(|&i| i as usize).collect(),
                other => panic!("{other:?}"),
            }
        };
        let faces: Vec<Vec<usize>> = ply.payload["face"].iter().map(corners).collect();
        let count: usize = faces.iter().map(|f| f.len().saturating_sub(2)).sum();
        assert_eq!(ours.triangles.len(), count, "{}", file.display());
        if faces.iter().all(|face| face.len() == 3) {
            let theirs: Vec<_> = faces
                .iter()
                .map(|f| [f[0], f[1], f[2]].map(|i| positions[i]))
                .collect();
            assert!(triangles(&ours) == theirs, "{}", file.display());
        }
    }
}

#[test]
fn threads_do_not_change_what_is_read() {
    for file in files("obj").into_iter().chain(files("ply")) {
        let digest = |threads| {
            let s = scene(&file, threads);
            (
                s.triangles.corners.to_vec(),
                s.triangles.vertices.clone(),
                s.triangles.material.to_vec(),
                s.view,
            )
        };
        let one = digest(1);
        assert!(one == digest(2) && one == digest(7), "{}", file.display());
    }
}
