//! Partly transparent surfaces, through which rays and light continue.
//!
//! Rays continue from hit to hit by a [`HitWalk`]. A fully transparent surface is passed at once.
//! For a partly transparent one, the light is weighted by its coverage, and the ray continues in
//! another wave ([`queue_passes`]). Scenes without such surfaces pay one branch per wave for it.

use super::bounce_queue::BounceQueue;
use super::fragments::FragmentSink;
use super::hit_grouping::group_hits;
use super::ray_batch::QueueSlice;
use super::wavefront_context::{WavefrontContext, is_worth_tracing};
use crate::shade::Surface;
use bumpalo::Bump;
use glam::Vec3;
use phalanx_scene::sampling::{BounceKind, SurfaceShare, child_seed};
use phalanx_scene::{MIN_SURFACE_SHARE, SurfaceHit};
use phalanx_trace::HitWalk;
use phalanx_trace::packet::{HitPacket, NO_PRIM, RayPacket, RayQueue};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, LaneU32, Lanes, Mask8, U32x8, Vec3x8};

/// Coverage of the hits of a wave, one row per packet; empty if every surface is opaque.
#[derive(Clone, Copy)]
pub(super) struct WaveCoverage<'arena>(&'arena [[f32; LANES]]);

impl WaveCoverage<'_> {
    /// Coverage of a wave whose surfaces are all opaque, or count as opaque.
    pub(super) const WHOLE: WaveCoverage<'static> = WaveCoverage(&[]);

    /// Coverage of eight surfaces; `None` if all of a scene's surfaces are opaque.
    #[inline]
    pub(super) fn of(self, surface: &Surface) -> Option<F32x8> {
        if self.0.is_empty() {
            return None;
        }
        let share = |ray: u32| self.0[ray as usize / LANES][ray as usize % LANES];
        Some(F32x8::new(surface.ray.map(share)))
    }
}

pub(super) fn surface_hit(hits: &HitPacket, lane: usize) -> SurfaceHit {
    SurfaceHit {
        prim_id: hits.prim_id.lane(lane),
        t: hits.t.lane(lane),
        u: hits.u.lane(lane),
        v: hits.v.lane(lane),
    }
}

/// Replaces hits on fully transparent surfaces, including invisible backs, by the next hits behind
/// them, and returns the coverage of the resulting hits. If all surfaces are opaque,
/// [`group_seen_hits`] passes the backs instead.
pub(super) fn pass_absent_surfaces<'arena>(
    context: &mut WavefrontContext,
    arena: &'arena Bump,
    rays: &QueueSlice,
    hits: &mut [HitPacket],
) -> WaveCoverage<'arena> {
    if !context.has_coverage {
        return WaveCoverage::WHOLE;
    }
    let shares = arena.alloc_slice_fill_copy(hits.len(), [1.0; LANES]);
    for (packet, (hits, shares)) in hits.iter_mut().zip(&mut *shares).enumerate() {
        pass_absent_in(context, rays, packet, rays.active(packet), hits, shares);
    }
    WaveCoverage(shares)
}

/// Passes absent surfaces in some lanes of a packet, and sets the coverage of the resulting hits.
fn pass_absent_in(
    context: &mut WavefrontContext,
    rays: &QueueSlice,
    packet: usize,
    mut unknown: Mask8,
    hits: &mut HitPacket,
    shares: &mut [f32; LANES],
) {
    let (ray, _) = rays.packet(packet);
    let after = rays.after.get(rays.packets.start + packet);
    let mut walk = HitWalk::default();
    loop {
        unknown = unknown & !hits.prim_id.eq(U32x8::splat(NO_PRIM));
        let mut absent = 0;
        for lane in unknown.lanes() {
            let passed = after.map(|after| surface_hit(after, lane));
            shares[lane] = seen_share(context, &ray, lane, passed, surface_hit(hits, lane));
            absent |= u32::from(shares[lane] == 0.0) << lane;
        }
        if absent == 0 {
            return;
        }
        unknown = Mask8::from_bits(absent);
        let next = walk.next(&mut context.traversal, &ray, unknown, hits);
        *hits = HitPacket::select(unknown, &next, hits);
    }
}

