//! Semantics of the records.

use super::{HEAD, read, scene};
use glam::Vec3;
use phalanx::formats::{Options, ReadOptions, load};
use phalanx::scene::{Material, OutputEncoding, Scene};

fn surface(scene: &Scene, prim: u32) -> Material {
    scene.materials.get(scene.prim_material(prim) as usize)
}

#[test]
fn the_prescribed_setting_is_taken() {
    let scene = scene("s 0 0 0 1\n");
    assert_eq!(scene.background, Vec3::new(0.1, 0.2, 0.3));
    assert_eq!((scene.width, scene.height), (4, 4));
    assert_eq!(scene.encoding, OutputEncoding::LINEAR);
    assert_eq!(scene.max_depth, 4, "depth 5, the eye ray's counted");
    assert_eq!(scene.view.eye, Vec3::new(0.0, 0.0, 5.0));
    assert_eq!(scene.view.center, Vec3::ZERO);
    assert_eq!(scene.view.up, Vec3::Y);
}

/// The centre of the first pixel row is seen at half the file's angle from the axis.
#[test]
fn the_angle_spans_the_centres_of_the_outer_rows() {
    for (angle, height) in [(45.0, 4), (45.0, 512), (60.0, 3), (120.0, 2)] {
        let text = HEAD
            .replace("angle 45", &format!("angle {angle}"))
            .replace("resolution 4 4", &format!("resolution 4 {height}"));
        let scene = read(&format!("{text}s 0 0 0 1\n")).scene;
        let edge = libm::tan(f64::from(scene.view.fovy).to_radians() / 2.0);
        let rows = f64::from(height);
        let first_row = edge * (rows - 1.0) / rows;
        let half = libm::atan(first_row).to_degrees();
        assert!(
            (half - angle / 2.0).abs() < 1e-5,
            "{angle}, {height}: {half}"
        );
    }
    let one_row = HEAD.replace("resolution 4 4", "resolution 4 1");
    assert_eq!(read(&one_row).scene.view.fovy, 45.0);
}

#[test]
fn the_parts_of_a_view_come_in_any_order_and_hither_may_be_absent() {
    let text = "v resolution 8 6 angle 30 up 0 0 1 at 1 2 3 from 4 5 6 s 0 0 0 1";
    let scene = read(text).scene;
    assert_eq!((scene.width, scene.height), (8, 6));
    assert_eq!(scene.view.eye, Vec3::new(4.0, 5.0, 6.0));
    assert_eq!(scene.view.center, Vec3::new(1.0, 2.0, 3.0));
}

#[test]
fn tokens_span_lines_and_comments_begin_anywhere() {
    let body = "s 0 0#no space\n0\r\n1 c\n0 0 0 2\n0 0 1 2 # a cylinder\np\n3 0 0 0 1 0 0 0 1 0";
    let scene = scene(body);
    assert_eq!(
        (
            scene.spheres.len(),
            scene.cones.len(),
            scene.triangles.len()
        ),
        (1, 1, 1)
    );
    // Line ends of old Macintoshes end comments too.
    let old = format!("\u{feff}{HEAD}# comment\ns 0 0 0 1\n").replace('\n', "\r");
    assert_eq!(read(&old).scene.spheres.len(), 1);
}

#[test]
fn lights_without_a_colour_share_the_level_with_ambient_light() {
    let body = "f 1 0.5 0.25 0.8 0.3 20 0.4 1.5\ns 0 0 0 1\n";
    for lights in 1..6 {
        let more = "l 1 2 3\n".repeat(lights - 1);
        let scene = scene(&format!("{more}{body}"));
        let n = lights as f64;
        let level = n.sqrt() / (2.0 * n);
        for i in 0..lights {
            assert_eq!(scene.lights.color.get(i), Vec3::splat(level as f32));
            assert_eq!(scene.lights.attenuation.get(i), Vec3::X);
        }
        let material = surface(&scene, 0);
        let kd = Vec3::new(0.8, 0.4, 0.2);
        assert!(material.kd.abs_diff_eq(kd, 1e-7), "{material:?}");
        assert!(
            material.ka.abs_diff_eq(kd * level as f32, 1e-7),
            "{material:?}"
        );
        assert_eq!(material.ks, Vec3::splat(0.3));
        assert_eq!(material.kt, Vec3::splat(0.4));
        assert_eq!((material.shininess, material.ior), (20.0, 1.5));
    }
}

