//! Report of a render, as a table and as a JSON document.

use crate::cli::output::{
    MemoryStats, PerRayKind, PrimitiveCounts, RenderSummary, SCHEMA_VERSION, TreeFigures, grouped,
    lines, origin_row,
};
use phalanx::frame::{Engine, Settings, TreeStats};
use phalanx::isa;
use phalanx::render::RenderStats;
use phalanx::scene::Scene;
use serde::Serialize;
use std::ops::RangeInclusive;
use std::path::Path;

/// The document of `render --json`.
#[derive(Debug, Serialize)]
pub struct RenderDocument {
    schema_version: u32,
    scene: String,
    engine: &'static str,
    /// `None` for the scalar engine, which has none.
    kernel: Option<&'static str>,
    isa: &'static str,
    threads: usize,
    image: RenderImage,
    max_depth: u32,
    #[serde(flatten)]
    summary: RenderSummary,
    primitives: PrimitiveCounts,
    /// Origin of the scene's coordinates, in the file's; zero if they are the same.
    origin: [f64; 3],
    bvh: TreeFigures,
    seconds: RenderSeconds,
    rays: PerRayKind<u64>,
    mrays_per_s: PerRayKind<f64>,
    /// `None` for the scalar engine.
    occupancy: Option<f64>,
    memory: MemoryStats,
}

/// The picture and its path.
#[derive(Debug, Serialize)]
pub struct RenderImage {
    width: u32,
    height: u32,
    /// Position of a region: column and row of its upper left pixel, and the size of the whole
    /// picture.
    region: Option<[u32; 4]>,
    /// The first and the last frame of a sequence.
    frames: Option<[u32; 2]>,
    path: String,
}

impl RenderImage {
    /// The picture of these settings at this path.
    pub fn new(
        settings: &Settings,
        path: &Path,
        frames: Option<RangeInclusive<u32>>,
    ) -> RenderImage {
        RenderImage {
            width: settings.window().width,
            height: settings.window().height,
            region: settings
                .region
                .map(|r| [r.x, r.y, settings.width, settings.height]),
            frames: frames.map(|frames| [*frames.start(), *frames.end()]),
            path: path.to_string_lossy().into_owned(),
        }
    }
}

#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct RenderSeconds {
    pub load: f64,
    pub build: f64,
    pub render: f64,
    /// Seconds of writing beyond rendering, which continues while finished parts are written.
    pub write: f64,
}

impl RenderDocument {
    /// A report of the settings; the figures come with [`RenderDocument::with_tree`] and
    /// [`RenderDocument::with_work`].
    pub fn new(
        path: &Path,
        scene: &Scene,
        settings: &Settings,
        image: RenderImage,
    ) -> RenderDocument {
        let simd = settings.engine == Engine::Simd;
        RenderDocument {
            schema_version: SCHEMA_VERSION,
            scene: path.to_string_lossy().into_owned(),
            engine: if simd { "simd" } else { "scalar" },
            kernel: simd.then(|| settings.kernel.name()),
            isa: isa::compiled_level(),
            threads: settings.threads,
            image,
            max_depth: settings.max_depth,
            summary: RenderSummary::of(settings),
            primitives: PrimitiveCounts::of(scene),
            origin: scene.origin,
            bvh: TreeFigures::default(),
            seconds: RenderSeconds::default(),
            rays: PerRayKind::default(),
            mrays_per_s: PerRayKind::default(),
            occupancy: None,
            memory: MemoryStats::default(),
        }
    }

    /// Adds the tree's figures.
    pub fn with_tree(self, stats: TreeStats) -> RenderDocument {
        RenderDocument {
            bvh: stats.into(),
            ..self
        }
    }

    /// Adds the memory figures.
    pub fn with_memory(self, memory: MemoryStats) -> RenderDocument {
        RenderDocument { memory, ..self }
    }

    /// Adds the render's figures, and the seconds of each part.
    pub fn with_work(self, stats: &RenderStats, seconds: RenderSeconds) -> RenderDocument {
        let rays = PerRayKind::of(&stats.rays);
        RenderDocument {
            seconds,
            rays,
            mrays_per_s: rays.mrays_per_s(seconds.render),
            occupancy: stats.occupancy(),
            ..self
        }
    }

