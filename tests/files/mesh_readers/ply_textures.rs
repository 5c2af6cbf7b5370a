//! Texture coordinates of PLY files, and the pictures that their headers name.

use super::messages;
use glam::Vec2;
use phalanx::formats::{LoadError, Loaded, Options, ReadOptions, load, read_bytes};
use phalanx::scene::{Material, NO_TEXTURE, Scene};
use std::path::Path;

const VERTICES: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const CORNERS: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
];
const FACES: &str = "element face 2\nproperty list uchar int vertex_indices\n";
const UVS: [[f32; 2]; 4] = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.25], [0.0, 0.25]];

/// A picture of one colour.
fn picture(color: [u8; 3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&color).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Reads a file with pictures in the same folder.
fn try_beside(file: &[u8], options: &Options) -> Result<Loaded, LoadError> {
    let scratch = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path: &Path = &scratch.path().join(name);
        std::fs::write(path, bytes).unwrap();
    };
    write("red dot.png", &picture([255, 0, 0]));
    write("a_A.png", &picture([255, 0, 0]));
    write("blue.png", &picture([0, 0, 255]));
    write("a.ply", file);
    load(&scratch.path().join("a.ply"), options)
}

fn beside(file: &[u8]) -> Loaded {
    try_beside(file, &Options::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// The header of a file that names pictures.
fn header(encoding: &str, pictures: &[&str], elements: &str) -> String {
    let pictures = pictures
        .iter()
        .map(|p| format!("comment TextureFile {p}\n"));
    let pictures: String = pictures.collect();
    format!("ply\nformat {encoding} 1.0\ncomment made by hand\n{pictures}{elements}end_header\n")
}

const RED: [&str; 1] = ["red dot.png"];

/// A square of two triangles as text; `vertex` and `face` end the rows.
fn ascii(
    pictures: &[&str],
    elements: &str,
    vertex: impl Fn(usize) -> String,
    face: impl Fn([usize; 3]) -> String,
) -> Vec<u8> {
    let mut text = header("ascii", pictures, elements);
    for (k, [x, y, z]) in CORNERS.into_iter().enumerate() {
        text += &format!("{x} {y} {z}{}\n", vertex(k));
    }
    for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
        text += &format!("3 {a} {b} {c}{}\n", face([a, b, c]));
    }
    text.into_bytes()
}

fn none<T>(_: T) -> String {
    String::new()
}

fn uv_of_vertex(k: usize) -> String {
    format!(" {} {}", UVS[k][0], UVS[k][1])
}

fn uvs_of_corners(corners: [usize; 3]) -> String {
    " 6".to_owned() + &corners.map(uv_of_vertex).concat()
}

fn with_uvs_of_vertices(u: &str, v: &str) -> String {
    format!("{VERTICES}property float {u}\nproperty float {v}\n{FACES}")
}

fn with_uvs_of_corners(name: &str) -> String {
    format!("{VERTICES}{FACES}property list uchar float {name}\n")
}

/// The material of a triangle.
fn material(scene: &Scene, triangle: usize) -> Material {
    scene
        .materials
        .get(scene.triangles.material[triangle] as usize)
}

/// The square shows its part of the picture, from the lower left corner upward.
fn assert_shown(loaded: &Loaded) {
    let t = &loaded.scene.triangles;
    let places = |corners: [usize; 3]| corners.map(|k| Vec2::new(UVS[k][0], 1.0 - UVS[k][1]));
    assert_eq!(t.corner_uvs(0, 0), Some(places([0, 1, 2])));
    assert_eq!(t.corner_uvs(1, 0), Some(places([0, 2, 3])));
    let shown = material(&loaded.scene, 0);
    assert_eq!(shown.kd, glam::Vec3::ONE, "the picture is not tinted");
    let texture = &loaded.scene.textures[shown.texture as usize];
    assert_eq!(texture.texels[..], [[255, 0, 0]]);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
}

#[test]
fn coordinates_of_vertices_and_of_corners_show_the_picture() {
    for (u, v) in [
        ("s", "t"),
        ("u", "v"),
        ("texture_u", "texture_v"),
        ("texture_s", "texture_t"),
    ] {
        assert_shown(&beside(&ascii(
            &RED,
            &with_uvs_of_vertices(u, v),
            uv_of_vertex,
            none,
        )));
    }
    for name in ["texcoord", "t"] {
        assert_shown(&beside(&ascii(
            &RED,
            &with_uvs_of_corners(name),
            none,
            uvs_of_corners,
        )));
    }
    let named_after_the_file = ascii(
        &["<this>_A.png"],
        &with_uvs_of_corners("t"),
        none,
        uvs_of_corners,
    );
    assert_shown(&beside(&named_after_the_file));
    // Those of corners go first.
    let both = with_uvs_of_vertices("s", "t") + "property list uchar float texcoord\n";
    let file = ascii(&RED, &both, |_| " 7 7".into(), uvs_of_corners);
    assert_shown(&beside(&file));
}

/// Bytes of floats and of a face's list in either byte order.
fn binary(big: bool, vertex_uvs: bool, list: bool) -> Vec<u8> {
    let mut elements = String::from(VERTICES);
    if list {
        elements += "property list uchar uchar more\n";
    }
    if vertex_uvs {
        elements += "property float s\nproperty double t\n";
    }
    elements += FACES;
    if !vertex_uvs {
        elements += "property list uchar float texcoord\n";
    }
    let order = if big { "big" } else { "little" };
    let mut bytes = header(&format!("binary_{order}_endian"), &RED, &elements).into_bytes();
    let mut put = |little: &[u8]| {
        if big { bytes.extend(little.iter().rev()) } else { bytes.extend(little) }
    };
    for (k, corner) in CORNERS.iter().enumerate() {
        corner.iter().for_each(|c| put(&c.to_le_bytes()));
        if list {
            [1, 9].iter().for_each(|byte| put(&[*byte]));
        }
        if vertex_uvs {
            put(&UVS[k][0].to_le_bytes());
            put(&f64::from(UVS[k][1]).to_le_bytes());
        }
    }
    for corners in [[0usize, 1, 2], [0, 2, 3]] {
        put(&[3]);
        corners.iter().for_each(|&c| put(&(c as i32).to_le_bytes()));
        if !vertex_uvs {
            put(&[6]);
            let numbers = corners.iter().flat_map(|&k| UVS[k]);
            numbers.for_each(|number| put(&number.to_le_bytes()));
        }
    }
    bytes
}

#[test]
fn binary_coordinates_are_those_of_text() {
    for big in [false, true] {
        for (vertex_uvs, list) in [(true, false), (true, true), (false, false)] {
            assert_shown(&beside(&binary(big, vertex_uvs, list)));
        }
    }
}

#[test]
fn polygons_keep_their_coordinates_and_faces_without_them_have_none() {
    let elements = with_uvs_of_corners("texcoord").replace("element face 2", "element face 4");
    let mut text = header("ascii", &RED, &elements);
    for [x, y, z] in CORNERS {
        text += &format!("{x} {y} {z}\n");
    }
    text +=
        "4 0 1 2 3 0\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n3 0 1 2 4 0 0 1 0\n3 0 1 2 6 0 0 1 0 1 inf\n";
    let loaded = beside(text.as_bytes());
    let t = &loaded.scene.triangles;
    assert_eq!(
        (t.corner_uvs(0, 0), t.corner_uvs(1, 0), t.corner_uvs(4, 0)),
        (None, None, None)
    );
    for triangle in 2..4 {
        for (corner, uv) in t
            .corners(triangle)
            .iter()
            .zip(t.corner_uvs(triangle, 0).unwrap())
        {
            assert_eq!((uv.x, 1.0 - uv.y), (corner.x, corner.y));
        }
    }
    assert_eq!(t.corner_uvs(5, 0).unwrap()[2], Vec2::ZERO);
    let warnings = messages(&loaded.warnings);
    assert!(
        warnings[0].contains("not finite") && warnings[1].contains("for each corner"),
        "{warnings:?}"
    );
    assert_eq!((warnings.len(), loaded.warnings[1].line), (2, 19));
}

#[test]
fn several_pictures_are_told_apart_by_the_faces() {
    let both = ["red dot.png", "blue.png"];
    let numbered = with_uvs_of_corners("texcoord") + "property int texnumber\n";
    let numbers =
        |[_, b, _]: [usize; 3]| uvs_of_corners([0, 1, 2]) + if b == 1 { " 1" } else { " 0" };
    let loaded = beside(&ascii(&both, &numbered, none, numbers));
    let first_texel = |triangle| {
        let row = material(&loaded.scene, triangle).texture as usize;
        loaded.scene.textures[row].texels[0]
    };
    assert_eq!([first_texel(0), first_texel(1)], [[0, 0, 255], [255, 0, 0]]);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);

    let out_of_range =
        |[_, b, _]: [usize; 3]| uvs_of_corners([0, 1, 2]) + if b == 1 { " -1" } else { " 2" };
    let scene = beside(&ascii(&both, &numbered, none, out_of_range)).scene;
    assert_eq!([0, 1].map(|k| material(&scene, k).texture), [NO_TEXTURE; 2]);

    // Vertices' coordinates, and rows of a fixed length.
    let numbered = with_uvs_of_vertices("s", "t") + "property int texnumber\n";
    let numbers = |[_, b, _]: [usize; 3]| String::from(if b == 1 { " 1" } else { " 0" });
    let scene = beside(&ascii(&both, &numbered, uv_of_vertex, numbers)).scene;
    assert_ne!(material(&scene, 0).texture, material(&scene, 1).texture);

    let file = ascii(
        &both,
        &with_uvs_of_corners("texcoord"),
        none,
        uvs_of_corners,
    );
    let loaded = beside(&file);
    let warnings = messages(&loaded.warnings);
    assert!(
        warnings.len() == 1 && warnings[0].contains("the first is used"),
        "{warnings:?}"
    );
    assert_eq!(
        (loaded.scene.textures.len(), loaded.warnings[0].line),
        (1, 5)
    );
}

