//! Report of a render, as a table and as a JSON document.

use crate::cli::options::{Sequence, exposure_row};
use crate::cli::output::{
    self, CameraReport, MemoryStats, Output, OutputFile, PictureWindow, PrimitiveCounts,
    RenderSummary, TreeFigures, grouped, lines, mrays_per_s, origin_row, rays_by_kind,
    serialize_rates, serialize_rays, video_rows,
};
use phalanx::frame::{Engine, Settings, TreeStats};
use phalanx::isa;
use phalanx::jobs::ExposureSpec;
use phalanx::render::{RayCounts, RenderStats};
use phalanx::report::counted;
use phalanx::scene::{Scene, Transfer};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The document of `render --json`.
#[derive(Debug, Serialize)]
pub struct RenderDocument {
    scene: String,
    engine: &'static str,
    /// `None` for the scalar engine, which has none.
    kernel: Option<&'static str>,
    isa: &'static str,
    threads: usize,
    image: RenderImage,
    max_depth: u32,
    /// The camera, which a turntable starts with; `None` with key frames.
    pub camera: Option<CameraReport>,
    #[serde(flatten)]
    summary: RenderSummary,
    primitives: PrimitiveCounts,
    /// Origin of the scene's coordinates, in the file's; zero if they are the same.
    origin: [f64; 3],
    bvh: TreeFigures,
    seconds: RenderSeconds,
    #[serde(serialize_with = "serialize_rays")]
    rays: RayCounts,
    #[serde(serialize_with = "serialize_rates")]
    mrays_per_s: [(&'static str, f64); 5],
    /// `None` for the scalar engine.
    occupancy: Option<f64>,
    /// Backs of single-sided materials that rays have passed.
    unseen_backs: u64,
    memory: MemoryStats,
    /// `None` without `--checkpoint`.
    pub checkpoint: Option<KeptTiles>,
}

/// Finished tiles that remain after the picture is written. The same command, or one that changes
/// only the file format or the exposure, then traces nothing.
#[derive(Debug, Serialize)]
pub struct KeptTiles {
    /// The file, or the name that frames get their numbers in.
    pub path: String,
    pub bytes: u64,
}

impl KeptTiles {
    fn row(&self) -> (&'static str, String) {
        let KeptTiles { path, bytes } = self;
        let size = output::bytes(*bytes);
        let words = format!("{path}: {size} of tiles, to resume or rewrite the picture");
        ("kept", words)
    }
}

/// The picture and its path.
#[derive(Debug, Serialize)]
pub struct RenderImage {
    #[serde(flatten)]
    window: PictureWindow,
    /// The first and the last frame of a sequence.
    frames: Option<[u32; 2]>,
    /// The picture's file, or that of the first frame.
    path: String,
    /// The exposure in stops, if one was given or measured.
    exposure: Option<ExposureSpec>,
    /// The file of the last frame of several.
    #[serde(skip)]
    last: Option<PathBuf>,
    /// How several frames become a video.
    #[serde(skip)]
    video: Vec<(&'static str, String)>,
    /// True if a format for screens holds linear samples, which most programs show too dark.
    #[serde(skip)]
    linear: bool,
}

impl RenderImage {
    /// The picture of these settings in this file.
    pub fn new(
        settings: &Settings,
        output: &OutputFile,
        sequence: Option<&Sequence>,
        exposure: Option<ExposureSpec>,
    ) -> RenderImage {
        let (path, file) = (output.path.as_path(), &output.file);
        let frames = sequence.map(|s| [*s.frames.start(), *s.frames.end()]);
        let name = |end: usize| Some(sequence?.name(path, frames?[end]));
        let first = name(0).unwrap_or_else(|| path.to_path_buf());
        let window = settings.window();
        let size = (window.width, window.height);
        let is_linear = file.format.is_linear();
        let video = frames.map(|frames| video_rows(path, frames, size, is_linear));
        RenderImage {
            window: PictureWindow::of(settings),
            frames,
            video: video.unwrap_or_default(),
            last: name(1).filter(|last| *last != first),
            path: first.to_string_lossy().into_owned(),
            exposure,
            linear: !is_linear && file.exposure.encoding.transfer == Transfer::None,
        }
    }

    /// The files as the table names them.
    fn written(&self) -> String {
        let first = self.path.clone();
        match &self.last {
            None => first,
            Some(last) => format!("{first} to {}", last.display()),
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

impl RenderSeconds {
    fn total(self) -> f64 {
        self.load + self.build + self.render + self.write
    }
}

impl RenderDocument {
    /// A report of a render with its tree, its memory, and the seconds of each part.
    pub fn new(
        path: &Path,
        scene: &Scene,
        settings: &Settings,
        image: RenderImage,
        (tree, memory): (TreeStats, MemoryStats),
        stats: &RenderStats,
        seconds: RenderSeconds,
    ) -> RenderDocument {
        let simd = settings.engine == Engine::Simd;
        let rate = |(kind, rays)| (kind, mrays_per_s(rays, seconds.render));
        RenderDocument {
            scene: path.to_string_lossy().into_owned(),
            engine: if simd { "simd" } else { "scalar" },
            kernel: simd.then(|| settings.kernel.name()),
            isa: isa::compiled_level(),
            threads: settings.threads,
            image,
            max_depth: settings.max_depth,
            camera: None,
            summary: RenderSummary::of(settings),
            primitives: PrimitiveCounts::of(scene),
            origin: scene.origin,
            bvh: tree.into(),
            seconds,
            rays: stats.rays,
            mrays_per_s: rays_by_kind(&stats.rays).map(rate),
            occupancy: stats.occupancy(),
            unseen_backs: stats.unseen_backs,
            memory,
            checkpoint: None,
        }
    }

    /// A row on backs that were not shown, if there were any.
    fn backs_row(&self) -> Option<(&'static str, String)> {
        let backs = grouped(self.unseen_backs);
        let words = format!("{backs} hidden, of single-sided materials (see --two-sided)");
        (self.unseen_backs > 0).then_some(("backs", words))
    }

    /// The rows that follow that of the files.
    fn last_rows(&self) -> impl Iterator<Item = (&'static str, String)> {
        let checkpoint = self.checkpoint.as_ref().map(KeptTiles::row);
        checkpoint.into_iter().chain(self.image.video.clone())
    }

    fn ray_table(&self) -> String {
        let mut text = format!("{:<12} {:>18} {:>10}\n", "rays", "count", "Mrays/s");
        for ((kind, rays), (_, speed)) in rays_by_kind(&self.rays).iter().zip(self.mrays_per_s) {
            let rays = grouped(*rays);
            text.push_str(&format!("  {kind:<10} {rays:>18} {speed:>10.3}\n"));
        }
        text
    }
}

impl Output for RenderDocument {
    /// The scene, the speed, and the file: lines of 80 columns, if names are short.
    fn short(&self) -> String {
        let PictureWindow { width, height, .. } = self.image.window;
        let region = self.image.window.region_words();
        let samples = self.summary.samples_words();
        let linear = if self.image.linear { ", linear (see --transfer)" } else { "" };
        let (render, all) = (self.seconds.render, self.seconds.total());
        let rays = self.rays.total() as f64 / 1e6;
        let speed = mrays_per_s(self.rays.total(), render);
        let (threads, written) = (counted(self.threads, "thread"), self.image.written());
        let scene = format!("{}: {}", self.scene, self.primitives.words());
        let speed = format!(
            "{speed:.1} Mrays/s, {rays:.1} million rays in {render:.2} s of {all:.2} s, {threads}"
        );
        let written = format!("{written}: {width}x{height}{region}, {samples}{linear}");
        let mut rows = vec![("scene", scene), ("speed", speed), ("written", written)];
        let made_up = self.camera.as_ref().filter(|camera| camera.is_made_up);
        rows.extend(made_up.map(CameraReport::row));
        rows.extend(exposure_row(self.image.exposure));
        rows.extend(self.backs_row());
        rows.extend(self.last_rows());
        lines(&rows)
    }

    fn table(&self) -> String {
        let PictureWindow { width, height, .. } = self.image.window;
        let region = self.image.window.region_words();
        let settings = self.summary.words();
        let (engine, isa, threads) = (self.engine, self.isa, counted(self.threads, "thread"));
        let kernel = self.kernel.map_or(String::new(), |k| format!("/{k}"));
        let RenderSeconds {
            load,
            build,
            render,
            write,
        } = self.seconds;
        let scene = format!("{}, {width}x{height}{region}, {settings}", self.scene);
        let seconds =
            format!("load {load:.3}, build {build:.3}, render {render:.3}, write {write:.3}");
        let camera = self.camera.as_ref().map(CameraReport::row);
        let mut rows = vec![
            ("scene", scene),
            ("engine", format!("{engine}{kernel} on {isa}, {threads}")),
            ("primitives", self.primitives.words()),
            ("tree", self.bvh.words()),
            ("seconds", seconds),
        ];
        let places = origin_row(self.origin).into_iter().chain(camera);
        rows.splice(1..1, places);
        let share = |share: f64| format!("{:.1} % of packet lanes", 100.0 * share);
        let occupancy = self.occupancy.map(|lanes| ("occupancy", share(lanes)));
        let mut after: Vec<_> = occupancy.into_iter().chain(self.backs_row()).collect();
        after.extend(self.memory.rows());
        after.push(("written", self.image.written()));
        after.extend(exposure_row(self.image.exposure));
        after.extend(self.last_rows());
        format!("{}\n{}\n{}", lines(&rows), self.ray_table(), lines(&after))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx::image::ImageFormat;
    use phalanx::jobs::PictureSpec;

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
            unseen_backs: 0,
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
        let spec = PictureSpec::default().resolve(&scene);
        let output =
            OutputFile::for_picture("out.png".into(), ImageFormat::Png, &spec, scene.origin);
        let image = RenderImage::new(&settings, &output.unwrap(), None, None);
        let sizes = (stats, MemoryStats::of(&scene, &stats, 1 << 20, 0));
        let name = Path::new("a.test");
        RenderDocument::new(name, &scene, &settings, image, sizes, &work, seconds)
    }

    #[test]
    fn the_document_has_the_promised_keys() {
        let json = serde_json::to_value(report()).unwrap();
        assert_eq!(json["engine"], "simd");
        assert_eq!(json["isa"], isa::compiled_level());
        assert_eq!(json["threads"], 2);
        let image = serde_json::json!({"width": 640, "height": 480, "region": null, "frames": null, "path": "out.png", "exposure": null});
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
    fn linear_samples_are_told() {
        let mut report = report();
        assert!(
            report
                .short()
                .ends_with("1 sample per pixel, linear (see --transfer)\n")
        );
        report.image.linear = false;
        assert!(report.short().ends_with("1 sample per pixel\n"));
    }

    #[test]
    fn the_table_says_the_same() {
        let table = report().table();
        for part in [
            "scene        a.test, 640x480, 1 sample per pixel\n",
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