    /// The report for people.
    pub fn table(&self) -> String {
        let RenderDocument {
            image,
            seconds,
            bvh,
            ..
        } = self;
        let kernel = self.kernel.map_or(String::new(), |k| format!("/{k}"));
        let plural = if self.threads == 1 { "" } else { "s" };
        let asked = self.summary.words();
        let region = image.region.map_or(String::new(), |[x, y, width, height]| {
            format!(" from ({x}, {y}) of {width}x{height}")
        });
        let mut rows = vec![
            (
                "scene",
                format!(
                    "{}, {}x{}{region}, {asked}",
                    self.scene, image.width, image.height
                ),
            ),
            (
                "engine",
                format!(
                    "{}{kernel} on {}, {} thread{plural}",
                    self.engine, self.isa, self.threads
                ),
            ),
            ("primitives", self.primitives.words()),
            (
                "tree",
                format!("{} nodes, depth {}", grouped(bvh.nodes as u64), bvh.depth),
            ),
            (
                "seconds",
                format!(
                    "load {:.3}, build {:.3}, render {:.3}, write {:.3}",
                    seconds.load, seconds.build, seconds.render, seconds.write
                ),
            ),
        ];
        if let Some(row) = origin_row(self.origin) {
            rows.insert(1, row);
        }
        let mut after = Vec::new();
        if let Some(share) = self.occupancy {
            after.push((
                "occupancy",
                format!("{:.1} % of packet lanes", 100.0 * share),
            ));
        }
        after.extend(self.memory.rows());
        after.push(("written", image.path.clone()));
        format!("{}\n{}\n{}", lines(&rows), self.ray_table(), lines(&after))
    }

    fn ray_table(&self) -> String {
        let (n, s) = (&self.rays, &self.mrays_per_s);
        let kinds = [
            ("primary", n.primary, s.primary),
            ("shadow", n.shadow, s.shadow),
            ("reflection", n.reflection, s.reflection),
            ("refraction", n.refraction, s.refraction),
            ("total", n.total, s.total),
        ];
        let mut text = format!("{:<12} {:>18} {:>10}\n", "rays", "count", "Mrays/s");
        for (kind, rays, speed) in kinds {
            text.push_str(&format!(
                "  {kind:<10} {:>18} {speed:>10.3}\n",
                grouped(rays)
            ));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx::render::RayCounts;

    fn report() -> RenderDocument {
        let scene = Scene::default();
        let settings = Settings {
            threads: 2,
            ..Settings::of(&scene)
        };
        let rays = RayCounts {
            primary: 1_500_000,
            shadow: 300_000,
            reflection: 0,
            refraction: 200_000,
        };
        let work = RenderStats {
            rays,
            packets: 500_000,
        };
        let seconds = RenderSeconds {
            load: 0.25,
            build: 0.125,
            render: 0.5,
            write: 0.0625,
        };
        let stats = TreeStats {
            nodes: 4711,
            depth: 17,
            sah: 33.5,
            node_bytes: 1,
            prim_bytes: 2,
            wide_bytes: 3,
        };
        let image = RenderImage::new(&settings, Path::new("out.png"), None);
        let report = RenderDocument::new(Path::new("a.test"), &scene, &settings, image);
        let memory = MemoryStats::of(&scene, &stats, 1 << 20, 0);
        let report = report.with_tree(stats).with_memory(memory);
        report.with_work(&work, seconds)
    }

    #[test]
    fn the_document_has_the_promised_keys() {
        let json = serde_json::to_value(report()).unwrap();
        assert_eq!(json["schema_version"], 1);
        assert_eq!(json["engine"], "simd");
        assert_eq!(json["isa"], isa::compiled_level());
        assert_eq!(json["threads"], 2);
        let image = serde_json::json!({"width": 640, "height": 480, "region": null, "frames": null, "path": "out.png"});
        assert_eq!(json["image"], image);
        let seconds =
            serde_json::json!({"load": 0.25, "build": 0.125, "render": 0.5, "write": 0.0625});
        assert_eq!(json["seconds"], seconds);
        let rays = serde_json::json!({
            "primary": 1_500_000, "shadow": 300_000, "reflection": 0, "refraction": 200_000, "total": 2_000_000
        });
        assert_eq!(json["rays"], rays);
        let speeds = serde_json::json!({
            "primary": 3.0, "shadow": 0.6, "reflection": 0.0, "refraction": 0.4, "total": 4.0
        });
        assert_eq!(json["mrays_per_s"], speeds);
        assert_eq!(json["occupancy"], 0.5);
        assert_eq!(json["bvh"]["nodes"], 4711);
        assert_eq!(json["scene"], "a.test");
        if cfg!(target_os = "linux") {
            assert!(json["memory"]["peak_rss_bytes"].as_u64().unwrap() > 100_000);
        }
    }

    #[test]
    fn the_table_says_the_same() {
        let table = report().table();
        for part in [
            "scene        a.test, 640x480, one sample a pixel\n",
            "simd/auto on ",
            ", 2 threads\n",
            "4,711 nodes, depth 17",
            "load 0.250, build 0.125, render 0.500, write 0.062",
            "  primary             1,500,000      3.000\n",
            "  total               2,000,000      4.000\n",
            "50.0 % of packet lanes",
            "film 1.0 MiB",
            "written      out.png\n",
        ] {
            assert!(table.contains(part), "{part:?} in\n{table}");
        }
    }
}
