//! Surfaces as the file has them, until the number of lights is known.

use glam::Vec3;
use phalanx_scene::{Column, NO_TEXTURE, Palette, Scene, Surface};

/// The numbers of an `f` record: red, green, blue, Kd, Ks, Shine, T and index of refraction.
pub(super) type Look = [f32; 8];

/// Of shapes that stand before the first `f`: dull, nearly white.
const DEFAULT: Look = [0.8, 0.8, 0.8, 1.0, 0.0, 1.0, 0.0, 1.0];

/// The surfaces so far. Shapes name them by number as if they were rows of the materials.
pub(super) struct Looks {
    looks: Vec<Kind>,
}

enum Kind {
    /// As the user wants what the file says nothing of.
    Given(Surface),
    Look(Look),
}

impl Looks {
    /// With the one that shapes before the first `f` get.
    pub(super) fn new(given: Option<Surface>) -> Self {
        Looks {
            looks: vec![given.map_or(Kind::Look(DEFAULT), Kind::Given)],
        }
    }

    /// From here on shapes have this surface.
    pub(super) fn push(&mut self, look: Look) {
        self.looks.push(Kind::Look(look));
    }

    /// The number of the surface that shapes have here.
    pub(super) fn current(&self) -> u32 {
        self.looks.len() as u32 - 1
    }

    /// Makes materials of the surfaces and gives the shapes their rows. Surfaces without a shape leave none.
    pub(super) fn settle(&self, level: f64, scene: &mut Scene) {
        let mut palette = Palette::default();
        let mut rows: Vec<Option<u32>> = vec![None; self.looks.len()];
        let materials = &mut scene.materials;
        let mut settle_column = |column: &mut Column<u32>| {
            for number in column.iter_mut() {
                let look = *number as usize;
                *number = *rows[look].get_or_insert_with(|| {
                    let surface = match &self.looks[look] {
                        Kind::Given(surface) => *surface,
                        Kind::Look(look) => surface_of(look, level),
                    };
                    palette.row(&surface, materials)
                });
            }
        };
        settle_column(&mut scene.spheres.material);
        settle_column(&mut scene.cones.material);
        settle_column(&mut scene.triangles.material);
    }
}

/// The document's parameters: Ka = level·Kd·rgb, diffuse Kd·rgb, specular and transmission white. The products are
/// made in f64 and rounded once. An index of refraction of 0, as the databases give opaque surfaces, counts as 1.
fn surface_of(&[r, g, b, kd, ks, shine, t, ior]: &Look, level: f64) -> Surface {
    let kd = Vec3::new(r, g, b).as_dvec3() * f64::from(kd);
    Surface {
        ka: (kd * level).as_vec3(),
        ke: Vec3::ZERO,
        kd: kd.as_vec3(),
        ks: Vec3::splat(ks),
        kt: Vec3::splat(t),
        shininess: shine,
        ior: if ior > 0.0 { ior } else { 1.0 },
        texture: NO_TEXTURE,
        gloss: 0.0,
    }
}
