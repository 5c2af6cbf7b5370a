//! Meshes stored once and placed many times.

use super::{Bounds, Column, PAD, Vec3s};
use glam::{DAffine3, DVec3, Vec3};

/// Runs of [`super::Scene::prims`] that are seen only through instances.
#[derive(Clone, Debug, Default)]
pub struct Meshes {
    /// First primitive of each.
    pub first: Column<u32>,
    /// Number of primitives of each, at least 1.
    pub count: Column<u32>,
}

impl Meshes {
    /// Number of meshes.
    pub fn len(&self) -> usize {
        self.first.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// The primitives of a mesh.
    pub fn prims(&self, mesh: usize) -> std::ops::Range<u32> {
        let first = self.first[mesh];
        first..first + self.count[mesh]
    }
}

/// Meshes placed in the world. Each map is stored as three columns of its matrix and its translation.
#[derive(Clone, Debug, Default)]
pub struct Instances {
    /// Which mesh.
    pub mesh: Column<u32>,
    /// Primitives of all instances before this one: see [`super::Scene::placed`].
    pub first: Column<u32>,
    /// Mesh to world.
    pub to_world: [Vec3s; 4],
    /// World to mesh.
    pub to_object: [Vec3s; 4],
}

/// An instance's map has no inverse, or a number of it or of its inverse is beyond single precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the transform cannot be inverted in single precision")]
pub struct NotInvertible;

impl Instances {
    /// Number of instances.
    pub fn len(&self) -> usize {
        self.mesh.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.mesh.is_empty()
    }

    pub(super) fn push(
        &mut self,
        mesh: u32,
        first: u32,
        to_world: DAffine3,
    ) -> Result<(), NotInvertible> {
        let to_object = to_world.inverse();
        let columns = |map: DAffine3| {
            let m = map.matrix3;
            [m.x_axis, m.y_axis, m.z_axis, map.translation].map(|c| c.as_vec3())
        };
        let maps = [columns(to_world), columns(to_object)];
        if to_world.matrix3.determinant() == 0.0 || !maps.iter().flatten().all(|c| c.is_finite()) {
            return Err(NotInvertible);
        }
        for (columns, map) in [&mut self.to_world, &mut self.to_object]
            .into_iter()
            .zip(maps)
        {
            for (column, vector) in columns.iter_mut().zip(map) {
                column.push(vector);
            }
        }
        self.mesh.push(mesh);
        self.first.push(first);
        Ok(())
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

    /// World bounds of an instance of a mesh with these bounds, grown by what the rounding of the two maps can
    /// amount to: [`PAD`] of the largest number that each of them adds up.
    pub fn bounds(&self, i: usize, mesh: Bounds) -> Bounds {
        if mesh.is_empty() {
            return Bounds::EMPTY;
        }
        let to_world = self.world_columns(i).map(|c| c.as_dvec3());
        let to_object = self.object_columns(i).map(|c| c.as_dvec3());
        let (lo, hi) = (mesh.lo.as_dvec3(), mesh.hi.as_dvec3());
        let (center, half) = ((lo + hi) / 2.0, (hi - lo) / 2.0);
        let place = linear(&to_world, center) + to_world[3];
        let reach = linear(&to_world.map(DVec3::abs), half);
        let (lo, hi) = (place - reach, place + reach);
        // A place p of the world becomes Mp + s with an error of |M||p| + |s|, which comes back through |W|.
        let far = lo.abs().max(hi.abs());
        let lost = linear(&to_object.map(DVec3::abs), far) + to_object[3].abs();
        let slack = linear(&to_world.map(DVec3::abs), lost) * f64::from(PAD);
        Bounds::new((lo - slack).as_vec3(), (hi + slack).as_vec3())
    }
}

fn linear([x, y, z, _]: &[DVec3; 4], v: DVec3) -> DVec3 {
    *x * v.x + *y * v.y + *z * v.z
}
