//! Facets of a smooth surface that a shadow ray crosses although the surface itself would not block
//! it. Both tracers use these definitions.
//!
//! Triangles with vertex normals stand for a smooth surface. A point of it is lit by the side of
//! the interpolated normal n on which the light is, so its facet may face away from a light that n
//! faces. There a shadow ray starts beneath the facet, and has to leave the body through the back
//! of another facet; elsewhere it starts above. In a crease it may enter once more through the
//! front of a facet that shares a vertex with its own, if n faces the light there, too. These
//! facets are spared if a second ray, from the smooth surface above the point (Hanika, "Hacking the
//! Shadow Terminator", Ray Tracing Gems II, 2021), reaches the light: no part of the body rises
//! between the two. Whatever else is on the way from the point to the light blocks it, so nothing
//! that stands on the surface loses its shadow.

use crate::coverage::EDGE_DISTANCE;
use crate::{PrimKind, Scene, SurfaceHit};
use glam::Vec3;

/// Depth of a triangle's corner below the tangent plane at another one, as a share of the edges,
/// beyond which the triangle stands for a smooth surface: a twentieth of a degree. Vertex normals
/// of flat faces are rounded by less in most files.
pub const SMOOTH_SLOPE: f32 = 1.0 / 1024.0;

/// A shadow ray on its way through facets of the smooth surface that it starts on.
#[derive(Clone, Copy, Debug)]
pub struct OwnFacets {
    dir: Vec3,
    /// The triangle from which the ray starts.
    from: u32,
    /// Sign of the slopes of a direction that leaves the body on the viewer's side.
    side: f64,
    is_inside: bool,
    /// The last facet that was spared.
    last: Option<SurfaceHit>,
}

impl OwnFacets {
    /// A ray of this direction that starts above a triangle, or `beneath` it as the viewer sees it.
    pub fn new(scene: &Scene, dir: Vec3, from: SurfaceHit, beneath: bool) -> OwnFacets {
        let slope = scene
            .outward_slopes(dir, from)
            .map_or(0.0, |[facet, _]| facet);
        let sign = f64::from(i8::from(slope > 0.0) - i8::from(slope < 0.0));
        OwnFacets {
            dir,
            from: from.prim_id,
            side: if beneath { -sign } else { sign },
            is_inside: beneath,
            last: None,
        }
    }

    /// Returns true if the next hit in the order of (t, prim_id) does not block the ray.
    pub fn spares(&mut self, scene: &Scene, hit: SurfaceHit) -> bool {
        let [start, end] = [self.from, hit.prim_id].map(|prim_id| scene.resolve(prim_id));
        let Some([facet, smooth]) = scene.outward_slopes(self.dir, hit) else {
            return false;
        };
        // On an edge, the ray crosses two facets at once.
        let last = self
            .last
            .filter(|last| hit.t - last.t <= EDGE_DISTANCE * hit.t);
        let leaves = facet * self.side > 0.0;
        let is_spared = if leaves {
            self.is_inside || last.is_some()
        } else {
            let corners =
                |stored: u32| scene.triangles.corners[scene.prims[stored as usize].index()];
            let end = corners(end.prim);
            let is_near = || corners(start.prim).iter().any(|c| end.contains(c));
            let enters = facet * self.side < 0.0 && smooth * self.side > 0.0;
            enters && (!self.is_inside || last.is_some()) && is_near()
        };
        if !is_spared || start.instance != end.instance {
            return false;
        }
        (self.is_inside, self.last) = (!leaves, Some(hit));
        true
    }
}

