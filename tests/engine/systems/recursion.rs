//! "Recursive shading model": mirrors, refraction, and the choice of rays to trace.

use super::{floor, scene, shot, shot_of_weight};
use glam::{DVec3, Vec3};
use phalanx::scene::Scene;

/// A ball with this emission as a ray's target; other balls and floors keep theirs.
const GLOW: Vec3 = Vec3::new(0.75, 0.5, 0.25);

fn glowing_ball(center: DVec3, radius: f64) -> String {
    let [x, y, z] = center.to_array();
    let plain = "specular 0 0 0\ntransmission 0 0 0\n";
    format!("{plain}ambient 0 0 0\nemission 0.75 0.5 0.25\nsphere {x} {y} {z} {radius}\n")
}

/// A ball so small that only the right direction hits it, at distance three.
const TARGET: f64 = 2e-3;

#[test]
fn recursion_reflection_refraction() {
    a_mirror();
    two_mirrors();
    a_slab();
    a_glass_ball();
    total_reflection();
    rays_without_weight();
    the_background();
}

/// The body of two mirrors that face each other above and below the eye.
fn facing_mirrors(depth: u32, material: &str) -> String {
    let (below, above) = (floor(-1.0, true), floor(1.0, false));
    format!("maxdepth {depth}\nambient 0.25 0.5 1\n{material}\n{below}{above}")
}

#[test]
fn rays_of_less_than_the_least_weight_are_not_traced() {
    let bounces = |material: &str, least: f32| {
        let body = facing_mirrors(100, material);
        let (radiance, rays) = shot_of_weight(&scene("0 0 0", "0 0 -1", &body), least);
        (radiance, rays.reflection)
    };
    // Weights of exactly the least are traced: 2⁻⁴ after four bounces.
    let halves = "specular 0.5 0.5 0.5";
    for (least, count) in [
        (0.0625, 4),
        (0.062_500_01, 3),
        (0.6, 0),
        (0.5, 1),
        (0.0, 100),
    ] {
        let (radiance, rays) = bounces(halves, least);
        assert_eq!(rays, count, "{least}");
        let sum = (0..=count).fold(0.0f32, |deeper, _| 1.0 + 0.5 * deeper);
        assert_eq!(radiance, Vec3::new(0.25, 0.5, 1.0) * sum, "{least}");
    }
    // The largest component counts.
    assert_eq!(bounces("specular 0.125 0.5 0.25", 0.0625).1, 4);
    assert_eq!(bounces("specular 1 0 0", 0.999).1, 100);
    // A product of nothing, although neither factor is that.
    let (red, green) = ("specular 1 0 0\n", "specular 0 1 0\n");
    let body = format!(
        "maxdepth 9\n{red}{}{green}{}",
        floor(-1.0, true),
        floor(1.0, false)
    );
    for (least, count) in [(0.0, 9), (1e-30, 1)] {
        let (_, rays) = shot_of_weight(&scene("0 0 0", "0 0 -1", &body), least);
        assert_eq!(rays.reflection, count, "{least}");
    }
    // Light goes in, is reflected totally, and its weight is then Ks + Kt.
    let glass = "ambient 0 0 0\nspecular 0.25 0.25 0.25\ntransmission 0.5 0.5 0.5\nior 1.5\n";
    let body =
        glass.to_owned() + &floor(0.0, true) + &glowing_ball(DVec3::new(3.0, 0.0, -3.0), 1.0);
    for (least, count) in [(0.75, 1), (0.76, 0)] {
        let (_, rays) = shot_of_weight(&scene("-2 0 -2", "0 0 0", &body), least);
        assert_eq!(rays.reflection, count, "{least}");
    }
}

/// Glass that reflects half of the light and transmits the other half sends two rays for each:
/// without a minimum weight, 2¹⁰⁰ of them.
#[test]
fn glass_and_mirrors_of_great_depth_take_bounded_time() {
    let body = facing_mirrors(100, "specular 0.5 0.5 0.5\ntransmission 0.5 0.5 0.5");
    let (radiance, rays) = shot_of_weight(&scene("0 0 0", "0 0 -1", &body), 1.0 / 4096.0);
    assert!(radiance.is_finite() && radiance.x > 0.25);
    assert!((12..8192).contains(&rays.total()), "{rays:?}");
}

