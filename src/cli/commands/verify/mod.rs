//! `phalanx verify`: compares every picture with the scalar engine's, bit by bit.

#[cfg(test)]
mod fixture;
mod pixel_diff;
mod pixel_hashes;

use crate::cli::options::{
    FrameArgs, KernelSet, MACHINE, OUTPUT, SceneArgs, SceneInput, TileArgs, TreeArgs,
    kernels_parser, parse_thread_count,
};
use crate::cli::output::{
    self, CliError, PictureWindow, ProgressMode, RenderSummary, interrupt, progress, rays_by_kind,
    serialize_rays,
};
use clap::Args;
use phalanx::files::shown_path;
use phalanx::formats::DefaultLights;
use phalanx::frame::{Accel, Aov, Engine, Frame, Settings};
use phalanx::isa;
use phalanx::jobs::{PixelSpec, ToneSpec};
use phalanx::render::RayCounts;
use phalanx::report::counted;
use phalanx::scene::Scene;
use pixel_diff::{FilmDifference, first_difference};
use pixel_hashes::{PixelHashFile, PixelHashes};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct VerifyArgs {
    #[arg(
        required = true,
        value_name = "SCENE",
        help = "Scene files, caches (.phx), standard:NAME[:SIZE], or -",
        long_help = "Scene files, scene caches (.phx), standard scenes (standard:NAME[:SIZE]), or - for stdin (see --format)"
    )]
    pub scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub pixels: PixelSpec,
    #[command(flatten)]
    pub tone: ToneSpec,
    #[command(flatten)]
    pub tiles: TileArgs,
    #[command(flatten)]
    pub scene_args: SceneArgs,
    #[command(flatten)]
    pub tree: TreeArgs,
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Thread counts to render with
    ///
    /// One render per count, separated by commas.
    #[arg(long, value_name = "N,…", help_heading = MACHINE, value_delimiter = ',', default_value = "1,2,3", value_parser = parse_thread_count)]
    pub threads: Vec<usize>,
    /// Traversal kernel, or all of them
    ///
    /// Traversal kernel of the simd engine: auto, packet8, packet16, beam8, beam16, single, or all
    /// of them in turn. [default: auto]
    #[arg(long, value_name = "NAME", help_heading = MACHINE, hide_possible_values = true, hide_default_value = true, default_value = "auto", value_parser = kernels_parser())]
    pub kernel: KernelSet,
    /// Write hashes of hits and radiance to this file
    ///
    /// One hash each per pixel, for --against.
    #[arg(long, value_name = "FILE", help_heading = OUTPUT, conflicts_with = "path")]
    pub record: Option<PathBuf>,
    /// Compare with the hashes in this file
    #[arg(long, value_name = "FILE", help_heading = OUTPUT, conflicts_with = "path")]
    pub against: Option<PathBuf>,
    /// Type of progress display
    #[arg(long, value_enum, value_name = "MODE", help_heading = OUTPUT, hide_short_help = true, default_value_t = ProgressMode::Auto)]
    pub progress: ProgressMode,
    /// Print the report as JSON
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// Maximum number of pixels of a verified picture: 7 GiB per film with hits.
const FILM_PIXELS: u64 = 1 << 28;

#[derive(Debug, Serialize)]
struct VerifyDocument {
    isa: &'static str,
    identical: bool,
    scenes: Vec<SceneOutcome>,
}

#[derive(Debug, Serialize)]
struct SceneOutcome {
    scene: String,
    #[serde(flatten)]
    window: PictureWindow,
    max_depth: u32,
    #[serde(flatten)]
    summary: RenderSummary,
    /// Rays of the scalar engine.
    #[serde(serialize_with = "serialize_rays")]
    rays: RayCounts,
    runs: Vec<KernelRun>,
    /// The comparison with `--against`, if it was requested.
    against: Option<Against>,
}

/// One render of the packet engine, compared with the scalar one.
#[derive(Debug, Serialize)]
struct KernelRun {
    kernel: &'static str,
    threads: usize,
    identical: bool,
    #[serde(serialize_with = "serialize_rays")]
    rays: RayCounts,
    first_difference: Option<FilmDifference>,
}

#[derive(Debug, Serialize)]
struct Against {
    file: String,
    identical: bool,
    /// Column and row of the first pixel whose hashes differ.
    first_pixel: Option<[u32; 2]>,
}

