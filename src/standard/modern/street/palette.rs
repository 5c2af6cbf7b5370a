//! Materials of the street.

use crate::builder::DocumentMaterial;
use crate::modern::materials::{glass, glow, matte, polished, rgb};
use glam::{DVec3, dvec3};

/// Mean light of the evening sky.
const AMBIENT: DVec3 = dvec3(0.105, 0.135, 0.225);

// Rows of the palette.
pub(super) const STUCCO: usize = 0;
pub(super) const STUCCOS: usize = 5;
pub(super) const BRICK: usize = STUCCO + STUCCOS;
pub(super) const TRIM: usize = BRICK + 3;
pub(super) const WOOD: usize = TRIM + 1;
pub(super) const SHUTTER: usize = WOOD + 1;
pub(super) const SHUTTERS: usize = 3;
pub(super) const PANE: usize = SHUTTER + SHUTTERS;
pub(super) const LIT: usize = PANE + 1;
pub(super) const ROOF: usize = LIT + 3;
pub(super) const IRON: usize = ROOF + 1;
pub(super) const COBBLE: usize = IRON + 1;
pub(super) const KERB: usize = COBBLE + 3;
pub(super) const WARM_WALL: usize = KERB + 1;
pub(super) const PLANK: usize = WARM_WALL + 1;
pub(super) const TABLE: usize = PLANK + 1;
pub(super) const BULB: usize = TABLE + 1;
pub(super) const SHADE: usize = BULB + 1;
pub(super) const BOTTLE: usize = SHADE + 1;
pub(super) const CHINA: usize = BOTTLE + 3;
pub(super) const LEAF: usize = CHINA + 1;
pub(super) const PICTURE: usize = LEAF + 2;

pub(super) fn palette() -> Vec<DocumentMaterial> {
    let dull = |r: f64, g: f64, b: f64| matte(rgb(r, g, b), AMBIENT);
    let wet = |material| polished(material, rgb(0.085, 0.085, 0.085), 120.0);
    // Light reflected by the walls inside the café is warm.
    let inside = |r: f64, g: f64, b: f64| matte(rgb(r, g, b), rgb(0.26, 0.17, 0.085));
    let tinted = |r: f64, g: f64, b: f64| DocumentMaterial {
        kt: rgb(r, g, b),
        ..glass(1.3)
    };
    vec![
        dull(0.62, 0.52, 0.37),
        dull(0.55, 0.34, 0.24),
        dull(0.58, 0.57, 0.52),
        dull(0.36, 0.43, 0.44),
        dull(0.60, 0.44, 0.22),
        dull(0.36, 0.13, 0.075),
        dull(0.30, 0.10, 0.06),
        dull(0.42, 0.18, 0.11),
        dull(0.62, 0.59, 0.53),
        dull(0.24, 0.13, 0.065),
        dull(0.075, 0.16, 0.12),
        dull(0.10, 0.15, 0.24),
        dull(0.27, 0.08, 0.06),
        polished(dull(0.02, 0.025, 0.035), rgb(0.42, 0.42, 0.42), 800.0),
        glow(rgb(1.0, 0.62, 0.24)),
        glow(rgb(0.74, 0.40, 0.135)),
        glow(rgb(0.40, 0.20, 0.07)),
        dull(0.30, 0.12, 0.07),
        dull(0.025, 0.027, 0.03),
        wet(dull(0.20, 0.19, 0.185)),
        wet(dull(0.155, 0.15, 0.15)),
        wet(dull(0.25, 0.235, 0.22)),
        wet(dull(0.30, 0.29, 0.27)),
        inside(0.70, 0.46, 0.22),
        polished(inside(0.30, 0.16, 0.07), rgb(0.05, 0.05, 0.05), 80.0),
        inside(0.24, 0.11, 0.045),
        glow(rgb(1.0, 0.86, 0.56)),
        DocumentMaterial {
            ke: rgb(0.50, 0.24, 0.07),
            ..inside(0.6, 0.4, 0.2)
        },
        tinted(0.15, 0.55, 0.20),
        tinted(0.65, 0.30, 0.07),
        tinted(0.75, 0.75, 0.70),
        polished(inside(0.75, 0.72, 0.66), rgb(0.06, 0.06, 0.06), 200.0),
        dull(0.06, 0.16, 0.04),
        dull(0.10, 0.22, 0.05),
        inside(0.12, 0.25, 0.30),
    ]
}
