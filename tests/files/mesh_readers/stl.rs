//! Semantics of STL files.

use super::{FLAT, errors, messages, read, triangles};

/// A binary file of facets with these corners.
fn binary(header: &[u8], facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut file = header.to_vec();
    file.resize(80, 0);
    file.extend((facets.len() as u32).to_le_bytes());
    for corners in facets {
        file.extend([0; 12]);
        file.extend(corners.as_flattened().iter().flat_map(|n| n.to_le_bytes()));
        file.extend([0; 2]);
    }
    file
}

const TEXT: &str = "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";

#[test]
fn text_and_numbers_give_the_same_triangle() {
    for text in [
        TEXT.into(),
        TEXT.to_uppercase(),
        TEXT.replace('\n', "\r\n"),
        TEXT.replace('\n', "\r"),
    ] {
        assert_eq!(
            triangles(&read("stl", text.as_bytes()).scene),
            FLAT,
            "{text:?}"
        );
    }
    for header in ["", "solid but binary"] {
        assert_eq!(
            triangles(&read("stl", &binary(header.as_bytes(), &FLAT)).scene),
            FLAT
        );
    }
}

#[test]
fn corners_are_shared() {
    let facets = vec![FLAT[0]; 100];
    let scene = read("stl", &binary(b"", &facets)).scene;
    assert_eq!(
        (scene.triangles.len(), scene.triangles.vertices.len()),
        (100, 3)
    );
}

#[test]
fn bad_files_are_refused() {
    let mut short = binary(b"", &[FLAT[0]; 3]);
    short.truncate(200);
    assert!(messages(&errors("stl", &short))[0].contains("ends after 2 of 3 facets"));
    let mut nan = FLAT;
    nan[0][2][1] = f32::NAN;
    let said = errors("stl", &binary(b"", &nan));
    assert_eq!((said[0].line, said[0].offset), (0, 84 + 36), "{said:?}");
    let said = errors(
        "stl",
        TEXT.replace("vertex 1 0 0", "vertex 1 inf 0").as_bytes(),
    );
    assert_eq!((said[0].line, said[0].column), (5, 1), "{said:?}");
    for text in ["", "x", "facet"] {
        assert_eq!(errors("stl", text.as_bytes()).len(), 1, "{text}");
    }
}

#[test]
fn what_follows_the_last_facet_and_files_without_any_are_warnings() {
    let mut file = binary(b"", &FLAT);
    file.push(0);
    let loaded = read("stl", &file);
    assert!(
        loaded.warnings[0].message.contains("1 bytes behind"),
        "{:?}",
        loaded.warnings
    );
    let loaded = read("stl", b"solid\nendsolid\n");
    assert!(
        loaded.warnings[0].message.contains("no faces"),
        "{:?}",
        loaded.warnings
    );
}
