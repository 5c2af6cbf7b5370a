//! What is to be known of the rays of a wave beside their radiance: hits, and what the layers tell.

use super::wave::Colors;
use crate::shade::{Material, Surface};
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_scene::film::{Aovs, Look};
use phalanx_trace::packet::{HitPacket, RayQueue};
use phalanx_trace::simd::{LANES, LaneMask, Vec3x8};
use std::ops::Range;

/// By ray of the wave.
pub(super) struct Kept<'arena> {
    pub(super) hits: &'arena mut [HitPacket],
    /// Eight a packet; empty where no layer tells of surfaces.
    pub(super) looks: &'arena mut [Look],
    /// Direct, reflected and refracted light; empty where no layer tells of it.
    pub(super) light: [&'arena mut [Colors]; 3],
}

impl<'arena> Kept<'arena> {
    /// Room for what is wanted of so many packets.
    pub(super) fn of(arena: &'arena Bump, packets: usize, aovs: Aovs) -> Kept<'arena> {
        let looks = if aovs.of_surface() {
            packets * LANES
        } else {
            0
        };
        let light = if aovs.of_light() { packets } else { 0 };
        Kept {
            hits: arena.alloc_slice_fill_copy(packets, HitPacket::miss()),
            looks: arena.alloc_slice_fill_copy(looks, Look::NONE),
            light: [0, 1, 2].map(|_| &mut *arena.alloc_slice_fill_copy(light, Colors::BLACK)),
        }
    }

    /// Those of some packets.
    pub(super) fn part(&mut self, packets: Range<usize>) -> Kept<'_> {
        let rays = packets.start * LANES..packets.end * LANES;
        Kept {
            hits: &mut self.hits[packets.clone()],
            // What is not wanted stays empty.
            looks: self.looks.get_mut(rays).unwrap_or_default(),
            light: self
                .light
                .each_mut()
                .map(|way| way.get_mut(packets.clone()).unwrap_or_default()),
        }
    }

    /// Takes what is known when all lights have answered.
    pub(super) fn take(
        &mut self,
        scene: &Scene,
        surfaces: &[Surface],
        tints: &[Vec3x8],
        colors: &[Colors],
    ) {
        if !self.light[0].is_empty() {
            self.light[0].copy_from_slice(colors);
        }
        if self.looks.is_empty() {
            return;
        }
        for (k, at) in surfaces.iter().enumerate() {
            let kd = Material::of(scene, at.material).kd;
            for lane in at.active.lanes() {
                let ray = at.ray[lane] as usize;
                let hit = &self.hits[ray / LANES];
                let tint = tints.get(k).map_or(glam::Vec3::ONE, |t| vec3(t, lane));
                self.looks[ray] = Look {
                    depth: hit.t.lane(ray % LANES) / scene.unit,
                    position: scene.file_place(vec3(&at.point, lane)).as_vec3().to_array(),
                    ng: vec3(&at.ng, lane).to_array(),
                    ns: vec3(&at.ns, lane).to_array(),
                    albedo: (kd * tint).to_array(),
                    material: at.material,
                    primitive: hit.prim_id.lane(ray % LANES),
                };
            }
        }
    }

    /// Adds the weighted answers of some packets of bounces, of which the first `mirrored` rays are mirror rays.
    pub(super) fn fold(
        &mut self,
        queue: &RayQueue,
        packets: Range<usize>,
        mirrored: usize,
        answers: &[Colors],
    ) {
        let [_, reflection, refraction] = &mut self.light;
        if reflection.is_empty() {
            return;
        }
        for (packet, answer) in packets.zip(answers) {
            let (weight, parent) = queue.payload(packet);
            for lane in queue.active(packet).lanes() {
                let ray = parent[lane] as usize;
                let rgb = [0, 1, 2].map(|c| weight[c][lane] * answer.0[c][lane]);
                let way = match packet * LANES + lane < mirrored {
                    true => &mut *reflection,
                    false => &mut *refraction,
                };
                way[ray / LANES].add(ray % LANES, rgb);
            }
        }
    }
}

fn vec3(v: &Vec3x8, lane: usize) -> glam::Vec3 {
    glam::Vec3::new(v.x.lane(lane), v.y.lane(lane), v.z.lane(lane))
}
