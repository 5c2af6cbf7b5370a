//! The modern standard scenes: triangles only, from thousands to tens of millions by one size
//! parameter.
//!
//! Haines' databases, made for the machines of 1987, do not test height fields, thin tubes,
//! interiors and closed meshes of glass. These scenes do. Each is drawn with a
//! [`mesh_builder::MeshBuilder`], chunk by chunk, so that a scene larger than memory can go to a
//! file. Lights are points, suns too (far away), because every file format here can hold those.

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
pub(super) mod street;
pub(super) mod terrain;

use super::builder::{StandardLight, StandardView};
use glam::DVec3;
use std::ops::RangeInclusive;

/// Numbers of triangles that every modern scene can be made of, about.
const SIZES: RangeInclusive<u32> = 4_000..=100_000_000;

/// A view of 1280x960 pixels with y up.
fn hd(from: DVec3, at: DVec3, fovy: f64) -> StandardView {
    StandardView {
        from,
        at,
        up: DVec3::Y,
        fovy,
        width: 1280,
        height: 960,
    }
}

/// A light so far away in this direction that its rays are practically parallel.
fn sun(toward: DVec3, color: DVec3) -> StandardLight {
    StandardLight::colored(toward / toward.length() * 1e4, color)
}

/// A lamp that has this colour at distance `reach`. Nearer it is brighter, but at most twice.
fn lamp(position: DVec3, color: DVec3, reach: f64) -> StandardLight {
    StandardLight {
        attenuation: DVec3::new(0.5, 0.0, 0.5 / (reach * reach)),
        ..StandardLight::colored(position, color)
    }
}
