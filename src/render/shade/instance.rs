//! Hits on instances: evaluated in the space of the mesh, and transformed into the world's.

use super::surface_point::{SurfacePoint, gather_column, unit_or};
use phalanx_scene::{PAD, Scene};
use phalanx_trace::packet::RayPacket;
use phalanx_trace::simd::{F32x8, LANES, Lanes, Vec3x8};

/// The transforms of eight instances, both ways: three columns of the matrix and the translation
/// each.
pub(super) struct InstanceTransforms {
    to_object: [Vec3x8; 4],
    pub(super) to_world: [Vec3x8; 4],
}

impl InstanceTransforms {
    pub(super) fn of(scene: &Scene, instances: &[usize; LANES]) -> InstanceTransforms {
        let i = &scene.instances;
        InstanceTransforms {
            to_object: std::array::from_fn(|k| gather_column(&i.to_object[k], instances)),
            to_world: std::array::from_fn(|k| gather_column(&i.to_world[k], instances)),
        }
    }

    /// The rays in the space of the meshes.
    pub(super) fn to_object(&self, rays: &RayPacket) -> RayPacket {
        RayPacket {
            org: linear(&self.to_object, rays.org) + self.to_object[3],
            dir: linear(&self.to_object, rays.dir),
            tmax: rays.tmax,
        }
    }

    /// Transforms a normal of the meshes' space into the world, where it has another length.
    #[inline(always)]
    pub(super) fn normal_to_world(&self, n: Vec3x8) -> Vec3x8 {
        let [mx, my, mz, _] = self.to_object;
        Vec3x8::new(mx.dot(n), my.dot(n), mz.dot(n))
    }

    /// Transforms a point of the meshes' space into the world. Normals are transformed by the
    /// transpose of the map that was applied to the rays. As with ellipsoids, the offset covers the
    /// rounding of the next ray's transform into the mesh's space, where a step along the normal is
    /// scaled by the length of the gradient Mᵀn.
    pub(super) fn to_world(&self, inside: SurfacePoint, rays: &RayPacket) -> SurfacePoint {
        let point = linear(&self.to_world, inside.point) + self.to_world[3];
        let [mx, my, mz, shift] = self.to_object;
        let gradient = self.normal_to_world(inside.ng);
        let length = gradient.dot(gradient).sqrt();
        let ng = unit_or(gradient, -rays.dir);
        let ns = unit_or(self.normal_to_world(inside.ns), ng);
        let outward = unit_or(self.normal_to_world(inside.outward), ng);
        let p = point.abs();
        let terms =
            ((mx.abs().scale(p.x) + my.abs().scale(p.y)) + mz.abs().scale(p.z)) + shift.abs();
        let reach = (terms.max_abs() * F32x8::splat(PAD) + inside.offset) / length;
        SurfacePoint {
            point,
            ng,
            ns,
            outward,
            offset: reach + point.max_abs() * F32x8::splat(PAD),
        }
    }
}

/// Transforms a vector.
pub(super) fn linear([x, y, z, _]: &[Vec3x8; 4], v: Vec3x8) -> Vec3x8 {
    (x.scale(v.x) + y.scale(v.y)) + z.scale(v.z)
}