/// Weights that add up to more than 1 are divided by their sum, component by component.
#[test]
fn materials_that_send_more_than_they_get_end_as_soon() {
    let sent = |material: &str, depth: u32, least: f32| {
        let body = facing_mirrors(depth, material);
        let (_, rays) = shot_of_weight(&scene("0 0 0", "0 0 -1", &body), least);
        rays.reflection + rays.refraction
    };
    // A mirror ray and a refracted one, which is lost, of each; as if the weights were halves.
    for w in [0.5, 0.6, 0.75, 1.0, 1e3] {
        let both = format!("specular {w} {w} {w}\ntransmission {w} {w} {w}");
        assert_eq!(sent(&both, 3, 0.0), 6, "{w}");
        assert_eq!(sent(&both, 9, 0.2), 4, "{w}");
        assert_eq!(sent(&both, 20, 1.0 / 4096.0), 24, "{w}");
    }
    // Nothing is a part of what is not a number.
    let both = "specular 3e38 3e38 3e38\ntransmission 3e38 3e38 3e38";
    assert_eq!((sent(both, 3, 0.0), sent(both, 3, 1e-30)), (6, 0));
    // A material that only mirrors does not fade, and nor does one component that another lets
    // through.
    assert_eq!(sent("specular 3 3 3", 50, 0.99), 50);
    assert_eq!(sent("specular 3 0 0\ntransmission 0 3 0", 50, 0.99), 51);
    // Total reflection is all that the first hit sends, and the mirror below it sends halves.
    let glass = "specular 1 1 1\ntransmission 1 1 1\nior 1.5\n";
    let below = floor(-4.0, true).replace("tri 0 1 2\ntri 0 2 3", "tri 4 5 6\ntri 4 6 7");
    let body = glass.to_owned() + &floor(0.0, true) + &below;
    for (least, count) in [(0.9, 1), (0.4, 3)] {
        let (_, rays) = shot_of_weight(&scene("-2 0 -2", "0 0 0", &body), least);
        assert_eq!(
            (rays.reflection, rays.refraction),
            (count, count / 3),
            "{least}"
        );
    }
}

/// Recursion deeper than any thread's stack. Every bounce adds Ka.
#[test]
fn perfect_mirrors_may_be_of_any_depth() {
    let body = facing_mirrors(1000, "specular 1 1 1");
    let mut scene = scene("0 0 0", "0 0 -1", &body);
    scene.materials.ka.set(0, Vec3::new(1.0, 0.5, 0.25));
    for depth in [1000, 100_000] {
        scene.max_depth = depth;
        let (radiance, rays) = shot_of_weight(&scene, 1.0 / 4096.0);
        assert_eq!(radiance, Vec3::new(1.0, 0.5, 0.25) * (depth + 1) as f32);
        assert_eq!(rays.reflection, u64::from(depth));
    }
}

fn a_mirror() {
    let mirror = format!("ambient 0 0 0\nspecular 0.5 0.25 1\n{}", floor(0.0, true));
    let mirrored = DVec3::new(3.0, 1.5, 3.0);
    let body = mirror.clone() + &glowing_ball(mirrored, TARGET);
    let (radiance, rays) = shot(&scene("-2 -1 2", "0 0 0", &body));
    assert_eq!(radiance, Vec3::new(0.5, 0.25, 1.0) * GLOW);
    assert_eq!((rays.reflection, rays.refraction, rays.total()), (1, 0, 2));
    let missed = mirrored + DVec3::new(3.0 * TARGET, 0.0, 0.0);
    let body = mirror + &glowing_ball(missed, TARGET);
    assert_eq!(shot(&scene("-2 -1 2", "0 0 0", &body)).0, Vec3::ZERO);
}

/// Between two mirrors every bounce adds Ka: a geometric sum, with `maxdepth` rays.
fn two_mirrors() {
    for depth in [0, 1, 2, 5, 20, 100] {
        let body = format!(
            "maxdepth {depth}\nambient 0.25 0.5 1\nspecular 0.5 0.5 0.5\n{}{}",
            floor(-1.0, true),
            floor(1.0, false)
        );
        let (radiance, rays) = shot(&scene("0 0 0", "0 0 -1", &body));
        // From the deepest outward, as the recursion adds: every step is exact until it no longer
        // matters.
        let sum = (0..=depth).fold(0.0f32, |deeper, _| 1.0 + 0.5 * deeper);
        assert_eq!(radiance, Vec3::new(0.25, 0.5, 1.0) * sum, "{depth}");
        assert_eq!(sum, 2.0 - 0.5f32.powi(depth));
        assert_eq!(rays.reflection, depth as u64);
        assert_eq!(rays.total(), depth as u64 + 1);
    }
}

/// A glass plate of thickness 1: the ray leaves in its original direction, displaced sideways by
/// Snell's law.
fn a_slab() {
    let down = DVec3::new(1.0, 0.0, -1.0).normalize();
    for index in [1.0, 1.25, 1.5, 2.5] {
        let sin = (0.5f64.sqrt()) / index;
        let sideways = (sin / (1.0 - sin * sin).sqrt()) * DVec3::X;
        let exit = sideways - DVec3::Z;
        let slab = format!(
            "ambient 0 0 0\ntransmission 0.5 0.25 1\nior {index}\n{}{}",
            floor(0.0, true),
            floor(-1.0, false)
        );
        let body = slab.clone() + &glowing_ball(exit + down * 3.0, TARGET);
        let (radiance, rays) = shot(&scene("-2 0 2", "0 0 0", &body));
        let twice = Vec3::new(0.25, 0.0625, 1.0);
        assert_eq!(radiance, twice * GLOW, "index {index}");
        assert_eq!((rays.refraction, rays.reflection, rays.total()), (2, 0, 3));
        // Straight on there is nothing, unless the glass is none.
        let body = slab + &glowing_ball(down * (3.0 + 2f64.sqrt()), TARGET);
        let straight = shot(&scene("-2 0 2", "0 0 0", &body)).0;
        assert_eq!(straight == Vec3::ZERO, index != 1.0, "index {index}");
    }
}

