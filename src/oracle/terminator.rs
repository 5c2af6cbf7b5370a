//! Lights that a smooth surface faces; explained in `scene::terminator`.

use super::intersect::{OracleHit, max, max_abs};
use super::primitives::unit_or;
use super::search::SceneSearch;
use super::shading::{OracleLightSample, OracleSurface, OracleTerminatorShift};
use glam::Vec3;
use phalanx_scene::{PrimKind, SMOOTH_SLOPE, Scene};

impl OracleTerminatorShift {
    /// The smooth surface; `None` if shadows follow the triangle itself.
    pub(super) fn of(scene: &Scene, hit: &OracleHit, surface: &OracleSurface) -> Option<Self> {
        let placed = scene.smooth_shadows.then(|| scene.resolve(hit.prim_id))?;
        let prim = scene.prims[placed.prim as usize];
        if prim.kind() != PrimKind::Triangle {
            return None;
        }
        let [a, b, c] = scene.triangles.corners(prim.index());
        let normals = scene.triangles.corner_normals(prim.index())?;
        let normals = normals.map(|n| if surface.entering { n } else { -n });
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
            normal: unit_or(normal, surface.ng),
        })
    }
}

impl OracleLightSample {
    /// Share of the light that reaches a hit: V, without facets of the smooth surface that the hit
    /// is on, if there is one and the light reaches it.
    pub(super) fn visibility(&self, search: &SceneSearch, from: &OracleHit) -> Vec3 {
        let Some((above, is_beneath)) = &self.above else {
            return search.visibility(&self.ray, self.tmax);
        };
        if !search.occluded(&self.ray, self.tmax) {
            return Vec3::ONE;
        }
        if search.visibility(above, self.tmax) == Vec3::ZERO {
            return search.visibility(&self.ray, self.tmax);
        }
        let scene = search.scene;
        let facing = |hit: &OracleHit| Facing::of(scene, self.ray.dir, hit);
        let start = facing(from);
        let mut is_inside = *is_beneath;
        let mut spared_at: Option<f32> = None;
        search.visibility_past(&self.ray, self.tmax, |hit| {
            let (Some(start), Some(here)) = (&start, facing(hit)) else {
                return false;
            };
            // Seen from the viewer's side, the ray leaves the body where it faces as at its start,
            // or where it does not if it starts beneath.
            let leaves =
                here.facet != 0 && start.facet != 0 && (here.facet == start.facet) != *is_beneath;
            let enters = here.facet != 0 && start.facet != 0 && !leaves;
            let is_lit = (here.smooth == start.facet) != *is_beneath && here.smooth != 0;
            let is_near = here
                .corners
                .iter()
                .any(|corner| start.corners.contains(corner));
            let is_edge = spared_at.is_some_and(|t| hit.t - t <= hit.t / 65_536.0);
            let spared = here.instance == start.instance
                && (leaves && (is_inside || is_edge)
                    || enters && is_lit && is_near && (!is_inside || is_edge));
            if spared {
                is_inside = enters;
                spared_at = Some(hit.t);
            }
            spared
        })
    }
}

/// A triangle with vertex normals, as a ray meets it.
struct Facing {
    instance: Option<u32>,
    corners: [u32; 3],
    /// Signs of the direction's products with the outward and with the interpolated normal.
    facet: i8,
    smooth: i8,
}

impl Facing {
    fn of(scene: &Scene, dir: Vec3, hit: &OracleHit) -> Option<Facing> {
        let placed = scene.resolve(hit.prim_id);
        let prim = scene.prims[placed.prim as usize];
        if prim.kind() != PrimKind::Triangle {
            return None;
        }
        let normals = scene.triangles.corner_normals(prim.index())?;
        let [na, nb, nc] = normals.map(Vec3::as_dvec3);
        let [a, b, c] = scene.triangles.corners(prim.index()).map(Vec3::as_dvec3);
        let dir = match placed.instance {
            None => dir,
            Some(instance) => {
                let [mx, my, mz, _] = scene.instances.object_columns(instance as usize);
                (mx * dir.x + my * dir.y) + mz * dir.z
            }
        };
        let dir = dir.as_dvec3();
        let sign = |x: f64| i8::from(x > 0.0) - i8::from(x < 0.0);
        let normal = (b - a).cross(c - a);
        let (beta, gamma) = (f64::from(hit.u), f64::from(hit.v));
        let smooth = (na * ((1.0 - beta) - gamma) + nb * beta) + nc * gamma;
        Some(Facing {
            instance: placed.instance,
            corners: scene.triangles.corners[prim.index()],
            facet: sign(normal.dot(dir)) * sign(normal.dot((na + nb) + nc)),
            smooth: sign(smooth.dot(dir)),
        })
    }
}
