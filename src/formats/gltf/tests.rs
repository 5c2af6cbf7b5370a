//! Tests that need access to internals: limits too large for a test file.

use super::*;
use base64::Engine;

/// Reads a mesh of `primitives` times the same triangle, shown by `nodes` nodes, when `most`
/// triangles may be made. Returns the number of triangles that may still be made, or the errors.
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
    let (folder, options) = (Folder::none(), ReadOptions::default());
    let mut report = DiagnosticSink::new(text.as_bytes());
    let parts = container::open(text.as_bytes()).expect("text");
    let mut source = GltfSource::parse(text.as_bytes(), &parts).expect("a document");
    source.load_buffers(None, &folder, &mut report);
    let mut reader = GltfReader::new(&source, &folder, &options, empty_scene(), report);
    reader.triangles_left = most;
    reader.run().unwrap();
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

/// A file with a node for each mesh of `shown`, and meshes of `primitives` times the same primitive
/// of `triangles` triangles. Coordinates are as large as `size`.
fn copies(shown: &[usize], primitives: usize, triangles: usize, size: f32) -> String {
    let floats: Vec<u8> = (0..9 * triangles)
        .flat_map(|k| ((k * 7919 % 1000) as f32 * size / 1000.0).to_le_bytes())
        .collect();
    let rows = 3 * triangles;
    let accessor =
        format!(r#"{{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": {rows}}}"#);
    // Accessors with equal contents count as the same.
    let mesh = |k: usize| {
        let primitive = format!(r#"{{"attributes": {{"POSITION": {}}}}}"#, k % 2);
        format!(
            r#"{{"primitives": [{}]}}"#,
            vec![primitive; primitives].join(", ")
        )
    };
    let meshes = shown.iter().max().map_or(0, |most| most + 1);
    let nodes = shown
        .iter()
        .enumerate()
        .map(|(k, mesh)| format!(r#"{{"mesh": {mesh}, "translation": [{k}, 0, 0]}}"#));
    let length = floats.len();
    let text = base64::engine::general_purpose::STANDARD.encode(&floats);
    format!(
        r#"{{"asset": {{"version": "2.0"}},
            "buffers": [{{"byteLength": {length}, "uri": "data:;base64,{text}"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": {length}}}],
            "accessors": [{accessor}, {accessor}],
            "meshes": [{}],
            "nodes": [{}]}}"#,
        (0..meshes).map(mesh).collect::<Vec<_>>().join(", "),
        nodes.collect::<Vec<_>>().join(", "),
    )
}

fn scene_of(text: &str) -> Scene {
    let read = read(text.as_bytes(), &Folder::none(), &ReadOptions::default());
    read.expect("a scene").scene
}

/// Numbers of triangles, meshes and instances.
fn counts(text: &str) -> [usize; 3] {
    let scene = scene_of(text);
    [
        scene.triangles.len(),
        scene.meshes.len(),
        scene.instances.len(),
    ]
}

#[test]
fn many_meshes_of_one_accessor_are_instances() {
    let each: Vec<usize> = (0..300).collect();
    assert_eq!(counts(&copies(&each, 1, 1000, 1.0)), [1000, 1, 300]);
    // Few copies stay triangles of their own.
    assert_eq!(counts(&copies(&each[..3], 1, 1000, 1.0)), [3000, 0, 0]);
    assert_eq!(counts(&copies(&each, 1, 2, 1.0)), [600, 0, 0]);
    // A mesh that is shown once stays as it is, too.
    let one = copies(&[0], 1, 1000, 1.0);
    assert_eq!(counts(&one), [1000, 0, 0]);
}

#[test]
fn many_primitives_of_one_accessor_are_instances() {
    assert_eq!(counts(&copies(&[0], 300, 1000, 1.0)), [1000, 1, 300]);
    assert_eq!(counts(&copies(&[0, 0], 300, 1000, 1.0)), [1000, 1, 600]);
    assert_eq!(counts(&copies(&[0], 3, 1000, 1.0)), [3000, 0, 0]);
    // A number of instances of nodes times primitives would be worse.
    let often = vec![0; 3000];
    assert_eq!(counts(&copies(&often, 300, 1000, 1.0)), [300_000, 1, 3000]);
}

#[test]
fn copies_beyond_the_comfortable_range_are_placed_where_they_were_baked() {
    let nodes = vec![0; 300];
    for size in [4e9, 1e-10] {
        let placed = scene_of(&copies(&nodes, 1, 1000, size));
        let one = scene_of(&copies(&[0], 1, 1000, size));
        let few = scene_of(&copies(&nodes[..2], 1, 1000, size));
        assert_eq!(
            (placed.triangles.len(), placed.instances.len()),
            (1000, 300)
        );
        assert_eq!((few.triangles.len(), few.instances.len()), (2000, 0));
        // The extent of the first copy, in the file's units.
        let extent = |scene: &Scene| {
            (
                scene.bounds().hi.y / scene.scale,
                scene.bounds().lo.y / scene.scale,
            )
        };
        let (a, b) = (extent(&placed), extent(&one));
        assert!(
            (a.0 - b.0).abs() <= size * 1e-5 && (a.1 - b.1).abs() <= size * 1e-5,
            "{a:?} {b:?}"
        );
    }
}

#[test]
fn rows_and_triangles_count_before_they_are_made() {
    let text = copies(&[0; 3], 1, 1000, 1e-20);
    let refused = |most: u64| {
        let asset_dir = Folder::none().with_limit(Some(most));
        let read = read(text.as_bytes(), &asset_dir, &ReadOptions::default()).is_ok();
        let refused = asset_dir.memory().refusal();
        assert_eq!(read, refused.is_none());
        refused.map(|refused| refused.what)
    };
    assert_eq!(refused(10 << 20), None);
    assert_eq!(
        refused(5 << 10).as_deref(),
        Some("for the rows of the document")
    );
    // The document keeps a text as long as that of the buffers, 48 KiB.
    assert_eq!(
        refused(80 << 10).as_deref(),
        Some("for the buffers in the text")
    );
    assert_eq!(
        refused(200 << 10).as_deref(),
        Some("for 1000 more triangles")
    );
}

/// Checks that neither the stack nor time runs out.
#[test]
fn nodes_may_nest_deeply() {
    let deep = 100_000;
    let nodes = (0..deep).map(|k| {
        if k + 1 < deep {
            format!(r#"{{"children": [{}], "scale": [1, 1, 1]}}"#, k + 1)
        } else {
            r#"{"mesh": 0}"#.to_owned()
        }
    });
    let nodes: Vec<String> = nodes.collect();
    let text = copies(&[0], 1, 1, 1.0);
    let start = text.find(r#""nodes": ["#).expect("nodes") + 10;
    let text = format!("{}{}]}}", &text[..start], nodes.join(","));
    assert_eq!(counts(&text), [1, 0, 0]);
}
