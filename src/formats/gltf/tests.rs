//! What can only be seen from inside: budgets that are too large for a file of a test.

use super::*;

/// Reads a mesh of `primitives` times the same triangle, shown by `nodes` nodes, when `most` triangles may be made.
/// What is wrong, or how many may still be made.
fn read_within(primitives: usize, nodes: usize, most: u64) -> Result<u64, String> {
    let primitive = r#"{"attributes": {"POSITION": 0}}"#;
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}},
            "buffers": [{{"byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}}],
            "meshes": [{{"primitives": [{}]}}],
            "nodes": [{}]}}"#,
        vec![primitive; primitives].join(", "),
        vec![r#"{"mesh": 0}"#; nodes].join(", "),
    );
    let (folder, options) = (Folder::nowhere(), Options::default());
    let mut report = Report::new(text.as_bytes());
    let parts = container::open(text.as_bytes()).expect("text");
    let mut source = Source::parse(text.as_bytes(), &parts).expect("a document");
    source.load_buffers(None, &folder, &mut report);
    let mut reader = Reader::new(&source, &folder, &options, empty_scene(), report);
    reader.triangles_left = most;
    reader.run(&mut BARE.clone()).unwrap();
    let left = reader.triangles_left;
    match reader.report.finish() {
        Ok(_) => Ok(left),
        Err(errors) => Err(errors.into_iter().map(|error| error.message).collect()),
    }
}

#[test]
fn the_primitives_of_a_mesh_share_what_triangles_may_be_made() {
    assert_eq!(read_within(3, 1, 3), Ok(0));
    let refused = read_within(3, 1, 2).expect_err("too many");
    assert!(
        refused.contains("primitives[2]: 1 more triangles are too many"),
        "{refused}"
    );
}

#[test]
fn a_stored_mesh_is_charged_once() {
    assert_eq!(read_within(2, 5, 3), Ok(1));
}
