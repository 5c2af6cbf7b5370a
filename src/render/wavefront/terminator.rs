//! Shadow rays that start on facets of smooth surfaces, which may pass through facets of their own:
//! the rule of `scene::terminator`.

use super::coverage::{surface_hit, visibility};
use super::hit_grouping::{HitGroups, hits_at};
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
    arena.alloc_slice_fill_iter(groups.surfaces.iter().map(|surface| {
        let may_face = lights.iter().any(|light| light.may_face(surface).any());
        may_face.then(|| TerminatorShift::of(scene, surface, &hits_at(surface, groups.hits)))?
    }))
}

/// Shadow rays that start on facets of smooth surfaces, each with another one that starts on the
/// smooth surface above.
pub(super) struct TerminatorRays<'arena> {
    pub(super) facet: RayQueue<'arena>,
    /// The weight is one where the facet's ray starts beneath it, else zero. These rays carry no
    /// light, so they are not counted.
    above: RayQueue<'arena>,
    hits: &'arena [HitPacket],
}

impl<'arena> TerminatorRays<'arena> {
    /// Room for the rays of all smooth surfaces.
    pub(super) fn new(arena: &'arena Bump, groups: &HitGroups<'arena>) -> TerminatorRays<'arena> {
        let rays = groups.above.len() * LANES;
        TerminatorRays {
            facet: RayQueue::with_capacity(arena, rays),
            above: RayQueue::with_capacity(arena, rays),
            hits: groups.hits,
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
        surface: &Surface,
        above: &TerminatorShift,
        is_directional: bool,
    ) {
        let LightSample {
            org, dir, radiance, ..
        } = *sample;
        self.facet.push(needed, org, dir, radiance, &surface.ray);
        let beneath = sample.beneath.select(F32x8::ONE, F32x8::ZERO);
        let org = (surface.point + surface.ng.scale(surface.offset)) + above.shift;
        let dir = if is_directional { dir } else { dir - above.shift };
        let weight = Vec3x8::new(beneath, beneath, beneath);
        self.above.push(needed, org, dir, weight, &surface.ray);
    }

    /// The lanes of a packet of blocked rays of facets that some light may pass, and its share,
    /// without their own facets where the ray from above reaches the light.
    pub(super) fn past_own_facets(
        &self,
        context: &mut WavefrontContext,
        packet: usize,
        tmax: f32,
        blocked: Mask8,
    ) -> (Mask8, [Vec3; LANES]) {
        let mut hidden = [0];
        let one = packet..packet + 1;
        (context.traversal).occluded(&self.above, one, tmax, &mut hidden);
        let hidden = blocked & Mask8::from_bits(u32::from(hidden[0]));
        let (mut traced, mut above) = (blocked & !hidden, [Vec3::ONE; LANES]);
        if context.has_clear_shadows {
            above = visibility(context, &self.above, packet, tmax, hidden, |_, _| false);
            traced = blocked;
        } else if !traced.any() {
            return (traced, above);
        }
        let scene = context.scene;
        let ([beneath, ..], rays) = self.above.payload(packet);
        let mut facets: [OwnFacets; LANES] = std::array::from_fn(|lane| {
            let ray = rays[lane] as usize;
            let from = surface_hit(&self.hits[ray / LANES], ray % LANES);
            let (_, dir) = self.facet.ray(packet, lane);
            OwnFacets::new(scene, dir.into(), from, beneath[lane] != 0.0)
        });
        let passed = visibility(context, &self.facet, packet, tmax, traced, |lane, on| {
            above[lane] != Vec3::ZERO && facets[lane].spares(scene, on)
        });
        (traced, passed)
    }
}
