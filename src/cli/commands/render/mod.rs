//! `phalanx render`.

mod args;
mod heatmap;
mod interior;
mod job;
mod kept_tiles;
mod report;
mod shard;
mod shard_index;

pub use args::RenderArgs;
pub use interior::hint as interior_hint;

use crate::cli::options::{SceneInput, Sequence, film_bytes, picture_file, resolve_exposure, stem};
use crate::cli::output::{self, CameraReport, CliError, MemoryStats, format_of, interrupt};
use job::{Job, films_in_memory};
use phalanx::files::{shown_path, shown_text};
use phalanx::formats::is_bare_name;
use phalanx::frame::{AccelRef, Aov, Engine, Integrator};
use phalanx::image::ImageFormat;
use phalanx::jobs::TileFile;
use phalanx::scene::Scene;
use report::{KeptTiles, RenderDocument, RenderImage, RenderSeconds};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Renders a scene to a picture and prints a report, or renders a shard of a plan.
pub fn run(args: &RenderArgs) -> Result<(), CliError> {
    match (&args.kept.plan, &args.scene) {
        (Some(plan), _) => shard::run(args, plan),
        (None, Some(scene)) => picture(args, scene),
        // Unreachable: the arguments' definition requires one of them.
        (None, None) => Err(CliError::Usage("no scene given".to_owned())),
    }
}

fn picture(args: &RenderArgs, name: &Path) -> Result<(), CliError> {
    args.pixels.check_use().map_err(CliError::Usage)?;
    check_places(args)?;
    interrupt::listen()?;
    output::advise();
    let start = Instant::now();
    let (picture, threads) = (args.frames.wanted(&args.pixels), args.work.threads);
    let mut scene_input = SceneInput::load(name, &args.scene_args, picture, threads.unwrap_or(0))?;
    let load = start.elapsed().as_secs_f64();
    let sequence = args.frames.sequence(&scene_input.scene)?;
    let (mut path, format) = output_path(args, name, &scene_input.scene)?;
    if args.output.is_none() {
        path = beside_inputs(path, sequence.as_ref());
    }
    check_output(args, &path)?;

    let settings = args.tiles.apply(args.pixels.settings(&scene_input.scene));
    let settings = args.work.apply(settings);
    let region = args.pixels.check_region(&settings);
    region.map_err(CliError::Usage)?;
    if settings.engine == Engine::Scalar && settings.aovs.has(Aov::Cost) {
        return Err(CliError::Usage("--aov cost needs --engine simd".to_owned()));
    }
    let scene = &scene_input.scene;
    if matches!(settings.integrator, Integrator::Occlusion { .. })
        && !args.scene_args.overrides.light.is_empty()
    {
        output::note("--light has no effect with --integrator ao");
    }
    let name_text = name.to_string_lossy();
    let mut spec = (args.scene_args).picture(name_text, &args.pixels, &args.encoding)?;
    let mut output = picture_file(path, format, &spec, scene)?;
    let heatmap = heatmap::from_args(args.heat.as_deref(), &settings)?;
    if let Some(sequence) = &sequence {
        check_frames(args, sequence, &output.path, scene)?;
    }
    let films = films_in_memory(&settings, &output);
    let start = Instant::now();
    let prepared = scene_input.prepare_render(&settings, &args.tree, films)?;
    let (build, tree) = (start.elapsed().as_secs_f64(), prepared.tree_stats());
    if let AccelRef::Packets(bvh) = prepared.accel() {
        interior_hint(&scene_input.scene, bvh).inspect(|hint| output::note(hint));
    }
    let with_keys = args.frames.keyframes.is_some();
    let size = (settings.width, settings.height);
    let camera = (!with_keys).then(|| CameraReport::of(&scene_input.scene, size));
    let (encoding, path) = (&mut spec.encoding, sequence.as_ref());
    let accel = Some(prepared.accel());
    resolve_exposure(encoding, &mut scene_input, path, accel, &settings)?;
    let (exposure, scene) = (encoding.exposure, &scene_input.scene);
    output.file.exposure = encoding.exposure(scene.encoding);
    let spec = spec.resolve(scene);
    let job = Job {
        args,
        prepared: &prepared,
        settings: &settings,
    };
    let work = match &sequence {
        None => {
            let scene = &scene_input.scene;
            let tiles = job.checkpoint(scene, args.kept.checkpoint.as_deref())?;
            let output = output.with_header(spec.header(scene, false));
            job.render(scene, &output, tiles.as_ref())?
        }
        Some(sequence) => job.sequence(&spec, sequence, &mut scene_input.scene, &output)?,
    };
    let scene = &scene_input.scene;
    if let Some(heatmap) = heatmap {
        heatmap::write(&heatmap, scene, &prepared, &settings)?;
    }

    let seconds = RenderSeconds {
        load,
        build,
        ..work.seconds
    };
    let film = films * film_bytes(&settings);
    let memory = MemoryStats::of(scene, &tree, film, scene_input.mapped_bytes);
    let image = RenderImage::new(&settings, &output, sequence.as_ref(), exposure);
    let sizes = (tree, memory);
    let stats = &work.stats;
    let mut report = RenderDocument::new(name, scene, &settings, image, sizes, stats, seconds);
    report.camera = camera;
    let checkpoint = args.kept.checkpoint.as_deref();
    report.checkpoint = checkpoint.map(|path| KeptTiles {
        path: path.to_string_lossy().into_owned(),
        bytes: work.kept_bytes,
    });
    output::print_output(&report, args.json)
}

