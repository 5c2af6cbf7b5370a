//! Outputs of the rays of a wave in addition to their radiance: hits, and the values of the AOVs.

use super::bounce_queue::BounceSlice;
use super::hit_grouping::HitGroups;
use super::ray_batch::RadianceX8;
use bumpalo::Bump;
use phalanx_scene::Scene;
use phalanx_scene::film::{Aovs, SurfaceAov};
use phalanx_trace::packet::HitPacket;
use phalanx_trace::simd::{LANES, LaneMask, Vec3x8};
use std::ops::Range;

/// Outputs of a wave's rays in addition to their radiance, indexed by ray. Outputs that are not
/// requested are empty.
#[derive(Default)]
pub(crate) struct AovBuffer<'arena> {
    /// Hits, one per packet.
    pub(crate) hits: &'arena mut [HitPacket],
    /// Surfaces, eight a packet.
    pub(crate) surfaces: &'arena mut [SurfaceAov],
    /// Direct, reflected and refracted light.
    pub(crate) light: [&'arena mut [RadianceX8]; 3],
}

impl<'arena> AovBuffer<'arena> {
    /// Allocates the outputs that `aovs` needs for the given number of packets: hits and surfaces
    /// only if `first` is true, for rays that are the first of their pixels.
    pub(crate) fn new(
        arena: &'arena Bump,
        packets: usize,
        aovs: Aovs,
        first: bool,
    ) -> AovBuffer<'arena> {
        let hits = if first { packets } else { 0 };
        let surfaces = if aovs.of_surface() { hits * LANES } else { 0 };
        let light = if aovs.of_light() { packets } else { 0 };
        AovBuffer {
            hits: arena.alloc_slice_fill_copy(hits, HitPacket::miss()),
            surfaces: arena.alloc_slice_fill_copy(surfaces, SurfaceAov::NONE),
            light: [0, 1, 2].map(|_| &mut *arena.alloc_slice_fill_copy(light, RadianceX8::BLACK)),
        }
    }

    /// The part of the outputs that belongs to some packets.
    pub(crate) fn part(&mut self, packets: Range<usize>) -> AovBuffer<'_> {
        let rays = packets.start * LANES..packets.end * LANES;
        let of_packets = packets.clone();
        AovBuffer {
            hits: self.hits.get_mut(packets).unwrap_or_default(),
            surfaces: self.surfaces.get_mut(rays).unwrap_or_default(),
            light: (self.light.each_mut())
                .map(|way| way.get_mut(of_packets.clone()).unwrap_or_default()),
        }
    }

    /// Records hits, surfaces and direct light, once all lights have been evaluated.
    pub(super) fn record(
        &mut self,
        scene: &Scene,
        hits: &[HitPacket],
        groups: &HitGroups,
        radiance: &[RadianceX8],
    ) {
        if !self.hits.is_empty() {
            self.hits.copy_from_slice(hits);
        }
        if !self.light[0].is_empty() {
            self.light[0].copy_from_slice(radiance);
        }
        if !self.surfaces.is_empty() {
            self.record_surfaces(scene, hits, groups);
        }
    }

    fn record_surfaces(&mut self, scene: &Scene, hits: &[HitPacket], groups: &HitGroups) {
        for (k, surface) in groups.surfaces.iter().enumerate() {
            let kd = groups.material(k).kd();
            for lane in surface.active.lanes() {
                let ray = surface.ray[lane] as usize;
                let hit = &hits[ray / LANES];
                self.surfaces[ray] = SurfaceAov {
                    depth: hit.t.lane(ray % LANES) / scene.scale,
                    position: scene
                        .relative_position(vec3(&surface.point, lane))
                        .to_array(),
                    ng: vec3(&surface.ng, lane).to_array(),
                    ns: vec3(&surface.ns, lane).to_array(),
                    albedo: vec3(&kd, lane).to_array(),
                    material: surface.material,
                    primitive: hit.prim_id.lane(ray % LANES),
                };
            }
        }
    }

    /// Adds the weighted radiance of bounces to reflected and refracted light.
    pub(super) fn accumulate(&mut self, bounces: &BounceSlice, bounced: &[RadianceX8]) {
        let [_, reflection, refraction] = &mut self.light;
        if reflection.is_empty() {
            return;
        }
        for (packet, bounced) in bounces.packets.clone().zip(bounced) {
            let (weight, parent) = bounces.queue.payload(packet);
            for lane in bounces.queue.active(packet).lanes() {
                let ray = parent[lane] as usize;
                let rgb = [0, 1, 2].map(|c| weight[c][lane] * bounced.0[c][lane]);
                let way = if packet * LANES + lane < bounces.mirrored {
                    &mut *reflection
                } else {
                    &mut *refraction
                };
                way[ray / LANES].add(ray % LANES, rgb);
            }
        }
    }
}

fn vec3(v: &Vec3x8, lane: usize) -> glam::Vec3 {
    glam::Vec3::new(v.x.lane(lane), v.y.lane(lane), v.z.lane(lane))
}
