use super::*;
use std::fmt::Write;

fn options(threads: usize) -> ReadOptions {
    ReadOptions {
        threads,
        ..ReadOptions::default()
    }
}

/// A file with rows of every kind: extra elements and properties, lists, polygons, strips.
fn everything() -> String {
    let mut text = String::from(
        "ply\nformat ascii 1.0\nelement vertex 60\nproperty double z\nproperty uchar red\nproperty list uchar int more\n\
         property float x\nproperty short y\nproperty float nx\nproperty float ny\nproperty float nz\nelement thing 3\n\
         property list int float what\nelement face 40\nproperty int flag\nproperty list ushort uint vertex_index\nelement \
         tristrips 1\nproperty list int int vertex_indices\nend_header\n",
    );
    for k in 0..60 {
        writeln!(text, "0.{k} 7 2 1 {k} {} {} 0 0 {}", k % 10, k / 10, k % 3).unwrap();
    }
    text += "0\n1 2.5\n\n2 1 2\n";
    for k in 0..40 {
        let corners = ["2 1 2", "3 1 2 13", "4 1 2 12 11", "5 1 3 23 22 11"][k % 4];
        writeln!(text, "{k} {corners} \r").unwrap();
    }
    text + "9 0 1 10 11 -1 20 21 30 31"
}

#[test]
fn neither_threads_nor_chunks_change_the_scene() {
    let text = everything();
    let read = |threads, chunk_bytes| {
        let loaded = read_in_chunks(
            text.as_bytes(),
            &Folder::none(),
            &options(threads),
            chunk_bytes,
        )
        .unwrap();
        let scene = format!("{:?} {:?}", loaded.scene.triangles, loaded.scene.view);
        (loaded.scene.prim_count(), scene, loaded.warnings)
    };
    let expected = read(1, CHUNK_BYTES);
    assert_eq!(expected.0, 10 + 20 + 30 + 4);
    for chunk_bytes in [1, 9, 100] {
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
    let text = everything()
        .replace("4 1 2 12 11", "4 1 2 99 11")
        .replace("3 1 2 13", "3 1 x 13");
    let read = |chunk_bytes| {
        read_in_chunks(text.as_bytes(), &Folder::none(), &options(3), chunk_bytes)
            .unwrap_err()
            .diagnostics()
    };
    let expected = read(CHUNK_BYTES);
    assert_eq!(expected.len(), 20);
    assert!(expected.is_sorted_by_key(|d| d.line));
    for chunk_bytes in [1, 30, 300] {
        assert_eq!(read(chunk_bytes), expected, "chunks of {chunk_bytes}");
    }
}
