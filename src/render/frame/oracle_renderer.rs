//! The oracle as a renderer of tiles.

use crate::coverage_layers::write_coverage;
use crate::{Aov, RadianceAovs, RenderStats, SurfaceAov, Tile, TileBuffer, TileRenderer, tiles};
use glam::Vec3;
use phalanx_oracle::{Oracle, OracleHit, OraclePixel, OracleRay};
use phalanx_scene::Scene;
use phalanx_scene::camera::Camera;
use phalanx_scene::sampling::{Adaptive, BLOCK, Sampling};

/// Renders tiles with the oracle, pixel by pixel.
pub(super) struct OracleRenderer<'a> {
    pub(super) camera: &'a Camera,
    pub(super) scene: &'a Scene,
    pub(super) sampling: Sampling,
    pub(super) oracle: Oracle<'a>,
}

impl OracleRenderer<'_> {
    /// Sets a pixel of a tile with all its outputs.
    fn set(&self, pixels: &mut TileBuffer, (x, y): (u32, u32), pixel: &OraclePixel) {
        pixels.set(x, y, pixel.radiance.to_array());
        let first = pixel.first.and_then(|(ray, hit)| Some((ray, hit?)));
        if let Some((_, hit)) = first {
            pixels.set_hit(x, y, [hit.t, hit.u, hit.v], hit.prim_id);
        }
        let aovs = pixels.aovs();
        if aovs.is_empty() {
            return;
        }
        let surface = first.map_or(SurfaceAov::NONE, |(ray, hit)| self.surface_aov(&ray, &hit));
        pixels.set_surface(x, y, &surface);
        pixels.set_light(x, y, &RadianceAovs(pixel.light.map(Vec3::into)));
        if aovs.of_coverage() {
            write_coverage(pixels, (x, y), &pixel.coverage);
        }
        if aovs.has(Aov::Samples) {
            pixels.set_layer(x, y, Aov::Samples, &[f32::from_bits(pixel.samples)]);
        }
    }

    fn surface_aov(&self, ray: &OracleRay, hit: &OracleHit) -> SurfaceAov {
        let (surface, kd, material) = self.oracle.surface_at(ray, hit);
        SurfaceAov {
            depth: hit.t / self.scene.scale,
            position: self.scene.relative_position(surface.point).to_array(),
            ng: surface.ng.to_array(),
            ns: surface.ns.to_array(),
            albedo: kd.to_array(),
            material,
            primitive: hit.prim_id,
        }
    }

    /// Renders the blocks that a tile touches, and keeps the part that lies in the tile.
    fn render_adaptively(&mut self, adaptive: Adaptive, tile: Tile, pixels: &mut TileBuffer) {
        let outer = tile.outward(BLOCK, self.camera.size());
        for block in tiles(outer, BLOCK) {
            let (camera, sampling) = (self.camera, &self.sampling);
            let rendered = self.oracle.block(camera, sampling, &adaptive, block);
            for (index, pixel) in (0..).zip(rendered) {
                let (x, y) = (block.x + index % block.width, block.y + index / block.width);
                if let Some(place) = tile.position_of(x, y) {
                    self.set(pixels, place, &pixel);
                }
            }
        }
    }
}

impl TileRenderer for OracleRenderer<'_> {
    fn render_tile(&mut self, tile: Tile, pixels: &mut TileBuffer) {
        if let Some(adaptive) = self.sampling.adaptively() {
            return self.render_adaptively(adaptive, tile, pixels);
        }
        for y in 0..tile.height {
            for x in 0..tile.width {
                let (column, row) = (tile.x + x, tile.y + y);
                let pixel = self.oracle.pixel(self.camera, &self.sampling, column, row);
                self.set(pixels, (x, y), &pixel);
            }
        }
    }

    fn stats(&self) -> RenderStats {
        RenderStats {
            rays: self.oracle.ray_counts(),
            packets: 0,
            unseen_backs: self.oracle.unseen_backs(),
        }
    }
}
