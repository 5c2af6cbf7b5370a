//! Secondary rays of hits: selects the bounces that are worth tracing, and queues them.

use super::bounce_queue::BounceQueue;
use super::coverage::WaveCoverage;
use super::hit_grouping::HitGroups;
use super::ray_batch::QueueSlice;
use super::wavefront_context::{WavefrontContext, is_worth_tracing};
use crate::shade::{SecondaryRays, ShadeMaterial, Surface, bounces, sample_glossy};
use bumpalo::Bump;
use glam::Vec3;
use phalanx_scene::Scene;
use phalanx_scene::sampling::{BounceKind, child_seed};
use phalanx_trace::packet::RayQueue;
use phalanx_trace::simd::Vec3x8;

/// Fills an empty queue with the mirror rays of all hits, then the refracted ones, except those
/// that are not worth tracing.
pub(super) fn spawn_secondary_rays(
    context: &mut WavefrontContext,
    arena: &Bump,
    rays: &QueueSlice,
    groups: &HitGroups,
    coverage: WaveCoverage,
    bounces: &mut BounceQueue,
) {
    let (bouncing, ways) = bouncing_groups(context.scene, arena, groups.surfaces);
    if bouncing.is_empty() {
        return;
    }
    let surface = |k: &u32| &groups.surfaces[*k as usize];
    let outgoing = bouncing.iter().map(|k| {
        let surface = surface(k);
        let mut out = sample_bounces(context, rays, &groups.material(*k as usize), surface);
        if let Some(share) = coverage.of(surface) {
            for out in [&mut out.mirror, &mut out.refracted] {
                out.weight = out.weight.scale(share);
            }
        }
        out
    });
    let outgoing = arena.alloc_slice_fill_iter(outgoing);
    let shares: &[[Vec3x8; 2]] = if context.columns.shares {
        let outgoing = bouncing.iter().zip(&mut *outgoing);
        arena.alloc_slice_fill_iter(outgoing.map(|(k, out)| {
            let divisor = groups.material(*k as usize).secondary_weight();
            drop_below_min_weight(
                context.integrator.min_weight,
                rays.shares(&surface(k).ray),
                divisor,
                out,
            )
        }))
    } else {
        &[]
    };
    let groups = || bouncing.iter().map(surface);
    bounces.fill(rays.packets.len(), ways, context.columns, |queue| {
        let push = |queue: &mut _, kind| {
            push_bounces(queue, kind, rays, groups(), outgoing, shares);
        };
        push(queue, BounceKind::Mirror);
        let mirrored = queue.len();
        push(queue, BounceKind::Refracted);
        context.stats.rays.reflection += mirrored as u64;
        context.stats.rays.refraction += (queue.len() - mirrored) as u64;
        mirrored
    });
}

/// Indices of the groups whose material sends bounces, and the maximum number of bounces per hit.
fn bouncing_groups<'arena>(
    scene: &Scene,
    arena: &'arena Bump,
    groups: &[Surface],
) -> (&'arena [u32], usize) {
    let bouncing = arena.alloc_slice_fill_copy(groups.len(), 0);
    let (mut len, mut most) = (0, 0);
    for (k, surface) in (0..).zip(groups) {
        let (m, i) = (&scene.materials, surface.material as usize);
        let ways = usize::from(m.may_mirror(i)) + usize::from(m.kt.get(i) != Vec3::ZERO);
        bouncing[len] = k;
        len += usize::from(ways > 0);
        most = most.max(ways);
    }
    (&bouncing[..len], most)
}

/// Queues the bounces of one kind. `shares` is empty where rays carry none.
#[inline]
fn push_bounces<'g>(
    queue: &mut RayQueue,
    kind: BounceKind,
    rays: &QueueSlice,
    groups: impl Iterator<Item = &'g Surface>,
    outgoing: &[SecondaryRays],
    shares: &[[Vec3x8; 2]],
) {
    for (k, (surface, out)) in groups.zip(outgoing).enumerate() {
        let (out, way) = match kind {
            BounceKind::Mirror => (&out.mirror, 0),
            BounceKind::Refracted => (&out.refracted, 1),
            // Queued by `coverage`.
            BounceKind::Passed => return,
        };
        if queue.has_seeds() {
            queue.push_seeds(out.active, &child_seed(rays.seeds(&surface.ray), kind));
        }
        if let Some(shares) = shares.get(k) {
            queue.push_shares(out.active, &shares[way]);
        }
        queue.push(out.active, out.org, out.dir, out.weight, &surface.ray);
    }
}

/// The bounces of eight hits.
fn sample_bounces(
    context: &WavefrontContext,
    rays: &QueueSlice,
    material: &ShadeMaterial,
    surface: &Surface,
) -> SecondaryRays {
    let mut out = bounces(material, surface);
    if context.columns.seeds {
        let gloss = context.scene.materials.gloss[surface.material as usize];
        if gloss > 0.0 {
            let seeds = rays.seeds(&surface.ray);
            sample_glossy(&mut out.mirror, surface, gloss, seeds, context.sample);
        }
    }
    out
}

/// Returns the shares of mirror rays and of refracted ones, and drops rays whose share is less than
/// `min_weight` in every component. `divisor` is the one that turns weights into shares of
/// everything that a hit sends.
fn drop_below_min_weight(
    min_weight: f32,
    share: Vec3x8,
    divisor: Vec3x8,
    out: &mut SecondaryRays,
) -> [Vec3x8; 2] {
    [&mut out.mirror, &mut out.refracted].map(|out| {
        let weight = out.weight;
        let part = Vec3x8::new(
            weight.x / divisor.x,
            weight.y / divisor.y,
            weight.z / divisor.z,
        );
        let share = share.mul_elementwise(part);
        out.active = out.active & is_worth_tracing(min_weight, share);
        share
    })
}
