//! The whole street: houses on both sides, the café, the lane, and the pavement.

use super::house::House;
use super::layout::{HALF, START};
use super::palette::palette;
use super::{cafe, lane};
use crate::builder::SceneBuilder;
use crate::modern::assembly;
use crate::modern::materials::rgb;
use crate::modern::props::{LocalFrame, PartBuilder, fitted_detail};
use crate::modern::setup::{hd, sun};
use glam::{DVec3, dvec3};

const SKY: DVec3 = dvec3(0.075, 0.135, 0.30);

pub(crate) fn generate(size: u32, builder: &mut dyn SceneBuilder) {
    builder.view(&hd(dvec3(1.75, 1.72, 10.1), dvec3(-1.6, 2.15, 0.0), 52.0));
    builder.background(SKY);
    let town = Town::of(size);
    builder.light(&sun(dvec3(0.35, 0.85, 0.55), rgb(0.13, 0.17, 0.29)));
    cafe::lights(&town.cafe()).for_each(|light| builder.light(&light));
    for post in lane::LAMPS {
        builder.light(&lane::light(post));
    }
    let budget = u64::from(size);
    let build = |parts: &mut PartBuilder, part| town.build(parts, part);
    let count = town.houses.len() + 1;
    let detail = fitted_detail(budget * 7 / 10, (0.01, 400.0), count, build);
    assembly::draw(builder, palette(), &|mesh| {
        let mut parts = PartBuilder::new(mesh, detail);
        (0..count).for_each(|part| build(&mut parts, part));
        let left = budget.saturating_sub(parts.mesh.triangles());
        lane::pave(&mut parts, town.length, left);
    });
}

/// The houses, left and right from the eye on, and one across the end.
struct Town {
    houses: Vec<House>,
    /// Length from the first houses to the last.
    length: f64,
}

impl Town {
    /// Builds more houses for larger sizes, so that small ones still have windows.
    fn of(size: u32) -> Town {
        let depth: u32 = match size {
            0..25_000 => 1,
            25_000..80_000 => 2,
            80_000..250_000 => 3,
            250_000..3_000_000 => 4,
            _ => 5,
        };
        let length = 7.2 * f64::from(depth);
        let mut houses = Vec::new();
        for k in 0..depth {
            let z = START - 7.2 * f64::from(k);
            // x runs to the right for an observer in front of the house.
            let left = LocalFrame::upright(dvec3(-HALF, 0.0, z), DVec3::NEG_Z, DVec3::X);
            let right = LocalFrame::upright(dvec3(HALF, 0.0, z - 7.2), DVec3::Z, DVec3::NEG_X);
            houses.push(House::new(left, u64::from(2 * k), 7.2, k == 0));
            houses.push(House::new(right, u64::from(2 * k + 1), 7.2, false));
        }
        let end = LocalFrame::at(dvec3(-HALF, 0.0, START - length - 0.01));
        houses.push(House::new(end, 99, 2.0 * HALF, false));
        Town { houses, length }
    }

    /// Frame of the café: the first house on the left.
    fn cafe(&self) -> LocalFrame {
        self.houses[0].frame
    }

    /// Builds one of the houses, or after them what stands in the lane.
    fn build(&self, parts: &mut PartBuilder, part: usize) {
        let Some(house) = self.houses.get(part) else {
            cafe::furnish(&mut parts.at(self.cafe()));
            return lane::furnish(parts, self.length);
        };
        let mut facade = parts.at(house.frame);
        house.build(&mut facade);
        if house.cafe {
            cafe::front(&mut facade, house);
        }
    }
}
