//! Results of camera rays, and their conversion to pixels: directly, or after accumulation.

use super::coverage_layers::write_coverage;
use super::ray_cost::{RayCost, count_cost};
use super::wavefront::{RadianceX8, RayFragment, block_of, pixel_of};
use phalanx_scene::film::{Aov, Aovs, RadianceAovs, SurfaceAov, TileBuffer};
use phalanx_scene::sampling::{PixelAccumulator, PixelCoverage, SurfaceShare};
use phalanx_trace::PacketTracer;
use phalanx_trace::packet::{HitPacket, NO_PRIM, RayQueue};
use phalanx_trace::simd::{LANES, LaneMask};

/// Results of some camera rays.
pub(super) struct TracedSamples<'t, 'a> {
    pub(super) rays: RayQueue<'t>,
    pub(super) radiance: &'t [RadianceX8],
    /// Hits, one per packet, and surfaces, eight a packet, of rays that are the first of their
    /// pixels. These and the other outputs are empty unless requested.
    pub(super) hits: &'t [HitPacket],
    pub(super) surfaces: &'t [SurfaceAov],
    /// Direct, reflected and refracted light.
    pub(super) light: [&'t [RadianceX8]; 3],
    /// All surfaces that the rays see, ray by ray.
    pub(super) fragments: &'t [RayFragment],
    /// Tracer that counts nodes, if an AOV needs their count.
    pub(super) counter: &'t mut Option<PacketTracer<'a>>,
}

/// The active rays with the positions of their pixels, packet by packet.
fn lanes(rays: &RayQueue) -> impl Iterator<Item = (usize, usize, (u32, u32))> {
    (0..rays.packets()).flat_map(|packet| {
        let places = rays.payload(packet).1;
        let lanes = rays.active(packet).lanes();
        lanes.map(move |lane| (packet, lane, pixel_of(places[lane])))
    })
}

impl TracedSamples<'_, '_> {
    /// Per ray: its radiance, the direct, reflected and refracted parts, which are black if no AOV
    /// needs them, and its filter weight.
    pub(super) fn outcomes(&self) -> impl Iterator<Item = ([f32; 3], [[f32; 3]; 3], f32)> {
        let parts = !self.light[0].is_empty();
        lanes(&self.rays).map(move |(packet, lane, _)| {
            let light = if parts {
                self.light.each_ref().map(|way| way[packet].lane(lane))
            } else {
                [[0.0; 3]; 3]
            };
            let weight = self.rays.payload(packet).0[0][lane];
            (self.radiance[packet].lane(lane), light, weight)
        })
    }

    /// Per ray: the surfaces that it sees, in their order.
    pub(super) fn seen(&self) -> impl Iterator<Item = impl Iterator<Item = SurfaceShare>> {
        let mut rest = self.fragments;
        lanes(&self.rays).map(move |(packet, lane, _)| {
            let ray = (packet * LANES + lane) as u32;
            let fragments = rest.iter().take_while(|fragment| fragment.ray == ray);
            let (fragments, later) = rest.split_at(fragments.count());
            rest = later;
            fragments.iter().map(|fragment| fragment.surface)
        })
    }

    /// Writes the hits and surfaces of first rays. `pixel` maps a ray's position to one in the
    /// tile, if it has one there.
    pub(super) fn write_hits(
        &mut self,
        pixels: &mut TileBuffer,
        pixel: impl Fn((u32, u32)) -> Option<(u32, u32)>,
    ) {
        if self.hits.is_empty() {
            return;
        }
        for (packet, lane, place) in lanes(&self.rays) {
            let Some((x, y)) = pixel(place) else {
                continue;
            };
            let hit = &self.hits[packet];
            let prim_id = hit.prim_id.lane(lane);
            let t = match prim_id {
                NO_PRIM => 0.0,
                _ => hit.t.lane(lane),
            };
            pixels.set_hit(x, y, [t, hit.u.lane(lane), hit.v.lane(lane)], prim_id);
            if let Some(surface) = self.surfaces.get(packet * LANES + lane) {
                pixels.set_surface(x, y, surface);
            }
            if let Some(counter) = self.counter {
                let nodes = count_cost(counter, &self.rays, packet, lane, RayCost::Nodes);
                pixels.set_layer(x, y, Aov::Cost, &[nodes]);
            }
        }
    }

