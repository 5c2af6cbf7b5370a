use super::*;

const ASPECTS: [f64; 7] = [4.0 / 3.0, 1.0, 0.5, 2.0, 16.0, 1.0 / 50.0, 300.0];

/// Deterministic numbers from -1 to 1.
fn numbers(mut seed: u32) -> impl FnMut() -> f32 {
    move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    }
}

fn scene_of(points: &[Vec3]) -> Scene {
    let mut scene = Scene::default();
    for triangle in points.chunks(3) {
        let corner = |k: usize| triangle[k.min(triangle.len() - 1)];
        scene.add_triangle([corner(0), corner(1), corner(2)], None, 0);
    }
    scene
}

/// The largest coordinate of any point in the picture of this view, where its sides are at 1.
fn largest_in_picture(points: &[Vec3], view: &View, aspect: f64) -> f64 {
    let basis = view.basis().expect("a camera");
    let slope = libm::tan(f64::from(view.fovy).to_radians() / 2.0);
    let largest = |p: &Vec3| {
        let to = p.as_dvec3() - view.eye.as_dvec3();
        let depth = -to.dot(basis.w.as_dvec3());
        assert!(depth > 0.0, "{p} behind {view:?}");
        let across = to.dot(basis.u.as_dvec3()).abs() / aspect;
        across.max(to.dot(basis.v.as_dvec3()).abs()) / (depth * slope)
    };
    points.iter().map(largest).fold(0.0, f64::max)
}

fn framed(points: &[Vec3], aspect: f64, up: UpAxis, turntable: bool) -> View {
    let scene = scene_of(points);
    let shape = PictureShape {
        aspect,
        up,
        turntable,
    };
    let visible = VisibleVertices::of(&scene, 2);
    framing(&scene, &visible, scene.bounds(), shape)
}

#[test]
fn every_vertex_is_in_the_picture_and_one_is_at_its_margin() {
    let mut number = numbers(1);
    for case in 0..300 {
        let size = Vec3::new(number(), number(), number()).map(|c| libm::exp2f(8.0 * c));
        let offset = Vec3::new(number(), number(), number()) * size.max_element() * 10.0;
        let scale = libm::exp2f(60.0 * number());
        let count = 3 + case % 40;
        let point = |n: &mut dyn FnMut() -> f32| (offset + size * Vec3::new(n(), n(), n())) * scale;
        let points: Vec<Vec3> = (0..count).map(|_| point(&mut number)).collect();
        let (aspect, (_, up)) = (ASPECTS[case % 7], UpAxis::ALL[case % 6]);
        let view = framed(&points, aspect, up, false);
        let largest = largest_in_picture(&points, &view, aspect);
        assert!((0.85..0.99).contains(&largest), "{case}: {largest}");
        assert_eq!(view.up.as_dvec3(), up.frame()[1]);
    }
}

#[test]
fn a_long_thin_diagonal_fills_the_picture_and_not_its_box() {
    let end = Vec3::new(100.0, 90.0, 80.0);
    let points = [-end, -end + Vec3::X * 0.1, end];
    for aspect in ASPECTS {
        let view = framed(&points, aspect, UpAxis::Y, false);
        let largest = largest_in_picture(&points, &view, aspect);
        assert!((0.9..0.96).contains(&largest), "{aspect}: {largest}");
    }
}

#[test]
fn what_is_small_beside_its_coordinates_is_framed_as_it_is() {
    // Units in the last place at 1, the last of which single precision can hardly tell apart.
    for (units, least) in [
        (1e5, 0.9),
        (1000.0, 0.9),
        (100.0, 0.7),
        (10.0, 0.3),
        (1.0, 0.02),
    ] {
        let size = units * f32::EPSILON;
        let points = [
            Vec3::ONE,
            Vec3::ONE + Vec3::X * size,
            Vec3::ONE + Vec3::Y * size,
        ];
        for aspect in [1.0, 4.0 / 3.0, 0.5] {
            let view = framed(&points, aspect, UpAxis::Y, false);
            let largest = largest_in_picture(&points, &view, aspect);
            assert!((least..=1.0).contains(&largest), "{units}: {largest}");
        }
    }
}

