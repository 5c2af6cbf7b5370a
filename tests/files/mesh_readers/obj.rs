//! Semantics of OBJ and MTL files.

use super::{FLAT, area_from_z, messages, triangles};
use glam::{Vec2, Vec3};
use phalanx::formats::{Loaded, Options, ReadOptions, load};
use phalanx::scene::{Material, Quantize, Scene, Transfer};

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn read(text: &str) -> Loaded {
    super::read("obj", text.as_bytes())
}

fn scene(text: &str) -> Scene {
    read(text).scene
}

#[test]
fn corners_are_numbered_from_one_or_backward() {
    for face in [
        "f 1 2 3",
        "f -3 -2 -1",
        "f 1 -2 3",
        "f 1/ 2// 3/",
        "\tf\t1  2 \\\n3 # last",
    ] {
        assert_eq!(
            triangles(&scene(&format!("{CORNERS}{face}"))),
            FLAT,
            "{face}"
        );
    }
    let later = scene("v 9 9 9\nf 2 3 4\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n");
    assert_eq!(triangles(&later), [FLAT[0], FLAT[0]]);
}

#[test]
fn lines_end_in_every_way() {
    let text = format!("\u{feff}# comment \\\n{CORNERS}f 1 2 3");
    for end in ["\n", "\r\n", "\r", "\n\n \t\n"] {
        assert_eq!(triangles(&scene(&text.replace('\n', end))), FLAT, "{end:?}");
    }
}

#[test]
fn blanks_may_stand_behind_the_mark_of_a_continued_line() {
    for end in ["\\ \n", "\\\t \r\n", "\\  \r", "\\\n"] {
        let text = format!("{CORNERS}f 1 2 {end} 3\n").replace("v 1 0 0", &format!("v 1 {end}0 0"));
        let loaded = read(&text);
        assert_eq!(triangles(&loaded.scene), FLAT, "{end:?}");
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    }
    // An empty line ends it, and a mark within a line continues nothing.
    assert_eq!(
        triangles(&scene(&format!("{CORNERS}f 1 2 3 \\ \n\nf 1 2 3\n"))).len(),
        2
    );
    assert_eq!(
        super::errors("obj", format!("{CORNERS}f 1 2 \\ 3\n").as_bytes()).len(),
        1
    );
}

#[test]
fn numbers_may_carry_signs_points_exponents_and_company() {
    let text = "v +0 -0 .0\nv 1. 0e5 0 1.0\nv 0 +1E0 0 1 .5 .25\nf +1 2 3";
    assert_eq!(triangles(&scene(text)), FLAT);
}

#[test]
fn normals_and_uvs_have_numbers_of_their_own() {
    let text = format!(
        "{CORNERS}vt 0.25 0.75\nvt .5\nvt 1 0 9\nvn 0 0 2\nvn 1 0 0\nf 1/1/1 2/2/2 3/3/1\nf 1 2 3\nf 1//-1 2//1 3//1"
    );
    let t = scene(&text).triangles;
    assert_eq!(
        t.corner_normals(0),
        Some([Vec3::Z * 2.0, Vec3::X, Vec3::Z * 2.0])
    );
    assert_eq!(t.corner_normals(1), None);
    assert_eq!(t.corner_normals(2).map(|n| n[0]), Some(Vec3::X));
    // v is 0 at the bottom in OBJ, at the top in the scene.
    let uvs = [
        Vec2::new(0.25, 0.25),
        Vec2::new(0.5, 1.0),
        Vec2::new(1.0, 1.0),
    ];
    assert_eq!((t.corner_uvs(0, 0), t.corner_uvs(1, 0)), (Some(uvs), None));
}

#[test]
fn polygons_are_cut_without_overlap() {
    let square = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";
    assert_eq!(area_from_z(&scene(&format!("{square}f 1 2 3 4"))), 8.0);
    // From the reflex corner's neighbour a fan would cover more than there is.
    let arrow = "v 4 0 0\nv 1 1 0\nv 0 4 0\nv 0 0 0\n";
    let arrow = scene(&format!("{arrow}f 4 1 2 3\nf 1 2 3 4"));
    assert_eq!((area_from_z(&arrow), arrow.triangles.len()), (16.0, 4));
    for [a, b, c] in triangles(&arrow) {
        assert!(
            (b[0] - a[0]) * (c[1] - a[1]) > (c[0] - a[0]) * (b[1] - a[1]),
            "turned over"
        );
    }
}