#[test]
fn what_is_not_shown_is_said_and_costs_nothing() {
    let bare = |loaded: &Loaded| {
        let t = &loaded.scene.triangles;
        assert!(t.uvs.is_empty() && t.vertex_uvs.is_empty() && loaded.scene.textures.is_empty());
        assert_ne!(material(&loaded.scene, 0).kd, glam::Vec3::ONE);
    };
    let notes_about =
        |loaded: &Loaded, what: &str| loaded.notes.iter().filter(|n| n.contains(what)).count();
    for (elements, vertex, corners) in [
        (with_uvs_of_vertices("s", "t"), true, false),
        (with_uvs_of_corners("texcoord"), false, true),
    ] {
        let end_vertex = |k| {
            if vertex { uv_of_vertex(k) } else { String::new() }
        };
        let end_face = |c| {
            if corners { uvs_of_corners(c) } else { String::new() }
        };
        let loaded = beside(&ascii(&[], &elements, end_vertex, end_face));
        bare(&loaded);
        assert_eq!(
            notes_about(&loaded, "names no picture"),
            1,
            "{:?}",
            loaded.notes
        );
        let loaded = beside(&ascii(&["none.png"], &elements, end_vertex, end_face));
        bare(&loaded);
        let warnings = messages(&loaded.warnings);
        assert!(
            warnings.len() == 1 && warnings[0].contains("`none.png` is left out"),
            "{warnings:?}"
        );
        let outside = ascii(&["../../etc/none.png"], &elements, end_vertex, end_face);
        let warnings = messages(&beside(&outside).warnings);
        assert!(
            warnings.len() == 1 && warnings[0].contains("not in the scene file's folder"),
            "{warnings:?}"
        );
    }
    let loaded = beside(&ascii(&RED, &format!("{VERTICES}{FACES}"), none, none));
    bare(&loaded);
    assert_eq!(
        notes_about(&loaded, "has no texture coordinates"),
        1,
        "{:?}",
        loaded.notes
    );
    let plain = beside(&ascii(&[], &format!("{VERTICES}{FACES}"), none, none));
    assert_eq!(notes_about(&plain, "texture"), 0);
}