/// Coverage at a hit after another that counted; 0 if both are on the same surface, and for
/// invisible backs.
fn seen_share(
    context: &mut WavefrontContext,
    ray: &RayPacket,
    lane: usize,
    passed: Option<SurfaceHit>,
    on: SurfaceHit,
) -> f32 {
    if passed.is_some_and(|passed| context.scene.is_same_surface(passed, on)) {
        return 0.0;
    }
    let dir = [ray.dir.x, ray.dir.y, ray.dir.z].map(|c| c.lane(lane));
    let seen = context.scene.seen_coverage(dir.into(), on);
    context.stats.unseen_backs += u64::from(seen.is_none());
    seen.unwrap_or(0.0)
}

/// The surfaces of a wave's hits. Hits on invisible backs are replaced by the next hits behind
/// them; they are found among the surfaces, so that waves without any pay next to nothing.
pub(super) fn group_seen_hits<'arena>(
    context: &mut WavefrontContext,
    arena: &'arena Bump,
    rays: &QueueSlice,
    hits: &mut [HitPacket],
) -> &'arena [Surface] {
    let surfaces = group_hits(arena, context.scene, rays, hits);
    // With coverage, all backs have been passed.
    let suspects = || surfaces.iter().filter(|offset| offset.maybe_unseen.any());
    if context.has_coverage || !context.has_unseen_backs || suspects().next().is_none() {
        return surfaces;
    }
    let lanes = arena.alloc_slice_fill_copy(hits.len(), 0);
    for offset in suspects() {
        for ray in offset
            .maybe_unseen
            .lanes()
            .map(|lane| offset.ray[lane] as usize)
        {
            lanes[ray / LANES] |= 1 << (ray % LANES);
        }
    }
    let before = context.stats.unseen_backs;
    for (packet, hits) in hits
        .iter_mut()
        .enumerate()
        .filter(|(offset, _)| lanes[*offset] != 0)
    {
        let lanes = Mask8::from_bits(lanes[packet]);
        pass_absent_in(context, rays, packet, lanes, hits, &mut [1.0; LANES]);
    }
    if context.stats.unseen_backs == before {
        surfaces
    } else {
        group_hits(arena, context.scene, rays, hits)
    }
}

/// Collects the surfaces that camera rays see: the hit of each ray and, behind partly transparent
/// surfaces, those after it, in the order of (t, prim_id).
pub(super) fn collect_fragments(
    context: &mut WavefrontContext,
    rays: &QueueSlice,
    hits: &[HitPacket],
    coverage: WaveCoverage,
    fragments: &mut FragmentSink,
) {
    let Some(mattes) = context.mattes else {
        return;
    };
    for (packet, hit) in hits.iter().enumerate() {
        let (ray, active) = rays.packet(packet);
        let mut shares = coverage.0.get(packet).copied().unwrap_or([1.0; LANES]);
        // Each ray's share that has not been stopped by a surface yet, and the last surface that
        // stopped some.
        let mut open = [1.0f32; LANES];
        let mut counted = [None; LANES];
        let (mut hits, mut followed) = (*hit, active);
        let mut walk = HitWalk::default();
        loop {
            followed = followed & !hits.prim_id.eq(U32x8::splat(NO_PRIM));
            let mut goes_on = 0;
            for lane in followed.lanes() {
                if shares[lane] > 0.0 {
                    let on = surface_hit(&hits, lane);
                    let surface = SurfaceShare {
                        ids: mattes.find(context.scene, on.prim_id),
                        share: open[lane] * shares[lane],
                    };
                    fragments.push(packet * LANES + lane, surface);
                    open[lane] *= 1.0 - shares[lane];
                    counted[lane] = Some(on);
                }
                goes_on |= u32::from(open[lane] >= MIN_SURFACE_SHARE) << lane;
            }
            if goes_on == 0 {
                break;
            }
            followed = Mask8::from_bits(goes_on);
            hits = walk.next(&mut context.traversal, &ray, followed, &hits);
            for lane in (followed & !hits.prim_id.eq(U32x8::splat(NO_PRIM))).lanes() {
                let on = surface_hit(&hits, lane);
                shares[lane] = seen_share(context, &ray, lane, counted[lane], on);
            }
        }
    }
}