#[test]
fn points_lines_and_nothing_have_a_camera() {
    let [right, up, front] = UpAxis::Y.frame();
    let back = right * THREE_QUARTER.x + up * THREE_QUARTER.y + front * THREE_QUARTER.z;
    for points in [
        vec![],
        vec![Vec3::ZERO],
        vec![Vec3::splat(5.0)],
        vec![Vec3::splat(1e-38)],
        vec![Vec3::ZERO, back.as_vec3() * 7.0],
        vec![Vec3::ZERO, Vec3::Y],
    ] {
        for (aspect, turntable) in [(1.0, false), (1.0, true), (0.01, false), (100.0, true)] {
            let view = framed(&points, aspect, UpAxis::Y, turntable);
            let largest = largest_in_picture(&points, &view, aspect);
            assert!(largest < 1.0, "{points:?}: {largest} {view:?}");
        }
    }
}

#[test]
fn a_turntable_shows_everything_in_every_frame() {
    let mut number = numbers(5);
    for case in 0..60 {
        let size = Vec3::new(number(), number(), number()).map(|c| libm::exp2f(4.0 * c));
        let offset = Vec3::new(number(), number(), number()) * 30.0;
        let points: Vec<Vec3> = (0..12)
            .map(|_| offset + size * Vec3::new(number(), number(), number()))
            .collect();
        let (aspect, (_, up)) = (ASPECTS[case % 4], UpAxis::ALL[case % 6]);
        let start = framed(&points, aspect, up, true);
        let path = phalanx_scene::CameraPath::Turntable { frames: 60 };
        let frames = (0..60).map(|frame| path.view(frame, &start));
        let largest = frames.map(|view| largest_in_picture(&points, &view, aspect));
        let largest = largest.fold(0.0, f64::max);
        assert!((0.85..0.99).contains(&largest), "{case}: {largest}");
        // It turns around the middle.
        let axis = start.up.as_dvec3();
        let scene = scene_of(&points);
        let (middle, half) = middle_and_half(scene.bounds());
        let off = start.center.as_dvec3() - middle;
        let off = off - axis * axis.dot(off);
        assert!(off.length() < 1e-4 * half.length(), "{case}: {off}");
    }
}

#[test]
fn balls_cones_and_instances_are_framed_whole() {
    let mut scene = Scene::default();
    scene.add_sphere(Vec3::new(-3.0, 0.0, 0.0), 2.0, 0);
    let mesh = scene.begin_mesh();
    scene.add_triangle([Vec3::ZERO, Vec3::X, Vec3::Y], None, 0);
    scene.end_mesh(mesh);
    let map = glam::DAffine3::from_translation(DVec3::new(9.0, 0.0, 1.0));
    scene.add_instance(mesh, map).expect("an inverse");
    for aspect in ASPECTS {
        let shape = PictureShape {
            aspect,
            up: UpAxis::Y,
            turntable: false,
        };
        let visible = VisibleVertices::of(&scene, 1);
        let view = framing(&scene, &visible, scene.bounds(), shape);
        let instance = [Vec3::new(9.0, 0.0, 1.0), Vec3::new(10.0, 0.0, 1.0)];
        let mut number = numbers(3);
        let surface = (0..500).map(|_| Vec3::new(number(), number(), number()).normalize() * 2.0);
        let surface = surface.map(|p| p + Vec3::new(-3.0, 0.0, 0.0));
        let points: Vec<Vec3> = instance.into_iter().chain(surface).collect();
        let largest = largest_in_picture(&points, &view, aspect);
        assert!((0.8..0.99).contains(&largest), "{aspect}: {largest}");
    }
}
