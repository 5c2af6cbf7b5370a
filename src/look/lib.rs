//! Makes a scene one that can be rendered: adds the parts that its file does not give, and applies
//! the user's overrides.
//!
//! | file | holds |
//! |---|---|
//! | `overrides` | the user's overrides of a scene |
//! | `finish` | the steps: overrides, default parts, validation; and the notes on them |
//! | `framing` | the default camera, which shows everything |
//! | `lights` | the default lights, and the sky that mirrors reflect |
//! | `camera_choice` | the choice among the cameras of a file |
//!
//! [`Scene::defaulted`](phalanx_scene::Scene::defaulted) says which parts are defaults, from the
//! reader through caches to the last picture.

mod camera_choice;
mod finish;
mod framing;
mod lights;
mod overrides;

pub use finish::{UnfitScene, finish_scene, override_scene};
pub use lights::{DefaultLights, SKY, environment_scale};
pub use overrides::{AddedLight, Overrides};
