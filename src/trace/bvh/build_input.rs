//! Input of a tree build: primitives, and in the world's tree also instances.

use super::{LeafCone, LeafEllipsoid, LeafInstance, LeafKind, LeafPrims, LeafSphere, LeafTriangle};
use phalanx_scene::{Bounds, PrimKind, Scene};
use rayon::prelude::*;

/// Number of an object: a stored primitive below [`Scene::prim_count`], from there on an instance.
pub(super) type PrimIndex = u32;

/// An object and its padded box.
#[derive(Clone, Copy)]
pub(super) struct PrimRef {
    pub(super) object: PrimIndex,
    pub(super) bounds: Bounds,
}

impl PrimRef {
    /// Twice the centre of the box.
    pub(super) fn center(&self) -> glam::Vec3 {
        self.bounds.lo + self.bounds.hi
    }
}

/// Access to the boxes, kinds and rows of objects.
pub(super) struct BuildInput<'a> {
    scene: &'a Scene,
    prims: u32,
    /// Bounds of every mesh, in its own space.
    mesh_bounds: Vec<Bounds>,
}

impl<'a> BuildInput<'a> {
    pub(super) fn new(scene: &'a Scene) -> BuildInput<'a> {
        let meshes = (0..scene.meshes.len()).into_par_iter();
        BuildInput {
            scene,
            prims: scene.prim_count() as u32,
            mesh_bounds: meshes.map(|mesh| scene.mesh_bounds(mesh)).collect(),
        }
    }

    /// The objects of the world.
    pub(super) fn world(&self) -> Vec<PrimIndex> {
        let direct = self.scene.world_runs().into_iter().flatten();
        let instances = 0..self.scene.instances.len() as u32;
        direct.chain(instances.map(|k| self.prims + k)).collect()
    }

    /// The objects of a mesh.
    pub(super) fn mesh(&self, mesh: usize) -> Vec<PrimIndex> {
        self.scene.meshes.prims(mesh).collect()
    }

    pub(super) fn kind(&self, object: PrimIndex) -> LeafKind {
        match object < self.prims {
            true => LeafKind::Prim(self.scene.prims[object as usize].kind()),
            false => LeafKind::Instance,
        }
    }

    /// The padded box, from which every box around it is made.
    pub(super) fn bounds(&self, object: PrimIndex) -> Bounds {
        if object < self.prims {
            return self.scene.prim_bounds(object).padded();
        }
        let k = (object - self.prims) as usize;
        let mesh = self.scene.instances.mesh[k] as usize;
        let bounds = self.scene.instances.bounds(k, self.mesh_bounds[mesh]);
        bounds.padded()
    }

    /// The objects with their boxes.
    pub(super) fn prim_refs(&self, all: Vec<PrimIndex>) -> Vec<PrimRef> {
        let all = all.into_par_iter().map(|object| PrimRef {
            object,
            bounds: self.bounds(object),
        });
        all.collect()
    }

    /// Appends an object to its column.
    pub(super) fn store(&self, item: &PrimRef, slots: &mut LeafPrims) {
        let object = item.object;
        let prim_aabb = [item.bounds.lo.to_array(), item.bounds.hi.to_array()];
        if object >= self.prims {
            return slots.instances.push(self.instance(object, prim_aabb));
        }
        let scene = self.scene;
        let prim = scene.prims[object as usize];
        let i = prim.index();
        match prim.kind() {
            PrimKind::Triangle => slots.triangles.push(LeafTriangle {
                vertices: scene.triangles.corners(i).map(|c| c.to_array()),
                prim_id: object,
            }),
            PrimKind::Sphere => slots.spheres.push(LeafSphere {
                center: scene.spheres.center.get(i).to_array(),
                radius: scene.spheres.radius[i],
                prim_aabb,
                prim_id: object,
            }),
            PrimKind::Ellipsoid => slots.ellipsoids.push(LeafEllipsoid {
                to_object: scene.ellipsoids.object_columns(i).map(|c| c.to_array()),
                prim_aabb,
                prim_id: object,
            }),
            PrimKind::Cone => slots.cones.push(self.cone(i, prim_aabb, object)),
        }
    }

    fn cone(&self, i: usize, prim_aabb: [[f32; 3]; 2], prim_id: u32) -> LeafCone {
        let cones = &self.scene.cones;
        let frame = cones.frame(i);
        LeafCone {
            base: frame.base.to_array(),
            axes: frame.axes.map(|axis| axis.to_array()),
            length: frame.length,
            radius: frame.radius,
            sin: frame.sin,
            cos_squared: frame.cos_squared,
            prim_aabb,
            inside: u32::from(cones.inside[i]),
            prim_id,
        }
    }

    fn instance(&self, object: PrimIndex, prim_aabb: [[f32; 3]; 2]) -> LeafInstance {
        let k = (object - self.prims) as usize;
        let mesh = self.scene.instances.mesh[k] as usize;
        let first_id = self.scene.instance_first_id(k);
        LeafInstance {
            to_object: self.scene.instances.object_columns(k).map(|c| c.to_array()),
            prim_aabb,
            // The root of the mesh's tree is known once all trees exist.
            root: mesh as u32,
            id_offset: first_id.wrapping_sub(self.scene.meshes.first[mesh]),
        }
    }
}
