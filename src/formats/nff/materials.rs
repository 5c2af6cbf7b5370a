//! Materials of the file in its own terms, until the number of lights is known.

use glam::Vec3;
use phalanx_scene::{Column, Material, MaterialTable, NO_TEXTURE, Scene};

/// The numbers of an `f` record: red, green, blue, Kd, Ks, Shine, T and index of refraction.
pub(super) type FillRecord = [f32; 8];

/// Record of shapes before the first `f`: dull, nearly white.
const DEFAULT: FillRecord = [0.8, 0.8, 0.8, 1.0, 0.0, 1.0, 0.0, 1.0];

/// The materials so far. Shapes refer to them by number as if they were rows of the scene's
/// materials.
pub(super) struct NffMaterials {
    materials: Vec<MaterialSource>,
}

enum MaterialSource {
    /// The user's material, for shapes for which the file gives none.
    Given(Material),
    Filled(FillRecord),
}

impl NffMaterials {
    /// Starts with the material of shapes before the first `f`.
    pub(super) fn new(default: Option<Material>) -> Self {
        NffMaterials {
            materials: vec![default.map_or(MaterialSource::Filled(DEFAULT), MaterialSource::Given)],
        }
    }

    /// Sets the material of the shapes from here on.
    pub(super) fn push(&mut self, fill: FillRecord) {
        self.materials.push(MaterialSource::Filled(fill));
    }

    /// The number of the material that shapes have here.
    pub(super) fn current(&self) -> u32 {
        self.materials.len() as u32 - 1
    }

    /// Creates materials from the records, and assigns their rows to the shapes. Records without a
    /// shape leave none.
    pub(super) fn settle(&self, level: f64, scene: &mut Scene) {
        let mut table = MaterialTable::default();
        let mut rows: Vec<Option<u32>> = vec![None; self.materials.len()];
        let materials = &mut scene.materials;
        let mut settle_column = |column: &mut Column<u32>| {
            for number in column.iter_mut() {
                let row = *number as usize;
                *number = *rows[row].get_or_insert_with(|| {
                    let material = match &self.materials[row] {
                        MaterialSource::Given(material) => *material,
                        MaterialSource::Filled(fill) => material_of(fill, level),
                    };
                    table.intern(&material, materials)
                });
            }
        };
        settle_column(&mut scene.spheres.material);
        settle_column(&mut scene.cones.material);
        settle_column(&mut scene.triangles.material);
    }
}

/// The document's parameters: Ka = level·Kd·rgb, diffuse Kd·rgb, specular and transmission white.
/// The products are made in f64 and rounded once. An index of refraction of 0, which the databases
/// use for opaque surfaces, counts as 1.
fn material_of(&[r, g, b, kd, ks, shine, t, ior]: &FillRecord, level: f64) -> Material {
    let kd = Vec3::new(r, g, b).as_dvec3() * f64::from(kd);
    Material {
        ka: (kd * level).as_vec3(),
        ke: Vec3::ZERO,
        kd: kd.as_vec3(),
        ks: Vec3::splat(ks),
        kt: Vec3::splat(t),
        shininess: shine,
        ior: if ior > 0.0 { ior } else { 1.0 },
        texture: NO_TEXTURE,
        ..Material::DEFAULT
    }
}
