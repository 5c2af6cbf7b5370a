//! The modern standard scenes: triangles only, from thousands to tens of millions, selected by one
//! size parameter.
//!
//! Haines' databases, made for the machines of 1987, do not test height fields, thin tubes,
//! interiors and closed meshes of glass. These scenes do. Each is drawn with a
//! [`mesh_builder::MeshBuilder`], chunk by chunk, so that a scene larger than memory can go to a
//! file. All lights are point lights, even suns (far away), because every file format here supports
//! those.

mod assembly;
pub(super) mod atrium;
mod chunks;
pub(super) mod cornell;
mod geodesic;
pub(super) mod hair;
mod knot;
mod materials;
pub(super) mod menger;
mod mesh_builder;
mod noise;
mod props;
pub(super) mod room;
mod section;
mod setup;
pub(super) mod street;
pub(super) mod terrain;
