//! balls: see `balls.c`.

use crate::standard::catalogue::{Entry, Family, Params};
use crate::standard::sink::Sink;

pub(in crate::standard) const ENTRY: Entry = Entry {
    name: "balls",
    purpose: "a sphereflake over a plane: depth complexity and mirrors",
    family: Family::Spd,
    default_size: 4,
    sizes: 1..=8,
    size_means: "levels of the recursion",
    max_depth: 4,
    generate,
};

fn generate(_: &Params, _: &mut dyn Sink) {}
