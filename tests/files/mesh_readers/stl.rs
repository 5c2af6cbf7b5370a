//! Semantics of STL files.

use super::{FLAT, area_from_z, errors, messages, read, triangles};
use glam::Vec3;
use phalanx::formats::{Options, Overrides, ReadOptions, UpAxis, read_bytes};
use phalanx::scene::Material;

/// A binary file of facets with these vertices.
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
    short.truncate(120);
    assert!(messages(&errors("stl", &short))[0].contains("within a facet, after 0 of 3 facets"));
    // Something else than a mesh.
    assert!(
        messages(&errors("stl", &[1, 0xff, 0xff, 0x7f].repeat(99)))[0].contains("within a facet")
    );
    let mut nan = FLAT;
    nan[0][2][1] = f32::NAN;
    let warnings = read("stl", &binary(b"", &nan)).warnings;
    assert_eq!(
        (warnings[0].line, warnings[0].offset),
        (0, 84 + 36),
        "{warnings:?}"
    );
    let infinite = TEXT.replace("vertex 1 0 0", "vertex 1 inf 0");
    let warnings = read("stl", infinite.as_bytes()).warnings;
    assert_eq!(
        (warnings[0].line, warnings[0].column),
        (5, 1),
        "{warnings:?}"
    );
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

/// A text file with facets in this form.
const SQUARE: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n\
                      facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";

#[test]
fn text_is_read_as_it_is_written_out_there() {
    let square = triangles(&read("stl", SQUARE.as_bytes()).scene);
    assert_eq!(square.len(), 2);
    let commented = SQUARE.replace('\n', " # a comment, endfacet\n  // another\n ; a third\n");
    for text in [
        SQUARE
            .replace("endloop", "end loop")
            .replace("endsolid", "end solid"),
        SQUARE.replace("endfacet", "END\tFACET"),
        SQUARE.replace("facet normal 0 0 1", "facet"),
        SQUARE.replace("normal 0 0 1", "normal"),
        SQUARE.replace("0 0 1\nouter", "-nan(ind) 1.#QNAN -1.#IND\nouter"),
        SQUARE.replace("0 0 1\nouter", "nan(snan) +Inf 1e999\nouter"),
        SQUARE.replace('\n', " "),
        SQUARE.replace('\n', " ").to_uppercase(),
        SQUARE.replace('\n', "\r"),
        SQUARE.replace("solid a", "solid"),
        SQUARE.replace("solid a", "solid a facet of # glass"),
        SQUARE.replace(" a\n", " Bad N\u{e4}me endfacet (1)\n"),
        format!("\u{feff}\n\n  {SQUARE}\0\0\x1a"),
        format!("# from somewhere\n\n{commented}"),
    ] {
        for ending in ["", "\n\n\t "] {
            let loaded = read("stl", format!("{text}{ending}").as_bytes());
            assert_eq!(triangles(&loaded.scene), square, "{text:?}");
            assert!(
                loaded.warnings.is_empty(),
                "{text:?}: {:?}",
                loaded.warnings
            );
        }
    }
    let twice = format!("{SQUARE}{SQUARE}");
    for text in [&twice, &twice.replace('\n', " ")] {
        assert_eq!(read("stl", text.as_bytes()).scene.triangles.len(), 4);
    }
}

#[test]
fn text_that_is_no_facet_is_ignored_with_a_warning() {
    for (text, part, line) in [
        (
            format!("{SQUARE}That was all.\n"),
            "up to the next facet",
            17,
        ),
        (
            SQUARE.replace("facet normal", "color 1 0 0\nfacet normal"),
            "2 pieces of text between facets",
            2,
        ),
        (
            SQUARE.replacen("solid a\n", "", 1),
            "lacks its first line",
            1,
        ),
        (
            format!("{SQUARE}facet normal 0 0 1\nouter loop\nvertex 1 2"),
            "within this facet",
            19,
        ),
    ] {
        let loaded = read("stl", text.as_bytes());
        assert_eq!(loaded.scene.triangles.len(), 2, "{text:?}");
        let warnings = &loaded.warnings[0];
        assert!(warnings.message.contains(part), "{warnings:?}");
        assert_eq!(
            (loaded.warnings.len(), warnings.line),
            (1, line),
            "{warnings:?}"
        );
    }
    // The words of a facet whose beginning is lost.
    let lost = SQUARE.replacen("facet normal", "facte normal", 1);
    let warnings = errors("stl", lost.as_bytes());
    assert_eq!((warnings.len(), warnings[0].line), (1, 2), "{warnings:?}");
}