#[test]
fn coordinates_of_corners_count_against_the_memory() {
    // Two bytes per corner become more than eight.
    let faces = 50_000;
    let elements = format!(
        "{VERTICES}element face {faces}\nproperty list uchar uchar vertex_indices\n\
         property list uchar uchar texcoord\n"
    );
    let mut bytes = header("binary_little_endian", &RED, &elements).into_bytes();
    let corners = CORNERS.as_flattened().iter().flat_map(|c| c.to_le_bytes());
    bytes.extend(corners);
    for _ in 0..faces {
        bytes.extend([3, 0, 1, 2, 6, 0, 0, 1, 0, 1, 1]);
    }
    let within = |max_memory| {
        try_beside(
            &bytes,
            &Options {
                read: ReadOptions {
                    max_memory: Some(max_memory),
                    ..ReadOptions::default()
                },
                ..Options::default()
            },
        )
    };
    assert!(within(6 << 20).is_ok());
    assert!(matches!(within(2 << 20), Err(LoadError::Memory { .. })));
}

#[test]
fn a_header_of_too_many_pictures_is_refused() {
    let names = vec!["a.png"; 1001];
    let file = ascii(&names, &with_uvs_of_vertices("s", "t"), uv_of_vertex, none);
    let errors = read_bytes("ply", &file, &Options::default())
        .unwrap()
        .unwrap_err();
    assert!(
        errors[0].message.contains("more than 1000 pictures"),
        "{errors:?}"
    );
}
