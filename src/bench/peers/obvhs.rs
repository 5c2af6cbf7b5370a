//! The traversals of obvhs with its own triangles. Our builder uses this crate; here its tracing is
//! measured.
//!
//! It traces one ray at a time, against its binary tree and against its compressed tree of eight
//! children. Occlusion uses `ray_traverse_miss`, which stops at the first hit (its
//! `ray_traverse_anyhit` is for transparency, and visits all). It has no spheres: they are
//! intersected by the plain formula, which users of the crate must supply themselves.

use super::engine::{
    BenchEngine, BenchEngineThread, PeerScene, RaySetRef, Unsupported, closest_each, occluded_each,
};
use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::{build_bvh2, build_bvh2_from_tris};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::{build_cwbvh, build_cwbvh_from_tris};
use obvhs::ray::{INVALID_ID, Ray, RayHit};
use obvhs::triangle::Triangle;
use obvhs::{Boundable, BvhBuildParams};
use phalanx_scene::{Prim, PrimKind, Scene};
use phalanx_trace::bvh::Quality;
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::LANES;
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

/// Preset for its trees. The best quality is the slowest preset: 3.7 s per tree for a million
/// triangles, seven times the time of medium, for 7 to 23 % more rays on the terrain. In the room
/// medium's trees are 20 to 40 times slower than these, and those of `slow_build` no better.
fn preset(quality: Quality) -> BvhBuildParams {
    match quality {
        Quality::Fast => BvhBuildParams::fast_build(),
        Quality::Medium => BvhBuildParams::medium_build(),
        Quality::Best => BvhBuildParams::very_slow_build(),
    }
}

/// Copies a scene and builds both trees, on one thread. Supports triangles and spheres, without
/// instances.
///
/// # Errors
/// [`Unsupported`]: primitives or instances that obvhs does not have.
pub fn build(scene: &Scene, quality: Quality) -> Result<PeerScene, Unsupported> {
    let unsupported = |reason: &str| Unsupported {
        peer: "obvhs",
        reason: reason.to_owned(),
    };
    let lacking = |prim: &Prim| !matches!(prim.kind(), PrimKind::Triangle | PrimKind::Sphere);
    if scene.prims.iter().any(lacking) {
        return Err(unsupported("it has neither ellipsoids nor cones"));
    }
    if !scene.meshes.is_empty() {
        return Err(unsupported("its binary tree has no instances"));
    }
    let preset = preset(quality);
    Ok(if scene.spheres.is_empty() {
        built_of::<Triangle>(scene, preset)
    } else if scene.triangles.is_empty() {
        built_of::<Sphere>(scene, preset)
    } else {
        built_of::<MixedShape>(scene, preset)
    })
}

fn built_of<S: ObvhsShape>(scene: &Scene, preset: BvhBuildParams) -> PeerScene {
    let shapes = scene.prims.iter().map(|&prim| S::from_prim(scene, prim));
    let shapes: Vec<S> = shapes.collect();
    let bvh2 = Arc::new(PeerTree::new(&shapes, S::bvh2(&shapes, preset)));
    let cwbvh = Arc::new(PeerTree::new(&shapes, S::cwbvh(&shapes, preset)));
    Box::new(move |rays| {
        let rays = Arc::new(obvhs_rays(rays));
        vec![
            ("bvh2".to_owned(), ObvhsEngine::boxed(&bvh2, &rays)),
            ("cwbvh".to_owned(), ObvhsEngine::boxed(&cwbvh, &rays)),
        ]
    })
}

/// A shape in obvhs's leaves.
trait ObvhsShape: Boundable + Copy + Send + Sync + 'static {
    /// The shape of a primitive, which is of a kind that it can be.
    fn from_prim(scene: &Scene, prim: Prim) -> Self;

    /// Distance along a ray, or infinity.
    fn intersect(&self, ray: &Ray) -> f32;

    fn bvh2(shapes: &[Self], preset: BvhBuildParams) -> Bvh2 {
        build_bvh2(&boxes(shapes), preset, &mut Duration::default())
    }

    fn cwbvh(shapes: &[Self], preset: BvhBuildParams) -> CwBvh {
        build_cwbvh(&boxes(shapes), preset, &mut Duration::default())
    }
}

