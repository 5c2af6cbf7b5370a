//! `phalanx scenes`: the catalogue of standard scenes.

use crate::cli::output::{self, CliError, Output, aligned, grouped};
use clap::Args;
use phalanx::standard::{self, CATALOGUE, Family, Spec, StandardScene};
use serde::Serialize;

#[derive(Debug, Args)]
pub struct ScenesArgs {
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct ScenesDocument {
    scenes: Vec<SceneListing>,
}

/// A scene at its default size.
#[derive(Debug, Serialize)]
struct SceneListing {
    name: &'static str,
    family: &'static str,
    purpose: &'static str,
    default_size: u32,
    /// The smallest and the largest size.
    sizes: [u32; 2],
    size_means: &'static str,
    spheres: u64,
    cones: u64,
    polygons: u64,
    triangles: u64,
    lights: u64,
}

impl SceneListing {
    fn of(entry: &'static StandardScene) -> SceneListing {
        let counts = standard::counts(Spec::of(entry));
        SceneListing {
            name: entry.name,
            family: match entry.family {
                Family::Spd => "spd",
                Family::Modern => "modern",
            },
            purpose: entry.purpose,
            default_size: entry.default_size,
            sizes: [*entry.sizes.start(), *entry.sizes.end()],
            size_means: entry.size_means,
            spheres: counts.spheres,
            cones: counts.cones,
            polygons: counts.polygons,
            triangles: counts.triangles,
            lights: counts.lights,
        }
    }

    /// The cells of the table, except the purpose.
    fn cells(&self) -> Vec<String> {
        let number = |n: u64| match n {
            0 => "-".to_owned(),
            n => grouped(n),
        };
        let [least, most] = self.sizes.map(short);
        let mut cells = vec![self.name.to_owned(), short(self.default_size)];
        cells.push(format!("{least}..{most}"));
        let shapes = [self.spheres, self.cones, self.polygons, self.triangles];
        cells.extend(shapes.into_iter().chain([self.lights]).map(number));
        cells
    }
}

/// Headings of all columns but the last.
const HEADS: &str = "NAME SIZE SIZES SPHERES CONES POLYGONS TRIANGLES LIGHTS";

/// Lists the standard scenes.
pub fn run(args: &ScenesArgs) -> Result<(), CliError> {
    let scenes = CATALOGUE.iter().map(SceneListing::of).collect();
    output::print_output(&ScenesDocument { scenes }, args.json)
}

impl Output for ScenesDocument {
    /// The rows in aligned columns, with a heading before each family and a note on sizes at the
    /// end.
    fn table(&self) -> String {
        let mut rows = vec![HEADS.split(' ').map(str::to_owned).collect()];
        rows.extend(self.scenes.iter().map(SceneListing::cells));
        let lines = aligned(&rows, 1);
        let mut text = format!("{}  PURPOSE\n", lines[0]);
        let mut family = "";
        for (scene, line) in self.scenes.iter().zip(&lines[1..]) {
            if scene.family != family {
                family = scene.family;
                text.push_str(heading(family));
            }
            text.push_str(&format!("{line}  {}\n", scene.purpose));
        }
        text + "\nCounts are for the default size. Commands accept standard:NAME or standard:NAME:SIZE in place of a scene file.\n\
                SIZE is a whole number, optionally with k or M, as in standard:terrain:20M.\n"
    }
}

fn heading(family: &str) -> &'static str {
    match family {
        "spd" => "\nHaines' Standard Procedural Databases; SIZE is their own size factor\n",
        _ => "\nModern triangle scenes; SIZE is the approximate number of triangles\n",
    }
}

/// 1000000 as 1M, 4000 as 4k, if no digit is lost.
fn short(size: u32) -> String {
    match size {
        0 => "0".to_owned(),
        n if n % 1_000_000 == 0 => format!("{}M", n / 1_000_000),
        n if n % 1_000 == 0 => format!("{}k", n / 1_000),
        n => n.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_shortened_without_loss() {
        for (size, text) in [
            (7, "7"),
            (4_000, "4k"),
            (1_500_000, "1500k"),
            (20_000_000, "20M"),
            (4_001, "4001"),
        ] {
            assert_eq!(short(size), text);
        }
    }

    #[test]
    fn columns_are_aligned() {
        let row = |name, triangles| SceneListing {
            name,
            triangles,
            ..SceneListing::of(&CATALOGUE[0])
        };
        let scenes = vec![row("a", 1), row("a-longer-name", 123_456_789)];
        let text = ScenesDocument { scenes }.table();
        let ends: Vec<_> = text
            .lines()
            .filter_map(|line| line.find(CATALOGUE[0].purpose).or(line.find("PURPOSE")))
            .collect();
        assert_eq!(ends.len(), 3);
        assert!(ends.iter().all(|end| *end == ends[0]), "{text}");
    }
}
