//! Semantics of PLY files.

use super::{FLAT, area_from_z, errors, messages, read, triangles};
use glam::Vec3;

const HEADER: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const BODY: &str = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn ascii(header: &str, body: &str) -> Vec<u8> {
    format!("ply\nformat ascii 1.0\n{header}{body}").into_bytes()
}

/// Numbers of a binary file, in either byte order.
struct BinaryNumbers {
    big: bool,
    all: Vec<u8>,
}

impl BinaryNumbers {
    fn new(big: bool, header: &str) -> BinaryNumbers {
        let order = if big { "big" } else { "little" };
        let all = format!("ply\nformat binary_{order}_endian 1.0\n{header}").into_bytes();
        BinaryNumbers { big, all }
    }

    /// The bytes of a number, given in little-endian order.
    fn put<const N: usize>(mut self, mut little: [u8; N]) -> Self {
        if self.big {
            little.reverse();
        }
        self.all.extend(little);
        self
    }

    fn floats(self, numbers: &[f32]) -> Self {
        numbers
            .iter()
            .fold(self, |bytes, n| bytes.put(n.to_le_bytes()))
    }

    fn ints(self, numbers: &[i32]) -> Self {
        numbers
            .iter()
            .fold(self, |bytes, n| bytes.put(n.to_le_bytes()))
    }
}

const POSITIONS: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

#[test]
fn every_encoding_gives_the_same_triangle() {
    assert_eq!(triangles(&read("ply", &ascii(HEADER, BODY)).scene), FLAT);
    for big in [false, true] {
        let file = BinaryNumbers::new(big, HEADER)
            .floats(&POSITIONS)
            .put([3])
            .ints(&[0, 1, 2]);
        let loaded = read("ply", &file.all);
        assert_eq!(triangles(&loaded.scene), FLAT, "big: {big}");
        assert!(loaded.warnings.is_empty());
    }
}

#[test]
fn numbers_may_have_any_type() {
    let header = "comment x\nobj_info y\nelement vertex 3\nproperty double y\nproperty short x\nproperty uchar extra\nproperty uint z\n\
                  element other 2\nproperty list char double a\nproperty ushort b\n\
                  element face 1\nproperty char first\nproperty list uint ushort vertex_index\nproperty double last\nend_header\n";
    for big in [false, true] {
        let mut file = BinaryNumbers::new(big, header);
        for [x, y] in [[0i16, 0], [1, 0], [0, 1]] {
            file = file
                .put(f64::from(y).to_le_bytes())
                .put(x.to_le_bytes())
                .put([9])
                .put(0u32.to_le_bytes());
        }
        file = file.put([0]).put([1, 0]);
        file = file.put([2]).put([0; 8]).put([0; 8]).put([1, 0]);
        file = file.put([7]).put(3u32.to_le_bytes());
        file = [0u16, 1, 2]
            .iter()
            .fold(file, |f, c| f.put(c.to_le_bytes()))
            .put([0; 8]);
        assert_eq!(triangles(&read("ply", &file.all).scene), FLAT, "big: {big}");
    }
}

#[test]
fn lines_end_in_every_way() {
    let text = String::from_utf8(ascii(HEADER, BODY)).unwrap();
    for end in ["\r\n", "\r"] {
        assert_eq!(
            triangles(&read("ply", text.replace('\n', end).as_bytes()).scene),
            FLAT,
            "{end:?}"
        );
        let mut file = BinaryNumbers::new(false, HEADER).all;
        file = String::from_utf8(file)
            .unwrap()
            .replace('\n', end)
            .into_bytes();
        // The first byte of the body is a line feed, but no line end.
        let positions: Vec<u8> = POSITIONS.iter().flat_map(|n| n.to_le_bytes()).collect();
        file.extend(positions);
        let first = file.len() - 36;
        file[first] = b'\n';
        file.push(3);
        file.extend([0i32, 1, 2].iter().flat_map(|n| n.to_le_bytes()));
        let scene = read("ply", &file).scene;
        assert_eq!(triangles(&scene)[0][1], FLAT[0][1], "{end:?}");
    }
}

