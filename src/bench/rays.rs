//! The rays that are measured: camera rays of one picture, and rays that start at their hits.
//!
//! Every kind but the first starts at every primary hit, regardless of material, so a scene's rates
//! do not depend on its materials. The oracle computes the hits and their normals, so the rays have
//! the same bits on every machine, and no kernel affects the rays that it is measured with.

use super::answer::Answer;
use crate::peers::RaySetRef;
use bumpalo::Bump;
use glam::{DVec3, Vec3};
use phalanx_oracle::{OracleHit, OracleRay, OracleSurface};
use phalanx_render::frame::DEFAULT_TILE;
use phalanx_render::{Tile, push_camera_rays, tiles};
use phalanx_report::{QueryKind, RayKind};
use phalanx_scene::camera::Camera;
use phalanx_scene::sampling::Sampling;
use phalanx_scene::{Scene, ViewError};
use phalanx_trace::packet::{NO_PRIM, RayQueue};

/// Rays of one kind, in a renderer's order.
pub struct RaySet<'a> {
    /// Kind of the rays.
    pub kind: RayKind,
    /// The rays.
    pub queue: RayQueue<'a>,
    /// Hits count only below this distance.
    pub tmax: f32,
}

impl RaySet<'_> {
    /// The rays in the form for engines.
    pub fn rays(&self) -> RaySetRef<'_> {
        RaySetRef {
            queue: &self.queue,
            tmax: self.tmax,
        }
    }
}

/// The camera rays of a picture, in a render's tiles and packets.
///
/// # Errors
/// [`ViewError`] if the scene was not validated.
pub fn primary<'a>(
    arena: &'a Bump,
    scene: &Scene,
    [width, height]: [u32; 2],
) -> Result<RaySet<'a>, ViewError> {
    let camera = Camera::new(&scene.view, width, height)?;
    let mut queue = RayQueue::with_capacity(arena, width as usize * height as usize);
    for tile in tiles(Tile::whole(width, height), DEFAULT_TILE) {
        push_camera_rays(&mut queue, &camera, tile, &Sampling::CENTER, 0);
    }
    Ok(RaySet {
        kind: RayKind::Primary,
        queue,
        tmax: f32::INFINITY,
    })
}

/// Index of refraction of all surfaces, for [`RayKind::Refraction`].
const GLASS: f32 = 1.5;

/// Length of [`RayKind::Ao`]'s rays as a share of the diagonal of the scene's box.
const AO_REACH: f32 = 0.05;

/// Rays of a kind that start at the hits of the primary rays.
pub fn secondary<'a>(
    arena: &'a Bump,
    scene: &Scene,
    kind: RayKind,
    primary: &RaySet,
    answer: &Answer,
) -> RaySet<'a> {
    let light = light(scene);
    let bounds = scene.bounds();
    let reach = (bounds.hi - bounds.lo).length() * AO_REACH;
    let mut queue = RayQueue::with_capacity(arena, answer.hits(primary.queue.len()));
    for (index, ray, hit) in hits(primary, answer) {
        let surface = OracleSurface::new(scene, &ray, &hit);
        let next = match kind {
            RayKind::Primary => Some(ray),
            RayKind::Shadow => light.and_then(|light| toward(scene, light, &surface)),
            RayKind::Reflection => Some(surface.offset_origin(mirrored(ray.dir, surface.ns))),
            RayKind::Refraction => {
                refracted(ray.dir, &surface).map(|dir| surface.offset_origin(dir))
            }
            RayKind::Diffuse => Some(surface.offset_origin(hemisphere(surface.ns, index))),
            RayKind::Ao => Some(surface.offset_origin(hemisphere(surface.ns, index) * reach)),
        };
        if let Some(next) = next {
            queue.push_ray(next.org.to_array(), next.dir.to_array());
        }
    }
    // Occlusion is tested up to the tip of the direction, or without limit for a directional light.
    let far = kind == RayKind::Shadow && light.is_some_and(|light| scene.lights.directional[light]);
    let segments = kind.query() == QueryKind::Occluded && !far;
    RaySet {
        kind,
        queue,
        tmax: if segments { 1.0 } else { f32::INFINITY },
    }
}