/// The boxes of shapes: all that builders ask of them, so that one is compiled for all shapes.
fn boxes(shapes: &[impl Boundable]) -> Vec<Aabb> {
    shapes.iter().map(Boundable::aabb).collect()
}

impl ObvhsShape for Triangle {
    fn from_prim(scene: &Scene, prim: Prim) -> Triangle {
        let [v0, v1, v2] = scene.triangles.corners(prim.index()).map(Vec3A::from);
        Triangle { v0, v1, v2 }
    }

    #[inline(always)]
    fn intersect(&self, ray: &Ray) -> f32 {
        self.intersect(ray)
    }

    // Only large triangles are split beforehand.
    fn bvh2(shapes: &[Triangle], preset: BvhBuildParams) -> Bvh2 {
        build_bvh2_from_tris(shapes, preset, &mut Duration::default())
    }

    fn cwbvh(shapes: &[Triangle], preset: BvhBuildParams) -> CwBvh {
        build_cwbvh_from_tris(shapes, preset, &mut Duration::default())
    }
}

#[derive(Clone, Copy)]
struct Sphere {
    center: Vec3A,
    radius: f32,
}

impl Boundable for Sphere {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.center - self.radius, self.center + self.radius)
    }
}

impl ObvhsShape for Sphere {
    fn from_prim(scene: &Scene, prim: Prim) -> Sphere {
        Sphere {
            center: scene.spheres.center.get(prim.index()).into(),
            radius: scene.spheres.radius[prim.index()],
        }
    }

    #[inline(always)]
    fn intersect(&self, ray: &Ray) -> f32 {
        let to_center = self.center - ray.origin;
        let inv_square = 1.0 / ray.direction.dot(ray.direction);
        let middle = to_center.dot(ray.direction) * inv_square;
        let off = to_center - ray.direction * middle;
        let gap = self.radius * self.radius - off.dot(off);
        if gap < 0.0 {
            return f32::INFINITY;
        }
        let half = (gap * inv_square).sqrt();
        let (near, far) = (middle - half, middle + half);
        let t = if near > ray.tmin { near } else { far };
        if t > ray.tmin { t } else { f32::INFINITY }
    }
}

#[derive(Clone, Copy)]
enum MixedShape {
    Triangle(Triangle),
    Sphere(Sphere),
}

impl Boundable for MixedShape {
    fn aabb(&self) -> Aabb {
        match self {
            MixedShape::Triangle(triangle) => triangle.aabb(),
            MixedShape::Sphere(sphere) => sphere.aabb(),
        }
    }
}

impl ObvhsShape for MixedShape {
    fn from_prim(scene: &Scene, prim: Prim) -> MixedShape {
        match prim.kind() {
            PrimKind::Triangle => MixedShape::Triangle(Triangle::from_prim(scene, prim)),
            _ => MixedShape::Sphere(Sphere::from_prim(scene, prim)),
        }
    }

    #[inline(always)]
    fn intersect(&self, ray: &Ray) -> f32 {
        match self {
            MixedShape::Triangle(triangle) => triangle.intersect(ray),
            MixedShape::Sphere(sphere) => sphere.intersect(ray),
        }
    }
}

/// Operations that both trees support.
trait ObvhsTraversal: Send + Sync + 'static {
    /// The primitive at each position in leaf order; some primitives have several positions.
    fn order(&self) -> &[u32];
    /// Finds the closest hit.
    fn closest(&self, ray: Ray, hit: &mut RayHit, intersect: impl FnMut(&Ray, usize) -> f32);
    /// Tests that nothing is hit.
    fn misses(&self, ray: Ray, intersect: impl FnMut(&Ray, usize) -> f32) -> bool;
}

