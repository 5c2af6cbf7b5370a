//! Tessellated spheres, in the double precision of their construction.

use glam::DVec3;
use phalanx::standard::{
    MaterialDesc, Prepare, PreparedMesh, SceneBuilder, StandardLight, StandardView, Tessellate,
};
use std::collections::HashSet;

/// Collects patches, and expects nothing else.
#[derive(Default)]
struct Patches(Vec<Vec<(DVec3, DVec3)>>);

impl SceneBuilder for Patches {
    fn view(&mut self, _: &StandardView) {}

    fn background(&mut self, _: DVec3) {}

    fn light(&mut self, _: &StandardLight) {}

    fn material(&mut self, _: &MaterialDesc) {}

    fn sphere(&mut self, _: DVec3, _: f64) {
        panic!("a sphere is left");
    }

    fn cone(&mut self, _: DVec3, _: f64, _: DVec3, _: f64) {
        panic!("a cone is left");
    }

    fn polygon(&mut self, _: &[DVec3]) {
        panic!("a polygon from nowhere");
    }

    fn patch(&mut self, points: &[(DVec3, DVec3)]) {
        self.0.push(points.to_vec());
    }

    fn preparation(&self) -> Box<Prepare> {
        panic!("a mesh from nowhere");
    }

    fn prepared(&mut self, _: PreparedMesh) {}
}

/// Each edge exists once in either direction, with ends equal to the last bit.
#[test]
fn a_tessellated_sphere_is_closed_and_faces_outward() {
    for fineness in [1, 2, 3, 7, 12] {
        let mut patches = Patches::default();
        Tessellate::new(fineness, &mut patches).sphere(DVec3::ZERO, 1.0);
        assert_eq!(patches.0.len(), 12 * (fineness * fineness) as usize);
        // + 0.0 makes zeros of −0.
        let bits = |v: DVec3| (v + 0.0).to_array().map(f64::to_bits);
        let mut edges = HashSet::new();
        for patch in &patches.0 {
            let [(a, _), (b, _), (c, _)] = patch[..] else {
                panic!("{} corners", patch.len())
            };
            assert!(
                (b - a).cross(c - a).dot(a + b + c) > 0.0,
                "{patch:?} faces inward"
            );
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let edge = (bits(from), bits(to));
                assert!(edges.insert(edge), "an edge twice in one direction");
            }
        }
        let closed = edges.iter().all(|&(from, to)| edges.contains(&(to, from)));
        assert!(closed, "open edges at {fineness}");
    }
}

#[test]
fn corners_lie_on_the_sphere_and_normals_point_away_from_its_middle() {
    let (center, radius) = (DVec3::new(1.0, -2.0, 3.0), 0.25);
    let mut patches = Patches::default();
    Tessellate::new(3, &mut patches).sphere(center, radius);
    for (point, normal) in patches.0.into_iter().flatten() {
        assert!((point - center - normal * radius).length() < 1e-15);
        assert!((normal.length() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn a_pointed_cone_ends_in_triangles() {
    for (base, apex) in [(1.0, 0.0), (0.0, 1.0)] {
        let mut patches = Patches::default();
        Tessellate::new(2, &mut patches).cone(DVec3::ZERO, base, DVec3::Z * 2.0, apex);
        assert_eq!(patches.0.len(), 8);
        for patch in &patches.0 {
            let [(a, n), (b, _), (c, _)] = patch[..] else {
                panic!("{} corners", patch.len())
            };
            assert!((b - a).cross(c - a).dot(n) > 0.0, "{patch:?} faces inward");
        }
    }
}
