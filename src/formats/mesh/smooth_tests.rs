use super::*;
use phalanx_scene::Mesh;
use std::f64::consts::TAU;

/// Numbers from 0 to 1, the same in each run.
fn random() -> impl FnMut() -> f64 {
    let mut seed = 1u32;
    move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24)
    }
}

/// Triangles of a scene, each with vertices of its own.
fn soup(corners: &[[[f64; 3]; 3]]) -> Triangles {
    let mut mesh = Mesh::default();
    for (k, corners) in (0..).zip(corners) {
        for corner in corners {
            let vertex = corner.map(|c| c as f32);
            mesh.vertices.push(vertex.into());
        }
        mesh.corners.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    let mut scene = phalanx_scene::Scene::default();
    scene.append_mesh(mesh);
    scene.triangles
}

fn smoothed(mut triangles: Triangles, angle: f32) -> Triangles {
    let memory = MemoryLedger::of(None);
    add_smooth_normals(&mut triangles, &[], angle, 2, &memory).unwrap();
    triangles
}

/// Quads around an axis, of these radii and heights, `sides` of them in each ring.
fn turned(profile: &[[f64; 2]], sides: usize) -> Vec<[[f64; 3]; 3]> {
    let point = |[r, z]: [f64; 2], k: usize| {
        let (sin, cos) = libm::sincos(TAU * (k % sides) as f64 / sides as f64);
        [r * cos, r * sin, z]
    };
    let rings = profile
        .windows(2)
        .flat_map(|ring| (0..sides).map(move |k| (ring, k)));
    let quads = rings.flat_map(|(ring, k)| {
        let [a, b] = [point(ring[0], k), point(ring[0], k + 1)];
        let [c, d] = [point(ring[1], k + 1), point(ring[1], k)];
        [[a, b, c], [a, c, d]]
    });
    let distinct = |t: &[[f64; 3]; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    quads.filter(distinct).collect()
}

/// Cosine of the smallest angle between a facet and any of its normals.
fn closest(triangles: &Triangles, k: usize) -> f32 {
    let [a, b, c] = triangles.corners(k);
    let facet = (b - a).cross(c - a).normalize();
    let normals = triangles
        .corner_normals(k)
        .map_or([facet; 3], |normals| normals);
    normals
        .map(|n| n.dot(facet))
        .into_iter()
        .fold(1.0, f32::min)
}

/// Asserts that normals are those that the definition gives, by a pass over all pairs of corners.
/// Corners of which some pair is within rounding of the angle may be either way.
fn assert_as_defined(corners: &[[[f64; 3]; 3]], angle: f32, what: &str) -> usize {
    let triangles = smoothed(soup(corners), angle);
    let rounded = corners
        .iter()
        .map(|t| t.map(|p| DVec3::from(p.map(|c| f64::from(c as f32)))));
    let rounded: Vec<[DVec3; 3]> = rounded.collect();
    let unit = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero();
    let least = (f64::from(angle) + 0.05).min(180.0);
    let least = libm::cos(least.to_radians());
    let mut checked = 0;
    for (k, own) in rounded
        .iter()
        .enumerate()
        .filter(|(_, own)| unit(own) != DVec3::ZERO)
    {
        let normals = triangles.corner_normals(k);
        for corner in 0..3 {
            let (mut sum, mut is_clear) = (DVec3::ZERO, true);
            for (other, vertex) in rounded.iter().flat_map(|t| [(t, 0), (t, 1), (t, 2)]) {
                let cos = unit(own).dot(unit(other));
                if other[vertex] != own[corner] || unit(other) == DVec3::ZERO {
                    continue;
                }
                is_clear &= (cos - least).abs() > 1e-9;
                if cos >= least {
                    let [a, b] = [1, 2].map(|next| other[(vertex + next) % 3] - other[vertex]);
                    sum += a.cross(b) / (a.length_squared() * b.length_squared());
                }
            }
            let expected = sum.normalize_or(unit(own)).as_vec3();
            let turns = sum.normalize_or_zero().dot(unit(own));
            if is_clear && turns > 1e-6 {
                let normal = normals.map_or(unit(own).as_vec3(), |normals| normals[corner]);
                let error = (normal - expected).length();
                assert!(
                    error < 2e-6,
                    "{what}: triangle {k}.{corner}: {normal}, not {expected}"
                );
                checked += 1;
            }
        }
    }
    checked
}

#[test]
fn normals_are_those_of_the_definition_in_double_precision() {
    let mut next = random();
    let mut checked = 0;
    for (number, scale) in [1.0, 1e-3, 3e-44, 1e30]
        .into_iter()
        .cycle()
        .take(40)
        .enumerate()
    {
        // Positions of a coarse grid, so that many triangles share them, some of which are equal,
        // opposite, or without an area.
        let mut point = || [(); 3].map(|()| (next() * 4.0).floor() * scale);
        let mut corners: Vec<_> = (0..60).map(|_| [point(), point(), point()]).collect();
        corners.extend(corners[..3].to_vec());
        corners.push([corners[0][1], corners[0][0], corners[0][2]]);
        let angle = [1.0, 30.0, 75.0, 130.0][number / 4 % 4];
        checked += assert_as_defined(&corners, angle, &format!("soup {number}"));
    }
    let arc = |i: u32| libm::sincos(f64::from(i) / 12.0 * TAU / 2.0);
    let globe = (0..=12).map(|i| [if i % 12 == 0 { 0.0 } else { arc(i).0 }, -arc(i).1]);
    let globe: Vec<_> = globe.collect();
    checked += assert_as_defined(&turned(&globe, 20), 40.0, "globe");
    // More than a leaf of facets around a point.
    checked += assert_as_defined(&turned(&[[0.0, 2.0], [1.0, 0.0]], 700), 30.0, "cone");
    assert!(checked > 5000, "{checked}");
}

#[test]
fn no_bit_depends_on_threads() {
    let corners = turned(&[[0.0, 3.0], [0.5, 2.5], [0.6, 1.0], [2.0, 0.0]], 4001);
    for objects in [&[][..], &[0, 3000, 9000]] {
        let made = [1, 2, 3, 7, 64].map(|threads| {
            let mut triangles = soup(&corners);
            let memory = MemoryLedger::of(None);
            assert!(add_smooth_normals(&mut triangles, objects, 30.0, threads, &memory).unwrap());
            let bits = triangles
                .vertex_normals
                .parts()
                .map(|part| part.iter().map(|c| c.to_bits()).collect::<Vec<u32>>());
            (triangles.normals, bits)
        });
        assert!(
            made[1..]
                .iter()
                .all(|other| (&*other.0, &other.1) == (&*made[0].0, &made[0].1))
        );
    }
}

fn cube() -> Vec<[[f64; 3]; 3]> {
    turned(&[[0.0, -0.7], [1.0, -0.7], [1.0, 0.7], [0.0, 0.7]], 4)
}

#[test]
fn boxes_stay_as_they_are_and_prisms_become_round() {
    let mut triangles = soup(&cube());
    let memory = MemoryLedger::of(None);
    for angle in [0.0, 30.0, 89.9] {
        let changed = add_smooth_normals(&mut triangles, &[], angle, 1, &memory);
        assert_eq!(changed, Ok(false), "{angle}");
        assert!(triangles.normals.is_empty() && triangles.vertex_normals.is_empty());
    }
    assert!((0..triangles.len()).all(|k| closest(&smoothed(soup(&cube()), 90.0), k) < 0.9));
    // Twelve sides are 30 degrees apart, up to rounding; the ends are not.
    let prism = |sides| turned(&[[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]], sides);
    for sides in [12, 24] {
        let round = smoothed(soup(&prism(sides)), 30.0);
        for k in 0..round.len() {
            let is_end = k < sides || k >= 3 * sides;
            assert_eq!(closest(&round, k) > 0.999_999, is_end, "{sides}: {k}");
        }
    }
    assert!(smoothed(soup(&prism(11)), 30.0).normals.is_empty());
}

#[test]
fn edges_between_opposite_sides_and_at_vertices_within_edges_stay() {
    // A sheet whose backs are triangles of their own, bent by twenty degrees.
    let (sin, cos) = libm::sincos(20f64.to_radians());
    let [a, b, c, d] = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [cos, 0.0, sin],
    ];
    let sheet = [[a, b, c], [b, a, d], [b, a, c], [a, b, d]];
    let both = smoothed(soup(&sheet), 30.0);
    for (k, up) in [(0, 1.0), (1, 1.0), (2, -1.0), (3, -1.0)] {
        let normals = both.corner_normals(k).unwrap();
        assert!(normals.iter().all(|n| n.z * up > 0.9), "{k}: {normals:?}");
        let at_bend = normals[usize::from(k % 3 != 0)];
        assert!(
            (at_bend.x * up + libm::sinf(10f32.to_radians())).abs() < 1e-6,
            "{k}: {at_bend}"
        );
    }
    // The middle of b c is a vertex of the two triangles beyond, which are bent away.
    let middle = [-0.5, 0.5, 0.0];
    let beyond = [-1.0, 1.0, 0.2];
    let joint = smoothed(
        soup(&[[a, b, c], [b, beyond, middle], [middle, beyond, c]]),
        30.0,
    );
    let normals = joint.corner_normals(0).unwrap();
    assert_eq!(normals[0], Vec3::Z);
    assert!(normals[1] != Vec3::Z && normals[2] != Vec3::Z);
}

#[test]
fn zeros_of_both_signs_are_one_position_and_objects_are_apart() {
    let [a, b] = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bent = [
        [a, b, [-1.0, 0.0, 0.0]],
        [[-0.0, 1.0, -0.0], [-0.0; 3], [1.0, 0.0, 0.3]],
    ];
    let joined = smoothed(soup(&bent), 30.0);
    assert_eq!(joined.vertex_normals.len(), 4);
    let mut apart = soup(&bent);
    let memory = MemoryLedger::of(None);
    assert_eq!(
        add_smooth_normals(&mut apart, &[0, 3], 30.0, 1, &memory),
        Ok(false)
    );
}

#[test]
fn normals_of_the_file_stay() {
    let mut triangles = soup(&turned(&[[1.0, -1.0], [1.0, 1.0]], 20));
    triangles.vertex_normals.push(Vec3::X);
    triangles.normals = vec![[NONE; 3]; triangles.len()].into();
    triangles.normals[7] = [0; 3];
    let triangles = smoothed(triangles, 30.0);
    assert_eq!(triangles.corner_normals(7), Some([Vec3::X; 3]));
    assert!((0..40).all(|k| triangles.normal_rows(k).is_some()));
    assert!(
        (0..40)
            .filter(|&k| k != 7)
            .all(|k| closest(&triangles, k) > 0.9)
    );
}

#[test]
fn a_pole_of_many_triangles_takes_no_time_of_their_square() {
    // So steep that opposite sides are apart.
    let pole = smoothed(soup(&turned(&[[0.0, 2.0], [1.0, 0.0]], 200_000)), 30.0);
    for k in [0, 1000, 199_999] {
        let [tip, ..] = pole.corner_normals(k).unwrap();
        assert!(closest(&pole, k) > 0.99 && tip.z.abs() < 0.55, "{k}: {tip}");
    }
}

#[test]
fn memory_counts_before_it_is_used() {
    let mut cube = soup(&cube());
    let count = cube.len() as u64;
    let memory = MemoryLedger::of(Some(count * 60 - 1));
    let refusal = add_smooth_normals(&mut cube, &[], 100.0, 1, &memory).unwrap_err();
    assert!(refusal.what.contains("smooth normals") && cube.normals.is_empty());
    let memory = MemoryLedger::of(Some(count * (60 + 3 * 28)));
    assert_eq!(
        add_smooth_normals(&mut cube, &[], 100.0, 1, &memory),
        Ok(true)
    );
    assert!(memory.used() >= count * 12 + 10 * 12, "{}", memory.used());
}
