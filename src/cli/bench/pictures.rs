//! Small pictures of a scene for the page: itself, and what it costs.

use super::super::failure::Failure;
use super::super::heat;
use phalanx::bvh::Bvh;
use phalanx::frame::{Control, Cost, Settings, Tree, costs, render_tree};
use phalanx::image::{encode, false_color, png_bytes};
use phalanx::report::html::ScenePictures;
use phalanx::scene::Scene;

/// Size of the pictures: the page shows them no wider.
const SIZE: [u32; 2] = [360, 270];

/// Both pictures.
pub fn of(name: &str, scene: &Scene) -> Result<ScenePictures, Failure> {
    let bvh = Bvh::build(scene);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let settings = Settings {
        width: SIZE[0],
        height: SIZE[1],
        threads,
        ..Settings::of(scene)
    };
    let control = Control::default();
    let frame = render_tree(scene, Tree::Packets(&bvh), &settings, &control)?;
    let nodes = costs(scene, &bvh, &settings, Cost::Nodes, &control)?;
    let legend = heat::title(Cost::Nodes);
    Ok(ScenePictures {
        scene: name.to_owned(),
        thumbnail_png: png_bytes(&encode(&frame.film, scene.tone)),
        heat_png: Some(png_bytes(&false_color(&nodes, SIZE[0], legend))),
        heat_legend: legend.to_owned(),
    })
}