impl ObvhsTraversal for Bvh2 {
    fn order(&self) -> &[u32] {
        &self.primitive_indices
    }

    #[inline(always)]
    fn closest(&self, ray: Ray, hit: &mut RayHit, intersect: impl FnMut(&Ray, usize) -> f32) {
        self.ray_traverse(ray, hit, intersect);
    }

    #[inline(always)]
    fn misses(&self, ray: Ray, intersect: impl FnMut(&Ray, usize) -> f32) -> bool {
        self.ray_traverse_miss(ray, intersect)
    }
}

impl ObvhsTraversal for CwBvh {
    fn order(&self) -> &[u32] {
        &self.primitive_indices
    }

    #[inline(always)]
    fn closest(&self, ray: Ray, hit: &mut RayHit, intersect: impl FnMut(&Ray, usize) -> f32) {
        self.ray_traverse(ray, hit, intersect);
    }

    #[inline(always)]
    fn misses(&self, ray: Ray, intersect: impl FnMut(&Ray, usize) -> f32) -> bool {
        self.ray_traverse_miss(ray, intersect)
    }
}

/// A tree and its primitives in leaf order, as the documentation of obvhs advises.
struct PeerTree<T, S> {
    tree: T,
    shapes: Vec<S>,
    prim_ids: Vec<u32>,
}

impl<T: ObvhsTraversal, S: ObvhsShape> PeerTree<T, S> {
    /// Shapes are numbered as the scene's primitives.
    fn new(shapes: &[S], tree: T) -> PeerTree<T, S> {
        let prim_ids = tree.order().to_vec();
        PeerTree {
            shapes: prim_ids.iter().map(|&id| shapes[id as usize]).collect(),
            tree,
            prim_ids,
        }
    }
}

/// A set of rays as obvhs stores them, reciprocals included.
fn obvhs_rays(rays: RaySetRef) -> Vec<Ray> {
    let ray = |ray: usize| {
        let (org, dir) = rays.queue.ray(ray / LANES, ray % LANES);
        Ray::new(org.into(), dir.into(), 0.0, rays.tmax)
    };
    (0..rays.queue.len()).map(ray).collect()
}

struct ObvhsEngine<T, S> {
    tree: Arc<PeerTree<T, S>>,
    rays: Arc<Vec<Ray>>,
}

impl<T: ObvhsTraversal, S: ObvhsShape> ObvhsEngine<T, S> {
    fn boxed(tree: &Arc<PeerTree<T, S>>, rays: &Arc<Vec<Ray>>) -> Box<dyn BenchEngine> {
        Box::new(ObvhsEngine {
            tree: Arc::clone(tree),
            rays: Arc::clone(rays),
        })
    }
}

impl<T: ObvhsTraversal, S: ObvhsShape> BenchEngine for ObvhsEngine<T, S> {
    fn thread(&self) -> Box<dyn BenchEngineThread + '_> {
        Box::new(self)
    }
}

impl<T: ObvhsTraversal, S: ObvhsShape> BenchEngineThread for &ObvhsEngine<T, S> {
    fn closest(&mut self, packets: Range<usize>, hits: &mut [HitPacket]) {
        let PeerTree {
            tree,
            shapes,
            prim_ids,
        } = &*self.tree;
        closest_each(packets, self.rays.len(), hits, |ray| {
            let mut nearest = RayHit::none();
            tree.closest(self.rays[ray], &mut nearest, |ray, i| {
                shapes[i].intersect(ray)
            });
            let is_hit = nearest.primitive_id != INVALID_ID;
            is_hit.then(|| {
                (
                    [nearest.t, 0.0, 0.0],
                    prim_ids[nearest.primitive_id as usize],
                )
            })
        });
    }

    fn occluded(&mut self, packets: Range<usize>, blocked: &mut [u8]) {
        let PeerTree { tree, shapes, .. } = &*self.tree;
        occluded_each(packets, self.rays.len(), blocked, |ray| {
            !tree.misses(self.rays[ray], |ray, i| shapes[i].intersect(ray))
        });
    }
}
