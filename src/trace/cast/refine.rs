//! A hit in double precision: where the ray meets the surface that single precision has found.

use super::Hit;
use glam::{DAffine3, DVec3, Vec3};
use phalanx_scene::{PrimKind, ResolvedPrim, Scene, Triangles};

/// A hit in double precision.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefinedHit {
    /// Distance in units of the ray's direction.
    pub t: f64,
    /// The point, in the scene's coordinates.
    pub point: [f64; 3],
    /// Outward unit normal of the surface there, in the world: of a triangle that of its plane,
    /// whose corners are counter-clockwise seen from where it points. Zero where a surface has
    /// none, as a triangle without area.
    pub normal: [f64; 3],
}

/// Computes a hit again from the ray and the primitive alone, in double precision, with the ray as
/// the caller has it. Coordinates of the scene are taken as they are stored.
///
/// The primitive is not tested again: a ray that misses it by a rounding error in double precision
/// gets the point on the triangle's plane, and one that passes a sphere gets the point next to it.
/// Where there is no answer (a ray within a triangle's plane), and on cones, `t` is that of the
/// hit. Costs about 50 ns; no bits of other answers depend on it.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{Bvh, Ray, Scene, refine};
///
/// let mut scene = Scene::new();
/// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
/// let hit = Bvh::build(&scene).intersect(&Ray::new([0.1, 0.0, -3.0], [0.0, 0.0, 1.0]));
/// let refined = refine(&scene, [0.1, 0.0, -3.0], [0.0, 0.0, 1.0], &hit.expect("a hit"));
/// assert!((refined.t - (3.0 - 0.99f64.sqrt())).abs() < 1e-15);
/// assert!((refined.normal[0] - 0.1).abs() < 1e-15);
/// # Ok::<(), phalanx::GeometryError>(())
/// ```
///
/// # Panics
/// If the hit's `prim_id` is not one of the scene.
pub fn refine(scene: &Scene, origin: [f64; 3], direction: [f64; 3], hit: &Hit) -> RefinedHit {
    let (origin, direction) = (DVec3::from(origin), DVec3::from(direction));
    let resolved = scene.resolve(hit.prim_id);
    let prim = scene.prims[resolved.prim as usize];
    let instances = &scene.instances;
    let t = f64::from(hit.t);
    let columns = scene.columns_of(prim.kind());
    let (t, normal) = match resolved.instance {
        None => columns.refine(prim.index(), origin, direction, t),
        Some(_) if prim.kind() == PrimKind::Triangle => {
            let corners = corners_in_world(scene, resolved);
            Triangles::refine_on_plane(corners, origin, direction, t)
        }
        Some(instance) => {
            // A curved surface is met in the space where it is stored. Distances are the same.
            let to_object = affine(instances.object_columns(instance as usize));
            let from = to_object.transform_point3(origin);
            let along = to_object.transform_vector3(direction);
            let (t, normal) = columns.refine(prim.index(), from, along, t);
            // A normal goes to the world by the transpose of the inverse.
            (t, to_object.matrix3.transpose() * normal)
        }
    };
    RefinedHit {
        t,
        point: (origin + t * direction).into(),
        normal: normal.normalize_or_zero().into(),
    }
}

/// Corners of a triangle in the world, in double precision; `None` for another primitive.
///
/// ```
/// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
/// use phalanx::{Scene, world_corners};
///
/// let mut scene = Scene::new();
/// scene.add_mesh(&[[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]], &[[0, 1, 2]])?;
/// let [a, b, c] = world_corners(&scene, 0).expect("a triangle");
/// assert_eq!((b - a).cross(c - a).to_array(), [0.0, 0.0, 16.0]);
/// # Ok::<(), phalanx::GeometryError>(())
/// ```
///
/// # Panics
/// If `prim_id` is not one of the scene.
pub fn world_corners(scene: &Scene, prim_id: u32) -> Option<[DVec3; 3]> {
    let resolved = scene.resolve(prim_id);
    let kind = scene.prims[resolved.prim as usize].kind();
    (kind == PrimKind::Triangle).then(|| corners_in_world(scene, resolved))
}

fn corners_in_world(scene: &Scene, resolved: ResolvedPrim) -> [DVec3; 3] {
    let row = scene.prims[resolved.prim as usize].index();
    let corners = scene.triangles.corners(row).map(|corner| corner.as_dvec3());
    let Some(instance) = resolved.instance else {
        return corners;
    };
    let to_world = affine(scene.instances.world_columns(instance as usize));
    corners.map(|corner| to_world.transform_point3(corner))
}

/// A map in double precision.
fn affine(columns: [Vec3; 4]) -> DAffine3 {
    let [x, y, z, offset] = columns.map(|column| column.as_dvec3());
    DAffine3::from_cols(x, y, z, offset)
}
