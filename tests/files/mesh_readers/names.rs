//! Names of objects and materials in OBJ and STL files.

use super::read;
use phalanx::formats::{Options, Origin, ReadOptions, load, read_bytes};
use phalanx::scene::{MatteIds, Scene, matte_id};

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// Names of each triangle's object and material; `-` for none.
fn named(scene: &Scene) -> Vec<String> {
    let names = (0..scene.prim_count() as u32).map(|prim| scene.prim_names(prim));
    names
        .map(|names| names.map(|name| name.unwrap_or("-")).join(":"))
        .collect()
}

/// Names after statements before each of which a triangle is added, if it is `f`.
fn obj(statements: &str) -> Vec<String> {
    let lines = statements.split(" | ").map(|line| match line {
        "f" => "f 1 2 3",
        line => line,
    });
    let text = format!("{CORNERS}{}\n", lines.collect::<Vec<_>>().join("\n"));
    let scene = read("obj", text.as_bytes()).scene;
    assert_eq!(scene.validate(), Ok(()));
    named(&scene)
}

#[test]
fn objects_are_those_of_o_and_groups_where_there_are_none() {
    assert_eq!(
        obj("f | o a | f | f | o b | f"),
        ["-:-", "a:-", "a:-", "b:-"]
    );
    assert_eq!(obj("g a b | f | G  c | f | g | f"), ["a b:-", "c:-", "-:-"]);
    // As in Blender, groups of an object are parts of it.
    assert_eq!(
        obj("g a | f | o b | g c | f | g d | f"),
        ["a:-", "b:-", "b:-"]
    );
    assert_eq!(obj("o a | g b | o c | f"), ["c:-"]);
    assert_eq!(
        obj("o a | usemtl m | f | usemtl n | f | o b | f"),
        ["a:m", "a:n", "b:n"]
    );
    assert_eq!(
        obj("usemtl m | f | o Cube #1 | f | o | f"),
        ["-:m", "Cube #1:m", "-:m"]
    );
    assert_eq!(obj("o a | f 1 2 3 1 2 | f"), ["a:-", "a:-", "a:-", "a:-"]);
    assert_eq!(obj("f"), ["-:-"]);
}

/// Materials of the same numbers are one row, and keep their names.
#[test]
fn equal_materials_keep_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let mtl = b"newmtl red\nKd 1 0 0\nnewmtl rouge # fr\nKd 1 0 0\nnewmtl r\xf6t\nKd 1 0 0\n";
    std::fs::write(folder.path().join("a.mtl"), mtl).unwrap();
    let uses: [&[u8]; 5] = [b"red", b"rouge", b"red # again", b"r\xf6t", b"none # here"];
    let mut text = format!("mtllib a.mtl\n{CORNERS}").into_bytes();
    for name in uses {
        text.extend([b"usemtl ", name, b"\nf 1 2 3\n"].concat());
    }
    let path = folder.path().join("a.obj");
    std::fs::write(&path, text).unwrap();
    let scene = load(&path, &Options::default()).unwrap().scene;
    assert_eq!(scene.materials.len(), 2);
    assert_eq!(
        named(&scene),
        ["-:red", "-:rouge", "-:red", "-:röt", "-:none"]
    );
    let ids = MatteIds::of(&scene);
    let materials: Vec<u32> = (0..5).map(|prim| ids.find(&scene, prim)[1]).collect();
    assert_eq!(
        materials,
        ["red", "rouge", "red", "röt", "none"].map(matte_id)
    );
}

#[test]
fn solids_are_objects() {
    let facet =
        "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n";
    let text = format!(
        "solid lid of it ; red\n{facet}{facet}endsolid lid\nsolid\n{facet}endsolid\nsolid b {facet}"
    );
    let scene = read("stl", text.as_bytes()).scene;
    assert_eq!(named(&scene), ["lid of it:-", "lid of it:-", "-:-", "b:-"]);
    let bare = read("stl", format!("{facet}{facet}").as_bytes()).scene;
    assert!(bare.names.is_empty() && bare.names.runs.is_empty());
}

/// A scene that is read again for its origin has each name once.
#[test]
fn names_are_those_of_the_last_reading() {
    let text = "v 5e6 0 0\nv 5000001 0 0\nv 5e6 1 0\no a\nusemtl m\nf 1 2 3\no b\nf 3 2 1\n";
    let scene = read("obj", text.as_bytes()).scene;
    assert!(scene.is_moved());
    assert_eq!(named(&scene), ["a:m", "b:m"]);
    assert_eq!(scene.names.len(), 3);
    let options = Options {
        read: ReadOptions {
            origin: Origin::File,
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let unmoved = read_bytes("obj", text.as_bytes(), &options)
        .unwrap()
        .unwrap();
    assert_eq!(unmoved.scene.names.runs, scene.names.runs);
}

/// Names count as memory, so that a file of nothing else is refused in time.
#[test]
fn names_take_memory() {
    let mut text = CORNERS.to_owned();
    for k in 0..2000 {
        text += &format!("o {k}\nf 1 2 3\n");
    }
    let limited = |bytes| {
        let options = Options {
            read: ReadOptions {
                max_memory: Some(bytes),
                ..ReadOptions::default()
            },
            ..Options::default()
        };
        read_bytes("obj", text.as_bytes(), &options).unwrap()
    };
    assert!(limited(1 << 20).is_ok());
    let errors = limited(100_000).unwrap_err();
    assert!(errors[0].message.contains("for the names"), "{errors:?}");
}
