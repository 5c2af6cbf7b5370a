//! Visibility of lights that the rays of a wave reuse from neighbouring samples, and the visibility
//! that they find. Used for samples that halve cells (`sampling::adaptive_edges`).

use super::adaptive_edges::RefineRequest;
use super::wavefront::RadianceX8;
use crate::shade::Surface;
use bumpalo::Bump;
use phalanx_scene::sampling::{Cells, LightVisibility, MAX_HITS, path_id};
use phalanx_trace::packet::{HitPacket, RayQueue};
use phalanx_trace::simd::{LANES, LaneMask, Mask8, Vec3x8};
use std::ops::Range;

/// Visibility cache for one wave of requested camera rays, or for one wave of their bounces.
pub(super) struct ShadowCache<'a> {
    /// Cells, one entry per block.
    pub(super) cells: &'a [Cells],
    /// Requests, one per camera ray.
    pub(super) requests: &'a [RefineRequest],
    /// Visibility of the lights at each hit of a path, one entry per camera ray.
    pub(super) visibility: &'a mut [[LightVisibility; MAX_HITS]],
    /// Camera ray and hit index of each ray of the wave; empty if the wave is the camera rays
    /// themselves.
    pub(super) ancestors: &'a [(u32, u8)],
}

/// Known visibility of the lights where the rays of a wave hit.
pub(super) struct CachedLights<'s, 'a, 'arena> {
    cache: &'s mut ShadowCache<'a>,
    /// Per surface and lane, as bits: the lights whose visibility is known, and those of them that
    /// are visible.
    lights: &'arena [[(u32, u32); LANES]],
}

impl<'a> ShadowCache<'a> {
    /// The camera ray of a ray of the wave, and the index of the ray's hit on that path.
    fn of(&self, ray: u32) -> (usize, usize) {
        match self.ancestors.get(ray as usize) {
            Some(&(camera_ray, hit_index)) => (camera_ray as usize, usize::from(hit_index)),
            None => (ray as usize, 0),
        }
    }

    /// Looks up the known visibility of the lights where the rays hit.
    pub(super) fn lookup<'s, 'arena>(
        &'s mut self,
        arena: &'arena Bump,
        groups: &[Surface],
        hits: &[HitPacket],
    ) -> CachedLights<'s, 'a, 'arena> {
        let lights = arena.alloc_slice_fill_copy(groups.len(), [(0, 0); LANES]);
        for (at, lights) in groups.iter().zip(&mut *lights) {
            for lane in at.active.lanes() {
                let ray = at.ray[lane];
                let prim_id = hits[ray as usize / LANES]
                    .prim_id
                    .lane(ray as usize % LANES);
                let (camera_ray, hit_index) = self.of(ray);
                let before = match hit_index {
                    0 => 0,
                    _ => self.visibility[camera_ray][0].path_id,
                };
                let path_id = path_id(before, hit_index, prim_id);
                self.visibility[camera_ray][hit_index].path_id = path_id;
                let (block, ask) = self.requests[camera_ray];
                lights[lane] =
                    self.cells[block as usize].known_lights(ask as usize, hit_index, path_id);
            }
        }
        CachedLights {
            cache: self,
            lights,
        }
    }

    /// The cache for some packets of bounces of the camera rays, of which the first `mirrored` rays
    /// are mirror rays.
    pub(super) fn child<'s>(
        &'s mut self,
        arena: &'s Bump,
        queue: &RayQueue,
        packets: Range<usize>,
        mirrored: usize,
    ) -> ShadowCache<'s> {
        let bounced = arena.alloc_slice_fill_with(packets.len() * LANES, |k| {
            let ray = packets.start * LANES + k;
            let camera_ray = queue.payload(ray / LANES).1[ray % LANES];
            (camera_ray, if ray < mirrored { 1 } else { 2 })
        });
        ShadowCache {
            cells: self.cells,
            requests: self.requests,
            visibility: self.visibility,
            ancestors: bounced,
        }
    }
}

impl CachedLights<'_, '_, '_> {
    /// Adds a light's term where the light is known to be visible. Returns the lanes of `needed`
    /// for which a shadow ray must be traced.
    pub(super) fn apply(
        &mut self,
        light: usize,
        (surface, at): (usize, &Surface),
        needed: Mask8,
        radiance: &Vec3x8,
        colors: &mut [RadianceX8],
    ) -> Mask8 {
        let bit = LightVisibility::bit(light);
        let mut left = needed.bits();
        for lane in needed.lanes() {
            let ray = at.ray[lane] as usize;
            let (camera_ray, hit_index) = self.cache.of(at.ray[lane]);
            let hit_index = &mut self.cache.visibility[camera_ray][hit_index];
            hit_index.queried |= bit;
            let (known, seen) = self.lights[surface][lane];
            let rgb = [&radiance.x, &radiance.y, &radiance.z].map(|c| c.lane(lane));
            let (block, ask) = self.cache.requests[camera_ray];
            let cells = &self.cache.cells[block as usize];
            if known & bit == 0 || !cells.may_reuse(ask as usize, rgb) {
                continue;
            }
            left &= !(1 << lane);
            if seen & bit != 0 {
                hit_index.visible |= bit;
                colors[ray / LANES].add(ray % LANES, rgb);
            }
        }
        Mask8::from_bits(left)
    }

    /// Records that a light is visible from where a ray hit.
    pub(super) fn record_visible(&mut self, light: usize, ray: u32) {
        let (camera_ray, hit_index) = self.cache.of(ray);
        self.cache.visibility[camera_ray][hit_index].visible |= LightVisibility::bit(light);
    }
}
