//! `phalanx render`.

use super::args::RenderArgs;
use super::budget::film_bytes;
use super::failure::Failure;
use super::frames::Sequence;
use super::input::Input;
use super::memory::Memory;
use super::picture_file::{Target, format_of};
use super::progress::{self, Watch};
use super::report::{Image, Report, Seconds};
use super::sight::{self, Sight};
use super::{advise, heat, input, interrupt, output, shard};
use phalanx::frame::{Aov, Engine, Prepared, Settings};
use phalanx::image::Format;
use phalanx::jobs::{Banded, Beside, Identity, TileFile, bands, render_bands};
use phalanx::render::RenderStats;
use phalanx::scene::Scene;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Renders a scene to a picture and says what it took; or a shard of one.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    match (&args.keep.plan, &args.scene) {
        (Some(plan), _) => shard::run(args, plan),
        (None, Some(scene)) => picture(args, scene),
        // The arguments' definition asks for one of them.
        (None, None) => Err(Failure::Usage("name a scene".to_owned())),
    }
}

fn picture(args: &RenderArgs, name: &Path) -> Result<(), Failure> {
    args.picture.check()?;
    check_places(args)?;
    interrupt::listen()?;
    advise();
    let start = Instant::now();
    let mut input = Input::load(name, &args.beside, args.work.threads.unwrap_or(0))?;
    let load = start.elapsed().as_secs_f64();
    let (path, format) = output_path(args, name, &input.scene)?;
    check_output(args, &path)?;

    let settings = args.work.apply(args.picture.settings(&input.scene));
    args.picture.check_region(&settings)?;
    if settings.engine == Engine::Scalar && settings.aovs.has(Aov::Cost) {
        return Err(Failure::Usage(
            "--aov cost counts the packet engine's work: leave out --engine scalar".to_owned(),
        ));
    }
    let (grade, picture) = (&args.grade, &args.picture);
    let target = Target::new(path, format, grade, picture, &input.scene, &settings)?;
    let heat = heat::asked(args.heat.as_deref(), &settings)?;
    let sequence = args.frames.sequence(&input.scene)?;
    if let Some(sequence) = &sequence {
        check_frames(args, sequence, &target.path)?;
    }
    let films = held(&settings, &target);
    let start = Instant::now();
    let prepared = input.prepare(settings.engine, &args.tree, settings.threads)?;
    input
        .budget
        .for_render(&input.scene, &prepared, &settings, films)?;
    prepared.make_ready(&settings);
    let (build, tree) = (start.elapsed().as_secs_f64(), prepared.tree_stats());
    let job = Job {
        args,
        prepared: &prepared,
        settings: &settings,
    };
    let work = match &sequence {
        None => job.render(&input.scene, &target, args.keep.checkpoint.as_deref())?,
        Some(sequence) => job.sequence(sequence, &mut input.scene, &target)?,
    };
    let scene = &input.scene;
    if let Some(heat) = heat {
        heat::write(&heat, scene, &prepared, &settings)?;
    }

    let seconds = Seconds {
        load,
        build,
        render: work.render,
        write: work.write,
    };
    let film = films * film_bytes(&settings);
    let image = Image::new(&settings, &target.path, sequence.map(|s| s.frames));
    let report = Report::new(name, scene, &settings, image)
        .with_tree(tree)
        .with_memory(Memory::of(scene, &tree, film, input.mapped_bytes))
        .with_work(&work.stats, seconds);
    if args.json {
        output::print_json(&report)
    } else {
        output::print(&report.table())
    }
}

/// Refuses places that cannot be written, before the scene is read.
fn check_places(args: &RenderArgs) -> Result<(), Failure> {
    heat::check_place(args.heat.as_deref())?;
    sight::check_place(&args.sight)?;
    if let Some(path) = &args.keep.checkpoint {
        TileFile::check_place(path)?;
    }
    let Some(path) = &args.output else {
        return Ok(());
    };
    format_of(path, args.beside.picture_format()?, "--output")?;
    if args.frames.frames.is_some() && output::is_dash(path) {
        return Err(Failure::Usage(
            "--frames writes a file for each frame, and stdout is one: name files".to_owned(),
        ));
    }
    check_output(args, path)
}