    /// Writes the result of each pixel's only camera ray.
    pub(super) fn write_pixels(&self, pixels: &mut TileBuffer) {
        for (packet, radiance) in self.radiance.iter().enumerate() {
            let (active, places) = (self.rays.active(packet), self.rays.payload(packet).1);
            let (x, y) = pixel_of(places[0]);
            if active.bits() == 0xff && *places == block_of(x, y) {
                let row = |k: usize| radiance.plane_halves().map(|plane| plane[k]);
                pixels.set_run(x, y, row(0));
                pixels.set_run(x, y + 1, row(1));
            } else {
                for lane in active.lanes() {
                    let (x, y) = pixel_of(places[lane]);
                    pixels.set(x, y, radiance.lane(lane));
                }
            }
        }
        let aovs = pixels.aovs();
        if aovs.of_coverage() {
            let mut coverage = PixelCoverage::default();
            for ((packet, lane, place), seen) in lanes(&self.rays).zip(self.seen()) {
                let weight = self.rays.payload(packet).0[0][lane];
                coverage.clear();
                coverage.add(seen, weight, 1.0);
                write_coverage(pixels, place, &coverage);
            }
        }
        if !aovs.of_light() && !aovs.has(Aov::Samples) {
            return;
        }
        for (packet, lane, (x, y)) in lanes(&self.rays) {
            if aovs.of_light() {
                let light = self.light.each_ref().map(|way| way[packet].lane(lane));
                pixels.set_light(x, y, &RadianceAovs(light));
            }
            if aovs.has(Aov::Samples) {
                pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(1)]);
            }
        }
    }
}

/// Accumulators of the pixels of a tile, row by row.
#[derive(Default)]
pub(super) struct PixelAccumulators {
    pub(super) radiance: Vec<PixelAccumulator>,
    /// Direct, reflected and refracted light; empty if no AOV needs it.
    light: [Vec<PixelAccumulator>; 3],
    /// Surfaces that the pixels show; empty if no AOV needs them.
    coverage: Vec<PixelCoverage>,
}

impl PixelAccumulators {
    /// Clears the accumulators and resizes them to the given number of pixels.
    pub(super) fn fit(&mut self, count: usize, aovs: Aovs) {
        let covered = if aovs.of_coverage() { count } else { 0 };
        self.coverage.resize_with(covered, PixelCoverage::default);
        self.coverage.iter_mut().for_each(PixelCoverage::clear);
        let clear = |all: &mut Vec<PixelAccumulator>, count: usize| {
            all.clear();
            all.resize(count, PixelAccumulator::default());
        };
        clear(&mut self.radiance, count);
        let count = if aovs.of_light() { count } else { 0 };
        self.light.iter_mut().for_each(|all| clear(all, count));
    }

    /// Adds samples to pixels, in rows of the given width.
    pub(super) fn add(&mut self, traced: &TracedSamples, width: u32) {
        for (packet, lane, (x, y)) in lanes(&traced.rays) {
            let index = (y * width + x) as usize;
            let weight = traced.rays.payload(packet).0[0][lane];
            self.radiance[index].add(traced.radiance[packet].lane(lane), weight);
            if !self.light[0].is_empty() {
                for (sum, radiance) in self.light.iter_mut().zip(&traced.light) {
                    sum[index].add(radiance[packet].lane(lane), weight);
                }
            }
        }
        if self.coverage.is_empty() {
            return;
        }
        for ((packet, lane, (x, y)), seen) in lanes(&traced.rays).zip(traced.seen()) {
            let weight = traced.rays.payload(packet).0[0][lane];
            self.coverage[(y * width + x) as usize].add(seen, weight, 1.0);
        }
    }

    /// Writes the sums of one accumulator to a pixel of the tile.
    pub(super) fn write_pixel(&self, index: usize, pixels: &mut TileBuffer, (x, y): (u32, u32)) {
        pixels.set(x, y, self.radiance[index].mean());
        let aovs = pixels.aovs();
        if aovs.is_empty() {
            return;
        }
        if aovs.of_light() {
            let light = self.light.each_ref().map(|all| all[index].mean());
            pixels.set_light(x, y, &RadianceAovs(light));
        }
        if aovs.of_coverage() {
            write_coverage(pixels, (x, y), &self.coverage[index]);
        }
        if aovs.has(Aov::Samples) {
            let count = self.radiance[index].count() as u32;
            pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(count)]);
        }
    }
}
