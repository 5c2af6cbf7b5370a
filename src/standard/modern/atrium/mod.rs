//! atrium: a court with two storeys of arcades in late sunlight, as architects' models are built.
//!
//! Walls, floors and timbers consist of a few triangles each at any size: they are long, slanted,
//! and their boxes overlap. `detail` is the fineness (quads to a metre) of turned and carved work
//! alone; the rest of the size is spent on drapes, which are finely tessellated cloth.

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
