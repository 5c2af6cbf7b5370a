//! All lights of a scene, to be picked by their importance.

use super::alias::AliasTable;
use super::{SceneMiddle, emitters, luminance};
use crate::scene::Scene;
use glam::Vec3;
use std::collections::HashMap;
use std::f64::consts::PI;

/// A light that can be picked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSource {
    /// A row of [`Scene::lights`].
    Punctual(u32),
    /// The surroundings.
    Environment,
    /// The `prim_id` of a triangle that emits light.
    Triangle(u32),
}

/// All lights of a scene that are not black, each with the probability of picking it: its share of
/// their importance.
///
/// The importance of a light is the luminance of a white Lambert surface in the middle of the scene
/// that faces it. Triangles count as if they stood at the edge of the scene, turned at random;
/// so the probability by area is one number for each material. The table is made by one thread in
/// one order, and depends on nothing but the scene.
#[derive(Clone, Debug, Default)]
pub struct LightTable {
    /// The lights, in the order of the scene.
    pub lights: Vec<LightSource>,
    /// Picks of their numbers.
    pub alias: AliasTable,
    /// Probability by area of picking a place on a surface of each material: that of its triangle,
    /// divided by the triangle's area in the world.
    pub densities: Vec<f64>,
}

/// A row of [`LightTable::shares`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightShare {
    /// The light, or the first triangle of a material.
    pub light: LightSource,
    /// Number of lights that the row stands for.
    pub count: u64,
    /// Sum of their probabilities.
    pub share: f64,
}

impl LightTable {
    /// The table of a valid scene.
    pub fn of(scene: &Scene) -> LightTable {
        let middle = SceneMiddle::of(scene.bounds());
        let (mut lights, mut weights) = (Vec::new(), Vec::new());
        let mut add = |light: LightSource, weight: f64| {
            if weight > 0.0 && weight.is_finite() {
                lights.push(light);
                weights.push(weight);
            }
        };
        for lamp in 0..scene.lights.len() {
            let (lamps, source) = (&scene.lights, LightSource::Punctual(lamp as u32));
            let terms = lamps.attenuation.get(lamp).to_array().map(f64::from);
            let attenuation = middle.attenuation(lamps.center(lamp).as_dvec3(), terms);
            let color = lamps.color.get(lamp).max(Vec3::ZERO);
            add(source, luminance(color) / attenuation);
        }
        add(LightSource::Environment, emitters::surroundings(scene));
        let mut densities = emitters::emissions(scene);
        // L·A·cos / (π·d²), where cos is 1/2 on average, and 1/4 if one side is dark.
        let share = 0.25 / (PI * middle.reach * middle.reach);
        densities.iter_mut().for_each(|density| *density *= share);
        emitters::for_each_triangle(scene, &densities, |id, material, area| {
            let weight = densities[material as usize] * area;
            add(LightSource::Triangle(id), weight);
        });
        let sum: f64 = weights.iter().sum();
        let alias = AliasTable::of(&weights, sum);
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        densities.iter_mut().for_each(|density| *density *= scale);
        LightTable {
            lights,
            alias,
            densities,
        }
    }

    /// The lights with their shares of the importance, the largest first. Triangles of a material
    /// are one row.
    pub fn shares(&self, scene: &Scene) -> Vec<LightShare> {
        let mut rows: Vec<LightShare> = Vec::new();
        let mut of_material = HashMap::new();
        for (number, &light) in self.lights.iter().enumerate() {
            let row = match light {
                LightSource::Triangle(id) => {
                    let material = scene.prim_material(scene.resolve(id).prim);
                    *of_material.entry(material).or_insert(rows.len())
                }
                _ => rows.len(),
            };
            if row == rows.len() {
                let (count, share) = (0, 0.0);
                rows.push(LightShare {
                    light,
                    count,
                    share,
                });
            }
            rows[row].count += 1;
            rows[row].share += self.alias.pdf[number];
        }
        rows.sort_by(|a, b| b.share.total_cmp(&a.share));
        rows
    }
}
