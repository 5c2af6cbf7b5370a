//! Shadow rays saved by neighbouring samples: visibility of lights that the rays of a wave reuse,
//! and the visibility that they find. Used for samples that halve cells (`sampling::cells`).

use super::bounce_queue::BounceSlice;
use super::ray_batch::RadianceX8;
use crate::shade::{LightSample, Surface};
use bumpalo::Bump;
use phalanx_scene::sampling::{Cells, LightVisibility, MAX_HITS, path_id};
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::{LANES, LaneMask, Mask8};

/// A block of a group, and the index of one of its requests.
pub(crate) type RefineRequest = (u32, u32);

/// Determines which shadow rays of a wave are traced: all of them, or those not answered by a
/// cache.
pub(crate) struct ShadowFilter<'a>(Option<ShadowCache<'a>>);

/// Visibility cache for one wave of requested camera rays, or for one wave of their bounces.
struct ShadowCache<'a> {
    /// Cells, one entry per block.
    cells: &'a [Cells],
    /// Requests, one per camera ray.
    requests: &'a [RefineRequest],
    /// Visibility of the lights at each hit of a path, one entry per camera ray.
    visibility: &'a mut [[LightVisibility; MAX_HITS]],
    /// Camera ray and hit index of each ray of the wave; empty if the wave is the camera rays
    /// themselves.
    ancestors: &'a [(u32, u8)],
}

/// Known visibility of the lights at the hits of a wave; without a cache, nothing is known.
pub(super) struct KnownLights<'s, 'a>(Option<CachedLights<'s, 'a>>);

struct CachedLights<'s, 'a> {
    cache: &'s mut ShadowCache<'a>,
    /// Per surface and lane, as bits: the lights whose visibility is known, and those of them that
    /// are visible.
    lights: &'s [[(u32, u32); LANES]],
}

impl<'a> ShadowFilter<'a> {
    /// Traces every shadow ray.
    pub(crate) const NONE: ShadowFilter<'a> = ShadowFilter(None);

    /// Omits the shadow rays of requested camera rays whose results are known to the cells, and
    /// records the `visibility` of the lights, one entry per camera ray.
    pub(crate) fn reuse(
        cells: &'a [Cells],
        requests: &'a [RefineRequest],
        visibility: &'a mut [[LightVisibility; MAX_HITS]],
    ) -> ShadowFilter<'a> {
        ShadowFilter(Some(ShadowCache {
            cells,
            requests,
            visibility,
            ancestors: &[],
        }))
    }

    /// The same filter, borrowed for one wave.
    pub(crate) fn reborrow(&mut self) -> ShadowFilter<'_> {
        let cache = self.0.as_mut();
        ShadowFilter(cache.map(|cache| cache.with_ancestors(cache.ancestors)))
    }

    /// The filter for some bounces of the camera rays.
    pub(super) fn for_bounces<'s>(
        &'s mut self,
        arena: &'s Bump,
        bounces: &BounceSlice,
    ) -> ShadowFilter<'s> {
        ShadowFilter(self.0.as_mut().map(|cache| {
            let first = bounces.packets.start * LANES;
            let ancestor = |k| {
                let ray = first + k;
                let camera_ray = bounces.queue.payload(ray / LANES).1[ray % LANES];
                (camera_ray, if ray < bounces.mirrored { 1 } else { 2 })
            };
            let rays = bounces.packets.len() * LANES;
            cache.with_ancestors(arena.alloc_slice_fill_with(rays, ancestor))
        }))
    }

    /// Looks up the visibility of the lights at the hits.
    pub(super) fn look_up<'s>(
        &'s mut self,
        arena: &'s Bump,
        groups: &[Surface],
        hits: &[HitPacket],
    ) -> KnownLights<'s, 'a> {
        let cache = self.0.as_mut();
        KnownLights(cache.map(|cache| cache.look_up(arena, groups, hits)))
    }
}

