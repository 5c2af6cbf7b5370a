//! A scene made twice: through C's interface, and by the library.

use crate::rng::Rng;
use phalanx::glam::{DAffine3, DQuat, dvec3};
use phalanx::{Bvh, Scene};
use phalanx_c::batch::PhxHitLists;
use phalanx_c::columns::PhxColumn;
use phalanx_c::hits::PhxHits;
use phalanx_c::rows::PhxRows;
use phalanx_c::scene::*;
use phalanx_c::status::{PhxStatus, phx_error_message};
use phalanx_c::table::Opaque;
use phalanx_c::tree::{phx_tree_build, phx_tree_destroy};
use std::ffi::CStr;
use std::ptr::{null, null_mut};

pub struct TwinScenes {
    pub scene: *mut Opaque,
    pub tree: *mut Opaque,
    pub bvh: Bvh,
}

pub const NO_ROWS: PhxRows = PhxRows {
    data: null(),
    stride: 0,
};

pub const NO_COLUMN: PhxColumn = PhxColumn {
    data: null_mut(),
    stride: 0,
    miss: 0,
    reserved: 0,
};
pub const NO_HITS: PhxHits = PhxHits {
    size: size_of::<PhxHits>(),
    t: NO_COLUMN,
    u: NO_COLUMN,
    v: NO_COLUMN,
    prim_id: NO_COLUMN,
    geom_id: NO_COLUMN,
    local_prim_id: NO_COLUMN,
    inst_id: NO_COLUMN,
    normal: NO_COLUMN,
    scene: null(),
};

/// Asserts that a call has succeeded.
pub fn check(status: PhxStatus) {
    // SAFETY: the library's text.
    let words = unsafe { CStr::from_ptr(phx_error_message()) };
    assert_eq!(status, PhxStatus::Ok, "{words:?}");
}

/// Rows of an array.
pub fn rows<T>(array: &[T]) -> PhxRows {
    PhxRows {
        data: array.as_ptr().cast(),
        stride: size_of::<T>(),
    }
}

pub fn mesh(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> PhxMesh {
    PhxMesh {
        size: size_of::<PhxMesh>(),
        vertices: rows(vertices),
        vertex_count: vertices.len(),
        triangles: rows(triangles),
        triangle_count: triangles.len(),
    }
}

/// Lists before a call fills them.
pub fn no_lists() -> PhxHitLists {
    let size = size_of::<PhxHitLists>();
    // SAFETY: numbers, and pointers that may be null.
    PhxHitLists {
        size,
        ..unsafe { std::mem::zeroed() }
    }
}

impl TwinScenes {
    /// Triangles, spheres and instances by chance.
    pub fn new(seed: u64) -> TwinScenes {
        let mut rng = Rng::new(seed);
        let vertices: Vec<[f32; 3]> = (0..3000).map(|_| rng.point(5.0).into()).collect();
        let near = |k: u32| [k, (k + 1) % 3000, (k + 2) % 3000];
        let triangles: Vec<[u32; 3]> = (0..3000).map(near).collect();
        let centers: Vec<[f32; 3]> = (0..200).map(|_| rng.point(6.0).into()).collect();
        let radii: Vec<f32> = (0..200).map(|_| rng.range(0.02, 0.4)).collect();
        let maps: Vec<DAffine3> = (0..50)
            .map(|_| {
                let axis = rng.direction().as_dvec3().normalize();
                let turn = DQuat::from_axis_angle(axis, f64::from(rng.range(0.0, 6.0)));
                DAffine3::from_rotation_translation(turn, rng.point(6.0).as_dvec3())
                    * DAffine3::from_scale(dvec3(0.1, 0.2, 0.3))
            })
            .collect();
        let mut scene = Scene::new();
        scene.add_mesh(&vertices, &triangles).unwrap();
        scene.add_spheres(&centers, &radii).unwrap();
        let leaf = scene
            .add_prototype(&vertices[..60], &triangles[..58])
            .unwrap();
        for map in &maps {
            scene.add_instance(leaf, *map).unwrap();
        }
        let (mut handle, mut tree) = (null_mut(), null_mut());
        // SAFETY: all is memory of this function's.
        unsafe {
            check(phx_scene_create_for(phx_version(), &mut handle));
            check(phx_scene_add_mesh(
                handle,
                &mesh(&vertices, &triangles),
                null_mut(),
            ));
            let mut id = 9;
            check(phx_scene_add_spheres(
                handle,
                rows(&centers),
                rows(&radii),
                200,
                &mut id,
            ));
            assert_eq!(id, 1);
            check(phx_scene_add_prototype(
                handle,
                &mesh(&vertices[..60], &triangles[..58]),
                &mut id,
            ));
            assert_eq!(id, leaf);
            for map in &maps {
                let [x, y, z, w] = [
                    map.matrix3.x_axis,
                    map.matrix3.y_axis,
                    map.matrix3.z_axis,
                    map.translation,
                ];
                let row = |k: usize| [x[k], y[k], z[k], w[k]];
                check(phx_scene_add_instance(
                    handle,
                    leaf,
                    &[row(0), row(1), row(2)],
                    null_mut(),
                ));
            }
            check(phx_tree_build(handle, null(), &mut tree));
        }
        TwinScenes {
            scene: handle,
            tree,
            bvh: Bvh::build(&scene),
        }
    }
}

impl Drop for TwinScenes {
    fn drop(&mut self) {
        check(phx_tree_destroy(self.tree));
        check(phx_scene_destroy(self.scene));
    }
}