#[test]
fn polygons_of_any_count_are_cut() {
    let header = HEADER
        .replace("vertex 3", "vertex 5")
        .replace("face 1", "face 4");
    let positions = [
        [4.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 4.0, 0.0],
        [0.0, 0.0, 0.0],
        [-1.0, -1.0, 0.0],
    ];
    let faces: [&[i32]; 4] = [&[0, 1, 2, 3], &[3, 0, 1, 2], &[0, 1], &[0, 2, 4]];
    let mut text = String::new();
    let mut file = BinaryNumbers::new(true, &header).floats(positions.as_flattened());
    positions
        .iter()
        .for_each(|[x, y, z]| text += &format!("{x} {y} {z}\n"));
    for face in faces {
        let words: Vec<String> = face.iter().map(i32::to_string).collect();
        text += &format!("{} {}\n", face.len(), words.join(" "));
        file = file.put([face.len() as u8]).ints(face);
    }
    for bytes in [ascii(&header, &text), file.all] {
        let loaded = read("ply", &bytes);
        assert_eq!(loaded.scene.triangles.len(), 5);
        assert_eq!(area_from_z(&loaded.scene), 8.0 + 8.0 + 24.0);
        assert!(
            loaded.warnings[0].message.contains("fewer than three"),
            "{:?}",
            loaded.warnings
        );
    }
}

#[test]
fn strips_turn_every_other_triangle() {
    let header = "element vertex 4\nproperty int x\nproperty int y\nproperty int z\n\
                  element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let scene = read(
        "ply",
        &ascii(header, "0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 0 1 2\n"),
    )
    .scene;
    assert_eq!((scene.triangles.len(), area_from_z(&scene)), (3, 3.0));
}

#[test]
fn normals_belong_to_vertices() {
    let header = HEADER.replace(
        "property float z\n",
        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n",
    );
    let header = header
        .replace("vertex 3", "vertex 4")
        .replace("face 1", "face 2");
    let rows = "0 0 0 0 0 1\n1 0 0 1 0 0\n0 1 0 0 2 0\n0 0 1 0 0 0\n3 0 1 2\n3 0 1 3\n";
    let loaded = read("ply", &ascii(&header, rows));
    let t = &loaded.scene.triangles;
    assert_eq!(t.corner_normals(0), Some([Vec3::Z, Vec3::X, Vec3::Y * 2.0]));
    assert_eq!(t.corner_normals(1), None);
    assert!(
        loaded.warnings[0]
            .message
            .starts_with("this normal is zero"),
        "{:?}",
        loaded.warnings
    );
}

#[test]
fn a_vertex_that_is_not_finite_leaves_out_its_faces() {
    let header = HEADER.replace("vertex 3", "vertex 4");
    for (corner, used) in [(2, false), (3, true)] {
        let positions = [&POSITIONS[..], &[0.0, f32::NAN, 0.0]].concat();
        let file = BinaryNumbers::new(false, &header)
            .floats(&positions)
            .put([3])
            .ints(&[0, 1, corner])
            .all;
        let text = |bad: &str| {
            let rows = format!("0 0 0\n1 0 0\n0 1 0\n0 {bad} 0\n3 0 1 {corner}\n");
            ascii(&header, &rows)
        };
        let position = file.len() - 13 - 12;
        assert_eq!(read("ply", &file).warnings[0].offset, position);
        for (file, line) in [(file, 0), (text("nan"), 13), (text("-1.#IND"), 13)] {
            let warnings = &read("ply", &file).warnings[0];
            let part = if used { "1 triangle is left out" } else { "no face uses it" };
            assert!(
                warnings.message.contains(part) && warnings.line == line,
                "{warnings:?}"
            );
        }
    }
}

#[test]
fn counts_and_indices_may_be_numbers_of_any_type() {
    for (count, item) in [("float", "double"), ("double", "float"), ("uchar", "float")] {
        let list = format!("list {count} {item}");
        let header = HEADER.replace("list uchar int", &list);
        assert!(header.contains(&list));
        let put = |file: BinaryNumbers, kind, number: u8| match kind {
            "uchar" => file.put([number]),
            "float" => file.floats(&[number.into()]),
            _ => file.put(f64::from(number).to_le_bytes()),
        };
        let binary = |corners: [u8; 3]| {
            let file = put(
                BinaryNumbers::new(false, &header).floats(&POSITIONS),
                count,
                3,
            );
            corners
                .into_iter()
                .fold(file, |file, corner| put(file, item, corner))
                .all
        };
        let text = |corners: &str| ascii(&header, &format!("0 0 0\n1 0 0\n0 1 0\n{corners}\n"));
        for file in [binary([0, 1, 2]), text("3.0 0.0 1 2e0")] {
            assert_eq!(triangles(&read("ply", &file).scene), FLAT, "{list}");
        }
        for wrong in [binary([0, 1, 3]), text("3 0 1 1.5")] {
            assert_eq!(errors("ply", &wrong).len(), 1, "{list}");
        }
    }
}

