//! Materials of the atrium.

use crate::builder::DocumentMaterial;
use crate::modern::materials::{glow, matte, polished, rgb};
use glam::{DVec3, dvec3};

/// Mean light in the court, and in the aisles, where it is warmed by other walls.
const OPEN: DVec3 = dvec3(0.125, 0.132, 0.172);
const COVERED: DVec3 = dvec3(0.155, 0.112, 0.085);

// Rows of the palette.
pub(super) const STONE: usize = 0;
pub(super) const CARVED: usize = 1;
pub(super) const PLASTER: usize = 2;
pub(super) const VAULT: usize = 3;
pub(super) const TERRACOTTA: usize = 4;
pub(super) const SLABS: [usize; 2] = [5, 6];
pub(super) const TIMBER: usize = 7;
pub(super) const BOARDS: usize = 8;
pub(super) const IRON: usize = 9;
pub(super) const BRASS: usize = 10;
pub(super) const WATER: usize = 11;
pub(super) const FLAME: usize = 12;
pub(super) const URN: usize = 13;
pub(super) const LEAVES: [usize; 2] = [14, 15];
pub(super) const FRUIT: usize = 16;
pub(super) const ROPE: usize = 17;
pub(super) const CLOTH: usize = 18;
/// Number of colours of cloth.
pub(super) const CLOTHS: usize = 4;

pub(super) fn palette() -> Vec<DocumentMaterial> {
    let dull = |r: f64, g: f64, b: f64| matte(rgb(r, g, b), OPEN);
    let indoors = |r: f64, g: f64, b: f64| matte(rgb(r, g, b), COVERED);
    // Cloth is dyed through: light from behind makes it glow a little.
    let cloth = |r: f64, g: f64, b: f64| matte(rgb(r, g, b), OPEN * 1.25);
    let slab = |material| polished(material, rgb(0.13, 0.13, 0.13), 300.0);
    vec![
        dull(0.68, 0.54, 0.36),
        dull(0.76, 0.64, 0.46),
        indoors(0.66, 0.44, 0.26),
        indoors(0.70, 0.58, 0.43),
        polished(indoors(0.42, 0.17, 0.09), rgb(0.03, 0.03, 0.03), 60.0),
        slab(dull(0.50, 0.42, 0.32)),
        slab(dull(0.26, 0.15, 0.10)),
        indoors(0.27, 0.145, 0.07),
        indoors(0.36, 0.22, 0.12),
        dull(0.03, 0.03, 0.032),
        polished(dull(0.45, 0.29, 0.09), rgb(0.28, 0.20, 0.09), 60.0),
        polished(dull(0.02, 0.055, 0.06), rgb(0.50, 0.52, 0.53), 900.0),
        glow(rgb(1.0, 0.74, 0.36)),
        dull(0.50, 0.22, 0.12),
        dull(0.07, 0.17, 0.04),
        dull(0.13, 0.25, 0.05),
        polished(dull(0.85, 0.34, 0.03), rgb(0.04, 0.04, 0.04), 60.0),
        dull(0.42, 0.33, 0.20),
        cloth(0.46, 0.03, 0.04),
        cloth(0.76, 0.38, 0.05),
        cloth(0.035, 0.085, 0.30),
        cloth(0.035, 0.20, 0.135),
    ]
}