#[test]
fn what_has_no_area_is_skipped_with_one_warning_but_degenerate_faces_stay() {
    let loaded = read(&format!(
        "{CORNERS}f 1 2\nl 1 2 3\np 1\nf 1 1 1\nf 1 2 3\nf 2 1"
    ));
    assert_eq!(loaded.scene.triangles.len(), 2);
    let [warning] = &loaded.warnings[..] else {
        panic!("{:?}", loaded.warnings)
    };
    assert!(
        warning.message.starts_with("4 faces of two corners"),
        "{warning:?}"
    );
    assert_eq!(warning.line, 4);
}

#[test]
fn other_statements_are_passed() {
    let loaded = read(&format!("g a b\no thing\ns off\nmg 1\n{CORNERS}f 1 2 3\n"));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let loaded = read(&format!(
        "{CORNERS}cstype bezier\ncurv 0 1 1 2 \\\n3\nend\nwhat\nf 1 2 3\n"
    ));
    let warnings = messages(&loaded.warnings);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(
        warnings[0].contains("curves") && warnings[1].contains("unknown"),
        "{warnings:?}"
    );
}

#[test]
fn coordinates_far_away_and_tiny_ones_are_read() {
    let far = scene("v 1e7 1e7 0\nv 10000001 1e7 0\nv 1e7 10000001 0\nf 1 2 3");
    let there = triangles(&far)[0].map(|corner| far.file_position(corner.into()).to_array());
    assert_eq!(
        there,
        [
            [1e7, 1e7, 0.0],
            [1e7 + 1.0, 1e7, 0.0],
            [1e7, 1e7 + 1.0, 0.0]
        ]
    );
    let tiny = scene("v 0 0 0\nv 1e-12 0 0\nv 0 1e-12 0\nf 1 2 3");
    let [[_, b, _]] = triangles(&tiny)[..] else {
        panic!()
    };
    assert_eq!(b[0], 1e-12 * tiny.scale, "scaled as a whole");
    assert!(tiny.scale > 1.0);
}

#[test]
fn a_vertex_that_is_not_finite_leaves_out_its_faces() {
    let loaded = read(&format!("{CORNERS}v nan 0 0\nv 0 1e39 0\nf 1 2 3"));
    assert_eq!(triangles(&loaded.scene), FLAT);
    assert!(
        loaded.warnings[0].message.starts_with("2 vertices"),
        "{:?}",
        loaded.warnings
    );
    // A polygon is left out as a whole; its triangles become points.
    let loaded = read(&format!(
        "{CORNERS}v nan 0 0\nv 0 inf 0\nf 1 2 3\nf 1 2 5 3\n"
    ));
    let (read, all) = (&loaded.warnings, triangles(&loaded.scene));
    assert_eq!((read[1].line, read[1].column), (5, 3), "{read:?}");
    assert!(
        read[1].message.ends_with("2 triangles are left out"),
        "{read:?}"
    );
    assert_eq!((all[0], all.len()), (FLAT[0], 3));
    assert!(all[1..].iter().all(|[a, b, c]| a == b && b == c), "{all:?}");
}

#[test]
fn a_vertex_beyond_all_others_does_not_make_them_vanish() {
    let far = read(&format!(
        "{CORNERS}v 0 1e25 0\nv 3e38 0 0\nf 1 2 3\nf 1 2 4\n"
    ));
    assert_eq!(triangles(&far.scene)[0], FLAT[0]);
    assert_eq!(far.scene.scale, 1.0);
    assert!(
        far.warnings[0]
            .message
            .contains("beyond 1e20: 1 triangle is left out")
    );
    let large = read("v 0 0 0\nv 1e25 0 0\nv 0 1e25 0\nf 1 2 3\n");
    assert!(large.warnings.is_empty(), "{:?}", large.warnings);
    assert!(super::area_from_z(&large.scene) > 0.0);
}

#[test]
fn unusable_normals_leave_their_faces_flat() {
    let loaded = read(&format!(
        "{CORNERS}vn 0 0 0\nvn 0 0 1\nvn nan 0 1\nf 1//1 2//2 3//2\nf 1//2 2//2 3//2"
    ));
    let t = &loaded.scene.triangles;
    assert_eq!(
        (t.corner_normals(0), t.corner_normals(1)),
        (None, Some([Vec3::Z; 3]))
    );
    assert!(
        loaded.warnings[0].message.starts_with("2 normals"),
        "{:?}",
        loaded.warnings
    );
}