/// A ball deflects a ray by 2(θi − θr), where sin θi is the impact parameter.
fn a_glass_ball() {
    for (index, impact) in [
        (1.5, 0.5),
        (1.5, -0.9),
        (1.33, 0.25),
        (0.8, 0.5),
        (2.0, 0.0),
    ] {
        let incident = f64::asin(impact);
        let inside = f64::asin(impact / index);
        let heading = |angle: f64| DVec3::new(angle.cos(), -angle.sin(), 0.0);
        let entry = DVec3::new(-incident.cos(), impact, 0.0);
        let exit = entry + heading(incident - inside) * 2.0 * inside.cos();
        assert!((exit.length() - 1.0).abs() < 1e-12);
        let target = exit + heading(2.0 * (incident - inside)) * 3.0;
        let body =
            format!("ambient 0 0 0\ntransmission 0.5 0.5 0.5\nior {index}\nsphere 0 0 0 1\n");
        let body = body + &glowing_ball(target, TARGET);
        let (eye, view) = (format!("-5 {impact} 0"), format!("0 {impact} 0"));
        let (radiance, rays) = shot(&scene(&eye, &view, &body));
        assert_eq!(radiance, 0.25 * GLOW, "index {index}, impact {impact}");
        assert_eq!((rays.refraction, rays.reflection), (2, 0));
    }
}

/// From below at 45° with index 1.5 nothing is transmitted: the term is (Ks + Kt)·I_R, one ray.
fn total_reflection() {
    for (specular, sum) in [("0.25 0.25 0.25", 0.75), ("0 0 0", 0.5)] {
        let glass =
            format!("ambient 0 0 0\nspecular {specular}\ntransmission 0.5 0.5 0.5\nior 1.5\n");
        let body = glass + &floor(0.0, true) + &glowing_ball(DVec3::new(3.0, 0.0, -3.0), TARGET);
        let (radiance, rays) = shot(&scene("-2 0 -2", "0 0 0", &body));
        assert_eq!(radiance, sum * GLOW);
        assert_eq!((rays.reflection, rays.refraction, rays.total()), (1, 0, 2));
        // Steeper than the critical angle of 41.8° it does.
        let (_, rays) = shot(&scene("-1 0 -2", "0 0 0", &body));
        assert_eq!(rays.refraction, 1);
        assert_eq!(rays.reflection, u64::from(specular != "0 0 0"));
    }
}

/// Traced rays: only those with a nonzero weight in some channel, and down to `maxdepth`.
fn rays_without_weight() {
    for (specular, transmission, depth, bounces) in [
        ("0 0 0", "0 0 0", 5, (0, 0)),
        ("0 0 0.5", "0 0 0", 5, (1, 0)),
        ("0 0 0", "0 0.5 0", 5, (0, 1)),
        ("1 0 0", "0 0.5 0", 5, (1, 1)),
        ("1 1 1", "1 1 1", 0, (0, 0)),
        ("1 1 1", "1 1 1", 1, (1, 1)),
    ] {
        let body = format!(
            "maxdepth {depth}\nspecular {specular}\ntransmission {transmission}\nior 1.5\n{}",
            floor(0.0, true)
        );
        let (_, rays) = shot(&scene("-2 0 2", "0 0 0", &body));
        assert_eq!((rays.reflection, rays.refraction), bounces, "{body}");
    }
    // Nor are shadow rays that could only bring black: a black light, or a surface that returns
    // none of it.
    for (light, diffuse, shadows) in [
        ("1 1 1", "1 1 1", 1),
        ("0 0 0", "1 1 1", 0),
        ("1 0 0", "0 1 1", 0),
        ("0 1 0", "0 1 1", 1),
        ("1 1 1", "0 0 0", 0),
    ] {
        let body = format!(
            "directional 0 0 1 {light}\ndiffuse {diffuse}\n{}",
            floor(0.0, true)
        );
        let (_, rays) = shot(&scene("-2 0 2", "0 0 0", &body));
        assert_eq!(rays.shadow, shadows, "light {light}, diffuse {diffuse}");
    }
}

/// A ray that misses returns the background, at any depth.
fn the_background() {
    let with_background = |body: &str| -> Scene {
        let mut scene = scene("-2 0 2", "0 0 0", body);
        scene.background = Vec3::new(0.5, 0.25, 0.125);
        scene
    };
    assert_eq!(shot(&with_background("")).0, Vec3::new(0.5, 0.25, 0.125));
    let mirror = format!("ambient 0.25 0 0\nspecular 0.5 1 0\n{}", floor(0.0, true));
    assert_eq!(shot(&with_background(&mirror)).0, Vec3::new(0.5, 0.25, 0.0));
}
