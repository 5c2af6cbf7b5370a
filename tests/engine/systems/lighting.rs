//! "Lighting model" and "Shading model".

use super::{assert_near, floor, scene, shot};
use crate::common::tolerances::{ATTENUATED, ON_A_SPHERE, RADIANCE, SPECULAR_PER_SHININESS};
use glam::{DVec3, Vec3};

#[test]
fn attenuation() {
    let colour = DVec3::new(0.5, 1.0, 2.0);
    let diffuse = DVec3::new(0.75, 0.5, 0.25);
    for (constant, linear, quadratic) in [
        (1.0, 0.0, 0.0),
        (2.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 0.5),
        (0.5, 0.25, 0.125),
        (1.0, 1e-3, 1e3),
    ] {
        let model = format!("attenuation {constant} {linear} {quadratic}\n");
        for height in [0.125, 1.0, 3.0, 100.0] {
            let light = format!("point 1.5 2 {height} 0.5 1 2\n");
            let paint = "ambient 0 0 0\ndiffuse 0.75 0.5 0.25\n";
            let body = format!("{model}{light}{paint}{}", floor(0.0, true));
            let (radiance, rays) = shot(&scene("-3 1 4", "1 2 0", &body));
            let d = DVec3::new(0.5, 0.0, height).length();
            let seen = colour / (constant + linear * d + quadratic * d * d);
            let want = seen * diffuse * (height / d);
            assert_near(radiance, want, ATTENUATED, &format!("{model} at {d}"));
            assert_eq!(rays.shadow, 1);
        }
        // A directional light has no distance.
        let light = "directional 0 3 4 0.5 1 2\nambient 0 0 0\ndiffuse 0.75 0.5 0.25\n";
        let body = format!("{model}{light}{}", floor(0.0, true));
        let (radiance, _) = shot(&scene("-3 1 4", "1 2 0", &body));
        assert_near(
            radiance,
            colour * diffuse * 0.8,
            RADIANCE,
            "a directional light",
        );
    }
    // A light too bright for f32 adds nothing where it would be ∞ · 0; it never makes a pixel that
    // is not a number.
    let light = "attenuation 0 0 1e-30\npoint 0 0 2 1e30 1e30 1e30\n";
    let body = format!(
        "{light}ambient 0.25 0 0\ndiffuse 1 0 0\n{}",
        floor(0.0, true)
    );
    assert_eq!(shot(&scene("-3 1 4", "1 2 0", &body)).0, Vec3::X * 0.25);
    // A light in the very point that is seen adds nothing, whether or not its denominator is zero
    // there.
    for model in ["1 0 0", "0 1 0", "0 0 1", "0 1 1"] {
        for direction in ["0 0 1", "0 0 0.99999994"] {
            let light = format!("attenuation {model}\npoint {direction} 1 1 1\n");
            let paint = "ambient 0.25 0 0\ndiffuse 1 1 1\nspecular 1 1 1\nmaxdepth 0\n";
            let body = format!("{light}{paint}sphere 0 0 0 1\n");
            let (radiance, rays) = shot(&scene("0 0 5", "0 0 0", &body));
            assert_eq!(radiance, Vec3::X * 0.25, "{model} at {direction}");
            assert_eq!(rays.shadow, 0, "{model} at {direction}");
        }
    }
}

/// Ka + Ke of the scenes below, exact in f32.
const OWN: Vec3 = Vec3::new(0.25, 0.375, 0.5);

const PAINT: &str = "maxdepth 0\nambient 0.125 0.25 0.375\nemission 0.125 0.125 0.125\n\
    diffuse 0.75 0.5 0.25\nspecular 0.5 0.25 1\n";

struct TestLight {
    position: DVec3,
    directional: bool,
    colour: DVec3,
}

/// The lights of [`LIGHTS`].
fn lights() -> [TestLight; 3] {
    let light = |directional, position: [f64; 3], colour: [f64; 3]| TestLight {
        position: position.into(),
        directional,
        colour: colour.into(),
    };
    [
        light(false, [4.0, 5.0, 6.0], [1.0, 0.5, 0.25]),
        light(true, [-1.0, 2.0, 3.0], [0.25, 0.5, 1.0]),
        light(false, [0.0, -3.0, 4.0], [0.5, 0.5, 0.5]),
    ]
}

