//! The surfaces under a pixel, in the words of the library and of the file.

use super::protocol::PixelRequest;
use super::viewed_scene::ViewedScene;
use glam::{DVec3, Vec3};
use phalanx::frame::{AccelRef, Aov, Aovs, Control, FrameError, Settings, Tile, render_with};
use phalanx::{Hit, Ray, RayFilter};
use serde_json::{Value, json};

/// Most surfaces that are listed.
const MAX_PASSED: usize = 64;

impl ViewedScene {
    /// The first surface that the picture does not pass under the centre of a pixel, with those
    /// that it passes.
    pub(super) fn pixel(&self, request: &PixelRequest) -> Result<Value, FrameError> {
        let PixelRequest { shot, x, y, bounds } = *request;
        let aovs = [
            Aov::Position,
            Aov::Ng,
            Aov::Ns,
            Aov::Albedo,
            Aov::Material,
            Aov::Cost,
        ];
        let region = Tile {
            x,
            y,
            width: 1,
            height: 1,
        };
        let settings = Settings {
            region: Some(region),
            aovs: aovs.into_iter().fold(Aovs::default(), Aovs::with),
            record_hits: true,
            threads: 1,
            max_depth: 0,
            ..self.settings(shot.mode, shot.size)
        };
        let tree = AccelRef::Packets(&self.bvh);
        let frame = render_with(&self.scene, tree, &settings, &Control::default())?;
        let [origin, direction] = settings.first_ray(&self.scene, x, y)?;
        let ray = Ray::new(origin, direction);
        let seen = frame.film.hits.as_ref();
        let seen = seen.map(|hits| (hits.prim_id[0], hits.t[0]));
        let is_seen = |hit: &Hit| Some((hit.prim_id, hit.t)) == seen;
        let along = self.bvh.all_hits_filtered(&ray, &RayFilter::default());
        let index = along.iter().position(is_seen);
        let passed = along[..index.unwrap_or(along.len())]
            .iter()
            .take(MAX_PASSED);
        let passed: Vec<Value> = passed.map(|hit| self.name(hit)).collect();
        let layer = |aov: Aov| -> Vec<f32> {
            let planes = frame.film.layer(aov).iter();
            planes.map(|plane| plane[0]).collect()
        };
        let file_origin = DVec3::from_array(self.scene.origin);
        let hit = index.map(|index| {
            let mut answer = self.name(&along[index]);
            let position = Vec3::from_slice(&layer(Aov::Position));
            answer["position"] = json!((position.as_dvec3() + file_origin).to_array());
            answer["normal"] = json!(layer(Aov::Ns));
            answer["face_normal"] = json!(layer(Aov::Ng));
            answer["albedo"] = json!(layer(Aov::Albedo));
            answer["material_id"] = json!(layer(Aov::Material)[0].to_bits());
            answer["nodes"] = json!(layer(Aov::Cost)[0]);
            answer
        });
        let mut answer = json!({
            "pixel": [x, y],
            "origin": self.scene.file_position(origin.into()).to_array(),
            "direction": direction,
            "hit": hit,
            "passed": passed,
        });
        if let (Some(index), true) = (index, bounds) {
            let bounds = self.scene.object_bounds(along[index].prim_id);
            let corner = |point| self.scene.file_position(point).to_array();
            answer["bounds"] = json!([corner(bounds.lo), corner(bounds.hi)]);
        }
        Ok(answer)
    }

    fn name(&self, hit: &Hit) -> Value {
        let [object, material] = self.scene.prim_names(hit.prim_id);
        json!({
            "primitive": hit.prim_id,
            "geometry": Some(hit.geom_id).filter(|id| *id != phalanx::NO_GEOM),
            "object": object,
            "material": material,
            "t": f64::from(hit.t) / f64::from(self.scene.scale),
            "u": hit.u,
            "v": hit.v,
        })
    }
}
