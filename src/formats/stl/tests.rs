use super::binary::{FACET, HEADER};
use super::*;
use std::fmt::Write;

fn facet(text: &mut String, corners: [[f32; 3]; 3]) {
    *text += "facet normal 0 0 nan\n outer loop\n";
    for [x, y, z] in corners {
        writeln!(text, "  vertex {x} {y} {z:e}\r").unwrap();
    }
    *text += " endloop\nENDFACET\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n";
}

#[test]
fn neither_threads_nor_chunks_change_the_scene() {
    let mut text = String::from(" solid of many facets\n");
    for k in 0..50 {
        let x = k as f32;
        if k % 9 == 8 {
            writeln!(text, "end solid x\nsolid part {k} # of it").unwrap();
        }
        facet(
            &mut text,
            [[x, 0.0, -0.0], [x + 1.0, 0.0, 0.0], [x, 1.5, 0.0]],
        );
    }
    text += "endsolid of many\nsolid another facet\nendsolid";
    let read = |threads, chunk_bytes| {
        let options = ReadOptions {
            threads,
            ..ReadOptions::default()
        };
        let loaded = read_in_chunks(
            text.as_bytes(),
            &MemoryLedger::of(None),
            &options,
            chunk_bytes,
        )
        .unwrap();
        format!("{:?}", (&loaded.scene.triangles, &loaded.scene.names))
    };
    let expected = read(1, CHUNK_BYTES);
    for name in ["\"of many facets\"", "\"part 8\"", "\"part 44\""] {
        assert!(expected.contains(name), "{name}");
    }
    for chunk_bytes in [1, 50, 1000] {
        for threads in [1, 2, 5] {
            assert!(
                read(threads, chunk_bytes) == expected,
                "{threads} threads, chunks of {chunk_bytes}"
            );
        }
    }
}

#[test]
fn corners_with_the_same_bits_are_one_vertex_in_order_of_appearance() {
    let soup = [[0u32, 1, 2], [2, 1, 3], [0x8000_0000, 1, 0]];
    let corner = |k: usize| [soup[k / 3][k % 3], 0, 0];
    for threads in [1, 2, 7] {
        let welded = weld::weld(3, threads, corner);
        assert_eq!(welded.corners, [[0, 1, 2], [2, 1, 3], [4, 1, 0]]);
        assert_eq!(welded.vertices.len(), 5);
        assert!(welded.vertices.x[4].is_sign_negative());
    }
}

#[test]
fn a_binary_file_is_known_by_its_length() {
    let mut file = b"solid, it says".to_vec();
    file.resize(80, b' ');
    file.extend(1u32.to_le_bytes());
    file.resize(HEADER + FACET, b'1');
    assert!(is_binary(&file));
    assert!(!is_binary(b"solid x\nendsolid x\n"));
    assert!(!is_binary(&[b'x'; 200]), "another kind of text");
    assert!(is_binary(&[1; 200]));
    assert!(!is_binary(&[b"solid x", &[0; 200][..]].concat()));
}

#[test]
fn text_may_begin_with_a_byte_order_mark_and_names_may_hold_keywords() {
    let mut text = String::from("\u{feff}solid an_endfacet vertex vertex\n");
    for _ in 0..3 {
        facet(
            &mut text,
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, f32::NAN]],
        );
    }
    let read = |text: &str, chunk_bytes| {
        read_in_chunks(
            text.as_bytes(),
            &MemoryLedger::of(None),
            &ReadOptions::default(),
            chunk_bytes,
        )
    };
    assert!(!is_binary(text.as_bytes()));
    let good = text.replace("NaN", "0");
    let loaded = read(&good, 1).unwrap();
    assert_eq!(loaded.scene.triangles.len(), 6);
    let warnings = read(&text, 1).unwrap().warnings;
    assert_eq!(warnings[0].line, 6, "{warnings:?}");
    assert!(
        warnings[0].message.ends_with("3 triangles are left out"),
        "{warnings:?}"
    );
}
