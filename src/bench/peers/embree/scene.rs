//! Conversion of our scenes to Embree's, and of the numbers of its primitives to ours.
//!
//! The primitives of the world, and those of each mesh, become two geometries of an Embree scene:
//! triangles with number 0, spheres with number 1. An instance of a mesh is an instance of the
//! mesh's scene; in the world's, instance k is number k + 2.
//!
//! The best quality is Embree's high one, which adds spatial splits to medium: over twice the time
//! to build, and 15 to 24 % more primary rays on the terrain (1 to 6 % in the room; shadow and
//! diffuse rays −5 to 9 %; Embree 4.4.0, one thread). Robust scenes are not split.

use super::api::{CommittedScene, Device, EmbreeFault, EmbreeSceneDraft, SceneOptions};
use super::layout::INVALID;
use phalanx_scene::{PrimKind, Scene};
use phalanx_trace::packet::NO_PRIM;
use std::ops::Range;
use std::sync::Arc;

const TRIANGLES: u32 = 0;
const SPHERES: u32 = 1;
const FIRST_INSTANCE: u32 = 2;

/// A scene in Embree's trees.
pub(super) struct EmbreeSceneData {
    pub(super) built: CommittedScene,
    pub(super) prim_ids: PrimIdMap,
    /// True if packets of sixteen are traced as such, for incoherent and for coherent rays.
    pub(super) sixteen: [bool; 2],
}

impl EmbreeSceneData {
    /// Builds the meshes' scenes, then the world's.
    pub(super) fn build(
        device: &Arc<Device>,
        scene: &Scene,
        options: SceneOptions,
    ) -> Result<EmbreeSceneData, EmbreeFault> {
        let mesh = |mesh| {
            let mut draft = EmbreeSceneDraft::new(device, options)?;
            let run = scene.meshes.prims(mesh);
            let first = run.start;
            let prim_ids = GeometryPrimIds::add(&mut draft, scene, &[run], first)?;
            Ok((draft.build()?, prim_ids))
        };
        let meshes = (0..scene.meshes.len()).map(mesh);
        let meshes: Vec<(CommittedScene, GeometryPrimIds)> = meshes.collect::<Result<_, _>>()?;
        let mut draft = EmbreeSceneDraft::new(device, options)?;
        let world = GeometryPrimIds::add(&mut draft, scene, &scene.world_runs(), 0)?;
        let mut instances = Vec::with_capacity(scene.instances.len());
        for k in 0..scene.instances.len() {
            let mesh = scene.instances.mesh[k];
            let columns = scene.instances.world_columns(k).map(|c| c.to_array());
            let id = FIRST_INSTANCE + k as u32;
            draft.instance(id, &meshes[mesh as usize].0, &columns)?;
            instances.push((mesh, scene.instance_first_id(k)));
        }
        Ok(EmbreeSceneData {
            built: draft.build()?,
            // Debian's 3.13.5 never returns from a coherent occlusion query of sixteen rays that
            // meets instances: in that kernel (not in those of triangles and spheres) the compiler
            // stores a mask of 16 bits, and reads 64.
            sixteen: [
                device.sixteen,
                device.sixteen && (device.version[0] > 3 || scene.instances.is_empty()),
            ],
            prim_ids: PrimIdMap {
                same: instances.is_empty() && world.same(),
                world,
                meshes: meshes.into_iter().map(|(_, prim_ids)| prim_ids).collect(),
                instances,
            },
        })
    }
}

/// Map from Embree's numbers to our `prim_id`s.
pub(super) struct PrimIdMap {
    /// True if every primitive has the same number as in our scene, so that no look-up is needed.
    pub(super) same: bool,
    world: GeometryPrimIds,
    meshes: Vec<GeometryPrimIds>,
    /// Mesh and first `prim_id` of each instance.
    instances: Vec<(u32, u32)>,
}

