//! atrium: a court with two storeys of arcades in late sunlight, built like an architect's model.
//!
//! Walls, floors and timbers consist of a few triangles each at any size: they are long and
//! slanted, and their boxes overlap. `detail` is the fineness (quads per metre) of turned and
//! carved work only; the rest of the size is spent on drapes, which are finely tessellated cloth.

mod arcade;
mod building;
mod column;
mod court;
mod drape;
mod gallery;
mod hanging;
mod layout;
mod palette;
mod relief;
mod turning;

pub(crate) use building::generate;
