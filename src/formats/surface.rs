//! The material a reader is at, and the table of those already used.

use crate::scene::Materials;
use glam::Vec3;
use std::collections::HashMap;

/// One row of [`Materials`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub(super) ka: Vec3,
    pub(super) ke: Vec3,
    pub(super) kd: Vec3,
    pub(super) ks: Vec3,
    pub(super) kt: Vec3,
    pub(super) shininess: f32,
    pub(super) ior: f32,
}

/// Numbers in a surface.
const NUMBERS: usize = 17;

impl Surface {
    /// Equal surfaces have equal bits; bits, unlike floats, can be hashed.
    fn bits(&self) -> [u32; NUMBERS] {
        let mut bits = [0; NUMBERS];
        let colors = [self.ka, self.ke, self.kd, self.ks, self.kt];
        let numbers = colors.iter().flat_map(Vec3::as_ref);
        for (bits, number) in bits
            .iter_mut()
            .zip(numbers.chain([&self.shininess, &self.ior]))
        {
            *bits = number.to_bits();
        }
        bits
    }
}

/// Gives each distinct surface one row.
#[derive(Debug, Default)]
pub(super) struct Palette {
    rows: HashMap<[u32; NUMBERS], u32>,
}

impl Palette {
    /// The row of `surface`, appended where it is new.
    pub(super) fn row(&mut self, surface: &Surface, materials: &mut Materials) -> u32 {
        *self.rows.entry(surface.bits()).or_insert_with(|| {
            let row = materials.len() as u32;
            materials.ka.push(surface.ka);
            materials.ke.push(surface.ke);
            materials.kd.push(surface.kd);
            materials.ks.push(surface.ks);
            materials.kt.push(surface.kt);
            materials.shininess.push(surface.shininess);
            materials.ior.push(surface.ior);
            row
        })
    }
}
