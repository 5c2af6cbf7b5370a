//! street: a lane of old houses at nightfall, with a café whose window and door stand open.
//!
//! Houses consist of real parts: frames, sills, shutters, balusters, bricks. `detail` is their
//! fineness (quads per metre); each kind of part appears at a detail of its own. The rest of the
//! size is spent on the pavement.

mod cafe;
mod house;
mod lane;
mod layout;
mod opening;
mod palette;
mod stone;
mod town;

pub(crate) use town::generate;