#[test]
fn counts_are_believed_only_as_far_as_there_are_bytes() {
    let header = |vertices: &str, faces: &str| {
        HEADER
            .replace("vertex 3", vertices)
            .replace("face 1", faces)
    };
    for (vertices, faces) in [
        ("vertex 4000000000", "face 1"),
        ("vertex 3", "face 18446744073709551615"),
        ("vertex 5", "face 1"),
    ] {
        let header = header(vertices, faces);
        let file = BinaryNumbers::new(false, &header)
            .floats(&POSITIONS)
            .put([3])
            .ints(&[0, 1, 2])
            .all;
        for bytes in [file, ascii(&header, BODY)] {
            let warnings = messages(&errors("ply", &bytes));
            let short = warnings
                .iter()
                .any(|warnings| warnings.contains("the file ends after"));
            assert!(short, "{warnings:?}");
        }
    }
    let header = HEADER.replace("uchar int", "int int");
    for count in [i32::MAX, -1, 4] {
        let file = BinaryNumbers::new(false, &header)
            .floats(&POSITIONS)
            .ints(&[count, 0, 1, 2])
            .all;
        assert_eq!(errors("ply", &file).len(), 1, "{count}");
    }
}

#[test]
fn corners_out_of_range_are_errors_with_their_span() {
    let file = BinaryNumbers::new(true, HEADER)
        .floats(&POSITIONS)
        .put([3])
        .ints(&[0, -1, 2])
        .all;
    let faults = errors("ply", &file);
    assert!(
        faults[0]
            .message
            .starts_with("vertex -1 is out of range: there are 3"),
        "{faults:?}"
    );
    assert_eq!((faults[0].line, faults[0].offset), (0, file.len() - 12));
    let faults = errors("ply", &ascii(HEADER, &BODY.replace("0 1 2", "0 1 3")));
    assert_eq!(faults[0].line, 13, "{faults:?}");
}

#[test]
fn headers_of_any_length_are_answered_soon() {
    let elements: String = (0..200_000).map(|k| format!("element e{k} 0\n")).collect();
    let faults = errors("ply", &ascii(&(elements + HEADER), BODY));
    assert_eq!(faults.len(), 20);
    assert_eq!((faults[0].line, faults[19].line), (1003, 1022));
    assert!(faults[0].message.contains("more than 1000 elements"));
    let faults = errors(
        "ply",
        &ascii(
            &format!("element a 0\n{}\n{HEADER}", "x ".repeat(1000)),
            BODY,
        ),
    );
    assert!(
        faults[0].message.contains("unknown header line `x`"),
        "{faults:?}"
    );
    let long = HEADER.replace("vertex 3", &format!("vertex 3{}", " 4".repeat(1000)));
    let faults = errors("ply", &ascii(&long, BODY));
    assert!(
        faults[0].message.contains("one operand too many"),
        "{faults:?}"
    );
}

const COLORED: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                       property TYPE red\nproperty TYPE green\nproperty TYPE blue\n\
                       element face 1\nproperty list uchar int vertex_indices\nend_header\n";

/// The colours of the first triangle's vertices.
fn colors(scene: &phalanx::scene::Scene) -> [[f32; 3]; 3] {
    let colors = scene.triangles.corner_colors(0).expect("colours");
    colors.map(|color| color.to_array())
}

const RED_GREEN_GREY: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.502_886_5; 3]];

fn assert_near(actual: [[f32; 3]; 3], expected: [[f32; 3]; 3]) {
    for (actual, expected) in actual.as_flattened().iter().zip(expected.as_flattened()) {
        assert!(
            (actual - expected).abs() < 2e-6,
            "{actual} is not {expected}"
        );
    }
}

