use super::*;
use phalanx_scene::Scene;

fn folder_with(files: &[(&str, &str)]) -> (tempfile::TempDir, Folder) {
    let scratch = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(scratch.path().join(name), text).unwrap();
    }
    let folder = Folder::of(&scratch.path().join("a.obj"));
    (scratch, folder)
}

/// Text of everything in a scene that the reader determines, for comparison.
fn digest(scene: &Scene) -> String {
    format!(
        "{:?}",
        (
            &scene.triangles,
            &scene.materials,
            &scene.names,
            &scene.view,
            &scene.lights
        )
    )
}

/// A text with every kind of statement, and with names and numbers that carry over from line to
/// line.
fn everything() -> String {
    let mut text = String::from("# all\nmtllib a.mtl\r\nmtllib none.mtl\n");
    for k in 0..60 {
        let (x, y) = (k % 10, k / 10);
        let color = if k % 5 == 4 { " .2 .4 1" } else { "" };
        text += &format!("v {x} {y} 0.{k}{color}\nvt 0.{k} .5\nvn 0 {} 1\n", k % 2);
        if k % 9 == 5 {
            text += &format!("s {}\nvt 1.#QNAN\n", k % 4);
        }
        if k % 6 == 1 {
            text += &format!("g group {k}\ng {}\n", k % 4);
        }
        if k > 40 && k % 5 == 0 {
            text += &format!("o part {}\n", k % 3);
        }
        if k % 7 == 3 {
            text += &format!("usemtl m{}\n", k % 3);
        }
        if k > 20 {
            text += "f -1 -2 -15\n";
            text += &format!("f 1/1/1 2/2/2 \\\n {k}/3/4\n");
            text += "f -1/-1 -11/-2 -12/-3 -2/-4\r\n";
            text += "f 1/0/900 2/1/1 3/2/2\n";
            text += &format!("f 1//1 3//2 {k}//2 21//3 11//4\nl 1 2\n");
        }
    }
    text
}

#[test]
fn neither_threads_nor_chunks_change_the_scene() {
    let mtl = "newmtl m0\nKd 1 0 0\nnewmtl m1\nKd 0 1 0\n";
    let (_scratch, folder) = folder_with(&[("a.mtl", mtl)]);
    let text = everything();
    let read = |threads, chunk_bytes| {
        let options = ReadOptions {
            threads,
            ..ReadOptions::default()
        };
        let loaded = read_in_chunks(text.as_bytes(), &folder, &options, chunk_bytes).unwrap();
        (digest(&loaded.scene), loaded.warnings)
    };
    let expected = read(1, CHUNK_BYTES);
    for part in ["corners", "\"part 1\"", "\"m2\""] {
        assert!(expected.0.contains(part), "{part}");
    }
    for chunk_bytes in [1, 7, 64, 500] {
        for threads in [1, 2, 5] {
            assert_eq!(
                read(threads, chunk_bytes),
                expected,
                "{threads} threads, chunks of {chunk_bytes}"
            );
        }
    }
}

#[test]
fn errors_come_in_file_order_from_every_piece() {
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for k in 0..15 {
        text += &format!("f 1 2 {}\nv 1 x 0\nf -{} 1 2\n", k * 1000, 3 + k * 500);
    }
    let read = |chunk_bytes| {
        let options = ReadOptions {
            threads: 3,
            ..ReadOptions::default()
        };
        read_in_chunks(text.as_bytes(), &Folder::none(), &options, chunk_bytes)
            .unwrap_err()
            .diagnostics()
    };
    let expected = read(CHUNK_BYTES);
    assert_eq!(expected.len(), crate::MAX_DIAGNOSTICS);
    assert!(expected.is_sorted_by_key(|d| d.line));
    for chunk_bytes in [1, 20, 100] {
        assert_eq!(read(chunk_bytes), expected, "chunks of {chunk_bytes}");
    }
}

#[test]
fn a_piece_does_not_begin_on_a_continued_line() {
    let text = b"f 1 \\\n2 3\nv 1 2 3\\\r\n\nend";
    assert_eq!(line_start(text, 0), 10);
    assert_eq!(line_start(text, 12), text.len() - 3);
    assert_eq!(line_start(text, text.len() - 2), text.len());
    let blanks = b"f 1 \\ \t\r\n2 3\\ x\nend";
    assert_eq!(line_start(blanks, 0), blanks.len() - 3);
}

#[test]
fn a_material_file_is_read_once_by_whatever_names() {
    let mtl = "newmtl m\nKd x\n";
    let (_scratch, folder) = folder_with(&[("a.mtl", mtl)]);
    let text =
        "mtllib a.mtl\nmtllib ./a.mtl\nmtllib .//a.mtl a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let text = format!("{text}usemtl m\nf 1 2 3\n");
    let loaded = read(text.as_bytes(), &folder, &ReadOptions::default()).unwrap();
    let warnings = loaded.warnings;
    assert_eq!(warnings.len(), 1, "its fault is told once: {warnings:?}");
}

#[test]
fn names_of_materials_are_bytes() {
    let (scratch, folder) = folder_with(&[]);
    let mtl = b"newmtl \xe4\nKd 1 0 0\nnewmtl \xf6\nKd 0 1 0\n";
    std::fs::write(scratch.path().join("a.mtl"), mtl).unwrap();
    let text = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl \xf6\nf 1 2 3\n";
    let scene = read(text, &folder, &ReadOptions::default()).unwrap().scene;
    let row = scene.triangles.material[0] as usize;
    assert_eq!(scene.materials.kd.get(row), glam::Vec3::Y);
}
