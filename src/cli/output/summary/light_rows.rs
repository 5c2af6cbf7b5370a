//! The lights of a scene by their share of the light in its middle.

use super::table::{aligned, grouped};
use phalanx::files::shown_text;
use phalanx::report::plural;
use phalanx::scene::lighting::{LightShare, LightSource, LightTable};
use phalanx::scene::{LightShape, Scene};
use serde::Serialize;

/// A light, or all triangles of a material that emits light.
#[derive(Debug, Default, Serialize)]
pub struct LightRow {
    kind: &'static str,
    /// Name of the material.
    name: Option<String>,
    /// Position, or the centre of an area light, in the file's coordinates.
    position: Option<[f64; 3]>,
    /// Unit vector toward a directional light.
    toward: Option<[f32; 3]>,
    triangles: Option<u64>,
    /// Share of the light in the middle of the scene, 0 to 1.
    share: f64,
}

/// Most rows of the table for people.
const MAX_ROWS: usize = 12;

impl LightRow {
    /// All lights of a scene, the strongest first.
    pub fn all(scene: &Scene) -> Vec<LightRow> {
        let shares = LightTable::of(scene).shares(scene);
        (shares.iter().map(|row| LightRow::of(scene, row))).collect()
    }

    fn of(scene: &Scene, row: &LightShare) -> LightRow {
        let (lights, mut named) = (&scene.lights, LightRow::default());
        named.share = row.share;
        match row.light {
            LightSource::Environment => named.kind = "environment",
            LightSource::Punctual(light) => {
                let light = light as usize;
                let center = lights.center(light);
                if lights.directional[light] {
                    named.toward = Some(center.to_array());
                } else {
                    named.position = Some(scene.short_position(center).to_array());
                }
                named.kind = match lights.shape(light) {
                    _ if !lights.casts_shadows(light) => "fill",
                    LightShape::Point if lights.is_spot(light) => "spot",
                    LightShape::Point => "point",
                    LightShape::Directional => "directional",
                    LightShape::Sphere(_) => "sphere",
                    LightShape::Rectangle(_) => "rectangle",
                };
            }
            LightSource::Triangle(first) => {
                let [_, name] = scene.names.of_prim(scene.resolve(first).prim);
                named.kind = "emission";
                named.name = scene.names.get(name).map(str::to_owned);
                named.triangles = Some(row.count);
            }
        }
        named
    }

    fn words(&self) -> Vec<String> {
        let what = if let Some([x, y, z]) = self.position {
            format!("at ({x}, {y}, {z})")
        } else if let Some(toward) = self.toward {
            // Hides rounding errors and the signs of zeros.
            let [x, y, z] = toward.map(|c| (f64::from(c) * 1000.0).round() / 1000.0 + 0.0);
            format!("from ({x}, {y}, {z})")
        } else if let Some(count) = self.triangles {
            let name = self
                .name
                .as_deref()
                .map(|name| format!("`{}`, ", shown_text(name)));
            let (name, triangles) = (name.unwrap_or_default(), plural(count as usize, "triangle"));
            format!("{name}{} {triangles}", grouped(count))
        } else {
            String::new()
        };
        vec![self.kind.to_owned(), what, percent(self.share)]
    }

    /// The strongest lights in words, and the sum of the others; empty without any.
    pub fn table(all: &[LightRow]) -> String {
        if all.is_empty() {
            return String::new();
        }
        let (shown, others) = all.split_at(all.len().min(MAX_ROWS));
        let mut rows = Vec::from_iter(shown.iter().map(LightRow::words));
        if !others.is_empty() {
            let more = format!("and {} more", grouped(others.len() as u64));
            let share = percent(others.iter().map(|row| row.share).sum());
            rows.push(vec![more, String::new(), share]);
        }
        let lines = aligned(&rows, 2).into_iter();
        let lines = lines.map(|line| format!("  {line}\n")).collect::<String>();
        format!("lights by power\n{lines}")
    }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}
