//! The smooth surface above a hit on a triangle with vertex normals, for shadow rays; explained in
//! `shade`.

use super::intersect::{OracleHit, OracleRay, max, max_abs};
use super::primitives::unit_or;
use super::search::SceneSearch;
use super::shading::{OracleSurface, OracleTerminatorShift};
use glam::Vec3;
use phalanx_scene::{PrimKind, SMOOTH_REACH, SMOOTH_SLOPE, Scene};

impl OracleTerminatorShift {
    /// The smooth surface; `None` if shadows follow the triangle itself.
    pub(super) fn of(scene: &Scene, hit: &OracleHit, at: &OracleSurface) -> Option<Self> {
        let placed = scene.smooth_shadows.then(|| scene.resolve(hit.prim_id))?;
        let prim = scene.prims[placed.prim as usize];
        if prim.kind() != PrimKind::Triangle {
            return None;
        }
        let [a, b, c] = scene.triangles.corners(prim.index());
        let normals = scene.triangles.corner_normals(prim.index())?;
        let normals = normals.map(|n| if at.entering { n } else { -n });
        let [na, nb, nc] = normals.map(|n| unit_or(n, Vec3::ZERO));
        let (ab, ac, bc) = (b - a, c - a, c - b);
        let (depth_ab, depth_ac) = (-ab.dot(na), -ac.dot(na));
        let (depth_ba, depth_bc) = (ab.dot(nb), -bc.dot(nb));
        let (depth_ca, depth_cb) = (ac.dot(nc), bc.dot(nc));
        let depths = [depth_ab, depth_ac, depth_ba, depth_bc, depth_ca, depth_cb];
        let least = max(max_abs(ab), max_abs(ac)) * SMOOTH_SLOPE;
        if !depths.iter().any(|&depth| depth > least) {
            return None;
        }
        let (beta, gamma) = (hit.u, hit.v);
        let alpha = (1.0 - beta) - gamma;
        let raise = |n: Vec3, weight: f32, depth: f32| n * (weight * max(depth, 0.0));
        let mut shift = (raise(na, alpha, beta * depth_ab + gamma * depth_ac)
            + raise(nb, beta, alpha * depth_ba + gamma * depth_bc))
            + raise(nc, gamma, alpha * depth_ca + beta * depth_cb);
        let [a, b, c] = normals;
        let mut normal = (a * alpha + b * beta) + c * gamma;
        if let Some(instance) = placed.instance {
            let [wx, wy, wz, _] = scene.instances.world_columns(instance as usize);
            shift = (wx * shift.x + wy * shift.y) + wz * shift.z;
            let [mx, my, mz, _] = scene.instances.object_columns(instance as usize);
            let n = unit_or(normal, Vec3::ZERO);
            normal = Vec3::new(mx.dot(n), my.dot(n), mz.dot(n));
        }
        Some(OracleTerminatorShift {
            shift,
            normal: unit_or(normal, at.ng),
        })
    }

    /// Returns true if nothing is in the way from the hit to the smooth surface, or if that is no
    /// farther than rays are offset anyway.
    pub(super) fn is_open(&self, search: &SceneSearch, at: &OracleSurface) -> bool {
        let way = OracleRay::new(at.point + at.ng * at.offset, self.shift);
        let far = max_abs(self.shift) > at.offset;
        !(far && search.occluded(&way, SMOOTH_REACH))
    }
}
