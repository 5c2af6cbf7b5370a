//! Semantics of a valid file.

use super::{HEAD, read, scene};
use glam::Vec3;
use phalanx::formats::read_test;
use phalanx::scene::{LightShape, PrimKind, Quantize, Scene, Transfer};

fn center(scene: &Scene, sphere: usize) -> Vec3 {
    scene.spheres.center.get(sphere)
}

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() <= 1e-6 * b.length().max(1.0)
}

#[test]
fn settings_reach_the_scene() {
    let text = "size 320 200\nmaxdepth 7\noutput my picture.png  \ncamera 1 2 3 4 5 6 0 1 0 30\n";
    let scene = read_test(text).unwrap().scene;
    assert_eq!((scene.width, scene.height, scene.max_depth), (320, 200, 7));
    assert_eq!(scene.output.as_deref(), Some("my picture.png"));
    assert_eq!(scene.view.eye, Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(scene.view.center, Vec3::new(4.0, 5.0, 6.0));
    assert_eq!((scene.view.up, scene.view.fovy), (Vec3::Y, 30.0));
}

#[test]
fn defaults_are_those_of_the_format() {
    let scene = scene("sphere 0 0 0 1\npoint 0 0 9 1 1 1\n");
    assert_eq!((scene.max_depth, scene.output.as_deref()), (5, None));
    assert_eq!(scene.encoding.transfer, Transfer::None);
    assert_eq!(scene.encoding.quantize, Quantize::Floor);
    assert_eq!((scene.background, scene.scale), (Vec3::ZERO, 1.0));
    let m = &scene.materials;
    assert_eq!(m.len(), 1);
    assert_eq!(m.ka.get(0), Vec3::splat(0.2));
    for column in [&m.ke, &m.kd, &m.ks, &m.kt] {
        assert_eq!(column.get(0), Vec3::ZERO);
    }
    assert_eq!((m.shininess[0], m.ior[0]), (1.0, 1.0));
    assert_eq!(scene.lights.attenuation.get(0), Vec3::X);
}

#[test]
fn line_ends_comments_tabs_and_signs_do_not_matter() {
    let plain = "size 4 4\ncamera 0 0 5 0 0 0 0 1 0 45\nambient 0.5 1 1\nsphere 1 2 3 0.5\n";
    let fancy = "\u{feff}# first\r\n\r\n  size\t+4 4 # pixels\r\n#camera 1 2\r\n\tcamera 0 0 5 0 0 0 0 +1 0 45\t\r\n\
                 ambient .5 +1. 1e0 #\r\n   # indented\r\nsphere 1 2 3 +.5";
    let (plain, fancy) = (read_test(plain).unwrap(), read_test(fancy).unwrap());
    assert_eq!(format!("{:?}", plain.scene), format!("{:?}", fancy.scene));
    assert!(fancy.warnings.is_empty());
}

#[test]
fn lights_with_an_area_take_transform_and_attenuation() {
    let scene = scene(
        "attenuation 0 1 2\ntranslate 1 2 3\nrotate 0 0 1 90\nscale -2 2 2\nspherelight 1 0 0 0.5 1 2 3\n\
         scale 1 3 1\nrectlight 0 0 1 1 0 0 0 1 0 4 5 6\npoint 0 0 0 1 1 1\n",
    );
    let lights = &scene.lights;
    assert_eq!(lights.shape(0), LightShape::Sphere(1.0));
    assert_eq!(lights.position.get(0), Vec3::new(1.0, 0.0, 3.0));
    assert_eq!(lights.color.get(0), Vec3::new(1.0, 2.0, 3.0));
    let edges = [Vec3::new(0.0, -2.0, 0.0), Vec3::new(-6.0, 0.0, 0.0)];
    assert_eq!(lights.shape(1), LightShape::Rectangle(edges));
    assert_eq!(lights.position.get(1), Vec3::new(1.0, 2.0, 5.0));
    assert_eq!(lights.center(1), Vec3::new(-2.0, 1.0, 5.0));
    assert_eq!(lights.color.get(1), Vec3::new(4.0, 5.0, 6.0));
    assert_eq!(lights.shape(2), LightShape::Point);
    for light in 0..3 {
        assert_eq!(lights.attenuation.get(light), Vec3::new(0.0, 1.0, 2.0));
    }
}

#[test]
fn the_last_transform_declared_acts_first() {
    let moved = scene("translate 1 2 3\nscale 2 2 2\nsphere 1 1 1 1\n");
    assert_eq!(center(&moved, 0), Vec3::new(3.0, 4.0, 5.0));
    assert_eq!(moved.spheres.radius[0], 2.0);
    let scaled = scene("scale 2 2 2\ntranslate 1 2 3\nsphere 1 1 1 1\n");
    assert_eq!(center(&scaled, 0), Vec3::new(4.0, 6.0, 8.0));
}

#[test]
fn rotations_are_counter_clockwise_and_quarter_turns_exact() {
    for (turn, expected) in [
        ("0 0 1 90", Vec3::new(-2.0, 1.0, 3.0)),
        ("0 0 5 -270", Vec3::new(-2.0, 1.0, 3.0)),
        ("0 0 1 180", Vec3::new(-1.0, -2.0, 3.0)),
        ("0 0 -1 90", Vec3::new(2.0, -1.0, 3.0)),
        ("1 0 0 90", Vec3::new(1.0, -3.0, 2.0)),
        ("0 1 0 450", Vec3::new(3.0, 2.0, -1.0)),
        ("0 1 0 -90", Vec3::new(-3.0, 2.0, 1.0)),
    ] {
        let scene = scene(&format!("rotate {turn}\nsphere 1 2 3 1\n"));
        assert_eq!(center(&scene, 0), expected, "{turn}");
    }
    let quarter = scene("rotate 0 0 1 90\nsphere 1 0 0 1\n");
    assert_eq!(center(&quarter, 0), Vec3::Y, "and not nearly so");
    let third = scene("rotate 1 1 1 120\nsphere 1 2 3 1\n");
    assert!(near(center(&third, 0), Vec3::new(3.0, 1.0, 2.0)));
    let degrees = 37.0f64;
    let (sin, cos) = (
        libm::sin(degrees.to_radians()),
        libm::cos(degrees.to_radians()),
    );
    let turned = scene("rotate 0 0 1 37\nsphere 1 0 0 1\n");
    assert_eq!(center(&turned, 0), Vec3::new(cos as f32, sin as f32, 0.0));
}

#[test]
fn pop_returns_to_what_was_pushed() {
    let scene = scene(
        "translate 1 0 0\npushTransform\ntranslate 0 1 0\npushTransform\nscale 3 3 3\nsphere 0 0 1 1\n\
         popTransform\nsphere 0 0 1 1\npopTransform\nsphere 0 0 1 1\n",
    );
    assert_eq!(center(&scene, 0), Vec3::new(1.0, 1.0, 3.0));
    assert_eq!(center(&scene, 1), Vec3::new(1.0, 1.0, 1.0));
    assert_eq!(center(&scene, 2), Vec3::new(1.0, 0.0, 1.0));
    assert_eq!(scene.spheres.radius, [3.0, 1.0, 1.0]);
}

#[test]
fn similarities_leave_spheres_round() {
    for similarity in [
        "",
        "scale 2 2 2",
        "scale 2 -2 2",
        "rotate 1 2 3 77\nscale 2 2 2\nrotate 3 1 0 12",
        "scale 4 1 1\nscale .5 2 2",
    ] {
        let scene = scene(&format!("{similarity}\nsphere 0 0 0 1.5\n"));
        assert_eq!(scene.prims[0].kind(), PrimKind::Sphere, "{similarity}");
        let expected = if similarity.is_empty() { 1.5 } else { 3.0 };
        assert_eq!(scene.spheres.radius[0], expected, "{similarity}");
    }
    // A stack of thousands of rotations gathers rounding errors, but none that counts.
    let spun = scene(&format!(
        "{}sphere 0 0 0 1\n",
        "rotate 1 2 3 33.3\n".repeat(1000)
    ));
    assert_eq!(spun.prims[0].kind(), PrimKind::Sphere);
    // One part in 2^23, the least that f32 operands can express, counts.
    let bent = scene("scale 1 1 1.0000001\nsphere 0 0 0 1\n");
    assert_eq!(bent.prims[0].kind(), PrimKind::Ellipsoid);
}

#[test]
fn other_maps_make_ellipsoids_with_both_maps() {
    let scene = scene("translate 1 2 3\nrotate 0 0 1 30\nscale 2 3 4\nsphere 1 -1 .5 .5\n");
    assert_eq!(scene.prims[0].kind(), PrimKind::Ellipsoid);
    let apply = |[x, y, z, t]: [Vec3; 4], p: Vec3| x * p.x + y * p.y + z * p.z + t;
    let to_world = scene.ellipsoids.world_columns(0);
    let to_object = scene.ellipsoids.object_columns(0);
    // M·(c + r·(0, 0, 1)) by hand: 30 degrees turn (2, -3) into (√3 + 1.5, 1 - 1.5·√3).
    let root = 3.0f32.sqrt();
    let top = Vec3::new(1.0 + root + 1.5, 2.0 + 1.0 - 1.5 * root, 3.0 + 4.0);
    assert!(near(apply(to_world, Vec3::Z), top));
    for p in [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(0.577)] {
        assert!(near(apply(to_object, apply(to_world, p)), p), "{p}");
    }
}

#[test]
fn triangles_take_the_transform_at_their_own_line() {
    let scene = scene(
        "maxverts 3\nvertex 0 0 0\ntranslate 0 0 7\nvertex 1 0 0\nvertex 0 1 0\ntri 0 1 2\n\
         scale 2 2 2\ntri 2 1 0\n",
    );
    let z = Vec3::new(0.0, 0.0, 7.0);
    assert_eq!(scene.triangles.corners(0), [z, z + Vec3::X, z + Vec3::Y]);
    let doubled = [z + 2.0 * Vec3::Y, z + 2.0 * Vec3::X, z];
    assert_eq!(scene.triangles.corners(1), doubled);
    assert_eq!(scene.triangles.corner_normals(0), None);
}

#[test]
fn vertices_with_normals_are_a_pile_of_their_own() {
    let scene = scene(
        "vertex 9 9 9\nvertex 9 9 9\nvertex 9 9 9\nmaxvertnorms 3\n\
         vertexnormal 0 0 0 1 1 0\nvertexnormal 1 0 0 0 0 5\nvertexnormal 0 1 0 0 1 0\n\
         rotate 0 0 1 90\nscale 2 1 1\ntrinormal 0 1 2\ntri 0 1 2\n",
    );
    let [a, b, c] = scene.triangles.corners(0);
    assert_eq!([a, b, c], [Vec3::ZERO, 2.0 * Vec3::Y, -Vec3::X]);
    let normals = scene.triangles.corner_normals(0).unwrap();
    // The inverse transpose of scale(2, 1, 1) takes (1, 1, 0) to (1/2, 1, 0); then a quarter turn.
    let tilted = Vec3::new(-1.0, 0.5, 0.0).normalize();
    assert!(near(normals[0], tilted), "{normals:?}");
    assert!(near(normals[1], Vec3::Z) && near(normals[2], -Vec3::X));
    assert_eq!(scene.triangles.corners(1)[0], Vec3::new(-9.0, 18.0, 9.0));
}

#[test]
fn primitives_capture_the_material_and_share_equal_ones() {
    let scene = scene(
        "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
         ambient .1 .2 .3\ndiffuse 1 0 0\nspecular 0 1 0\nemission 0 0 1\ntransmission .4 .5 .6\nshininess 20\nior 1.5\n\
         sphere 0 0 0 1\nshininess 21\ndiffuse 0 0 0\ntri 0 1 2\nshininess 20\ndiffuse 1 0 0\n\
         scale 1 2 1\nsphere 0 0 0 1\nior 1.6\n",
    );
    let rows: Vec<_> = (0..3).map(|id| scene.prim_material(id)).collect();
    assert_eq!(rows, [0, 1, 0]);
    let m = &scene.materials;
    assert_eq!(
        m.len(),
        2,
        "a material that no primitive captures is no row"
    );
    assert_eq!(m.ka.get(0), Vec3::new(0.1, 0.2, 0.3));
    assert_eq!((m.kd.get(0), m.kd.get(1)), (Vec3::X, Vec3::ZERO));
    assert_eq!((m.ks.get(0), m.ke.get(0)), (Vec3::Y, Vec3::Z));
    assert_eq!(m.kt.get(0), Vec3::new(0.4, 0.5, 0.6));
    assert_eq!((m.shininess[0], m.shininess[1]), (20.0, 21.0));
    assert_eq!(m.ior, [1.5, 1.5]);
}

#[test]
fn materials_that_differ_in_one_number_are_two() {
    for change in [
        "ambient .2 .2 .3",
        "diffuse 0 1 0",
        "specular 0 0 1",
        "emission 1 0 0",
        "transmission 0 1 0",
        "shininess 2",
        "ior 2",
        "gloss 2",
    ] {
        let scene = scene(&format!("sphere 0 0 0 1\n{change}\nsphere 0 0 0 1\n"));
        assert_eq!(scene.materials.len(), 2, "{change}");
        assert_eq!(scene.prim_material(1), 1, "{change}");
    }
}

#[test]
fn point_lights_capture_the_attenuation_and_the_transform() {
    let lights = scene(
        "point 1 0 0 1 .5 .25\nattenuation 1 2 3\ntranslate 0 0 4\nscale 2 3 4\npoint 1 1 1 1 1 1\n\
         directional 0 0 1 1 1 1\nattenuation 0 0 1\npoint 0 0 0 1 1 1\n",
    )
    .lights;
    assert_eq!(lights.directional, [false, false, true, false]);
    assert_eq!(lights.position.get(0), Vec3::X);
    assert_eq!(lights.color.get(0), Vec3::new(1.0, 0.5, 0.25));
    assert_eq!(lights.position.get(1), Vec3::new(2.0, 3.0, 8.0));
    let attenuations: Vec<_> = (0..4).map(|i| lights.attenuation.get(i)).collect();
    let faded = Vec3::new(1.0, 2.0, 3.0);
    assert_eq!(attenuations, [Vec3::X, faded, Vec3::X, Vec3::Z]);
}

#[test]
fn directional_lights_take_the_linear_part_and_have_unit_length() {
    let lights =
        scene("translate 5 5 5\nscale 1 3 1\nrotate 0 0 1 90\ndirectional 4 3 0 1 1 1\n").lights;
    // (4, 3) turns to (-3, 4), stretches to (-3, 12).
    let expected = Vec3::new(-3.0, 12.0, 0.0) / 153.0f32.sqrt();
    assert!(near(lights.position.get(0), expected));
    assert!((lights.position.get(0).length() - 1.0).abs() < 1e-6);
}

#[test]
fn capacity_hints_neither_allocate_nor_bind_when_kept() {
    let loaded = read(
        "maxverts 1000000000000\nmaxvertnorms 18446744073709551615\nvertex 0 0 0\ntri 0 0 0\n",
    );
    assert_eq!(loaded.scene.prim_count(), 1);
    assert_eq!(
        read("maxverts 1\nvertex 0 0 0\ntri 0 0 0\n")
            .scene
            .prim_count(),
        1
    );
    // Without a hint there is no limit.
    let many = "vertex 0 0 0\n".repeat(5000);
    assert_eq!(read(&format!("{many}tri 0 1 4999\n")).scene.prim_count(), 1);
}

#[test]
fn what_does_not_stop_a_render_is_a_warning() {
    let camera = HEAD.lines().nth(1).unwrap();
    let loaded = read(&format!("pushTransform\n{camera}\npushTransform"));
    let positions: Vec<_> = loaded.warnings.iter().map(|w| (w.line, w.column)).collect();
    assert_eq!(
        positions,
        [(3, 1), (4, 1), (5, 14)],
        "{:?}",
        loaded.warnings
    );
    let without_end = read_test(HEAD.trim_end()).unwrap();
    assert_eq!(without_end.warnings.len(), 1);
}