#[test]
fn lights_may_have_a_colour_and_count_all_the_same() {
    let scene = scene("l 1 2 3 .5 .25 0\nl 1 1 1\nl 2 2 2\ns 0 0 0 1\n");
    assert_eq!(scene.lights.len(), 4);
    assert_eq!(scene.lights.color.get(0), Vec3::splat(0.25));
    assert_eq!(scene.lights.color.get(1), Vec3::new(0.5, 0.25, 0.0));
    assert_eq!(scene.lights.position.get(1), Vec3::new(1.0, 2.0, 3.0));
}

/// Lights count even after the shapes.
#[test]
fn all_lights_of_the_file_count() {
    let scene = scene("f 1 1 1 1 0 1 0 1\ns 0 0 0 1\nl 0 0 1\nl 0 0 2\nl 0 0 3\n");
    assert_eq!(surface(&scene, 0).ka, Vec3::splat(0.25));
}

#[test]
fn surfaces_apply_to_the_shapes_that_follow() {
    let scene = scene(
        "s 0 0 0 1\nf 1 0 0 1 0 1 0 1\ns 0 0 0 1\nc 0 0 0 1 0 0 1 1\nf 0 1 0 1 0 1 0 0\n\
         p 3 0 0 0 1 0 0 0 1 0\nf 1 0 0 1 0 1 0 1\ns 0 0 0 1\n",
    );
    assert_eq!(surface(&scene, 1).kd, Vec3::X);
    assert_eq!(surface(&scene, 2).kd, Vec3::X);
    assert_eq!(surface(&scene, 3).kd, Vec3::Y);
    assert_eq!(surface(&scene, 3).ior, 1.0, "0 stands for none");
    assert_eq!(surface(&scene, 4).kd, Vec3::X);
    assert_eq!(scene.materials.len(), 3, "equal surfaces share a row");
}

#[test]
fn shapes_before_any_surface_get_the_users() {
    let given = Material {
        kd: Vec3::new(0.0, 0.0, 1.0),
        ..Material::default()
    };
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("a.NFF");
    std::fs::write(
        &path,
        format!("{HEAD}s 0 0 0 1\nf 1 0 0 1 0 1 0 1\ns 0 0 0 1\n"),
    )
    .unwrap();
    let options = Options {
        read: ReadOptions {
            material: Some(given),
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    let scene = load(&path, &options).unwrap().scene;
    assert_eq!(surface(&scene, 0), given);
    assert_eq!(surface(&scene, 1).kd, Vec3::X);
}

#[test]
fn negative_radii_show_the_inside() {
    let scene = scene("c 0 0 0 -2 0 0 1 -1\nc 0 0 0 2 0 0 1 0\nc 0 0 0 0 0 0 1 -1\n");
    let cones: Vec<_> = (0..3).map(|i| scene.cones.get(i)).collect();
    assert_eq!(
        cones.iter().map(|c| c.inside).collect::<Vec<_>>(),
        [true, false, true]
    );
    assert_eq!((cones[0].base_radius, cones[0].apex_radius), (2.0, 1.0));
    assert_eq!((cones[2].base_radius, cones[2].apex_radius), (0.0, 1.0));
}

#[test]
fn patches_keep_their_normals() {
    let scene = scene("pp 4\n0 0 0 0 0 1\n1 0 0 1 0 1\n1 1 0 0 0 2\n0 1 0 0 1 1\n");
    assert_eq!(scene.triangles.len(), 2);
    let normals = scene.triangles.corner_normals(1).unwrap();
    let expected = [Vec3::Z, Vec3::Z * 2.0, Vec3::new(0.0, 1.0, 1.0)];
    assert_eq!(normals, expected);
}

/// An arrow head, cut from its notch or not at all into triangles that leave the notch empty.
#[test]
fn concave_polygons_keep_their_area() {
    let scene = scene("p 4\n0 0 0\n4 0 0\n1 1 0\n0 4 0\n");
    let area = |i: usize| {
        let [a, b, c] = scene.triangles.corners(i);
        (b - a).cross(c - a).z / 2.0
    };
    let areas = [area(0), area(1)];
    assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
    assert_eq!(areas[0] + areas[1], 4.0);
}

#[test]
fn a_file_without_view_and_lights_is_framed_and_lit() {
    let loaded = read("s 10 20 30 3\n");
    assert_eq!(loaded.notes.len(), 2, "{:?}", loaded.notes);
    assert_eq!(loaded.scene.lights.len(), 2, "a key light and a fill light");
    assert!(!loaded.scene.defaulted.samples, "NFF has one sample");
    assert_eq!(
        loaded.scene.background,
        Vec3::ZERO,
        "NFF says what it is without `b`"
    );
    assert!(
        loaded
            .scene
            .view
            .center
            .abs_diff_eq(Vec3::new(10.0, 20.0, 30.0), 1e-4)
    );
}