impl PrimIdMap {
    /// The `prim_id` of a hit.
    #[inline]
    pub(super) fn prim_id(&self, prim: u32, geometry: u32, instance: u32) -> u32 {
        if geometry == INVALID {
            return NO_PRIM;
        }
        if instance == INVALID {
            return self.world.prim_id(geometry, prim);
        }
        let (mesh, first) = self.instances[(instance - FIRST_INSTANCE) as usize];
        first + self.meshes[mesh as usize].prim_id(geometry, prim)
    }
}

/// Numbers of the primitives of one Embree scene, relative to the first primitive of its mesh.
struct GeometryPrimIds {
    triangles: PrimIds,
    spheres: PrimIds,
}

/// Numbers of one kind's primitives.
enum PrimIds {
    /// Consecutive numbers from this one on.
    From(u32),
    /// A number for each primitive, for primitives mixed with other kinds.
    Each(Vec<u32>),
}

impl PrimIds {
    fn new(numbers: Vec<u32>) -> PrimIds {
        let first = numbers.first().copied().unwrap_or(0);
        let in_order = (first..)
            .zip(&numbers)
            .all(|(want, &number)| want == number);
        if in_order { PrimIds::From(first) } else { PrimIds::Each(numbers) }
    }

    fn prim_id(&self, prim: u32) -> u32 {
        match self {
            PrimIds::From(first) => first + prim,
            PrimIds::Each(numbers) => numbers[prim as usize],
        }
    }

    fn is_from_zero(&self) -> bool {
        matches!(self, PrimIds::From(0))
    }
}

impl GeometryPrimIds {
    /// Adds the primitives of some runs to a draft. Kinds that Embree lacks do not occur, because
    /// the caller has checked.
    fn add(
        draft: &mut EmbreeSceneDraft,
        scene: &Scene,
        runs: &[Range<u32>],
        first: u32,
    ) -> Result<GeometryPrimIds, EmbreeFault> {
        let of_kind = |kind: PrimKind| -> (Vec<usize>, Vec<u32>) {
            let prims = runs.iter().cloned().flatten();
            let prims = prims.map(|id| (scene.prims[id as usize], id - first));
            let prims = prims.filter(|(prim, _)| prim.kind() == kind);
            prims.map(|(prim, number)| (prim.index(), number)).unzip()
        };
        let (triangles, triangle_numbers) = of_kind(PrimKind::Triangle);
        if !triangles.is_empty() {
            let (vertices, corners) = indexed(scene, &triangles);
            draft.triangles(TRIANGLES, &vertices, &corners)?;
        }
        let (spheres, sphere_numbers) = of_kind(PrimKind::Sphere);
        if !spheres.is_empty() {
            let rows = spheres.iter().map(|&i| {
                let center = scene.spheres.center.get(i);
                [center.x, center.y, center.z, scene.spheres.radius[i]]
            });
            let rows: Vec<[f32; 4]> = rows.collect();
            draft.spheres(SPHERES, &rows)?;
        }
        Ok(GeometryPrimIds {
            triangles: PrimIds::new(triangle_numbers),
            spheres: PrimIds::new(sphere_numbers),
        })
    }

    #[inline]
    fn prim_id(&self, geometry: u32, prim: u32) -> u32 {
        if geometry == TRIANGLES {
            self.triangles.prim_id(prim)
        } else {
            self.spheres.prim_id(prim)
        }
    }

    /// Returns true if both kinds are numbered as in the scene. A kind without primitives counts as
    /// such.
    fn same(&self) -> bool {
        self.triangles.is_from_zero() && self.spheres.is_from_zero()
    }
}

/// The vertex indices of some triangles, and the vertices in the range of these indices.
fn indexed(scene: &Scene, triangles: &[usize]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let all = &scene.triangles;
    let named = || triangles.iter().flat_map(|&i| all.corners[i]);
    let (lo, hi) = (named().min().unwrap_or(0), named().max().unwrap_or(0));
    let vertices = (lo..=hi).map(|v| all.vertices.get(v as usize).to_array());
    let corners = triangles.iter().map(|&i| all.corners[i].map(|v| v - lo));
    (vertices.collect(), corners.collect())
}