/// A binary file with this count, of two facets with data after each.
fn counted(count: u32, data: &[&[u8]]) -> Vec<u8> {
    let mut file = vec![b' '; 80];
    file.extend(count.to_le_bytes());
    let facet = &binary(b"", &FLAT)[84..132];
    for payload in data {
        file.extend(facet);
        file.extend((payload.len() as u16).to_le_bytes());
        file.extend(*payload);
    }
    file
}

#[test]
fn the_length_decides_how_many_facets_there_are() {
    let complete = [FLAT[0]; 2];
    for (file, part) in [
        (counted(2, &[b"", b""]), ""),
        (
            counted(0, &[b"", b""]),
            "2 facets by its length, and announces 0",
        ),
        (counted(1, &[b"", b""]), "announces 1"),
        (counted(u32::MAX, &[b"", b""]), "announces 4294967295"),
        // Data after facets, as many bytes as their words say.
        (counted(2, &[b"ABCD", b"ABCD"]), ""),
        (counted(2, &[b"", b"123456789"]), ""),
        (counted(2, &[&[7; 25], &[7; 25]]), ""),
        (
            counted(7, &[b"ABC", b"ABCD"]),
            "2 facets by its length, and announces 7",
        ),
        (
            [counted(2, &[b"", b""]), vec![9; 60]].concat(),
            "60 bytes behind",
        ),
        (
            [counted(3, &[b"", b""]), vec![0; 20]].concat(),
            "after 2 of 3 facets",
        ),
        (
            [counted(0, &[b"", b""]), vec![0; 20]].concat(),
            "after 2 of 0 facets",
        ),
    ] {
        let loaded = read("stl", &file);
        assert_eq!(triangles(&loaded.scene), complete, "{part}");
        let warnings = messages(&loaded.warnings);
        match part {
            "" => assert!(warnings.is_empty(), "{warnings:?}"),
            _ => assert!(
                warnings.len() == 1 && warnings[0].contains(part),
                "{warnings:?}"
            ),
        }
        assert_eq!(loaded.scene.triangles.colors.len(), 0);
    }
    let mut bad = counted(2, &[b"ABCD", b"ABCD"]);
    bad[84 + 54 + 36..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(read("stl", &bad).warnings[0].offset, 84 + 54 + 36);
}

#[test]
fn facets_have_the_colours_of_both_dialects() {
    let mut file = binary(b"", &[FLAT[0]; 3]);
    let words = |file: &mut Vec<u8>, words: [u16; 3]| {
        for (k, word) in words.into_iter().enumerate() {
            file[84 + 50 * k + 48..][..2].copy_from_slice(&word.to_le_bytes());
        }
    };
    let colors = |file: &[u8]| {
        let triangles = read("stl", file).scene.triangles;
        [0, 1, 2].map(|k| triangles.corner_colors(k).map(|c| c[2].to_array()))
    };
    assert_eq!(colors(&file), [None; 3]);
    let (red, blue) = (Some([1.0, 0.0, 0.0]), Some([0.0, 0.0, 1.0]));
    words(&mut file, [0xfc00, 0x801f, 0]);
    // The grey of all meshes, over the white beneath colours.
    let grey = Some([0.75, 0.73, 0.70]);
    assert_eq!(colors(&file), [red, blue, grey]);
    words(&mut file, [0xfc00, 0x001f, 0]);
    assert_eq!(colors(&file), [None; 3]);
    file[..10].copy_from_slice(b"COLOR=\xff\0\0\xff");
    words(&mut file, [0x8000, 0x7c00, 0x001f]);
    assert_eq!(colors(&file), [red, blue, red]);
}

#[test]
fn colours_lie_over_white_and_no_colour_over_grey() {
    let mut file = binary(b"COLOR=\xff\xff\xff\xff", &FLAT);
    let white = read("stl", &file).scene;
    assert_eq!(white.materials.get(0).kd, Vec3::ONE);
    assert_eq!(white.triangles.corner_colors(0), Some([Vec3::ONE; 3]));
    file[..6].fill(b' ');
    let grey = read("stl", &file).scene;
    assert_eq!(grey.materials.get(0).kd, Vec3::new(0.75, 0.73, 0.70));
    assert_eq!(grey.triangles.corner_colors(0), None);
    // The user's material is that of facets without a colour.
    let mut file = binary(b"", &[FLAT[0]; 2]);
    file[84 + 48..][..2].copy_from_slice(&0xfc00_u16.to_le_bytes());
    let options = Options {
        read: ReadOptions {
            material: Some(Material::DEFAULT),
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let scene = read_bytes("stl", &file, &options).unwrap().unwrap().scene;
    assert_eq!(scene.materials.get(0), Material::DEFAULT);
    assert_eq!(scene.triangles.corner_colors(0), Some([Vec3::X; 3]));
    assert_eq!(scene.triangles.corner_colors(1), None);
}

#[test]
fn text_with_control_characters_is_text() {
    let square = triangles(&read("stl", SQUARE.as_bytes()).scene);
    for text in [
        SQUARE.replace("solid a", "solid a\x01\x7f"),
        SQUARE.replace("vertex 1 0 0", "vertex 1 0 \x10 0"),
        SQUARE.to_uppercase().replacen('\n', "\n\x08", 3),
    ] {
        let loaded = read("stl", text.as_bytes());
        assert_eq!(triangles(&loaded.scene), square, "{text:?}");
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    }
}

#[test]
fn cut_off_binary_files_are_drawn_whatever_their_header_says() {
    let header = b"solid of vertex and VERTEX, outer loop, endfacet\0";
    let mut file = binary(header, &[FLAT[0]; 20]);
    file.truncate(84 + 19 * 50 + 7);
    let loaded = read("stl", &file);
    assert_eq!(triangles(&loaded.scene), [FLAT[0]; 19]);
    assert!(loaded.warnings[0].message.contains("after 19 of 20 facets"));
    // A few wild numbers are left out; if there are many, it is something else than a mesh.
    let mut wild = |facets: usize| {
        for facet in 0..facets {
            file[84 + 50 * facet + 12..][..4].copy_from_slice(&1e30_f32.to_le_bytes());
        }
        read_bytes("stl", &file, &Options::default()).unwrap()
    };
    let warnings = messages(&wild(5).expect("a scene").warnings);
    assert!(
        warnings[0].ends_with("5 triangles are left out"),
        "{warnings:?}"
    );
    let warnings = wild(6).expect_err("no scene")[0].message.clone();
    assert!(warnings.contains("within a facet"), "{warnings}");
}

#[test]
fn the_third_axis_points_up_unless_the_user_says_otherwise() {
    let read_with = |up| {
        let options = Options {
            look: Overrides {
                up,
                ..Overrides::default()
            },
            ..Options::default()
        };
        let loaded = read_bytes("stl", SQUARE.as_bytes(), &options)
            .unwrap()
            .unwrap();
        let is_noted = loaded.notes.iter().any(|note| note.contains("Z-up"));
        (loaded.scene.view.up.to_array(), is_noted)
    };
    assert_eq!(read_with(None), ([0.0, 0.0, 1.0], true));
    assert_eq!(read_with(Some(UpAxis::Y)), ([0.0, 1.0, 0.0], false));
}

#[test]
fn words_behind_keywords_and_corners_beyond_three_are_read() {
    let read = |rest: &str| {
        let text = format!("solid\nfacet normal 0 0 1 0 up\nouter loop\n{rest}endsolid\n");
        let loaded = read("stl", text.as_bytes());
        (
            area_from_z(&loaded.scene),
            loaded.scene.triangles.len(),
            messages(&loaded.warnings),
        )
    };
    let corners = "vertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n";
    let ends = "endloop of 3\nendfacet of 1\n";
    let (area, count, _) = read(&format!("{corners}{ends}"));
    assert_eq!((area, count), (1.0, 1));
    let quad = format!("{corners}vertex 0 1 0\n{ends}");
    assert_eq!((read(&quad).0, read(&quad).1), (2.0, 2));
    for bad in ["nan", "1.#QNAN", "-nan(ind)", "1e999", "-1.#INF00"] {
        let more = format!("facet\nouter loop\n{corners}endloop\nendfacet\n");
        let lost = format!("{quad}{}", more.replacen("1 0 0", &format!("1 {bad} 0"), 1));
        let (area, _, messages) = read(&lost);
        assert_eq!(area, 2.0, "{bad}");
        assert!(
            messages
                .iter()
                .any(|s| s.ends_with("1 triangle is left out")),
            "{bad}: {messages:?}"
        );
    }
}
