//! Small pictures of a scene for the page: the render, and the heat map of its cost.

use crate::cli::output::CliError;
use phalanx::bench::BenchPlan;
use phalanx::bvh::Bvh;
use phalanx::frame::{AccelRef, Control, RayCost, Settings, render_heatmap, render_with};
use phalanx::image::{encode, false_color, png_bytes};
use phalanx::report::html::ScenePictures;
use phalanx::scene::Scene;

/// Size of the pictures, the maximum at which the page shows them.
const SIZE: [u32; 2] = [360, 270];

/// Both pictures.
pub fn draw(name: &str, scene: &Scene) -> Result<ScenePictures, CliError> {
    let bvh = Bvh::build(scene);
    let settings = Settings {
        width: SIZE[0],
        height: SIZE[1],
        threads: BenchPlan::all_threads(),
        ..Settings::of(scene)
    };
    let control = Control::default();
    let frame = render_with(scene, AccelRef::Packets(&bvh), &settings, &control)?;
    let nodes = render_heatmap(scene, &bvh, &settings, RayCost::Nodes, &control)?;
    let legend = RayCost::Nodes.title();
    Ok(ScenePictures {
        scene: name.to_owned(),
        thumbnail_png: png_bytes(&encode(&frame.film, scene.encoding)),
        heat_png: Some(png_bytes(&false_color(&nodes, SIZE[0], legend))),
        heat_legend: legend.to_owned(),
    })
}
