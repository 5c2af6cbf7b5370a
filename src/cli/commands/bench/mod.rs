//! `phalanx bench`: measures our kernels, the oracle and other tracers on the same rays.

mod args;
mod bar;
mod baseline;
mod measure;
mod pictures;
mod program;
mod saved;
mod table;

pub use args::BenchArgs;

use crate::cli::options::{SceneInput, ending_of};
use crate::cli::output::{self, CliError, interrupt};
use args::{BenchCommand, PeerArg, RunArgs};
use bar::BenchProgressBar;
use baseline::Baseline;
use measure::{BenchScene, measure_scene, record};
use phalanx::bench::{
    BenchError, BenchPlan, DumpError, Measured, SceneInfo, Suite, SuiteScene, dump,
};
use phalanx::files::shown_path;
use phalanx::frame::Control;
use phalanx::jobs::SceneOverrides;
use phalanx::open::{is_cache, standard_name};
use phalanx::peers::Peer;
use phalanx::peers::embree::EmbreeLibrary;
use phalanx::report::html::{ScenePictures, page_against};
use phalanx::report::{BenchRecord, to_csv, to_json};
use phalanx::trace::Kernel;
use saved::save;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant, SystemTime};

/// The standard suite, from the repository.
const SUITE: &str = include_str!("../../../../perf/suite.toml");

/// Measures, or compares records.
pub fn run(args: &BenchArgs) -> Result<(), CliError> {
    match &args.command {
        Some(BenchCommand::Compare(args)) => saved::compare(args),
        Some(BenchCommand::Page(args)) => saved::report(args),
        None => measure_all(&args.run),
    }
}

fn measure_all(args: &RunArgs) -> Result<(), CliError> {
    interrupt::listen()?;
    output::advise();
    let suite =
        Suite::parse(SUITE).map_err(|e| CliError::Runtime(format!("perf/suite.toml: {e}")))?;
    check_places(args)?;
    let baseline = args.baseline.as_deref().map(Baseline::load).transpose()?;
    let peers = peers(args)?;
    let plan = plan(args, &suite, &peers);
    let scenes = bench_scenes(args, &suite, &plan)?;
    if let Some(baseline) = &baseline {
        baseline.check(args, &plan, &scenes)?;
    }
    if let Some(path) = &args.dump_rays {
        return dump_rays(path, &plan, &scenes);
    }
    if args.quick && plan.timed {
        output::print(&format!(
            "quick: {} of the suite's {} scenes, {} samples per rate (full suite: {})\n\n",
            scenes.len(),
            suite.scene.len(),
            plan.repeat,
            suite.repeat
        ))?;
    }
    let start = Instant::now();
    // A clock before 1970 has no such text.
    let now = SystemTime::now().max(SystemTime::UNIX_EPOCH);
    let started = humantime::format_rfc3339(now).to_string();
    let (measured, stopped) = interrupt::interruptible(|control| {
        let measured = measure_each(args, &plan, &scenes, control);
        (measured, control.stop.load(Relaxed))
    });
    let (all, shown) = measured?;
    let mut rows = all.iter().flat_map(|scene| &scene.rows);
    let partial = all.len() < scenes.len() || rows.any(|row| row.samples.len() < plan.repeat);
    let done = format!("{} of {} scenes were measured", all.len(), scenes.len());
    if all.is_empty() {
        return Err(if stopped {
            CliError::Interrupted
        } else {
            CliError::Usage(format!("--time-limit: {done}"))
        });
    }
    if let Some(path) = &args.update_suite {
        return update_suite(path, suite, &all);
    }
    let mut record = record(&plan, all, started, start.elapsed().as_secs_f64());
    record.run.partial = partial;
    output::print(&table::summary(&record, output::stdout_columns()))?;
    write_files(args, &record, &shown, baseline.as_ref())?;
    match &baseline {
        _ if stopped => Err(CliError::Resumable(done)),
        Some(baseline) => baseline.judge(args, &plan, &scenes, &record),
        None => Ok(()),
    }
}