/// Verifies every scene; exit code 4 if any picture differs.
pub fn run(args: &VerifyArgs) -> Result<(), CliError> {
    args.pixels.check_use().map_err(CliError::Usage)?;
    args.scene_args.no_picture()?;
    let record = args.against.as_deref().map(PixelHashFile::load);
    let record = record.transpose()?;
    if let Some(path) = &args.record {
        output::check_report_place(path, "--record")?;
        PixelHashFile::check_names(&args.scenes)?;
    }
    SceneInput::note_all(&args.scenes)?;
    interrupt::listen()?;
    output::advise();
    let picture = args.frames.wanted(&args.pixels);
    let mut hashes = Vec::new();
    let mut scenes = Vec::new();
    for path in &args.scenes {
        let mut scene_input = SceneInput::load(path, &args.scene_args, picture, 0)?;
        let start = scene_input.scene.view;
        let lights = DefaultLights::of(&scene_input.scene, 0);
        let sequence = args.frames.sequence(&scene_input.scene)?;
        let frames = sequence.as_ref().map(|sequence| sequence.frames.clone());
        for frame in frames.unwrap_or(0..=0) {
            if let Some(sequence) = &sequence {
                let view = sequence.view(frame, &start)?;
                lights.move_camera(&mut scene_input.scene, view);
            }
            let (outcome, reference) = verify(args, path, &mut scene_input, record.as_ref())?;
            scenes.push(outcome);
            hashes.extend(reference);
        }
    }
    if let Some(path) = &args.record {
        PixelHashFile::new(hashes).save(path)?;
    }
    let identical = scenes.iter().all(SceneOutcome::identical);
    if args.json {
        output::print_json(&VerifyDocument {
            isa: isa::compiled_level(),
            identical,
            scenes,
        })?;
    }
    if identical { Ok(()) } else { Err(CliError::Mismatch) }
}

impl SceneOutcome {
    fn identical(&self) -> bool {
        let against = self.against.as_ref();
        self.runs.iter().all(|run| run.identical) && against.is_none_or(|a| a.identical)
    }
}

/// Verifies one scene, and returns its hashes if they are recorded or compared.
fn verify(
    args: &VerifyArgs,
    path: &Path,
    scene_input: &mut SceneInput,
    record: Option<&PixelHashFile>,
) -> Result<(SceneOutcome, Option<PixelHashes>), CliError> {
    let scene = &scene_input.scene;
    let settings = args.tiles.apply(args.pixels.settings(scene));
    let settings = Settings {
        threads: 1,
        engine: Engine::Scalar,
        record_hits: true,
        // The cost of a ray depends on the engine, so it is not compared.
        aovs: settings.aovs.without(Aov::Cost),
        ..settings
    };
    let region = args.pixels.check_region(&settings);
    region.map_err(CliError::Usage)?;
    if settings.pixels() > FILM_PIXELS {
        return Err(CliError::Usage(format!(
            "verify keeps two whole pictures in memory, at most {FILM_PIXELS} pixels, not {}: choose a part with --region",
            settings.pixels()
        )));
    }
    let encoding = args.tone.encoding(scene.encoding);
    // A record of other settings is refused before anything is rendered.
    let expected = record.map(|record| record.find(path, &settings, encoding));
    let expected = expected.transpose()?;
    let prepared = scene_input.prepare(Engine::Scalar, &args.tree, 0)?;
    let reference = render(args, scene_input, &prepared, &settings)?;
    drop(prepared);
    let is_hashed = args.record.is_some() || args.against.is_some();
    let hashes = is_hashed.then(|| PixelHashes::of(path, &settings, encoding, &reference.film));
    let against = match (&args.against, expected, &hashes) {
        (Some(file), Some(expected), Some(hashes)) => {
            Some(compare_with(args, path, file, expected, hashes)?)
        }
        _ => None,
    };
    let outcome = SceneOutcome {
        scene: path.to_string_lossy().into_owned(),
        window: PictureWindow::of(&settings),
        max_depth: settings.max_depth,
        summary: RenderSummary::of(&settings),
        rays: reference.stats.rays,
        runs: runs(args, path, scene_input, &settings, &reference)?,
        against,
    };
    Ok((outcome, hashes))
}

fn compare_with(
    args: &VerifyArgs,
    path: &Path,
    file: &Path,
    expected: &PixelHashes,
    hashes: &PixelHashes,
) -> Result<Against, CliError> {
    let first_pixel = hashes.first_difference(expected);
    if !args.json {
        let verdict = match first_pixel {
            None => "identical".to_owned(),
            Some([x, y]) => format!("DIFFERENT, first at pixel ({x}, {y})"),
        };
        let [path, file] = [path, file].map(shown_path);
        output::print(&format!("{path}: against {file}: {verdict}\n"))?;
    }
    Ok(Against {
        file: file.to_string_lossy().into_owned(),
        identical: first_pixel.is_none(),
        first_pixel,
    })
}