/// Refuses output files that cannot be written, before the scene is read.
fn check_places(args: &RenderArgs) -> Result<(), CliError> {
    if let Some([_, path]) = args.heat.as_deref() {
        output::check_png_place(path.as_ref(), "--heat")?;
    }
    if let Some(path) = &args.preview.snapshot {
        output::check_png_place(path, "--snapshot")?;
    }
    if let Some(path) = &args.kept.checkpoint {
        check_checkpoint(path, args.frames.origin("--checkpoint"))?;
    }
    let Some(path) = &args.output else {
        return Ok(());
    };
    format_of(path, args.scene_args.picture_format()?, "--output")?;
    if args.frames.are_given() && output::is_dash(path) {
        let message = "a sequence cannot be written to stdout: give a file name";
        return Err(CliError::Usage(message.to_owned()));
    }
    check_output(args, path)
}

/// Refuses a path that the picture cannot be written to, or that is already in use.
fn check_output(args: &RenderArgs, path: &Path) -> Result<(), CliError> {
    output::check_picture_place(path, args.frames.origin("--output"))
}

/// Refuses a path that finished tiles cannot be kept at, or that is already in use.
fn check_checkpoint(path: &Path, origin: Option<&'static str>) -> Result<(), CliError> {
    output::refuse_stdout(path, Some("--checkpoint"))?;
    TileFile::check_place(path)?;
    origin.map_or(Ok(()), |origin| output::writes(origin, path))
}

/// The default path, changed until it replaces neither an input nor another program's picture.
fn beside_inputs(path: PathBuf, sequence: Option<&Sequence>) -> PathBuf {
    let (free, taken) = output::free_path(&path, |path| match sequence {
        None => output::taken(path),
        Some(sequence) => {
            let mut frames = sequence.frames.clone();
            frames.find_map(|frame| output::taken(&sequence.name(path, frame)))
        }
    });
    if let Some(taken) = taken {
        let [path, free] = [&path, &free].map(shown_path);
        output::note(&format!("{path} is {taken}: writing {free} instead"));
    }
    free
}

/// Refuses frames without a valid view, and frame names that cannot be written or are already in
/// use, before the first frame is rendered.
fn check_frames(
    args: &RenderArgs,
    sequence: &Sequence,
    path: &Path,
    scene: &Scene,
) -> Result<(), CliError> {
    args.frames.note_camera(&args.scene_args);
    for frame in sequence.frames.clone() {
        sequence.view(frame, &scene.view)?;
        output::check_kind(&sequence.name(path, frame), "--output")?;
        if let Some(path) = &args.kept.checkpoint {
            check_checkpoint(&sequence.name(path, frame), Some("--checkpoint"))?;
        }
    }
    Ok(())
}

/// The picture's path: from the arguments, else from the scene, else named after the scene. The
/// latter two are always in the current folder.
fn output_path(
    args: &RenderArgs,
    name: &Path,
    scene: &Scene,
) -> Result<(PathBuf, ImageFormat), CliError> {
    let format = args.scene_args.picture_format()?;
    if let Some(path) = &args.output {
        return Ok((path.clone(), format_of(path, format, "--output")?));
    }
    match scene.output.as_deref() {
        Some(name) if !is_bare_name(name) => {
            let name = shown_text(name);
            let message = format!(
                "the scene's output `{name}` is not a bare file name: a scene may not choose the folder"
            );
            Err(CliError::Usage(message).with_hint("choose a file with -o"))
        }
        Some(name) => {
            // Only the command line may choose stdout: a scene's `-` is the file `./-`.
            let path = if output::is_dash(Path::new(name)) {
                Path::new(".").join(name)
            } else {
                PathBuf::from(name)
            };
            let format = format_of(&path, format, "the scene's output");
            let hinted = |error: CliError| error.with_hint("choose another file with -o");
            Ok((path, format.map_err(hinted)?))
        }
        None => {
            let format = format.unwrap_or(ImageFormat::Png);
            let mut stem = stem(name).to_os_string();
            stem.push(format!(".{}", format.ending()));
            Ok((PathBuf::from(stem), format))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Args, FromArgMatches};

    fn path_of(line: &str, output: Option<&str>) -> Result<PathBuf, CliError> {
        let scene = Scene {
            output: output.map(str::to_owned),
            ..Scene::default()
        };
        let command = RenderArgs::augment_args(clap::Command::new("render"));
        let matches = command.try_get_matches_from(line.split(' ')).unwrap();
        let args = RenderArgs::from_arg_matches(&matches).unwrap();
        let name = args.scene.clone().unwrap();
        output_path(&args, &name, &scene).map(|(path, _)| path)
    }

    #[test]
    fn the_picture_goes_where_the_user_says_else_to_the_current_folder() {
        let plain = "render folder/a.b.test";
        let line = "render folder/a.test -o other/c.png";
        assert_eq!(
            path_of(line, Some("b.png")).unwrap(),
            Path::new("other/c.png")
        );
        assert_eq!(path_of(plain, Some("b.png")).unwrap(), Path::new("b.png"));
        assert_eq!(path_of(plain, None).unwrap(), Path::new("a.b.png"));
        let standard = "render standard:balls:3";
        assert_eq!(path_of(standard, None).unwrap(), Path::new("balls.png"));
        let folder = path_of(plain, Some("../../etc/b.png")).unwrap_err();
        assert_eq!(folder.code(), 2);
        let refused = path_of(plain, Some("b.bmp")).unwrap_err();
        assert_eq!(refused.code(), 2);
        assert!(matches!(refused, CliError::Usage(m) if m.contains("b.bmp") && m.contains("-o")));
    }
}
