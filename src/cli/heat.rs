//! `render --heat`: a picture of what the picture cost.

use super::failure::Failure;
use super::progress::{self, Watch};
use super::{interrupt, output};
use phalanx::frame::{Cost, Prepared, Settings, Tree, costs};
use phalanx::image::{false_color, save_png};
use phalanx::scene::Scene;
use std::path::PathBuf;

/// What to count, and where the picture of it goes.
pub struct Heat {
    cost: Cost,
    path: PathBuf,
}

/// Most pixels of the picture.
const PIXELS: u64 = 1 << 28;

/// Names of what can be counted, and what the legend says.
const COSTS: [(&str, Cost, &str); 3] = [
    ("nodes", Cost::Nodes, "nodes visited by a camera ray"),
    ("prims", Cost::Prims, "primitives tested by a camera ray"),
    ("time", Cost::Time, "nanoseconds a camera ray"),
];

/// Refuses a place that `--heat` cannot write to.
pub fn check_place(heat: Option<&[String]>) -> Result<(), Failure> {
    let Some([_, path]) = heat else {
        return Ok(());
    };
    output::check_png_name(path.as_ref(), "--heat")?;
    output::check_picture_place(path.as_ref())
}

/// The picture that `--heat` asks for.
pub fn asked(heat: Option<&[String]>, settings: &Settings) -> Result<Option<Heat>, Failure> {
    let Some([name, path]) = heat else {
        return Ok(None);
    };
    let Some((_, cost, _)) = COSTS.iter().find(|(known, ..)| known == name) else {
        return Err(Failure::Usage(format!(
            "--heat {name}: expected nodes, prims or time, then the picture's name"
        )));
    };
    if settings.engine != phalanx::frame::Engine::Simd {
        return Err(Failure::Usage(
            "--heat shows the packet engine's work: leave out --engine scalar".to_owned(),
        ));
    }
    if settings.pixels() > PIXELS {
        return Err(Failure::Usage(format!(
            "--heat holds a whole picture in memory: {} pixels are more than {PIXELS}; take a part, with --region",
            settings.pixels()
        )));
    }
    let path = PathBuf::from(path);
    Ok(Some(Heat { cost: *cost, path }))
}

/// Traces the camera rays once more, and writes what they cost.
pub fn write(
    heat: &Heat,
    scene: &Scene,
    prepared: &Prepared,
    settings: &Settings,
) -> Result<(), Failure> {
    let Tree::Packets(bvh) = prepared.tree() else {
        return Ok(());
    };
    let costs = progress::watched(Watch::of(settings.pixels()), |control| {
        costs(scene, bvh, settings, heat.cost, control)
    })?;
    let picture = false_color(&costs, settings.window().width, title(heat.cost));
    Ok(interrupt::undisturbed(&heat.path, || {
        save_png(&heat.path, &picture)
    })??)
}

/// What the legend says.
pub fn title(cost: Cost) -> &'static str {
    let known = COSTS.iter().find(|(_, c, _)| *c == cost);
    known.map_or("", |(_, _, title)| title)
}