const LIGHTS: &str =
    "point 4 5 6 1 0.5 0.25\ndirectional -1 2 3 0.25 0.5 1\npoint 0 -3 4 0.5 0.5 0.5\n";

/// Blinn's model in f64, with everything visible.
fn blinn_phong(point: DVec3, normal: DVec3, eye: DVec3, shininess: f64) -> DVec3 {
    let viewer = (eye - point).normalize();
    let (kd, ks) = (DVec3::new(0.75, 0.5, 0.25), DVec3::new(0.5, 0.25, 1.0));
    lights().iter().fold(OWN.as_dvec3(), |sum, light| {
        let l = if light.directional {
            light.position.normalize()
        } else {
            (light.position - point).normalize()
        };
        let h = (l + viewer).normalize();
        let lobe = h.dot(normal).max(0.0).powf(shininess);
        sum + light.colour * (kd * l.dot(normal).max(0.0) + ks * lobe)
    })
}

#[test]
fn shading_with_shadow_rays() {
    // A sphere of radius 1.5, seen from the front: the first point of the ray through (0.3, 0.4,
    // 0).
    let (eye, lights) = (DVec3::new(0.5, 1.0, 7.0), DVec3::new(0.3, 0.4, 0.0));
    let dir = (lights - eye).normalize();
    let b = eye.dot(dir);
    let t = -b - (b * b - (eye.length_squared() - 2.25)).sqrt();
    let point = eye + dir * t;
    for shininess in [0.0, 0.5, 1.0, 10.0, 100.0, 1000.0] {
        let body = format!("{LIGHTS}{PAINT}shininess {shininess}\nsphere 0 0 0 1.5\n");
        let (radiance, rays) = shot(&scene("0.5 1 7", "0.3 0.4 0", &body));
        let want = blinn_phong(point, point.normalize(), eye, shininess);
        let relative = ON_A_SPHERE * (RADIANCE + shininess * SPECULAR_PER_SHININESS);
        assert_near(radiance, want, relative, &format!("shininess {shininess}"));
        assert_eq!((rays.shadow, rays.primary, rays.total()), (3, 1, 4));
    }
    occluders(point);
    lights_behind();
}

/// One ball on the way to each light leaves exactly Ka + Ke, even if it is of glass.
fn occluders(point: DVec3) {
    for glass in ["", "transmission 1 1 1\nior 1.5\n"] {
        let mut body = format!("{LIGHTS}{PAINT}sphere 0 0 0 1.5\n{glass}");
        for light in lights() {
            let way = if light.directional {
                light.position.normalize() * 3.0
            } else {
                (light.position - point) * 0.5
            };
            let [x, y, z] = (point + way).to_array();
            body += &format!("sphere {x} {y} {z} 0.1\n");
        }
        let (radiance, rays) = shot(&scene("0.5 1 7", "0.3 0.4 0", &body));
        assert_eq!(radiance, OWN);
        assert_eq!(rays.shadow, 3);
    }
    // Objects behind a light cast no shadow.
    let free = format!("point 0 0 4 1 1 1\n{PAINT}{}", floor(0.0, true));
    let behind = format!("{free}sphere 0 0 5 0.9\n");
    let (alone, _) = shot(&scene("-3 0 3", "0 0 0", &free));
    assert!(alone.cmpgt(OWN).all());
    assert_eq!(shot(&scene("-3 0 3", "0 0 0", &behind)).0, alone);
}

/// A light adds nothing if l·ng ≤ 0, and no ray is traced, regardless of the interpolated normal.
fn lights_behind() {
    for light in [
        "point 1 0 -2 9 9 9",
        "directional 1 0 -1 9 9 9",
        "directional 1 0 0 9 9 9",
    ] {
        let body = format!("{light}\n{PAINT}{}", floor(0.0, true));
        let (radiance, rays) = shot(&scene("-3 0 3", "0 0 0", &body));
        assert_eq!(radiance, OWN, "{light}");
        assert_eq!(rays.shadow, 0, "{light}");
    }
    let tilted =
        "vertexnormal -9 -9 0 1 0 0.1\nvertexnormal 9 -9 0 1 0 0.1\nvertexnormal 0 9 0 1 0 0.1\n";
    let body = format!("directional 1 0 -0.05 9 9 9\n{PAINT}{tilted}trinormal 0 1 2\n");
    let (radiance, rays) = shot(&scene("3 0 3", "0 0 0", &body));
    assert_eq!((radiance, rays.shadow), (OWN, 0));
}
