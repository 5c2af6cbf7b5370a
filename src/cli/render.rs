//! `phalanx render`.

use super::args::RenderArgs;
use super::budget::film_bytes;
use super::failure::Failure;
use super::input::Input;
use super::memory::Memory;
use super::picture_file::{PictureFile, format_of};
use super::report::{Image, Report};
use super::{advise, heat, input, interrupt, output, progress};
use phalanx::frame::{Pin, Settings};
use phalanx::image::Format;
use phalanx::scene::Scene;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Renders a scene to a picture and says what it took.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    args.picture.check()?;
    if let Some(path) = &args.output {
        format_of(path, "--output")?;
    }
    interrupt::listen()?;
    advise();
    let start = Instant::now();
    let mut input = Input::load(&args.scene, &args.beside, args.threads.unwrap_or(0))?;
    let load = start.elapsed().as_secs_f64();
    let (path, format) = output_path(args, &input.scene)?;
    output::check_place(&path)?;

    let settings = settings(args, &input.scene);
    let (grade, picture) = (&args.grade, &args.picture);
    let file = PictureFile::new(path, format, grade, picture, &input.scene, &settings)?;
    let heat = heat::asked(args.heat.as_deref(), &settings)?;
    let start = Instant::now();
    let prepared = input.prepare(settings.engine, &args.tree, settings.threads)?;
    let scene = &input.scene;
    input.budget.for_render(scene, &prepared, &settings, 1)?;
    prepared.make_ready(&settings);
    let (build, tree) = (start.elapsed().as_secs_f64(), prepared.tree_stats());
    let frame = progress::render(scene, &prepared, &settings)?;
    file.write(&frame.film)?;
    if let Some(heat) = heat {
        heat::write(&heat, scene, &prepared, &settings)?;
    }

    let image = Image::new(&settings, &file.path);
    let report = Report::new(&args.scene, scene, &settings, image)
        .with_tree(tree)
        .with_memory(Memory::of(
            scene,
            &tree,
            film_bytes(&settings),
            input.mapped_bytes,
        ))
        .with_frame(&frame, load, build);
    if args.json {
        output::print_json(&report)
    } else {
        output::print(&report.table())
    }
}

fn settings(args: &RenderArgs, scene: &Scene) -> Settings {
    // Counts the CPUs of the process's affinity mask, not those of the machine.
    let available = std::thread::available_parallelism().map_or(1, |n| n.get());
    let threads = args.threads.unwrap_or(available);
    // With fewer workers than cores, runs side by side would all sit on the first ones.
    let pin = match args.pin {
        Some(pin) => pin.into(),
        None if threads >= available => Pin::Cores,
        None => Pin::None,
    };
    Settings {
        threads,
        pin,
        engine: args.engine.into(),
        kernel: args.kernel,
        ..args.picture.settings(scene)
    }
}

/// Where the picture goes: as asked, else as the scene says, else named like the scene; the latter two in the current
/// folder, whatever folders the scene names.
fn output_path(args: &RenderArgs, scene: &Scene) -> Result<(PathBuf, Format), Failure> {
    if let Some(path) = &args.output {
        return Ok((path.clone(), format_of(path, "--output")?));
    }
    let named = scene
        .output
        .as_deref()
        .map(Path::new)
        .and_then(Path::file_name);
    match named {
        Some(name) => {
            let path = PathBuf::from(name);
            let format = format_of(&path, "the scene asks for the output")
                .map_err(|failure| failure.and("choose another with -o"))?;
            Ok((path, format))
        }
        None => {
            let mut name = input::stem(&args.scene).to_os_string();
            name.push(".png");
            Ok((PathBuf::from(name), Format::Png))
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
            Command::Render(args) => output_path(&args, &scene).map(|(path, _)| path),
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