/// Refuses a place that the picture cannot be written to, or that is another result's.
fn check_output(args: &RenderArgs, path: &Path) -> Result<(), Failure> {
    output::check_picture_place(path)?;
    let heat = args.heat.as_ref().and_then(|words| words.get(1));
    output::check_distinct(&[
        ("the picture", Some(path)),
        ("--checkpoint", args.keep.checkpoint.as_deref()),
        ("--heat", heat.map(Path::new)),
        ("--snapshot", args.sight.snapshot.as_deref()),
    ])
}

/// Refuses names of frames at which no file can be written, before the first is rendered.
fn check_frames(args: &RenderArgs, sequence: &Sequence, path: &Path) -> Result<(), Failure> {
    for frame in sequence.frames.clone() {
        output::check_kind(&sequence.name(path, frame))?;
        if let Some(path) = &args.keep.checkpoint {
            TileFile::check_place(&sequence.name(path, frame))?;
        }
    }
    Ok(())
}

/// What is the same for all frames of a sequence.
struct Job<'a> {
    args: &'a RenderArgs,
    prepared: &'a Prepared,
    settings: &'a Settings,
}

/// What rendering came to, and how long it and the rest of writing took.
#[derive(Default)]
struct Work {
    stats: RenderStats,
    render: f64,
    write: f64,
}

impl Job<'_> {
    /// Renders one frame after the other; each is finished before the next begins.
    fn sequence(
        &self,
        sequence: &Sequence,
        scene: &mut Scene,
        target: &Target,
    ) -> Result<Work, Failure> {
        let start = scene.view;
        let mut all = Work::default();
        for frame in sequence.frames.clone() {
            scene.view = sequence.view(frame, &start)?;
            let path = sequence.name(&target.path, frame);
            let target = Target {
                path,
                ..target.clone()
            };
            let checkpoint = self.args.keep.checkpoint.as_deref();
            let checkpoint = checkpoint.map(|path| sequence.name(path, frame));
            let work = self.render(scene, &target, checkpoint.as_deref())?;
            if !self.args.json {
                let speed = work.stats.rays.total() as f64 / 1e6 / work.render.max(1e-9);
                output::print(&format!(
                    "frame {frame}: {:.3} seconds, {speed:.3} Mrays/s, {}\n",
                    work.render,
                    target.path.display()
                ))?;
            }
            all.stats.add(&work.stats);
            all.render += work.render;
            all.write += work.write;
        }
        Ok(all)
    }

    /// Renders a picture, and writes it as it is made.
    fn render(
        &self,
        scene: &Scene,
        target: &Target,
        checkpoint: Option<&Path>,
    ) -> Result<Work, Failure> {
        let Job { args, settings, .. } = self;
        let sight = Sight::of(&args.sight, target, settings.window())?;
        let tiles = checkpoint
            .map(|path| tiles(path, scene, settings))
            .transpose()?;
        let watch = Watch {
            pixels: settings.pixels(),
            mode: args.progress,
            sight: sight.as_ref(),
        };
        let start = Instant::now();
        let banded = write(
            scene,
            self.prepared,
            settings,
            target,
            tiles.as_ref(),
            watch,
        )?;
        Ok(Work {
            stats: banded.stats,
            render: banded.seconds,
            write: start.elapsed().as_secs_f64() - banded.seconds,
        })
    }
}

/// The file of finished tiles.
fn tiles(path: &Path, scene: &Scene, settings: &Settings) -> Result<TileFile, Failure> {
    let file = TileFile::open(path, &Identity::of(scene, settings))?;
    shard::tell_damaged(&file, path);
    if file.pixels() > 0 {
        let share = 100.0 * file.pixels() as f64 / settings.pixels() as f64;
        output::note(&format!(
            "going on: {} has {share:.1} % of the picture",
            path.display()
        ));
    }
    Ok(file)
}

