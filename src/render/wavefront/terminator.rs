//! Shadow rays that start on facets of smooth surfaces, which may pass through facets of their own:
//! the rule of `scene::terminator`.

use super::coverage::{surface_hit, visibility};
use super::hit_grouping::{HitGroups, hits_at};
use super::ray_batch::{RadianceX8, add_lanes};
use super::wavefront_context::WavefrontContext;
use crate::shade::{LightSample, ShadeLight, Surface, TerminatorShift};
use bumpalo::Bump;
use glam::Vec3;
use phalanx_scene::OwnFacets;
use phalanx_trace::packet::{HitPacket, RayQueue};
use phalanx_trace::simd::{F32x8, LANES, LaneMask, Lanes, Mask8, Vec3x8};

/// The smooth surface above each surface of the wave; empty if light follows the scene's facets.
/// Surfaces that no light may face need none.
pub(super) fn find_smooth_surfaces<'arena>(
    context: &WavefrontContext,
    arena: &'arena Bump,
    groups: &HitGroups,
) -> &'arena [Option<TerminatorShift>] {
    let (scene, t) = (context.scene, &context.scene.triangles);
    if !scene.smooth_shadows || t.normals.is_empty() || t.vertex_normals.is_empty() {
        return &[];
    }
    let lights = arena.alloc_slice_fill_with(scene.lights.len(), |k| ShadeLight::of(scene, k));
    arena.alloc_slice_fill_iter(groups.surfaces.iter().map(|at| {
        let may_face = lights.iter().any(|light| light.may_face(at).any());
        may_face.then(|| TerminatorShift::of(scene, at, &hits_at(at, groups.hits)))?
    }))
}

/// Shadow rays that start on facets of smooth surfaces, each with another one that starts on the
/// smooth surface above.
pub(super) struct TerminatorRays<'arena> {
    facet: RayQueue<'arena>,
    /// The weight is that of the facet's ray where it starts beneath the facet, else zero.
    above: RayQueue<'arena>,
}