/// Runs the packet engine with each kernel and thread count.
fn runs(
    args: &VerifyArgs,
    path: &Path,
    scene_input: &mut SceneInput,
    settings: &Settings,
    reference: &Frame,
) -> Result<Vec<KernelRun>, CliError> {
    let prepared = scene_input.prepare(Engine::Simd, &args.tree, 0)?;
    let mut runs = Vec::new();
    for &kernel in &args.kernel.0 {
        for &threads in &args.threads {
            let settings = Settings {
                threads,
                kernel,
                engine: Engine::Simd,
                ..settings.clone()
            };
            let frame = render(args, scene_input, &prepared, &settings)?;
            let run = KernelRun::of(&scene_input.scene, &settings, reference, &frame);
            if !args.json {
                output::print(&run.line(path, reference))?;
            }
            runs.push(run);
        }
    }
    Ok(runs)
}

fn render(
    args: &VerifyArgs,
    scene_input: &SceneInput,
    prepared: &Accel,
    settings: &Settings,
) -> Result<Frame, CliError> {
    let scene = &scene_input.scene;
    // Two films: one is the scalar engine's.
    (scene_input.budget).for_render(scene, prepared, settings, 2)?;
    let frame = progress::render(scene, prepared, settings, args.progress)?;
    if frame.film.hits.is_none() {
        // Without hits, half of the comparison would be skipped silently.
        let message = "the engine recorded no hits to compare";
        return Err(CliError::Runtime(message.to_owned()));
    }
    Ok(frame)
}

impl KernelRun {
    fn of(scene: &Scene, settings: &Settings, reference: &Frame, frame: &Frame) -> KernelRun {
        let first_difference = first_difference(scene, settings, &reference.film, &frame.film);
        KernelRun {
            kernel: settings.kernel.name(),
            threads: settings.threads,
            identical: first_difference.is_none() && reference.stats.rays == frame.stats.rays,
            rays: frame.stats.rays,
            first_difference,
        }
    }

    fn line(&self, path: &Path, reference: &Frame) -> String {
        let threads = counted(self.threads, "thread");
        let verdict = match &self.first_difference {
            _ if self.identical => "identical".to_owned(),
            Some(difference) => format!("DIFFERENT, {difference}"),
            None => format!(
                "DIFFERENT, in rays traced: {}",
                differing_counts(&reference.stats.rays, &self.rays)
            ),
        };
        let (path, kernel) = (shown_path(path), self.kernel);
        format!("{path}: {threads}, kernel {kernel}: {verdict}\n")
    }
}

/// Kinds of rays whose counts differ between the engines.
fn differing_counts(scalar: &RayCounts, simd: &RayCounts) -> String {
    let pairs = rays_by_kind(scalar).into_iter().zip(rays_by_kind(simd));
    let different = pairs.filter(|((_, scalar), (_, simd))| scalar != simd);
    let words = different
        .map(|((kind, scalar), (_, simd))| format!("{kind} {scalar} by scalar and {simd} by simd"));
    Vec::from_iter(words).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx::frame::Kernel;
    use phalanx::render::RenderStats;

    fn frame() -> Frame {
        Frame {
            film: fixture::film(),
            stats: RenderStats::default(),
            tracing: std::time::Duration::ZERO,
            seconds: 1.0,
            tile_seconds: Vec::new(),
            threads: 1,
        }
    }

    fn settings(kernel: Kernel, threads: usize) -> Settings {
        Settings {
            kernel,
            threads,
            ..Settings::of(&Scene::default())
        }
    }

    #[test]
    fn ray_counts_must_agree_even_where_the_pictures_do() {
        let (scene, reference) = (Scene::default(), frame());
        let mut other = frame();
        let path = Path::new("a.test");
        let same = KernelRun::of(&scene, &settings(Kernel::Auto, 1), &reference, &other);
        assert!(same.identical);
        assert_eq!(
            same.line(path, &reference),
            "a.test: 1 thread, kernel auto: identical\n"
        );
        other.stats.rays.shadow = 7;
        let more = KernelRun::of(&scene, &settings(Kernel::Packet8, 2), &reference, &other);
        assert!(!more.identical);
        let line = more.line(path, &reference);
        assert!(
            line.starts_with("a.test: 2 threads, kernel packet8: DIFFERENT, in rays traced"),
            "{line}"
        );
    }

    #[test]
    fn a_difference_in_the_films_is_one_even_where_the_counts_agree() {
        let (scene, reference) = (Scene::default(), frame());
        let mut other = frame();
        other.film.planes[1][0] = 0.25;
        let run = KernelRun::of(&scene, &settings(Kernel::Auto, 3), &reference, &other);
        assert!(!run.identical);
        let line = run.line(Path::new("a.test"), &reference);
        assert!(
            line.contains("DIFFERENT, 1 pixel, first at (0, 0)\n"),
            "{line}"
        );
    }
}