/// Measures the scenes one after another, until the end, a signal or the time limit, and draws them
/// for a page.
fn measure_each(
    args: &RunArgs,
    plan: &BenchPlan,
    scenes: &[BenchScene],
    control: &Control,
) -> Result<(Vec<Measured>, Vec<ScenePictures>), CliError> {
    let (mut all, mut shown) = (Vec::new(), Vec::new());
    let limit = args.time_limit.map(Duration::from_secs_f64);
    let end = limit.map(|limit| Instant::now() + limit);
    let mut bar = BenchProgressBar::new(scenes.len(), control, end);
    for scene in scenes {
        let (measured, scene_input) = match measure_scene(plan, scene, &mut bar) {
            Err(CliError::Bench(BenchError::Stopped)) => break,
            done => done?,
        };
        if args.html.is_some() {
            shown.push(pictures::draw(&scene.info.name, &scene_input.scene)?);
        }
        all.push(measured);
    }
    bar.finish();
    Ok((all, shown))
}

/// Refuses files that cannot be written, and scenes that cannot be read again if necessary.
fn check_places(args: &RunArgs) -> Result<(), CliError> {
    let places = [
        ("--json", &args.json),
        ("--csv", &args.csv),
        ("--html", &args.html),
        ("--dump-rays", &args.dump_rays),
        ("--update-suite", &args.update_suite),
    ];
    for (origin, place) in places {
        (place.iter()).try_for_each(|place| output::check_report_place(place, origin))?;
    }
    let is_scene = |path: &&Path| standard_name(path).is_some() || ending_of(path).is_some();
    if let Some(scene) = args.json.as_deref().filter(is_scene) {
        let message = format!("--json {0}: give {0} before --json", shown_path(scene));
        return Err(CliError::Usage(message));
    }
    SceneInput::note_all(&args.scenes)?;
    args.scene_args.no_picture()?;
    let stdin = args.scenes.iter().any(|scene| output::is_dash(scene));
    if stdin && args.fail_above.is_some() {
        Err(CliError::Usage(
            "--fail-above may measure a scene again, but stdin can be read only once: give a file name"
                .to_owned(),
        ))
    } else {
        Ok(())
    }
}

/// Writes the requested files.
fn write_files(
    args: &RunArgs,
    record: &BenchRecord,
    pictures: &[ScenePictures],
    baseline: Option<&Baseline>,
) -> Result<(), CliError> {
    if let Some(path) = &args.json {
        save(path, &to_json(record))?;
    }
    if let Some(path) = &args.csv {
        save(path, &to_csv(record))?;
    }
    if let Some(path) = &args.html {
        // Incompatible records are reported when the run is judged.
        let comparison = baseline.and_then(|baseline| baseline.compare(args, record).ok());
        let earlier = baseline.map(|baseline| &baseline.record);
        let baseline = earlier.zip(comparison.as_ref());
        save(path, &page_against(record, pictures, baseline))?;
    }
    Ok(())
}

/// Writes the rays of one scene, whole or not at all.
fn dump_rays(path: &Path, plan: &BenchPlan, scenes: &[BenchScene]) -> Result<(), CliError> {
    let [scene] = scenes else {
        return Err(CliError::Usage(
            "--dump-rays takes one scene, as in: phalanx bench standard:terrain --dump-rays terrain.rays".to_owned(),
        ));
    };
    let scene_input = SceneInput::load(&scene.path, &scene.args, measure::picture(plan), 0)?;
    let mut counts = Vec::new();
    interrupt::write_file(path, |file| {
        let dumped = dump(&scene_input.scene, &scene.info, plan, file);
        counts = dumped.map_err(|error| match error {
            DumpError::Io(error) => error,
            other => std::io::Error::other(other),
        })?;
        Ok(())
    })?;
    let words = |(kind, rays): &(&str, usize)| format!("{} {kind}", output::grouped(*rays as u64));
    let counts: Vec<String> = counts.iter().map(words).collect();
    output::print(&format!("{}: {}\n", shown_path(path), counts.join(", ")))
}

fn plan<'p>(args: &RunArgs, suite: &Suite, peers: &'p [Peer]) -> BenchPlan<'p> {
    let usual_repeat = if args.quick { suite.quick_repeat } else { suite.repeat };
    BenchPlan {
        kinds: args.kinds(),
        frames: args.frames(),
        kernels: kernels(args),
        quality: args.quality,
        threads: args.thread_counts(),
        size: args.size.map_or(suite.size, Into::into),
        repeat: args.repeat.map_or(usual_repeat, |n| n as usize),
        min_time: args.min_time.unwrap_or(suite.min_time),
        pin: args.pin,
        peers,
        timed: !args.counters_only && args.update_suite.is_none(),
    }
}

