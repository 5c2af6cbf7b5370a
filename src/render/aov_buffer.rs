//! Outputs of the rays of a wave beside their radiance: hits, and the values of the AOVs.

use super::wavefront::RadianceX8;
use crate::shade::{ShadeMaterial, Surface};
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_scene::film::{Aovs, SurfaceAov};
use phalanx_trace::packet::{HitPacket, RayQueue};
use phalanx_trace::simd::{LANES, LaneMask, Vec3x8};
use std::ops::Range;

/// Outputs of a wave's rays beside their radiance, indexed by ray.
pub(super) struct AovBuffer<'arena> {
    pub(super) hits: &'arena mut [HitPacket],
    /// Surfaces, eight a packet; empty where no AOV needs surfaces.
    pub(super) surfaces: &'arena mut [SurfaceAov],
    /// Direct, reflected and refracted light; empty where no AOV needs it.
    pub(super) light: [&'arena mut [RadianceX8]; 3],
}

impl<'arena> AovBuffer<'arena> {
    /// Allocates the arrays that `aovs` needs for the given number of packets.
    pub(super) fn of(arena: &'arena Bump, packets: usize, aovs: Aovs) -> AovBuffer<'arena> {
        let looks = if aovs.of_surface() {
            packets * LANES
        } else {
            0
        };
        let light = if aovs.of_light() { packets } else { 0 };
        AovBuffer {
            hits: arena.alloc_slice_fill_copy(packets, HitPacket::miss()),
            surfaces: arena.alloc_slice_fill_copy(looks, SurfaceAov::NONE),
            light: [0, 1, 2].map(|_| &mut *arena.alloc_slice_fill_copy(light, RadianceX8::BLACK)),
        }
    }

    /// The part of the arrays that belongs to some packets.
    pub(super) fn part(&mut self, packets: Range<usize>) -> AovBuffer<'_> {
        let rays = packets.start * LANES..packets.end * LANES;
        AovBuffer {
            hits: &mut self.hits[packets.clone()],
            // Arrays that are not wanted stay empty.
            surfaces: self.surfaces.get_mut(rays).unwrap_or_default(),
            light: self
                .light
                .each_mut()
                .map(|way| way.get_mut(packets.clone()).unwrap_or_default()),
        }
    }

    /// Records surfaces and direct light, which are known once all lights have been evaluated.
    pub(super) fn record_surfaces(
        &mut self,
        scene: &Scene,
        groups: &[Surface],
        tints: &[Vec3x8],
        radiance: &[RadianceX8],
    ) {
        if !self.light[0].is_empty() {
            self.light[0].copy_from_slice(radiance);
        }
        if self.surfaces.is_empty() {
            return;
        }
        for (k, at) in groups.iter().enumerate() {
            let kd = ShadeMaterial::of(scene, at.material).kd;
            for lane in at.active.lanes() {
                let ray = at.ray[lane] as usize;
                let hit = &self.hits[ray / LANES];
                let color = tints.get(k).map_or(glam::Vec3::ONE, |t| vec3(t, lane));
                self.surfaces[ray] = SurfaceAov {
                    depth: hit.t.lane(ray % LANES) / scene.scale,
                    position: scene
                        .file_position(vec3(&at.point, lane))
                        .as_vec3()
                        .to_array(),
                    ng: vec3(&at.ng, lane).to_array(),
                    ns: vec3(&at.ns, lane).to_array(),
                    albedo: (kd * color).to_array(),
                    material: at.material,
                    primitive: hit.prim_id.lane(ray % LANES),
                };
            }
        }
    }

    /// Adds the weighted results of some packets of bounces, of which the first `mirrored` rays are
    /// mirror rays.
    pub(super) fn accumulate(
        &mut self,
        queue: &RayQueue,
        packets: Range<usize>,
        mirrored: usize,
        answers: &[RadianceX8],
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
