//! Meshes stored once and placed many times.

use super::{Bounds, Column, NO_NAME, PAD, Vec3s};
use glam::{DAffine3, DVec3, Vec3};

/// Meshes: runs of [`super::Scene::prims`] that are visible only through instances.
#[derive(Clone, Debug, Default)]
pub struct Meshes {
    /// First primitive of each mesh.
    pub first: Column<u32>,
    /// Number of primitives of each mesh; 0 for a prototype that was removed.
    pub count: Column<u32>,
}

impl Meshes {
    /// Number of meshes.
    #[inline]
    pub fn len(&self) -> usize {
        self.first.len()
    }

    /// Returns true if there are no meshes.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// The primitives of a mesh.
    #[inline]
    pub fn prims(&self, mesh: usize) -> std::ops::Range<u32> {
        let first = self.first[mesh];
        first..first + self.count[mesh]
    }
}

/// Meshes placed in the world. Each map is stored as the three columns of its matrix and its
/// translation.
#[derive(Clone, Debug, Default)]
pub struct Instances {
    /// Index of the mesh.
    pub mesh: Column<u32>,
    /// Number of primitives of all instances before this one, with those that are free again: see
    /// [`super::Scene::resolve`].
    pub first: Column<u32>,
    /// Number of its name in [`super::Scene::names`], or [`NO_NAME`].
    pub name: Column<u32>,
    /// Mesh-to-world map.
    pub to_world: [Vec3s; 4],
    /// World-to-mesh map.
    pub to_object: [Vec3s; 4],
}

/// Largest factor by which a map or its inverse may stretch a direction, and one over the smallest
/// length of its longest column. Beyond it, squares of mapped mesh coordinates leave single
/// precision.
const MAX_STRETCH: f64 = 1_099_511_627_776.0; // 2^40

impl Instances {
    /// Number of instances.
    #[inline]
    pub fn len(&self) -> usize {
        self.mesh.len()
    }

    /// Returns true if there are no instances.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.mesh.is_empty()
    }

    /// Adds an instance with both of its maps.
    pub(super) fn push(&mut self, mesh: u32, first: u32, maps: [[Vec3; 4]; 2]) {
        for column in self.to_world.iter_mut().chain(&mut self.to_object) {
            column.push(Vec3::ZERO);
        }
        self.set_maps(self.len(), maps);
        self.mesh.push(mesh);
        self.first.push(first);
        self.name.push(NO_NAME);
    }

    /// The columns of a map and of its inverse; `None` if it has none in single precision.
    pub(super) fn maps(to_world: DAffine3) -> Option<[[Vec3; 4]; 2]> {
        let to_object = to_world.inverse();
        let columns = |map: DAffine3| {
            let m = map.matrix3;
            [m.x_axis, m.y_axis, m.z_axis, map.translation].map(|c| c.as_vec3())
        };
        let maps = [columns(to_world), columns(to_object)];
        let fine = |map: &[Vec3; 4]| map.iter().all(|c| c.is_finite()) && is_moderate(map);
        (to_world.matrix3.determinant() != 0.0 && maps.iter().all(fine)).then_some(maps)
    }

    /// Replaces both maps of an instance.
    pub(super) fn set_maps(&mut self, i: usize, maps: [[Vec3; 4]; 2]) {
        let columns = self.to_world.iter_mut().chain(&mut self.to_object);
        for (column, vector) in columns.zip(maps.into_iter().flatten()) {
            column.set(i, vector);
        }
    }

    /// The four columns of the mesh-to-world map.
    #[inline]
    pub fn world_columns(&self, i: usize) -> [Vec3; 4] {
        std::array::from_fn(|k| self.to_world[k].get(i))
    }

    /// The four columns of the world-to-mesh map.
    #[inline]
    pub fn object_columns(&self, i: usize) -> [Vec3; 4] {
        std::array::from_fn(|k| self.to_object[k].get(i))
    }

    /// Returns true if [`super::Scene::add_instance`] would accept both maps. It does not check
    /// that they are each other's inverse.
    #[inline]
    pub(super) fn has_moderate_transforms(&self, i: usize) -> bool {
        is_moderate(&self.world_columns(i)) && is_moderate(&self.object_columns(i))
    }

    /// The power of two that is nearest to another one, `factor`, by which the meshes' contents may
    /// be scaled beside the world, so that all maps stay as [`super::Scene::add_instance`] accepts
    /// them.
    pub(super) fn bounded_factor(&self, mut factor: f64) -> f64 {
        // The factor of nearly every scene, and within any bounds.
        if factor == 1.0 {
            return factor;
        }
        let (mut least, mut most) = (0.0f64, f64::INFINITY);
        for i in (0..self.len()).filter(|&i| self.has_moderate_transforms(i)) {
            let [world, object] = [self.world_columns(i), self.object_columns(i)].map(longest);
            least = least
                .max(world / MAX_STRETCH)
                .max(1.0 / (object * MAX_STRETCH));
            most = most.min(world * MAX_STRETCH).min(MAX_STRETCH / object);
        }
        while factor > most {
            factor /= 2.0;
        }
        while factor < least {
            factor *= 2.0;
        }
        factor
    }

    /// World bounds of an instance of a mesh with these bounds, grown by the greatest rounding
    /// error of the two maps: [`PAD`] of the largest number that each of them adds up.
    #[inline]
    pub fn bounds(&self, i: usize, mesh: Bounds) -> Bounds {
        if mesh.is_empty() {
            return Bounds::EMPTY;
        }
        let (lo, hi) = self.corners(i, mesh);
        Bounds::new(lo.as_vec3(), hi.as_vec3())
    }

    /// The corners of [`Instances::bounds`] of a mesh that is not empty, before rounding or
    /// overflow.
    pub(super) fn corners(&self, i: usize, mesh: Bounds) -> (DVec3, DVec3) {
        let to_world = self.world_columns(i).map(|c| c.as_dvec3());
        let to_object = self.object_columns(i).map(|c| c.as_dvec3());
        let (lo, hi) = (mesh.lo.as_dvec3(), mesh.hi.as_dvec3());
        let (center, half) = ((lo + hi) / 2.0, (hi - lo) / 2.0);
        let position = linear(&to_world, center) + to_world[3];
        let reach = linear(&to_world.map(DVec3::abs), half);
        let (lo, hi) = (position - reach, position + reach);
        // A world position p becomes Mp + s with an error of |M||p| + |s|, which maps back to the
        // world through |W|.
        let far = lo.abs().max(hi.abs());
        let lost = linear(&to_object.map(DVec3::abs), far) + to_object[3].abs();
        let slack = linear(&to_world.map(DVec3::abs), lost) * f64::from(PAD);
        (lo - slack, hi + slack)
    }
}