fn kernels(args: &RunArgs) -> Vec<Kernel> {
    match &args.kernel {
        Some(kernels) => kernels.0.clone(),
        None if args.counters_only => Kernel::ALL.map(|(_, kernel)| kernel).to_vec(),
        None => vec![Kernel::packets()],
    }
}

/// The peers to measure.
fn peers(args: &RunArgs) -> Result<Vec<Peer>, CliError> {
    if args.embree.is_some() && !args.against.contains(&PeerArg::Embree) {
        let message = "--embree needs --against embree".to_owned();
        return Err(CliError::Usage(message));
    }
    let mut peers = Vec::new();
    if args.against.contains(&PeerArg::Embree) {
        let library = EmbreeLibrary::open(args.embree.as_deref());
        let library = Arc::new(library.map_err(|error| CliError::Usage(error.to_string()))?);
        peers.extend([false, true].map(|robust| Peer::Embree {
            library: Arc::clone(&library),
            robust,
        }));
    }
    if args.against.contains(&PeerArg::Obvhs) {
        peers.push(Peer::Obvhs);
    }
    Ok(peers)
}

/// The scenes given by the arguments, or those of the suite. The answers of a suite scene are
/// checked even if it comes from the arguments.
fn bench_scenes(
    args: &RunArgs,
    suite: &Suite,
    plan: &BenchPlan,
) -> Result<Vec<BenchScene>, CliError> {
    let overrides = &args.scene_args.overrides;
    let is_plain = *overrides == SceneOverrides::default();
    let answers = plan.size == suite.size && args.update_suite.is_none() && is_plain;
    let mut paths = args.scenes.clone();
    if paths.is_empty() {
        let text = args.filter.as_deref().unwrap_or("");
        let is_chosen =
            |scene: &&SuiteScene| (scene.quick || !args.quick) && scene.name.contains(text);
        let chosen = suite.scene.iter().filter(is_chosen);
        paths.extend(chosen.map(|scene| PathBuf::from(&scene.name)));
        if paths.is_empty() {
            let part = if args.quick { "'s quick part" } else { "" };
            let message = format!("no scene of the suite{part} has `{text}` in its name");
            return Err(CliError::Usage(message));
        }
    }
    let words = overrides.camera.as_deref().unwrap_or_default();
    // One for all, or one for each but the caches, which keep their own.
    let each = words.len() == 4 * paths.iter().filter(|path| !is_cache(path)).count();
    if words.len() > 4 && !each {
        let words = "--camera: give one for all scenes, or one for each that is no cache";
        return Err(CliError::Usage(words.to_owned()));
    }
    let mut cameras = words.chunks(4).map(<[String]>::to_vec).peekable();
    let named = |(k, path): (usize, &PathBuf)| {
        let mut of_suite = suite.scene.iter();
        let of_suite = of_suite.find(|scene| path.as_os_str() == &*scene.name);
        let mut info = of_suite
            .map(|scene| SceneInfo::of_suite(scene, answers))
            .unwrap_or_default();
        info.name = path.file_name().unwrap_or_default().display().to_string();
        let is_namesake = |other: &&PathBuf| other.file_name() == path.file_name();
        let before = paths[..k].iter().filter(is_namesake).count();
        if before > 0 {
            info.name += &format!(" ({})", before + 1);
        }
        let (path, mut args) = (path.clone(), args.scene_args.clone());
        if each && !words.is_empty() {
            args.overrides.camera = cameras.next_if(|_| !is_cache(&path));
        }
        BenchScene { path, args, info }
    };
    Ok(paths.iter().enumerate().map(named).collect())
}

/// Writes the suite with this run's answers as the expected ones.
fn update_suite(path: &Path, mut suite: Suite, all: &[Measured]) -> Result<(), CliError> {
    for scene in &mut suite.scene {
        let measured = all.iter().find(|m| m.scene.name == scene.name);
        let Some(measured) = measured else { continue };
        scene.expected = measured.scene.rays.clone();
    }
    let text = suite.to_text();
    let text = text.map_err(|e| CliError::Runtime(e.to_string()))?;
    save(path, &format!("{SUITE_HEAD}\n{text}"))
}

/// Comment at the head of a suite's file.
const SUITE_HEAD: &str = "\
# The standard suite of `phalanx bench`: scenes by family and size, and the right answers to their rays at this size.
#
# Scenes, sizes and `quick` are written by hand; what is expected was written by
#
#   phalanx bench --update-suite perf/suite.toml
#
# which takes it from the scalar oracle. A change of a scene or of the rays needs that again.
";
