//! Rescaling of coordinates, so that products of four of them neither overflow nor vanish in f32.

use super::{PrimKind, Scene, Vec3s};
use crate::prims::{Prim, RowScale, ScaleFactors};
use crate::threads::{BLOCK_ROWS, map_on_pool};
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Largest coordinate (as a power of two) of an unscaled scene. If the largest one is beyond it, or
/// below its inverse, the scene is scaled.
const SAFE_EXTENT: f32 = 268_435_456.0; // 2^28

/// Largest colour of a light that compensates for a dimmer attenuation: brighter than any picture
/// can show, while sums stay finite.
const MAX_RADIANCE: f64 = 1.2676506002282294e30; // 2^100

impl Scene {
    /// Scales the scene by an exact power of two if its largest coordinate lies outside \[2⁻²⁸,
    /// 2²⁸\], so that the largest becomes about 1. [`Scene::scale`] records the factor; the picture
    /// stays the same.
    ///
    /// Meshes have their own spaces. They are measured and scaled separately, and the maps of
    /// instances compensate for both factors as far as they can: meshes too small for that are too
    /// small to be visible.
    pub fn rescale_to_f32_range(&mut self) {
        let world = power_of_two_factor(self.largest_coordinate());
        let meshes = f64::from(power_of_two_factor(self.largest_in_meshes()));
        let ratio = self.instances.bounded_factor(meshes / f64::from(world));
        let scale = ScaleFactors {
            world,
            meshes: (f64::from(world) * ratio) as f32,
        };
        let apart = scale.world != scale.meshes && self.shares_vertices();
        if (scale.world, scale.meshes) != (1.0, 1.0) && !apart {
            self.scale_by(scale);
            self.edits.mark_everything();
        }
    }

    /// Returns true if camera and lights lie within the safe range.
    pub fn is_in_safe_range(&self) -> bool {
        self.largest_of_view_and_lights() <= f64::from(SAFE_EXTENT)
    }

    /// Largest coordinate of the safe range, in the file's units.
    pub fn safe_extent(&self) -> f64 {
        f64::from(SAFE_EXTENT) / f64::from(self.scale)
    }

    /// Largest coordinate of all visible primitives, of the camera and of the lights.
    fn largest_coordinate(&self) -> f64 {
        let shapes = if self.has_only_the_world() {
            self.largest_stored()
        } else {
            self.largest_seen()
        };
        shapes.max(self.largest_of_view_and_lights())
    }

    /// Returns true if all that is stored is visible, or may be.
    fn has_only_the_world(&self) -> bool {
        self.meshes.is_empty() && self.geometries.is_empty()
    }

    fn largest_of_view_and_lights(&self) -> f64 {
        let view = self.view.eye.abs().max(self.view.center.abs());
        let lights = (0..self.lights.len())
            .filter(|&i| !self.lights.directional[i])
            .map(|i| self.reach_of_light(i));
        lights.fold(f64::from(view.max_element()), f64::max)
    }

    /// Largest coordinate in all rows of all columns, whatever they belong to.
    fn largest_stored(&self) -> f64 {
        let kinds = PrimKind::ALL.into_iter();
        let largest = kinds.map(|kind| self.columns_of(kind).largest_of_all());
        largest.fold(0.0, f64::max)
    }

    /// Largest coordinate of the primitives in the world itself, and of the boxes of instances
    /// there.
    fn largest_seen(&self) -> f64 {
        let world = self.largest_reach(self.world_runs());
        let meshes = self.bounds_of_meshes();
        let instances = self.visible_instances().map(|k| {
            let mesh = self.instances.mesh[k] as usize;
            let (lo, hi) = self.instances.corners(k, meshes[mesh]);
            lo.abs().max(hi.abs()).max_element()
        });
        instances.fold(world, f64::max)
    }

    /// Largest coordinate of the contents of meshes, in their own spaces.
    fn largest_in_meshes(&self) -> f64 {
        let meshes = (0..self.meshes.len()).map(|mesh| self.meshes.prims(mesh));
        self.largest_reach(meshes)
    }

    /// Largest coordinate of the stored primitives in these runs.
    fn largest_reach(&self, runs: impl IntoIterator<Item = Range<u32>>) -> f64 {
        let reach = |prim: &Prim| {
            self.columns_of(prim.kind())
                .largest_coordinate(prim.index())
        };
        let of_run = |run: Range<u32>| {
            let prims = &self.prims[run.start as usize..run.end as usize];
            map_on_pool(prims.chunks(BLOCK_ROWS), |block| {
                block.iter().map(reach).fold(0.0, f64::max)
            })
        };
        runs.into_iter().flat_map(of_run).fold(0.0, f64::max)
    }

    /// Largest coordinate of a light that is not directional.
    fn reach_of_light(&self, i: usize) -> f64 {
        let lights = &self.lights;
        let [position, e, f] = [&lights.position, &lights.edges[0], &lights.edges[1]]
            .map(|column| column.get(i).as_dvec3().abs());
        (position + e + f).max_element() + f64::from(lights.radius[i])
    }