/// Returns true if the longest column of a map's matrix is neither too long nor too short.
fn is_moderate(map: &[Vec3; 4]) -> bool {
    (1.0 / MAX_STRETCH..=MAX_STRETCH).contains(&longest(*map))
}

/// Length of the longest column of a map's matrix.
fn longest([x, y, z, _]: [Vec3; 4]) -> f64 {
    let lengths = [x, y, z].map(|c| c.as_dvec3().length());
    lengths.into_iter().fold(0.0, f64::max)
}

fn linear([x, y, z, _]: &[DVec3; 4], v: DVec3) -> DVec3 {
    *x * v.x + *y * v.y + *z * v.z
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DQuat};

    /// Checks that a position that single precision maps to the mesh and back is still within the
    /// box.
    #[test]
    fn boxes_hold_what_rounding_does_to_their_corners() {
        let mut seed = 1u32;
        let mut unit = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) * 2.0 - 1.0
        };
        let mesh = Bounds::new(Vec3::splat(-1.0), Vec3::ONE);
        let mut beyond_padding = 0;
        for _ in 0..2000 {
            let mut turn =
                || DMat3::from_quat(DQuat::from_xyzw(unit(), unit(), unit(), unit()).normalize());
            let turns = [turn(), turn()];
            let stretch = DVec3::new(unit(), unit(), unit()) * 3.0;
            let stretch = stretch.to_array().map(|e| libm::pow(10.0, e));
            let map = DAffine3 {
                matrix3: turns[0] * DMat3::from_diagonal(stretch.into()) * turns[1],
                translation: DVec3::new(unit(), unit(), unit()) * 100.0,
            };
            let mut instances = Instances::default();
            instances.push(0, 0, Instances::maps(map).expect("an invertible map"));
            let (own, [wx, wy, wz, wt]) = (instances.bounds(0, mesh), instances.world_columns(0));
            let [mx, my, mz, mt] = instances.object_columns(0);
            for corner in 0..8 {
                let side = |bit: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
                let p = Vec3::new(side(0), side(1), side(2));
                let world = (wx * p.x + wy * p.y + wz * p.z) + wt;
                let back = (mx * world.x + my * world.y + mz * world.z) + mt;
                let again = linear(&[wx, wy, wz, wt].map(|c| c.as_dvec3()), back.as_dvec3())
                    + wt.as_dvec3();
                let inside = |b: Bounds| {
                    again.cmpge(b.lo.as_dvec3()).all() && again.cmple(b.hi.as_dvec3()).all()
                };
                assert!(inside(own), "{p} comes back at {again}, outside {own:?}");
                let position = map.transform_point3(p.as_dvec3());
                let far = (again - position).abs().max_element();
                beyond_padding += usize::from(far > f64::from(PAD) * position.abs().max_element());
            }
        }
        assert!(
            beyond_padding > 100,
            "only {beyond_padding} corners needed more than the padding"
        );
    }
}
