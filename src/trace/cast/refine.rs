//! A hit in double precision: where the ray meets the surface that single precision has found.

use super::Hit;
use glam::{DMat3, DVec3};
use phalanx_scene::{PrimKind, Scene, Triangles};

/// A hit in double precision.
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
    let instance = resolved
        .instance
        .map(|i| InstanceMaps::of(scene, i as usize));
    let t = f64::from(hit.t);
    let columns = scene.columns_of(prim.kind());
    let (t, normal) = match instance {
        None => columns.refine(prim.index(), origin, direction, t),
        Some(maps) if prim.kind() == PrimKind::Triangle => {
            let corners = scene.triangles.corners(prim.index());
            let corners = corners.map(|corner| maps.to_world(corner.as_dvec3()));
            Triangles::refine_on_plane(corners, origin, direction, t)
        }
        Some(maps) => {
            // A curved surface is met in the space where it is stored. Distances are the same.
            let (from, along) = (maps.to_object(origin), maps.object * direction);
            let (t, normal) = columns.refine(prim.index(), from, along, t);
            (t, maps.normal(normal))
        }
    };
    RefinedHit {
        t,
        point: (origin + t * direction).into(),
        normal: normal.normalize_or_zero().into(),
    }
}

/// The two maps of an instance, each the inverse of the other.
struct InstanceMaps {
    world: DMat3,
    world_offset: DVec3,
    object: DMat3,
    object_offset: DVec3,
}

impl InstanceMaps {
    fn of(scene: &Scene, i: usize) -> InstanceMaps {
        let instances = &scene.instances;
        let (world, object) = (instances.world_columns(i), instances.object_columns(i));
        let [wx, wy, wz, world_offset] = world.map(|c| c.as_dvec3());
        let [ox, oy, oz, object_offset] = object.map(|c| c.as_dvec3());
        InstanceMaps {
            world: DMat3::from_cols(wx, wy, wz),
            world_offset,
            object: DMat3::from_cols(ox, oy, oz),
            object_offset,
        }
    }

    fn to_world(&self, point: DVec3) -> DVec3 {
        self.world * point + self.world_offset
    }

    fn to_object(&self, point: DVec3) -> DVec3 {
        self.object * point + self.object_offset
    }

    /// A normal goes to the world by the transpose of the inverse.
    fn normal(&self, normal: DVec3) -> DVec3 {
        self.object.transpose() * normal
    }
}