    fn scale_by(&mut self, scale: ScaleFactors) {
        let world = scale.world;
        self.scale *= world;
        let cameras = self.cameras.iter_mut().map(|camera| &mut camera.view);
        for view in cameras.chain([&mut self.view]) {
            view.eye *= world;
            view.center *= world;
            view.ortho = view.ortho.map(|height| height * world);
        }
        self.scale_shapes(scale);
        self.scale_instances(scale);
        let lights = &mut self.lights;
        for i in 0..lights.len() {
            if lights.directional[i] {
                continue;
            }
            lights.radius[i] *= world;
            for column in lights.edges.iter_mut().chain([&mut lights.position]) {
                let scaled = column.get(i) * world;
                column.set(i, scaled);
            }
            let (attenuation, color) =
                scaled_attenuation(lights.attenuation.get(i), lights.color.get(i), world);
            lights.attenuation.set(i, attenuation);
            lights.color.set(i, color);
        }
    }

    fn scale_shapes(&mut self, factors: ScaleFactors) {
        let in_meshes = self.rows_in_meshes();
        for (kind, in_meshes) in PrimKind::ALL.into_iter().zip(in_meshes) {
            let scale = RowScale { factors, in_meshes };
            self.columns_of_mut(kind).rescale(&scale);
        }
    }

    /// Changes the maps of instances to go from one scaled space to the other and back. This is
    /// done in f64: the quotient of the factors may lie beyond f32 even if its product with the map
    /// does not.
    fn scale_instances(&mut self, scale: ScaleFactors) {
        let (world, meshes) = (f64::from(scale.world), f64::from(scale.meshes));
        let all = |columns: &mut [Vec3s], factor: f64| {
            for part in columns.iter_mut().flat_map(|v| v.parts_mut()) {
                let scaled = |c: &mut f32| *c = (f64::from(*c) * factor) as f32;
                part.iter_mut().for_each(scaled);
            }
        };
        let maps = &mut self.instances;
        all(&mut maps.to_world[..3], world / meshes);
        all(&mut maps.to_world[3..], world);
        all(&mut maps.to_object[..3], meshes / world);
        all(&mut maps.to_object[3..], meshes);
    }

    /// Marks the rows of each kind that belong to meshes; no lists for a scene without meshes.
    fn rows_in_meshes(&self) -> [Vec<bool>; PrimKind::COUNT] {
        if self.meshes.is_empty() {
            return Default::default();
        }
        let mut marks = self.counts().map(|count| vec![false; count]);
        for prim in (0..self.meshes.len()).flat_map(|mesh| self.meshes.prims(mesh)) {
            let prim = self.prims[prim as usize];
            marks[prim.kind() as usize][prim.index()] = true;
        }
        marks
    }

    /// Returns true if a vertex is used both in a mesh and in the world: two factors would tear it
    /// apart.
    fn shares_vertices(&self) -> bool {
        let marks = &self.rows_in_meshes()[PrimKind::Triangle as usize];
        let vertices = self.triangles.marked_vertices(marks);
        let triangles = self.triangles.corners.iter().zip(marks);
        let mut world = triangles.filter(|(_, in_mesh)| !**in_mesh);
        world.any(|(corners, _)| corners.iter().any(|&v| vertices[v as usize]))
    }
}

/// The factor that makes the largest coordinate about 1, or 1 if it is in the safe range.
fn power_of_two_factor(largest: f64) -> f32 {
    let comfort = f64::from(SAFE_EXTENT);
    if largest == 0.0 || !largest.is_finite() || (1.0 / comfort..=comfort).contains(&largest) {
        return 1.0;
    }
    // Bounded so that the factor and its inverse are both normal numbers. At the ends of f32's
    // range the largest coordinate ends up within SAFE_EXTENT, if not at 1.
    let (_, exponent) = libm::frexp(largest);
    libm::scalbn(1.0, (-exponent).clamp(-126, 126)) as f32
}

/// The attenuation that gives the same light at the scaled distance, (const, lin/s, quad/s²), and
/// the colour with it. If the attenuation would leave f32, it and the colour are both multiplied by
/// the same power of two.
fn scaled_attenuation(attenuation: Vec3, color: Vec3, scale: f32) -> (Vec3, Vec3) {
    let s = f64::from(scale);
    let scaled = attenuation.as_dvec3() / DVec3::new(1.0, s, s * s);
    let (_, exponent) = libm::frexp(scaled.max_element());
    if (-100..=100).contains(&exponent) {
        return (scaled.as_vec3(), color);
    }
    let common = libm::scalbn(1.0, -exponent);
    let bounded = |c: f64| c.clamp(-MAX_RADIANCE, MAX_RADIANCE) as f32;
    let color = (color.as_dvec3() * common).to_array().map(bounded);
    ((scaled * common).as_vec3(), Vec3::from_array(color))
}

#[cfg(test)]
mod tests {
    use crate::{Material, Scene};
    use glam::{DAffine3, Vec3};

    /// A factor that suits the mesh alone would leave the maps that bring it back beyond their
    /// limits.
    #[test]
    fn meshes_that_are_too_small_for_their_world_leave_a_valid_scene() {
        for tiny in [1e-9, 1e-20, 1e-36] {
            let mut scene = Scene::default();
            scene.materials.push(&Material::default());
            let mesh = scene.begin_mesh();
            scene.add_triangle([Vec3::ZERO, Vec3::X * tiny, Vec3::Y * tiny], None, 0);
            scene.end_mesh(mesh);
            scene.add_instance(mesh, DAffine3::IDENTITY).unwrap();
            scene.add_triangle([Vec3::X, Vec3::Y, Vec3::Z], None, 0);
            scene.rescale_to_f32_range();
            assert_eq!(scene.validate(), Ok(()), "{tiny}");
        }
    }
}