#[test]
fn colours_of_vertices_are_made_linear() {
    let body = |full: &str, grey: &str| {
        format!("0 0 0 {full} 0 0\n1 0 0 0 {full} 0\n0 1 0 {grey} {grey} {grey}\n3 0 1 2\n")
    };
    for (kind, full, grey) in [
        ("uchar", "255", "188"),
        ("uint8", "255", "188"),
        ("char", "255", "188"),
        ("ushort", "255", "188"),
        ("ushort", "65535", "48316"),
        ("int", "255", "188"),
        ("uint", "4294967295", "3166485692"),
        ("float", "1", "0.7372549"),
        ("double", "1.0", "0.73725490196"),
        ("double", "255.0", "188.0"),
        // Announced as bytes, and written as shares.
        ("uchar", "1.0", "0.7372549"),
    ] {
        let header = COLORED.replace("TYPE", kind);
        let loaded = read("ply", &ascii(&header, &body(full, grey)));
        assert_near(colors(&loaded.scene), RED_GREEN_GREY);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert!(loaded.notes.iter().all(|note| !note.contains("colour")));
    }
    for names in [
        ["diffuse_red", "diffuse_green", "diffuse_blue"],
        ["r", "g", "b"],
    ] {
        let mut header = COLORED.replace("TYPE", "uchar");
        for (name, other) in ["red", "green", "blue"].into_iter().zip(names) {
            header = header.replace(&format!(" {name}\n"), &format!(" {other}\n"));
        }
        assert_near(
            colors(&read("ply", &ascii(&header, &body("255", "188"))).scene),
            RED_GREEN_GREY,
        );
    }
    // Not all three, or in lists.
    for (from, to) in [
        ("property TYPE blue", "property TYPE other"),
        ("TYPE blue", "list uchar TYPE blue"),
    ] {
        let header = COLORED.replace(from, to).replace("TYPE", "uchar");
        let body = body("255", "0");
        let scene = read("ply", &ascii(&header, &body)).scene;
        assert!(scene.triangles.colors.is_empty());
    }
}

#[test]
fn binary_colours_are_those_of_text() {
    let three = [[255u8, 0, 0], [0, 255, 0], [188; 3]];
    let shares = three.map(|row| row.map(|c| f64::from(c) / 255.0));
    let position = |k: usize| &POSITIONS[3 * k..3 * k + 3];
    for big in [false, true] {
        let mut bytes = BinaryNumbers::new(big, &COLORED.replace("TYPE", "uchar"));
        let mut doubles = BinaryNumbers::new(big, &COLORED.replace("TYPE", "double"));
        // A list before the colour takes the slow way.
        let listed = COLORED.replace(
            "property TYPE red",
            "property list uchar uchar x\nproperty TYPE red",
        );
        let mut lists = BinaryNumbers::new(big, &listed.replace("TYPE", "uchar"));
        for k in 0..3 {
            bytes = three[k]
                .into_iter()
                .fold(bytes.floats(position(k)), |b, c| b.put([c]));
            doubles = doubles.floats(position(k));
            doubles = shares[k]
                .into_iter()
                .fold(doubles, |b, c| b.put(c.to_le_bytes()));
            lists = lists.floats(position(k)).put([2]).put([7]).put([8]);
            lists = three[k].into_iter().fold(lists, |b, c| b.put([c]));
        }
        for file in [bytes, doubles, lists] {
            let file = file.put([3]).ints(&[0, 1, 2]);
            assert_near(colors(&read("ply", &file.all).scene), RED_GREEN_GREY);
        }
    }
}