impl KnownLights<'_, '_> {
    /// Adds a light's term to `colors` for lanes in which the light is known to be visible. Returns
    /// the lanes for which a shadow ray must be traced.
    #[inline]
    pub(super) fn unknown(
        &mut self,
        light: usize,
        group: (usize, &Surface),
        sample: &LightSample,
        colors: &mut [RadianceX8],
    ) -> Mask8 {
        match &mut self.0 {
            Some(lights) => lights.add_visible(light, group, sample, colors),
            None => sample.needed,
        }
    }

    /// Records that a light is visible from the hits of some of eight rays.
    #[inline]
    pub(super) fn record_visible(&mut self, light: usize, open: Mask8, rays: &[u32; LANES]) {
        if let Some(CachedLights { cache, .. }) = &mut self.0 {
            for lane in open.lanes() {
                cache.at_hit(rays[lane]).visible |= LightVisibility::bit(light);
            }
        }
    }
}

impl<'a> ShadowCache<'a> {
    /// The same cache, for a wave of rays with these ancestors.
    fn with_ancestors<'s>(&'s mut self, ancestors: &'s [(u32, u8)]) -> ShadowCache<'s> {
        ShadowCache {
            cells: self.cells,
            requests: self.requests,
            visibility: self.visibility,
            ancestors,
        }
    }

    /// The camera ray of a ray of the wave, and the index of the ray's hit on that path.
    fn path(&self, ray: u32) -> (usize, usize) {
        match self.ancestors.get(ray as usize) {
            Some(&(camera_ray, hit_index)) => (camera_ray as usize, usize::from(hit_index)),
            None => (ray as usize, 0),
        }
    }

    /// Visibility of the lights from the hit of a ray of the wave.
    fn at_hit(&mut self, ray: u32) -> &mut LightVisibility {
        let (camera_ray, hit_index) = self.path(ray);
        &mut self.visibility[camera_ray][hit_index]
    }

    fn look_up<'s>(
        &'s mut self,
        arena: &'s Bump,
        groups: &[Surface],
        hits: &[HitPacket],
    ) -> CachedLights<'s, 'a> {
        let lights = arena.alloc_slice_fill_copy(groups.len(), [(0, 0); LANES]);
        for (surface, lights) in groups.iter().zip(&mut *lights) {
            for lane in surface.active.lanes() {
                let ray = surface.ray[lane];
                let hit = &hits[ray as usize / LANES];
                let prim_id = hit.prim_id.lane(ray as usize % LANES);
                let (camera_ray, hit_index) = self.path(ray);
                let before = match hit_index {
                    0 => 0,
                    _ => self.visibility[camera_ray][0].path_id,
                };
                let path_id = path_id(before, hit_index, prim_id);
                self.at_hit(ray).path_id = path_id;
                let (block, request) = self.requests[camera_ray];
                let cells = &self.cells[block as usize];
                lights[lane] = cells.known_lights(request as usize, hit_index, path_id);
            }
        }
        CachedLights {
            cache: self,
            lights,
        }
    }
}

impl CachedLights<'_, '_> {
    fn add_visible(
        &mut self,
        light: usize,
        (surface, group): (usize, &Surface),
        sample: &LightSample,
        colors: &mut [RadianceX8],
    ) -> Mask8 {
        let bit = LightVisibility::bit(light);
        let mut left = sample.needed.bits();
        for lane in sample.needed.lanes() {
            let ray = group.ray[lane] as usize;
            self.cache.at_hit(group.ray[lane]).queried |= bit;
            let (known, visible) = self.lights[surface][lane];
            let radiance = &sample.radiance;
            let rgb = [&radiance.x, &radiance.y, &radiance.z].map(|c| c.lane(lane));
            let (block, request) = self.cache.requests[self.cache.path(group.ray[lane]).0];
            let cells = &self.cache.cells[block as usize];
            if known & bit == 0 || !cells.may_reuse(request as usize, rgb) {
                continue;
            }
            left &= !(1 << lane);
            if visible & bit != 0 {
                self.cache.at_hit(group.ray[lane]).visible |= bit;
                colors[ray / LANES].add(ray % LANES, rgb);
            }
        }
        Mask8::from_bits(left)
    }
}
