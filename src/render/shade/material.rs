//! The row of one material, as shading reads it.

use glam::Vec3;
use phalanx_scene::Scene;

/// One material, with colours in the form for multiplication.
#[derive(Clone, Copy, Debug)]
pub struct ShadeMaterial {
    /// Ambient colour.
    pub ka: Vec3,
    /// Emission colour.
    pub ke: Vec3,
    /// Diffuse colour.
    pub kd: Vec3,
    /// Specular colour.
    pub ks: Vec3,
    /// Transmission colour.
    pub kt: Vec3,
    /// Blinn exponent.
    pub shininess: f32,
    /// Index of refraction.
    pub ior: f32,
}

impl ShadeMaterial {
    /// Reads one row of the columns. Callers use a few of the fields, and the rest is not read
    /// where this is inlined.
    #[inline(always)]
    pub fn of(scene: &Scene, index: u32) -> ShadeMaterial {
        let (m, i) = (&scene.materials, index as usize);
        ShadeMaterial {
            ka: m.ka.get(i),
            ke: m.ke.get(i),
            kd: m.kd.get(i),
            ks: m.ks.get(i),
            kt: m.kt.get(i),
            shininess: m.shininess[i],
            ior: m.ior[i],
        }
    }

    /// Divisor that turns Ks and Kt into shares: Ks + Kt, but no less than 1. A share is the part
    /// of its camera ray that a bounce carries. After this division, the weights of all rays from a
    /// hit add up to 1 at most, and so do the shares of a camera ray's bounces at every depth,
    /// regardless of the materials. So no more than 1/w of them in each component are w or more.
    pub fn secondary_weight(&self) -> Vec3 {
        (self.ks.abs() + self.kt.abs()).max(Vec3::ONE)
    }
}

/// The material of one batch after another, read only when it changes.
pub struct CurrentMaterial<'s> {
    scene: &'s Scene,
    current: Option<(u32, ShadeMaterial)>,
}

impl<'s> CurrentMaterial<'s> {
    /// Materials of a scene.
    pub fn new(scene: &'s Scene) -> CurrentMaterial<'s> {
        CurrentMaterial {
            scene,
            current: None,
        }
    }

    /// The row of one material.
    #[inline(always)]
    pub fn row(&mut self, index: u32) -> ShadeMaterial {
        match self.current {
            Some((current, row)) if current == index => row,
            _ => {
                let row = ShadeMaterial::of(self.scene, index);
                self.current = Some((index, row));
                row
            }
        }
    }
}