impl<'arena> TerminatorRays<'arena> {
    /// Room for the rays of this number of surfaces.
    pub(super) fn with_capacity(arena: &'arena Bump, surfaces: usize) -> TerminatorRays<'arena> {
        TerminatorRays {
            facet: RayQueue::with_capacity(arena, surfaces * LANES),
            above: RayQueue::with_capacity(arena, surfaces * LANES),
        }
    }

    /// Removes all rays.
    pub(super) fn clear(&mut self) {
        self.facet.clear();
        self.above.clear();
    }

    /// Adds the smooth lanes of `needed` of a surface, for a light in this direction or position.
    pub(super) fn push(
        &mut self,
        needed: Mask8,
        sample: &LightSample,
        at: &Surface,
        above: &TerminatorShift,
        is_directional: bool,
    ) {
        let LightSample {
            org, dir, radiance, ..
        } = *sample;
        self.facet.push(needed, org, dir, radiance, &at.ray);
        let beneath = sample.beneath.select(F32x8::ONE, F32x8::ZERO);
        let org = (at.point + at.ng.scale(at.offset)) + above.shift;
        let dir = if is_directional {
            dir
        } else {
            dir - above.shift
        };
        let weight = Vec3x8::new(beneath, beneath, beneath);
        self.above.push(needed, org, dir, weight, &at.ray);
    }

    /// Moves some rays of a packet to another queue.
    fn move_lanes(&self, packet: usize, lanes: Mask8, to: &mut TerminatorRays) {
        for (from, to) in [(&self.facet, &mut to.facet), (&self.above, &mut to.above)] {
            let (rays, _) = from.packet::<F32x8>(packet, 0.0);
            let ([x, y, z], parent) = from.payload(packet);
            let weight = Vec3x8::new(F32x8::new(*x), F32x8::new(*y), F32x8::new(*z));
            to.push(lanes, rays.org, rays.dir, weight, parent);
        }
    }

    /// Traces the rays of facets as [`add_unoccluded`](super::shadow_rays::add_unoccluded) does.
    /// What blocks them is spared by the rule of [`OwnFacets`] where the ray from above reaches the
    /// light. Rays from above carry no light, so they are not counted. `blocked` has room for one
    /// byte per packet; `again`, for the same number of rays.
    pub(super) fn add_unoccluded(
        &self,
        context: &mut WavefrontContext,
        hits: &[HitPacket],
        tmax: f32,
        (again, blocked): (&mut TerminatorRays, &mut [u8]),
        radiance: &mut [RadianceX8],
        mut record: impl FnMut(Mask8, &[u32; LANES]),
    ) {
        again.clear();
        context.stats.rays.shadow += self.facet.len() as u64;
        occlude(context, &self.facet, tmax, blocked);
        for packet in 0..self.facet.packets() {
            let (carried, rays) = self.facet.payload(packet);
            let active = self.facet.active(packet);
            let blocked = active & Mask8::from_bits(u32::from(blocked[packet]));
            add_lanes(radiance, active & !blocked, rays, carried);
            record(active & !blocked, rays);
            self.move_lanes(packet, blocked, again);
        }
        occlude(context, &again.above, tmax, blocked);
        for packet in 0..again.facet.packets() {
            let active = again.facet.active(packet);
            let mut open = active & !Mask8::from_bits(u32::from(blocked[packet]));
            if context.has_clear_shadows {
                let hidden = active & !open;
                let passed = visibility(context, &again.above, packet, tmax, hidden, |_, _| false);
                let is_clear = |lane: usize| u32::from(passed[lane] != Vec3::ZERO) << lane;
                let clear: u32 = hidden.lanes().map(is_clear).sum();
                open = open | Mask8::from_bits(clear);
            }
            let passed = again.past_own_facets(context, hits, packet, tmax, open);
            let (carried, rays) = again.facet.payload(packet);
            for lane in active.lanes().filter(|&lane| passed[lane] != Vec3::ZERO) {
                let rgb = [0, 1, 2].map(|c| carried[c][lane] * passed[lane][c]);
                radiance[rays[lane] as usize / LANES].add(rays[lane] as usize % LANES, rgb);
                record(Mask8::from_bits(1 << lane), rays);
            }
        }
    }

    /// Share of the light that passes what blocks the facets' rays of a packet, without their own
    /// facets in lanes that are `open` from above; zero in lanes where it cannot be another.
    fn past_own_facets(
        &self,
        context: &mut WavefrontContext,
        hits: &[HitPacket],
        packet: usize,
        tmax: f32,
        open: Mask8,
    ) -> [Vec3; LANES] {
        let traced = match context.has_clear_shadows {
            true => self.facet.active(packet),
            false => open,
        };
        if !traced.any() {
            return [Vec3::ZERO; LANES];
        }
        let scene = context.scene;
        let ([beneath, ..], rays) = self.above.payload(packet);
        let mut own: [OwnFacets; LANES] = std::array::from_fn(|lane| {
            let ray = rays[lane] as usize;
            let from = surface_hit(&hits[ray / LANES], ray % LANES);
            let (_, dir) = self.facet.ray(packet, lane);
            OwnFacets::new(scene, dir.into(), from, beneath[lane] != 0.0)
        });
        let open = open.bits();
        let mut passed = visibility(context, &self.facet, packet, tmax, traced, |lane, on| {
            open >> lane & 1 == 1 && own[lane].spares(scene, on)
        });
        for lane in (!traced).lanes() {
            passed[lane] = Vec3::ZERO;
        }
        passed
    }
}

/// Sets `blocked` to the lanes of all rays of a queue that hit anything, a byte a packet.
fn occlude(context: &mut WavefrontContext, queue: &RayQueue, tmax: f32, blocked: &mut [u8]) {
    let all = 0..queue.packets();
    let blocked = &mut blocked[..all.len()];
    context.trace(|traversal| traversal.occluded(queue, all, tmax, blocked));
}