/// Fills an empty queue with the rays that continue through partly covered surfaces, except those
/// that are not worth tracing. Their weight is the uncovered share, and their search begins after
/// the hit.
pub(super) fn queue_passes(
    context: &WavefrontContext,
    rays: &QueueSlice,
    hits: &[HitPacket],
    coverage: WaveCoverage,
    passes: &mut BounceQueue,
) {
    if coverage.0.is_empty() {
        return;
    }
    let columns = context.columns;
    passes.fill_after(hits.len(), columns, |queue, after| {
        for (packet, (hit, shares)) in hits.iter().zip(coverage.0).enumerate() {
            let (ray, active) = rays.packet(packet);
            let open = F32x8::ONE - F32x8::new(*shares);
            let index = std::array::from_fn(|lane| (packet * LANES + lane) as u32);
            let mut goes_on =
                active & !hit.prim_id.eq(U32x8::splat(NO_PRIM)) & open.gt(F32x8::ZERO);
            if columns.shares {
                let share = rays.shares(&index).scale(open);
                goes_on = goes_on & is_worth_tracing(context.integrator.min_weight, share);
                queue.push_shares(goes_on, &share);
            }
            if columns.seeds {
                let seeds = child_seed(rays.seeds(&index), BounceKind::Passed);
                queue.push_seeds(goes_on, &seeds);
            }
            push_after(after, queue, goes_on, hit);
            let weight = Vec3x8::new(open, open, open);
            queue.push(goes_on, ray.org, ray.dir, weight, &index);
        }
    });
}

/// Sets the starting hits of the rays that the next push with the same `mask` appends.
fn push_after(after: &mut [HitPacket], queue: &RayQueue, mask: Mask8, hits: &HitPacket) {
    for (ray, lane) in (queue.len()..).zip(mask.lanes()) {
        let [t, u, v] = [hits.t.lane(lane), hits.u.lane(lane), hits.v.lane(lane)];
        after[ray / LANES].set(ray % LANES, [t, u, v], hits.prim_id.lane(lane));
    }
}

/// Share of a lamp's light that passes all surfaces before `tmax`, for the `blocked` lanes of a
/// packet of shadow rays: V, the product over the hits in order of (t, prim_id), up to the first
/// zero, without the hits that `spares` takes, by lane.
pub(super) fn visibility(
    context: &mut WavefrontContext,
    queue: &RayQueue,
    packet: usize,
    tmax: f32,
    blocked: Mask8,
    mut spares: impl FnMut(usize, SurfaceHit) -> bool,
) -> [Vec3; LANES] {
    let (rays, _) = queue.packet(packet, tmax);
    let mut product = [Vec3::ONE; LANES];
    let mut open = blocked;
    // No hit is at a distance of zero.
    let mut passed = HitPacket {
        t: F32x8::ZERO,
        ..HitPacket::miss()
    };
    // The last hits that count.
    let mut counted: [Option<SurfaceHit>; LANES] = [None; LANES];
    let mut walk = HitWalk::default();
    loop {
        let hits = walk.next(&mut context.traversal, &rays, open, &passed);
        open = open & !hits.prim_id.eq(U32x8::splat(NO_PRIM));
        for lane in open.lanes() {
            let on = surface_hit(&hits, lane);
            let is_counted = |counted| context.scene.is_same_surface(counted, on);
            if !spares(lane, on) && !counted[lane].is_some_and(is_counted) {
                product[lane] = context.scene.pass_light(product[lane], on);
                counted[lane] = Some(on);
            }
            if product[lane] == Vec3::ZERO {
                open = open & !Mask8::from_bits(1 << lane);
            }
        }
        if !open.any() {
            return product;
        }
        passed = hits;
    }
}
