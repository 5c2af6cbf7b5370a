//! A hint for rooms: the default camera, which frames the whole model, shows only outer walls.
//!
//! A closed object on a large plane is not a room: its walls are far from the sides of the scene's
//! box.

use glam::Vec3;
use phalanx::camera::Camera;
use phalanx::scene::{Scene, View};
use phalanx::{Bvh, Hit, HitBuffer, Ray, RayBuffer};
use std::collections::HashSet;

/// Side of the small test picture, in pixels.
const SIDE: u32 = 32;
/// Minimum number of primitives of a furnished room.
const MIN_PRIMS: usize = 1000;
/// Hits per visible primitive above which a few large faces are taken to hide the rest.
const HITS_PER_PRIM: usize = 16;

/// Share of the distance to the sides of the scene's box that is free in most horizontal directions
/// of a room.
const FREE_WAY: f32 = 0.25;

/// Vertical field of view of the suggested camera, in degrees.
const FOVY: f32 = 60.0;

/// Suggests a camera inside the model if the default camera sees only a few large faces and the
/// centre of the model is enclosed; `None` otherwise, or if the scene has a camera.
pub fn hint(scene: &Scene, bvh: &Bvh) -> Option<String> {
    if !scene.defaulted.view || scene.prim_count() < MIN_PRIMS {
        return None;
    }
    let (hits, prims) = seen(bvh, &scene.view);
    if hits <= HITS_PER_PRIM * prims {
        return None;
    }
    let bounds = scene.bounds();
    let eye = (bounds.lo + bounds.hi) / 2.0;
    let up = scene.view.up;
    let half = (bounds.hi - bounds.lo) / 2.0;
    let hits = hits_of(bvh, directions().map(|way| (eye, way)));
    let free = |way: Vec3| FREE_WAY * (half / way.abs()).min_element();
    let level = directions()
        .zip(&hits)
        .filter(|(way, _)| way.dot(up) == 0.0);
    let is_wide = level.map(|(way, hit)| hit.is_none_or(|hit| hit.t >= free(way)));
    let is_wide = Vec::from_iter(is_wide);
    let wide = is_wide.iter().filter(|wide| **wide).count();
    if hits.iter().flatten().count() * 20 < hits.len() * 19 || wide * 2 < is_wide.len() {
        return None;
    }
    let size = (bounds.hi - bounds.lo).max_element();
    let view = |direction: Vec3| View {
        eye,
        center: eye + direction * size / 2.0,
        up,
        fovy: FOVY,
        ortho: None,
    };
    let level = directions().filter(|direction| direction.dot(up) == 0.0);
    let richest = level.map(view).max_by_key(|view| seen(bvh, view).1)?;
    let [eye, center] = [eye, richest.center].map(|point| words(scene, point, size / scene.scale));
    Some(format!(
        "a few large faces hide the rest; if this is a room, try a camera inside it: --camera {eye} {center} {},{},{} {FOVY}",
        up.x, up.y, up.z
    ))
}

/// Numbers of hits and of different primitives hit in a small picture of this view.
fn seen(bvh: &Bvh, view: &View) -> (usize, usize) {
    let Ok(camera) = Camera::new(view, SIDE, SIDE) else {
        return (0, 0);
    };
    let ray = |k: u32| camera.ray((k / SIDE) as f32 + 0.5, (k % SIDE) as f32 + 0.5);
    let hits = hits_of(bvh, (0..SIDE * SIDE).map(ray));
    let prims: HashSet<_> = hits.iter().flatten().map(|hit| hit.prim_id).collect();
    (hits.iter().flatten().count(), prims.len())
}

/// The hits of rays, given by origin and direction. They are a batch of more than a few
/// hundred, because smaller ones build the wide tree, which a frame of few pixels does not need.
/// Those of a hint that is given may build it after all: they are many.
fn hits_of(bvh: &Bvh, rays: impl Iterator<Item = (Vec3, Vec3)>) -> Vec<Option<Hit>> {
    let rays: RayBuffer = rays.map(|(origin, way)| Ray::new(origin, way)).collect();
    let mut hits = HitBuffer::new(rays.len());
    bvh.intersect_batch(&rays.columns(), &mut hits.columns(), 1)
        .expect("columns of one length");
    hits.iter().collect()
}

