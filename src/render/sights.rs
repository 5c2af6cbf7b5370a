//! What the rays of a wave know of the lights from samples around theirs, and what they see: for samples that halve cells
//! (`sampling::cells`).

use super::cells::Asked;
use super::wave::Colors;
use crate::shade::Surface;
use bumpalo::Bump;
use phalanx_scene::sampling::{Cells, SIGHTS, Sight, trail};
use phalanx_trace::packet::{HitPacket, RayQueue};
use phalanx_trace::simd::{LANES, LaneMask, Mask8, Vec3x8};
use std::ops::Range;

/// Of a wave of camera rays that were asked for, or of one of their bounces.
pub(super) struct Sights<'a> {
    /// By block.
    pub(super) cells: &'a [Cells],
    /// By camera ray.
    pub(super) asks: &'a [Asked],
    /// By camera ray.
    pub(super) all: &'a mut [[Sight; SIGHTS]],
    /// Camera ray and sight, by ray of the wave; empty where those are the camera rays themselves.
    pub(super) bounced: &'a [(u32, u8)],
}

/// What is known of the lights where the rays of a wave hit.
pub(super) struct Known<'s, 'a, 'arena> {
    sights: &'s mut Sights<'a>,
    /// By surface and lane, the lights that are known, and those of them that are seen.
    lights: &'arena [[(u32, u32); LANES]],
}

impl<'a> Sights<'a> {
    /// The camera ray of a ray of the wave, and which of its sights that has.
    fn of(&self, ray: u32) -> (usize, usize) {
        match self.bounced.get(ray as usize) {
            Some(&(camera_ray, sight)) => (camera_ray as usize, usize::from(sight)),
            None => (ray as usize, 0),
        }
    }

    /// Looks up what is known where the rays hit.
    pub(super) fn met<'s, 'arena>(
        &'s mut self,
        arena: &'arena Bump,
        surfaces: &[Surface],
        hits: &[HitPacket],
    ) -> Known<'s, 'a, 'arena> {
        let lights = arena.alloc_slice_fill_copy(surfaces.len(), [(0, 0); LANES]);
        for (at, lights) in surfaces.iter().zip(&mut *lights) {
            for lane in at.active.lanes() {
                let ray = at.ray[lane];
                let prim_id = hits[ray as usize / LANES]
                    .prim_id
                    .lane(ray as usize % LANES);
                let (camera_ray, sight) = self.of(ray);
                let before = match sight {
                    0 => 0,
                    _ => self.all[camera_ray][0].trail,
                };
                let trail = trail(before, sight, prim_id);
                self.all[camera_ray][sight].trail = trail;
                let (block, ask) = self.asks[camera_ray];
                lights[lane] = self.cells[block as usize].known(ask as usize, sight, trail);
            }
        }
        Known {
            sights: self,
            lights,
        }
    }

    /// For some packets of bounces of the camera rays, of which the first `mirrored` rays are mirror rays.
    pub(super) fn onward<'s>(
        &'s mut self,
        arena: &'s Bump,
        queue: &RayQueue,
        packets: Range<usize>,
        mirrored: usize,
    ) -> Sights<'s> {
        let bounced = arena.alloc_slice_fill_with(packets.len() * LANES, |k| {
            let ray = packets.start * LANES + k;
            let camera_ray = queue.payload(ray / LANES).1[ray % LANES];
            (camera_ray, if ray < mirrored { 1 } else { 2 })
        });
        Sights {
            cells: self.cells,
            asks: self.asks,
            all: self.all,
            bounced,
        }
    }
}

impl Known<'_, '_, '_> {
    /// Adds a light's term where it is known to be seen, and gives the lanes of the `needed` ones for which it must be asked.
    pub(super) fn answer(
        &mut self,
        light: usize,
        (surface, at): (usize, &Surface),
        needed: Mask8,
        radiance: &Vec3x8,
        colors: &mut [Colors],
    ) -> Mask8 {
        let bit = Sight::bit(light);
        let mut left = needed.bits();
        for lane in needed.lanes() {
            let ray = at.ray[lane] as usize;
            let (camera_ray, sight) = self.sights.of(at.ray[lane]);
            let sight = &mut self.sights.all[camera_ray][sight];
            sight.asked |= bit;
            let (known, seen) = self.lights[surface][lane];
            let rgb = [&radiance.x, &radiance.y, &radiance.z].map(|c| c.lane(lane));
            let (block, ask) = self.sights.asks[camera_ray];
            let cells = &self.sights.cells[block as usize];
            if known & bit == 0 || !cells.may_believe(ask as usize, rgb) {
                continue;
            }
            left &= !(1 << lane);
            if seen & bit != 0 {
                sight.seen |= bit;
                colors[ray / LANES].add(ray % LANES, rgb);
            }
        }
        Mask8::from_bits(left)
    }

    /// Tells that a light is seen from where a ray hit.
    pub(super) fn saw(&mut self, light: usize, ray: u32) {
        let (camera_ray, sight) = self.sights.of(ray);
        self.sights.all[camera_ray][sight].seen |= Sight::bit(light);
    }
}