/// Renders band by band, and writes each while the next is made.
fn write(
    scene: &Scene,
    prepared: &Prepared,
    settings: &Settings,
    target: &Target,
    tiles: Option<&TileFile>,
    watch: Watch,
) -> Result<Banded, Failure> {
    let beside = Beside {
        file: tiles,
        overview: watch.sight.map(|sight| &sight.overview),
    };
    let written = progress::watched_writing(&target.path, watch, |control| {
        let tree = prepared.tree();
        target.write_while(control, |take| {
            render_bands(scene, tree, settings, control, beside, take)
        })
    });
    let Some(tiles) = tiles else {
        return written;
    };
    // Even where it was interrupted: what is finished is not to be lost.
    tiles.sync()?;
    written.map_err(|failure| match failure {
        Failure::Interrupted => Failure::Kept(format!(
            "finished tiles are kept in {}; the same command goes on from there",
            tiles.path().display()
        )),
        other => other,
    })
}

/// Films in memory at a time: one that is rendered, and one that is written; and as many as a file
/// that is put together in memory takes the place of.
fn held(settings: &Settings, target: &Target) -> u64 {
    let bands = bands(settings.window()).len() as u64;
    let file = if target.is_in_memory() { bands } else { 0 };
    bands.min(2) + file
}

/// Where the picture goes: as asked, else as the scene says, else named like the scene; the latter two in the current
/// folder, whatever folders the scene names.
fn output_path(
    args: &RenderArgs,
    name: &Path,
    scene: &Scene,
) -> Result<(PathBuf, Format), Failure> {
    let asked = args.beside.picture_format()?;
    if let Some(path) = &args.output {
        return Ok((path.clone(), format_of(path, asked, "--output")?));
    }
    let named = scene
        .output
        .as_deref()
        .map(Path::new)
        .and_then(Path::file_name);
    match named {
        Some(name) => {
            // Only the command line may choose stdout: a scene's `-` is the file `./-`.
            let path = match output::is_dash(Path::new(name)) {
                true => Path::new(".").join(name),
                false => PathBuf::from(name),
            };
            let format = format_of(&path, asked, "the scene asks for the output")
                .map_err(|failure| failure.and("choose another with -o"))?;
            Ok((path, format))
        }
        None => {
            let format = asked.unwrap_or(Format::Png);
            let mut stem = input::stem(name).to_os_string();
            stem.push(format!(".{}", format.ending()));
            Ok((PathBuf::from(stem), format))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::{Arguments, Command};
    use clap::Parser;

    fn path_of(line: &str, output: Option<&str>) -> Result<PathBuf, Failure> {
        let scene = Scene {
            output: output.map(str::to_owned),
            ..Scene::default()
        };
        match Arguments::try_parse_from(line.split(' ')).unwrap().command {
            Command::Render(args) => {
                let name = args.scene.clone().unwrap();
                output_path(&args, &name, &scene).map(|(path, _)| path)
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_picture_goes_where_the_user_says_else_to_the_current_folder() {
        let plain = "phalanx render folder/a.b.test";
        let asked = "phalanx render folder/a.test -o other/c.png";
        assert_eq!(
            path_of(asked, Some("b.png")).unwrap(),
            Path::new("other/c.png")
        );
        assert_eq!(path_of(plain, Some("b.png")).unwrap(), Path::new("b.png"));
        assert_eq!(
            path_of(plain, Some("../../etc/b.png")).unwrap(),
            Path::new("b.png")
        );
        assert_eq!(path_of(plain, None).unwrap(), Path::new("a.b.png"));
        let standard = "phalanx render standard:balls:3";
        assert_eq!(path_of(standard, None).unwrap(), Path::new("balls.png"));
        let refused = path_of(plain, Some("b.bmp")).unwrap_err();
        assert_eq!(refused.code(), 2);
        assert!(matches!(refused, Failure::Usage(m) if m.contains("b.bmp") && m.contains("-o")));
    }
}