/// Unit vectors in all directions: from the centre of a cube to a grid on its faces.
fn directions() -> impl Iterator<Item = Vec3> {
    let cell = |k: i32| {
        Vec3::new(
            (k % 11 - 5) as f32,
            (k / 11 % 11 - 5) as f32,
            (k / 121 - 5) as f32,
        )
    };
    let on_face = |cell: &Vec3| cell.abs().max_element() == 5.0;
    (0..1331).map(cell).filter(on_face).map(Vec3::normalize)
}

/// A position as `--camera` takes it, to a hundredth or a thousandth of the model's size.
fn words(scene: &Scene, position: Vec3, size: f32) -> String {
    let digits = (2.0 - size.log10()).ceil().clamp(0.0, 9.0) as usize;
    let [x, y, z] = scene.short_position(position).to_array();
    format!("{x:.digits$},{y:.digits$},{z:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds a closed box, each of whose faces is a grid of `cells`² squares.
    fn add_box(scene: &mut Scene, lo: Vec3, size: f32, cells: u32) {
        let mut vertices: Vec<[f32; 3]> = Vec::new();
        let mut indices: Vec<[u32; 3]> = Vec::new();
        for face in 0..6 {
            for cell in 0..cells * cells {
                let first = vertices.len() as u32;
                for [a, b] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
                    let coordinate = |k: u32| k as f32 / cells as f32;
                    let mut corner = [
                        coordinate(cell % cells + a),
                        coordinate(cell / cells + b),
                        (face / 3) as f32,
                    ];
                    corner.rotate_right(face % 3);
                    vertices.push((lo + Vec3::from(corner) * size).to_array());
                }
                indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            }
        }
        scene.add_mesh(&vertices, &indices).unwrap();
    }

    fn hint_of(boxes: &[(Vec3, f32, u32)]) -> Option<String> {
        let mut scene = Scene::default();
        for &(lo, size, cells) in boxes {
            add_box(&mut scene, lo, size, cells);
        }
        hint_in(scene)
    }

    fn hint_in(mut scene: Scene) -> Option<String> {
        scene.view.eye = Vec3::new(20.0, 14.0, 40.0);
        scene.view.center = Vec3::splat(2.0);
        scene.view.up = Vec3::Y;
        scene.view.fovy = 20.0;
        scene.defaulted.view = true;
        scene.defaulted.light = true;
        let bvh = Bvh::build(&scene);
        let hint = hint(&scene, &bvh);
        assert!(hint.is_some() || !bvh.has_wide(), "a frame may not need it");
        hint
    }

    #[test]
    fn a_furnished_room_is_looked_into_and_a_solid_is_not() {
        let (room, table) = ((Vec3::ZERO, 10.0, 1), (Vec3::splat(1.0), 2.0, 14));
        let hint = hint_of(&[room, table]).unwrap();
        let options = "--camera 5.0,5.0,5.0 1.1,5.0,1.9 0,1,0 60";
        assert!(hint.ends_with(options), "{hint}");
        assert_eq!(
            hint_of(&[(Vec3::ZERO, 10.0, 14)]),
            None,
            "a finely divided box"
        );
        assert_eq!(hint_of(&[room]), None, "a plain box");
        let far = (Vec3::new(30.0, 0.0, 0.0), 10.0, 1);
        assert_eq!(hint_of(&[room, table, far]), None, "the middle is outside");
    }

    #[test]
    fn a_closed_object_on_a_ground_is_no_room() {
        let mut scene = Scene::default();
        add_box(&mut scene, Vec3::new(-1.0, 0.0, -1.0), 2.0, 14);
        let corner = |x: f32, z: f32| Vec3::new(x * 60.0, 0.0, z * 60.0);
        for k in [-1.0, 1.0] {
            let corners = [corner(-1.0, -1.0), corner(1.0, 1.0), corner(k, -k)];
            scene.add_triangle(corners, None, 0);
        }
        assert_eq!(hint_in(scene), None);
    }
}
