//! "Creating an orthonormal coordinate frame" and "Creating a ray from the camera".

use crate::common::rng::Rng;
use crate::common::tolerances::{DIRECTION, FRAME, PLACE, UNIT_LENGTH};
use glam::{DVec3, Vec3};
use phalanx::camera::Camera;
use phalanx::formats::read_test;
use phalanx::lanes::{F32x8, LANES};
use phalanx::scene::{View, ViewError};

fn random_view(rng: &mut Rng) -> View {
    let scale = rng.magnitude(-3.0, 6.0);
    View {
        eye: rng.point(scale),
        center: rng.point(scale),
        up: rng.direction() * rng.magnitude(-10.0, 10.0),
        fovy: rng.range(1.0, 170.0),
        ortho: None,
    }
}

/// (u, v, w) as in the document.
fn frame(view: &View) -> [DVec3; 3] {
    let a = view.eye.as_dvec3() - view.center.as_dvec3();
    let b = view.up.as_dvec3();
    let w = a / a.length();
    let u = b.cross(w) / b.cross(w).length();
    [u, w.cross(u), w]
}

#[test]
fn camera_frame() {
    let mut rng = Rng::new(41);
    for _ in 0..2000 {
        let view = random_view(&mut rng);
        let basis = view.basis().expect("a frame");
        let got = [basis.u, basis.v, basis.w].map(Vec3::as_dvec3);
        for (got, want) in got.iter().zip(frame(&view)) {
            assert!((*got - want).abs().max_element() <= FRAME, "{view:?}");
        }
        for i in 0..3 {
            for k in 0..3 {
                let want = if i == k { 1.0 } else { 0.0 };
                let error = (got[i].dot(got[k]) - want).abs();
                assert!(error <= FRAME, "{view:?}: {i}·{k} is off by {error:e}");
            }
        }
        // Right-handed.
        assert!((got[0].cross(got[1]) - got[2]).abs().max_element() <= FRAME);
    }
    let ahead = View {
        eye: Vec3::new(0.0, 0.0, 4.0),
        center: Vec3::ZERO,
        up: Vec3::Y,
        fovy: 45.0,
        ortho: None,
    };
    let wrong = [
        (Vec3::ZERO, Vec3::Y, ViewError::NoDirection),
        (Vec3::Z, Vec3::ZERO, ViewError::NoUp),
        (Vec3::Z, Vec3::Z * 7.0, ViewError::UpParallel),
        (
            Vec3::new(1.0, 2.0, 3.0),
            Vec3::new(-2.0, -4.0, -6.0),
            ViewError::UpParallel,
        ),
        (Vec3::Z, Vec3::NAN, ViewError::NotFinite),
    ];
    for (eye, up, want) in wrong {
        let view = View { eye, up, ..ahead };
        assert_eq!(view.basis(), Err(want), "{view:?}");
        assert!(Camera::new(&view, 4, 4).is_err(), "{view:?}");
    }
    // In a file it is an error with its line, not a picture of NaN.
    for camera in [
        "0 0 4 0 0 0 0 0 1 45",
        "1 2 3 1 2 3 0 1 0 45",
        "0 0 4 0 0 0 0 0 0 45",
    ] {
        let errors = read_test(&format!("size 4 4\n\ncamera {camera}\n")).expect_err(camera);
        assert_eq!(errors[0].line, 3, "{errors:?}");
    }
}

/// The direction as in the document, with fov_x = 2 atan(tan(fov_y/2)·W/H).
fn direction(view: &View, size: (u32, u32), row: f64, column: f64) -> DVec3 {
    let (width, height) = (f64::from(size.0), f64::from(size.1));
    let tan_y = (f64::from(view.fovy).to_radians() / 2.0).tan();
    let fov_x = 2.0 * (tan_y * width / height).atan();
    let alpha = (fov_x / 2.0).tan() * (column - width / 2.0) / (width / 2.0);
    let beta = tan_y * (height / 2.0 - row) / (height / 2.0);
    let [u, v, w] = frame(view);
    (u * alpha + v * beta - w).normalize()
}

#[test]
fn camera_rays() {
    let mut rng = Rng::new(42);
    for size in [
        (1, 1),
        (640, 480),
        (480, 640),
        (33, 65),
        (3000, 2),
        (4096, 4096),
    ] {
        for _ in 0..50 {
            let view = random_view(&mut rng);
            let camera = Camera::new(&view, size.0, size.1).expect("a camera");
            for _ in 0..40 {
                let rows = [0; LANES].map(|_| rng.below(size.1 as usize) as f32 + 0.5);
                let columns = [0; LANES].map(|_| rng.below(size.0 as usize) as f32 + 0.5);
                let wide = phalanx::packet::camera::directions(
                    &camera,
                    F32x8::new(rows),
                    F32x8::new(columns),
                );
                let wide = [wide.x, wide.y, wide.z].map(F32x8::to_array);
                for lane in 0..LANES {
                    let (row, column) = (rows[lane], columns[lane]);
                    let got = camera.direction(row, column);
                    let want = direction(&view, size, f64::from(row), f64::from(column));
                    let error = (got.as_dvec3() - want).abs().max_element();
                    assert!(
                        error <= DIRECTION,
                        "{view:?} {size:?} {row} {column}: {error:e}"
                    );
                    let length = got.as_dvec3().length();
                    assert!(
                        (length - 1.0).abs() <= UNIT_LENGTH,
                        "{got} is {length} long"
                    );
                    let lanes = wide.map(|c| c[lane].to_bits());
                    assert_eq!(lanes, got.to_array().map(f32::to_bits), "lane {lane}");
                }
            }
        }
    }
    centre_and_corners();
}

/// Expected results of the formula for a view along −z.
fn centre_and_corners() {
    let view = View {
        eye: Vec3::ZERO,
        center: -Vec3::Z,
        up: Vec3::Y,
        fovy: 90.0,
        ortho: None,
    };
    let camera = Camera::new(&view, 9, 5).expect("a camera");
    // The centre of the middle pixel is the view's own direction, exactly.
    assert_eq!(camera.direction(2.5, 4.5), -Vec3::Z);
    // The image's upper edge is half the field of view away; rows run down, columns to the right.
    let top = camera.direction(0.0, 4.5);
    assert!((top.y + top.z).abs() < PLACE && top.y > 0.0, "{top}");
    assert!(camera.direction(2.5, 9.0).x > 0.0);
    // Square pixels: a step to the right is as large as a step down, on the plane z = −1.
    let on_plane = |row: f32, column: f32| {
        let d = camera.direction(row, column);
        d / -d.z
    };
    let right = on_plane(2.5, 5.5).x - on_plane(2.5, 4.5).x;
    let down = on_plane(2.5, 4.5).y - on_plane(3.5, 4.5).y;
    assert!(
        (right - down).abs() < PLACE && (right - 0.4).abs() < PLACE,
        "{right} {down}"
    );
}