impl Scene {
    /// Products of a direction with the outward normal of a triangle and with its interpolated
    /// normal, of which only the signs have a meaning; `None` without vertex normals, which define
    /// the outside.
    fn outward_slopes(&self, dir: Vec3, hit: SurfaceHit) -> Option<[f64; 2]> {
        let placed = self.resolve(hit.prim_id);
        let prim = self.prims[placed.prim as usize];
        let is_triangle = prim.kind() == PrimKind::Triangle;
        let normals = is_triangle.then(|| self.triangles.corner_normals(prim.index()))??;
        let [na, nb, nc] = normals.map(Vec3::as_dvec3);
        let [a, b, c] = self.triangles.corners(prim.index()).map(Vec3::as_dvec3);
        let dir = self.object_direction(dir, placed.instance).as_dvec3();
        let normal = (b - a).cross(c - a);
        let (beta, gamma) = (f64::from(hit.u), f64::from(hit.v));
        let smooth = (na * ((1.0 - beta) - gamma) + nb * beta) + nc * gamma;
        Some([
            normal.dot(dir) * normal.dot((na + nb) + nc),
            smooth.dot(dir),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mesh;
    use glam::DAffine3;

    /// A profile along x, extruded along y: corners are (x, z, lean of the normal along x), and
    /// each pair of neighbours makes two triangles.
    fn profile(scene: &mut Scene, corners: &[[f32; 3]]) {
        let mut mesh = Mesh::default();
        for &[x, z, lean] in corners {
            for y in [-1.0, 1.0] {
                mesh.vertices.push(Vec3::new(x, y, z));
                mesh.vertex_normals
                    .push(Vec3::new(lean, 0.0, 1.0).normalize());
            }
        }
        for k in 0..corners.len() as u32 - 1 {
            let [a, b, c, d] = [2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1];
            for corners in [[a, b, c], [a, c, d]] {
                mesh.corners.push(corners);
                mesh.normals.push(corners);
            }
        }
        scene.append_mesh(mesh);
    }

    fn hit(prim_id: u32, t: f32) -> SurfaceHit {
        SurfaceHit {
            prim_id,
            t,
            u: 0.3,
            v: 0.3,
        }
    }

    /// Facets 0 and 1 face away from a light at the right, 2 and 3 face it, and so on.
    const WAVES: [[f32; 3]; 6] = [
        [0.0, 0.0, 0.2],
        [1.0, 0.3, 0.2],
        [2.0, 0.0, 0.2],
        [3.0, 0.3, 0.2],
        [4.0, 0.0, 0.2],
        [5.0, 0.3, 0.2],
    ];

    const LIGHT: Vec3 = Vec3::new(1.0, 0.0, 0.1);

    #[test]
    fn a_ray_from_beneath_leaves_its_surface_once() {
        let mut scene = Scene::default();
        profile(&mut scene, &WAVES);
        let mut own = OwnFacets::new(&scene, LIGHT, hit(0, 1.0), true);
        assert!(own.spares(&scene, hit(2, 0.5)));
        // On the edge of the facet beside it, at the same place.
        assert!(own.spares(&scene, hit(3, 0.500_001)));
        assert!(!own.spares(&scene, hit(6, 2.5)));
        assert!(!own.spares(&scene, hit(4, 2.5)));
    }

    #[test]
    fn a_ray_from_above_leaves_nothing() {
        let mut scene = Scene::default();
        profile(&mut scene, &WAVES);
        for facing in [0, 2] {
            let mut own = OwnFacets::new(&scene, LIGHT, hit(facing, 1.0), false);
            assert!(!own.spares(&scene, hit(6, 0.5)), "{facing}");
        }
    }

    #[test]
    fn only_lit_facets_beside_its_own_let_a_ray_in() {
        let mut scene = Scene::default();
        profile(&mut scene, &WAVES);
        let spares = |dir: Vec3, from: u32, to: u32| {
            OwnFacets::new(&scene, dir, hit(from, 1.0), false).spares(&scene, hit(to, 0.5))
        };
        assert!(spares(LIGHT, 2, 4));
        // It shares no vertex.
        assert!(!spares(LIGHT, 2, 8));
        // Its normals face away.
        assert!(!spares(Vec3::new(1.0, 0.0, -0.3), 2, 4));
        // The ray leaves again, once.
        let mut own = OwnFacets::new(&scene, LIGHT, hit(2, 1.0), false);
        assert!(own.spares(&scene, hit(4, 0.5)) && own.spares(&scene, hit(6, 0.7)));
        assert!(!own.spares(&scene, hit(6, 0.9)));
    }

    #[test]
    fn instances_and_surfaces_without_normals_block_each_other() {
        let mut scene = Scene::default();
        let mesh = scene.begin_mesh();
        profile(&mut scene, &WAVES);
        scene.end_mesh(mesh);
        for _ in 0..2 {
            scene
                .add_instance(mesh, DAffine3::IDENTITY)
                .expect("invertible");
        }
        let [first, second] = [0, 1].map(|k| scene.instance_first_id(k));
        let beneath = || OwnFacets::new(&scene, LIGHT, hit(first, 1.0), true);
        assert!(beneath().spares(&scene, hit(first + 2, 0.5)));
        assert!(!beneath().spares(&scene, hit(second + 2, 0.5)));
        let mut flat = Scene::default();
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        flat.add_triangle(triangle, None, 0);
        let mut own = OwnFacets::new(&flat, -Vec3::Z, hit(0, 1.0), true);
        assert!(!own.spares(&flat, hit(0, 0.5)));
    }
}
