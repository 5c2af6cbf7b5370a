//! The whole atrium: four wings around the court, and everything in it.

use super::layout::{GROUND, UPPER, Wing, wings};
use super::palette::palette;
use super::{arcade, column, court, drape, gallery, hanging};
use crate::builder::SceneBuilder;
use crate::modern::assembly;
use crate::modern::materials::rgb;
use crate::modern::props::{PartBuilder, fitted_detail};
use crate::modern::setup::{hd, lamp, sun};
use glam::{DVec3, dvec3};

const SKY: DVec3 = dvec3(0.25, 0.43, 0.73);

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    let atrium = Atrium::of(size);
    let long = atrium.wings[1].length() / 2.0;
    let (from, target) = (dvec3(-1.7, 2.3, long - 0.3), dvec3(0.7, 3.6, -0.3 * long));
    builder.view(&hd(from, target, 60.0));
    builder.background(SKY);
    builder.light(&sun(dvec3(-0.58, 0.72, 0.38), rgb(1.55, 0.98, 0.46)));
    builder.light(&sun(dvec3(0.25, 0.9, 0.22), rgb(0.09, 0.135, 0.23)));
    // Light reflected from the sunny side to the shady one.
    let bounce = dvec3(3.2, 5.2, 0.1 * long);
    builder.light(&lamp(bounce, rgb(0.21, 0.14, 0.08), 7.0));
    for (wing, bay) in [(0, 0), (0, 3), (1, 1), (1, 2)] {
        builder.light(&hanging::light(&atrium.wings[wing], bay));
    }
    let budget = u64::from(size);
    let build = |parts: &mut PartBuilder, part| atrium.build(parts, part);
    let count = atrium.wings.len() + 1;
    let detail = fitted_detail(budget * 7 / 10, (0.05, 4000.0), count, build);
    let drapes = drape::drapes(&atrium.wings);
    assembly::draw(builder, palette(), &|mesh| {
        let mut parts = PartBuilder::new(mesh, detail);
        (0..count).for_each(|part| build(&mut parts, part));
        let left = budget.saturating_sub(mesh.triangles());
        drape::hang(mesh, &drapes, left);
    });
}

/// The sides of the court.
struct Atrium {
    bays: u32,
    wings: [Wing; 4],
}

impl Atrium {
    /// Builds fewer bays for small sizes, so that those still have carved columns.
    fn of(size: u32) -> Atrium {
        let bays = match size {
            0..9_000 => 2,
            9_000..30_000 => 4,
            30_000..75_000 => 6,
            _ => 8,
        };
        Atrium {
            bays,
            wings: wings(bays),
        }
    }

    /// Builds one of the wings, or after them what is in the court; not the drapes.
    fn build(&self, parts: &mut PartBuilder, part: usize) {
        let Some(wing) = self.wings.get(part) else {
            court::furnish(parts, self.bays);
            return hanging::ropes(parts, self.bays);
        };
        let mut side = parts.at(wing.frame);
        for storey in [&GROUND, &UPPER] {
            column::colonnade(&mut side, wing, storey);
            arcade::storey(&mut side, wing, storey);
        }
        arcade::aisle(&mut side, wing);
        gallery::gallery(&mut side, wing);
        gallery::roof(&mut side, wing);
        hanging::lanterns(&mut side, wing);
    }
}