/// Primary rays that hit, with their indices.
fn hits<'s>(
    primary: &'s RaySet,
    answer: &'s Answer,
) -> impl Iterator<Item = (usize, OracleRay, OracleHit)> + 's {
    let packets = match answer {
        Answer::Closest(packets) => packets.as_slice(),
        Answer::Occluded(_) => &[],
    };
    let count = primary.queue.len();
    let rows = packets.iter().enumerate().flat_map(|(packet, hit)| {
        let (t, u, v) = (hit.t.to_array(), hit.u.to_array(), hit.v.to_array());
        let prim_id = hit.prim_id.to_array();
        (0..8).map(move |lane| {
            let [t, u, v] = [t[lane], u[lane], v[lane]];
            let prim_id = prim_id[lane];
            (packet * 8 + lane, OracleHit { t, u, v, prim_id })
        })
    });
    let rows = rows.filter(move |(index, hit)| *index < count && hit.prim_id != NO_PRIM);
    rows.map(|(index, hit)| {
        let (org, dir) = primary.queue.ray(index / 8, index % 8);
        (index, OracleRay::new(org.into(), dir.into()), hit)
    })
}

/// The target of shadow rays: of the lights that cast shadows, the first point light, or else the
/// first.
fn light(scene: &Scene) -> Option<usize> {
    let lights = &scene.lights;
    let mut casting = (0..lights.len()).filter(|&light| lights.casts_shadows(light));
    let point = casting.clone().find(|&light| !lights.directional[light]);
    point.or(casting.next())
}

/// The shadow ray toward a light, if the surface faces it.
fn toward(scene: &Scene, light: usize, surface: &OracleSurface) -> Option<OracleRay> {
    let position = scene.lights.center(light);
    let dir = if scene.lights.directional[light] {
        position
    } else {
        position - surface.point
    };
    let faces = dir.dot(surface.ng) > 0.0 && dir.dot(surface.ns) > 0.0;
    faces.then(|| surface.offset_origin(dir))
}

fn mirrored(dir: Vec3, n: Vec3) -> Vec3 {
    unit(dir - n * (2.0 * dir.dot(n)))
}

/// Direction refracted by Snell's law; `None` at total reflection.
fn refracted(dir: Vec3, surface: &OracleSurface) -> Option<Vec3> {
    let eta = if surface.entering { 1.0 / GLASS } else { GLASS };
    let cos = -dir.dot(surface.ns);
    let k = 1.0 - (eta * eta) * (1.0 - cos * cos);
    (k >= 0.0).then(|| unit(dir * eta + surface.ns * (eta * cos - k.sqrt())))
}

fn unit(v: Vec3) -> Vec3 {
    v * (1.0 / v.dot(v).sqrt())
}

/// A unit direction around `n`, cosine-distributed, selected by the ray's index. Computed in f64
/// with `libm`: the same bits on every machine.
fn hemisphere(n: Vec3, index: usize) -> Vec3 {
    let bits = scrambled(index as u64);
    let [a, b] = [bits >> 32, bits & 0xffff_ffff].map(|half| (half as f64 + 0.5) / 4_294_967_296.0);
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * a);
    let radius = b.sqrt();
    let n = n.as_dvec3();
    // An axis across the normal: one with a small component.
    let across = if n.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
    let x = across.cross(n).normalize();
    let y = n.cross(x);
    let dir = x * (radius * cos) + y * (radius * sin) + n * (1.0 - b).sqrt();
    dir.normalize().as_vec3()
}

/// SplitMix64's output function (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
/// Generators", 2014).
fn scrambled(index: u64) -> u64 {
    let z = index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
