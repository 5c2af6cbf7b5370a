//! Both tracers: against each other, bit for bit, against closed forms and exact arithmetic, and
//! against other tracers.

#[path = "../common/mod.rs"]
mod common;

mod all_hits;
mod beams;
mod bit_identity;
mod coverage;
mod distance;
mod distributed;
mod environments;
mod far_sides;
mod filters;
mod front_door;
mod goldens;
mod instances;
mod isa_guard;
mod lanes;
mod layers;
mod maps;
mod mattes;
mod moving;
mod oracle_truth;
mod peers;
mod random_scenes;
mod ray_sets;
mod references;
mod refined;
mod refusals;
mod regressions;
mod same_tree;
mod sampling;
mod small_batches;
mod systems;
mod terminator;
mod textures;
mod threads;
mod traversal;
mod watertight;
mod wide_tree;