#[test]
fn an_opacity_of_vertices_is_one_warning_in_every_encoding() {
    let warning_of = |kind: &str, alpha: [&str; 3]| {
        let header = COLORED.replace(
            "property TYPE red",
            &format!("property {kind} alpha\nproperty TYPE red"),
        );
        let header = header.replace("TYPE", "uchar");
        let [a, b, c] = alpha;
        let body = format!("0 0 0 {a} 255 0 0\n1 0 0 {b} 9 9 9\n0 1 0 {c} 0 0 0\n3 0 1 2\n");
        let text = read("ply", &ascii(&header, &body));
        let listed = header.replace(
            "property uchar red",
            "property list uchar uchar x\nproperty uchar red",
        );
        let all = [false, true].map(|big| {
            let mut file = BinaryNumbers::new(big, &header);
            let mut lists = BinaryNumbers::new(big, &listed);
            let starts = [file.all.len(), lists.all.len()];
            for (k, alpha) in alpha.into_iter().enumerate() {
                file = file.floats(&POSITIONS[3 * k..3 * k + 3]);
                lists = lists.floats(&POSITIONS[3 * k..3 * k + 3]);
                (file, lists) = match kind {
                    "float" => {
                        let alpha = [alpha.parse().unwrap()];
                        (file.floats(&alpha), lists.floats(&alpha))
                    }
                    _ => {
                        let alpha = [alpha.parse().unwrap()];
                        (file.put(alpha), lists.put(alpha))
                    }
                };
                (file, lists) = (file.put([9; 3]), lists.put([0]).put([9; 3]));
            }
            [(file, starts[0]), (lists, starts[1])].map(|(file, start)| {
                let warning_of = read("ply", &file.put([3]).ints(&[0, 1, 2]).all).warnings;
                let second = warning_of.first().map(|w| w.offset >= start + 16);
                (messages(&warning_of), second)
            })
        });
        let expected = messages(&text.warnings);
        for (warning_of, second) in all.into_iter().flatten() {
            assert_eq!(warning_of, expected, "{kind} {alpha:?}");
            assert_eq!(
                second,
                (!warning_of.is_empty()).then_some(true),
                "{alpha:?}"
            );
        }
        expected
    };
    let one = ["the opacity of this colour is not used"];
    let two = ["2 colours, this one first, have an opacity that is not used"];
    assert_eq!(warning_of("uchar", ["255", "254", "255"]), one);
    assert_eq!(warning_of("uchar", ["255", "0", "128"]), two);
    assert_eq!(warning_of("float", ["1", "0.99", "1"]), one);
    assert_eq!(warning_of("float", ["1", "0", "0.5"]), two);
    for (kind, opaque) in [("uchar", "255"), ("float", "1"), ("float", "255")] {
        assert!(warning_of(kind, [opaque; 3]).is_empty(), "{kind} {opaque}");
    }
    // An alpha beside no colour is some other number.
    let header = COLORED.replace("TYPE red", "uchar alpha");
    let body = "0 0 0 0 0 0\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2\n";
    let loaded = read("ply", &ascii(&header.replace("TYPE", "uchar"), body));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
}

#[test]
fn faces_have_colours_where_vertices_have_none() {
    let header = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                  element face COUNT\nproperty uchar red\nproperty list uchar int vertex_indices\n\
                  property uchar green\nproperty uchar blue\n\
                  element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let vertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let strip = "4 0 1 3 2\n";
    let colors_of = |bytes: &[u8]| {
        let triangles = read("ply", bytes).scene.triangles;
        let color = |k: usize| triangles.corner_colors(k).map(|c| c[1].to_array());
        (0..triangles.len()).map(color).collect::<Vec<_>>()
    };
    let (red, blue) = (Some([1.0, 0.0, 0.0]), Some([0.0, 0.0, 1.0]));
    // A polygon, a face of two corners, and a triangle.
    let faces = "255 4 0 1 2 3 0 0\n7 2 0 1 7 7\n0 3 0 1 2 0 255\n";
    let text = ascii(
        &header.replace("COUNT", "3"),
        &format!("{vertices}{faces}{strip}"),
    );
    assert_eq!(colors_of(&text), [red, red, blue, None, None]);
    let square = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    for big in [false, true] {
        for polygons in [false, true] {
            let header = header.replace("COUNT", if polygons { "3" } else { "2" });
            let mut file = BinaryNumbers::new(big, &header).floats(&square);
            if polygons {
                file = file.put([7]).put([2]).ints(&[0, 1]).put([7]).put([7]);
            }
            file = file.put([255]).put([3]).ints(&[0, 1, 2]).put([0]).put([0]);
            file = file.put([0]).put([3]).ints(&[0, 2, 3]).put([0]).put([255]);
            file = file.ints(&[4, 0, 1, 3, 2]);
            assert_eq!(colors_of(&file.all), [red, blue, None, None]);
        }
    }
    // More numbers than announced are not the colours that were.
    let more = format!("{vertices}{}{strip}", faces.replace('\n', " 5 6\n"));
    let text = ascii(&header.replace("COUNT", "3"), &more);
    assert_eq!(colors_of(&text), [None; 5]);
    // Vertices with colours have the last word.
    let both = header.replace("COUNT", "3").replace(
        "property float z\n",
        "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n",
    );
    let vertices = vertices.replace(" 0\n", " 0 0 255 0\n");
    let text = ascii(&both, &format!("{vertices}{faces}{strip}"));
    assert_eq!(colors_of(&text), [Some([0.0, 1.0, 0.0]); 5]);
}