#[test]
fn a_bare_mesh_gets_everything_a_picture_needs() {
    let loaded = read(&format!("{CORNERS}f 1 2 3"));
    let s = &loaded.scene;
    assert_eq!((s.width, s.height, s.max_depth), (1280, 960, 5));
    assert_eq!(
        (s.encoding.transfer, s.encoding.quantize),
        (Transfer::Srgb, Quantize::Round)
    );
    assert_eq!(
        (s.lights.len(), s.materials.len(), loaded.notes.len()),
        (2, 1, 2)
    );
    assert!(s.materials.get(0).kd.min_element() > 0.5);
    // A key light, and a dim fill light from the other side, which nothing blocks.
    let casts = [0, 1].map(|light| s.lights.casts_shadows(light));
    assert_eq!(casts, [true, false]);
    let toward = [0, 1].map(|light| s.lights.position.get(light).normalize());
    assert!(toward[0].dot(toward[1]) < 0.0, "{toward:?}");
    let [key, fill] = [0, 1].map(|light| s.lights.color.get(light));
    assert!(fill.max_element() < key.min_element() / 3.0, "{fill}");
}

const LIBRARY: &str =
    "newmtl red\nKd 1 0 0\nnewmtl big green \nKd 0 1 0\nmap_Kd none.png\nnewmtl unused\nKd 0 0 1\n";

fn beside(files: &[(&str, &str)], options: &Options) -> Loaded {
    let scratch = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(scratch.path().join(name), text).unwrap();
    }
    load(&scratch.path().join("a.obj"), options).unwrap_or_else(|e| panic!("{e}"))
}

fn diffuse(scene: &Scene) -> Vec<Vec3> {
    let row = |&row: &u32| scene.materials.get(row as usize).kd;
    scene.triangles.material.iter().map(row).collect()
}

#[test]
fn materials_hold_until_the_next_one() {
    let text = format!(
        "mtllib my lib.mtl\n{CORNERS}f 1 2 3\nusemtl red\nf 1 2 3\nf 1 2 3\nusemtl red\nusemtl big green\nf 1 2 3\nusemtl nobody\n\
         f 1 2 3\nusemtl red\n"
    );
    let own = Material {
        kd: Vec3::splat(0.25),
        ..Material::default()
    };
    let options = Options {
        read: ReadOptions {
            material: Some(own),
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let loaded = beside(&[("a.obj", &text), ("my lib.mtl", LIBRARY)], &options);
    let expected = [own.kd, Vec3::X, Vec3::X, Vec3::Y, own.kd];
    assert_eq!(diffuse(&loaded.scene), expected);
    assert_eq!(
        loaded.scene.materials.len(),
        3,
        "no row for what is not used"
    );
    let warnings = messages(&loaded.warnings);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(
        warnings[0].contains("none.png") && warnings[1].contains("`nobody`"),
        "{warnings:?}"
    );
}

#[test]
fn several_material_files_are_searched_and_missing_ones_are_warnings() {
    let other = "newmtl red\nKd 0 0 1\nnewmtl white\nKd 1 1 1\n";
    let text = format!(
        "mtllib a.mtl b.mtl\nmtllib ../c.mtl\n{CORNERS}usemtl red\nf 1 2 3\nusemtl white\nf 1 2 3\n"
    );
    let files = [("a.obj", &text[..]), ("a.mtl", LIBRARY), ("b.mtl", other)];
    let loaded = beside(&files, &Options::default());
    assert_eq!(diffuse(&loaded.scene), [Vec3::X, Vec3::ONE]);
    let warnings = messages(&loaded.warnings);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        warnings[0].contains("`../c.mtl`")
            && warnings[0].contains("not in the scene file's folder"),
        "{warnings:?}"
    );
}

#[test]
fn a_broken_statement_of_a_material_is_left_out() {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("a.obj");
    std::fs::write(&path, format!("{CORNERS}mtllib a.mtl\nusemtl a\nf 1 2 3\n")).unwrap();
    std::fs::write(scratch.path().join("a.mtl"), "newmtl a\nKd 1 oops 1\n").unwrap();
    let warnings = load(&path, &Options::default()).unwrap().warnings;
    let message = "a.mtl:2:1: `Kd` is left out (a number is missing, or is none)";
    assert_eq!(warnings[0].message, message);
}