#[test]
fn rows_may_be_broken_and_joined_and_lines_may_be_comments() {
    let plain = read("ply", &ascii(HEADER, BODY)).scene;
    for (body, warns) in [
        (
            "0 0 0\ncomment made by hand\n\n1 0 0\nobj_info x\n0 1 0\n# 3 0 1 2\n3 0 1 2\ncomment end\n",
            false,
        ),
        ("0 0\n0\n1\n0 0\n0 1 0\n3\n0 1 2\n", true),
        ("0 0\ncomment 7 7 7\n0\n1 0 0\n0 1 0\n3 0 1\n2\n\n", true),
        ("0 0 0 1 0 0\n0 1 0\n3 0 1 2", true),
        ("0 0 0 1 0 0 0 1 0 3 0 1 2", true),
    ] {
        for end in ["\n", "\r", "\r\n"] {
            let text = ascii(HEADER, body);
            let text = String::from_utf8(text).unwrap().replace('\n', end);
            let loaded = read("ply", text.as_bytes());
            assert_eq!(triangles(&loaded.scene), triangles(&plain), "{body:?}");
            let warnings = messages(&loaded.warnings);
            assert_eq!(warnings.len(), usize::from(warns), "{warnings:?}");
            assert!(
                warnings
                    .iter()
                    .all(|m| m.contains("rows and lines do not agree"))
            );
        }
    }
    // A word too few here and one too many there, or too few or too many in the end.
    for body in [
        "0 0\n0 1 0 0\n0 1 0\n3 0 1 2\n",
        "0 0 0\n1 0\n0 1 0 0\n3 0 1 2\n",
        "0 0\n0 1 0 0\n0 1 0\n3 0 1\n",
        "0 0 0 1 0 0\n0 1 0\n3 0 1 2 5\n",
    ] {
        assert!(!errors("ply", &ascii(HEADER, body)).is_empty(), "{body:?}");
    }
}

#[test]
fn a_file_may_begin_with_a_mark_or_blank_lines_and_end_with_anything() {
    let text = String::from_utf8(ascii(HEADER, BODY)).unwrap();
    for before in ["\u{feff}", "\n \n", "\u{feff}\n"] {
        let loaded = read("ply", format!("{before}{text}").as_bytes());
        assert_eq!(triangles(&loaded.scene), FLAT, "{before:?}");
    }
    let mut file = BinaryNumbers::new(false, HEADER).floats(&POSITIONS);
    file = file.put([3]).ints(&[0, 1, 2]).put(*b"more");
    for bytes in [&format!("{text}more\nand more").into_bytes(), &file.all] {
        let loaded = read("ply", bytes);
        assert_eq!(triangles(&loaded.scene), FLAT);
        assert_eq!(loaded.warnings.len(), 1);
    }
    // Blender 2.47 wrote its name without the word for a comment.
    let named = text.replace("element vertex", "Created by somebody\nelement vertex");
    let loaded = read("ply", named.as_bytes());
    assert_eq!(triangles(&loaded.scene), FLAT);
    assert_eq!((loaded.warnings.len(), loaded.warnings[0].line), (1, 3));
    // Numbers that are not used may be none.
    let header = HEADER.replace("float z\n", "float z\nproperty float quality\n");
    let body = BODY
        .replacen("0\n", "0 -nan(ind)\n", 1)
        .replacen("1 0 0\n", "1 0 0 1.#QNAN\n", 1);
    let body = body.replacen("0 1 0\n", "0 1 0 n/a\n", 1);
    assert_eq!(triangles(&read("ply", &ascii(&header, &body)).scene), FLAT);
}
