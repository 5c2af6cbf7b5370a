//! `phalanx plan`: a picture cut into shards, for many machines.

use crate::cli::options::{GradeArgs, NamedScene, PictureArgs, SceneArgs, SceneInput, set_header};
use crate::cli::output::{
    self, CliError, Output, OutputFile, absolute_path, format_of, interrupt, lines,
};
use clap::{Args, FromArgMatches, value_parser};
use phalanx::frame::Settings;
use phalanx::image::{Depth, Exposure, ImageFormat};
use phalanx::jobs::{KeyDifference, MAX_SHARDS, RenderKey, RenderPlan, TileEncoding, kept_output};
use phalanx::open::standard_name;
use phalanx::scene::{OutputEncoding, Quantize, Transfer, shown_path};
use serde::Serialize;
use std::io;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct PlanArgs {
    #[arg(help = "Scene file, cache (.phx), or standard:NAME[:SIZE]")]
    pub scene: PathBuf,
    /// How many shards to cut the picture into
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_SHARDS)))]
    pub shards: u32,
    /// Picture that the shards will be merged into; its ending says what is written. If it lies
    /// outside the plan's folder, merge wants to be told again
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    /// Plan to write; shards are rendered into files beside it
    #[arg(long, value_name = "PLAN.json")]
    pub plan: PathBuf,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub grade: GradeArgs,
    #[command(flatten)]
    pub beside: SceneArgs,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}

impl PlanArgs {
    /// The arguments that these words of a command line, `plan` first, give.
    fn of_words(words: &[String]) -> Option<PlanArgs> {
        if words.first()? != "plan" {
            return None;
        }
        let command = PlanArgs::augment_args(clap::Command::new("plan"));
        let found = command.try_get_matches_from(words).ok()?;
        PlanArgs::from_arg_matches(&found).ok()
    }
}

#[derive(Debug, Serialize)]
struct PlanDocument<'a> {
    plan: &'a Path,
    shards: u32,
    tile: u32,
    output: &'a Path,
    scene_hash: &'a str,
    /// All shards in Slurm's notation.
    array: String,
    /// The command that merges them.
    #[serde(skip)]
    merge: String,
}

/// Writes a plan.
pub fn run(args: &PlanArgs) -> Result<(), CliError> {
    if output::is_dash(&args.scene) || output::is_dash(&args.output) {
        return Err(CliError::Usage(
            "a plan is carried out later, elsewhere: stdin and stdout will not be there, name files".to_owned(),
        ));
    }
    args.beside.no_picture()?;
    let format = format_of(&args.output, None, "--output")?;
    output::check_place(&args.plan)?;
    output::check_place(&args.output)?;
    output::check_distinct(&[
        ("--output", Some(&args.output)),
        ("--plan", Some(&args.plan)),
    ])?;
    interrupt::listen()?;
    refuse_special(&args.scene)?;
    let scene_input = SceneInput::load(&args.scene, &args.beside, args.picture.wanted(), 0)?;
    let scene = &scene_input.scene;
    let settings = args.picture.settings(scene);
    args.picture.check_region(&settings)?;
    let output = text(&absolute_path(&args.output)?)?;
    let picture = &args.picture;
    let target = (args.grade).output_file(output.into(), format, picture, scene, &settings)?;
    let named = NamedScene {
        name: &args.scene,
        args: &args.beside,
        scene,
        is_moved: false,
    };
    let header = named.header(&settings)?;
    let name = match standard_name(&args.scene) {
        Some(name) => name.to_owned(),
        None => text(&absolute_path(&args.scene)?)?,
    };
    let kept = kept_output(&args.plan, &args.output)
        .map_err(|e| CliError::not_located(&args.output, e))?;
    let plan = RenderPlan::new(
        name,
        arguments()?,
        kept,
        tile_encoding(&target),
        RenderKey::of(scene, &settings),
        args.shards,
    )
    .with_header(header);
    plan.check()
        .map_err(|error| CliError::Usage(format!("the plan's {error}")))?;
    interrupt::write_file(&args.plan, |out| {
        serde_json::to_writer_pretty(out, &plan).map_err(io::Error::other)
    })?;
    print_plan(args, &plan, &target.path)
}

/// Refuses a scene that not every shard could read again.
fn refuse_special(scene: &Path) -> Result<(), CliError> {
    let file = standard_name(scene).is_none();
    match std::fs::metadata(scene) {
        Ok(found) if file && !found.is_file() && !found.is_dir() => Err(CliError::Usage(format!(
            "{} is no regular file: every shard has to read the scene again",
            shown_path(scene)
        ))),
        _ => Ok(()),
    }
}

fn print_plan(args: &PlanArgs, plan: &RenderPlan, picture: &Path) -> Result<(), CliError> {
    let array = format!("0-{}", plan.shards - 1);
    let mut merge = format!("phalanx merge {}", shown_path(&args.plan));
    if plan.picture_path(&args.plan).is_err() {
        let picture = shown_path(&args.output);
        output::note(&format!(
            "{picture} lies outside the plan's folder, where no plan writes: name it again for the merge, with -o"
        ));
        merge.push_str(&format!(" -o {picture}"));
    }
    let document = PlanDocument {
        plan: &args.plan,
        shards: plan.shards,
        tile: plan.tile,
        output: picture,
        scene_hash: &plan.picture.scene,
        array,
        merge,
    };
    output::print_output(&document, args.json)
}

impl Output for PlanDocument<'_> {
    fn table(&self) -> String {
        let path = shown_path(self.plan);
        let render = format!(
            "phalanx render --plan {path} --shard I, I from {}",
            self.array
        );
        lines(&[
            ("plan", format!("{path}, {} shards", self.shards)),
            ("render", render),
            ("merge", self.merge.clone()),
        ])
    }
}

/// The arguments of this process, as they are kept in the plan.
fn arguments() -> Result<Vec<String>, CliError> {
    let all = std::env::args_os().skip(1);
    all.map(|argument| {
        argument.into_string().map_err(|argument| {
            CliError::Usage(format!(
                "a plan is a text, and this argument is none: {}",
                argument.to_string_lossy()
            ))
        })
    })
    .collect()
}

fn text(path: &Path) -> Result<String, CliError> {
    let text = path.to_str().map(str::to_owned);
    text.ok_or_else(|| {
        CliError::Usage(format!(
            "a plan is a text, and this name is none: {}",
            shown_path(path)
        ))
    })
}

/// Opens a plan's picture again: its scene, and its settings, which must still be those of the
/// plan.
pub fn reopen(
    path: &Path,
    plan: &RenderPlan,
    threads: usize,
) -> Result<(SceneInput, Settings), CliError> {
    let asked = PlanArgs::of_words(&plan.arguments).ok_or_else(|| {
        CliError::Runtime(format!(
            "{}: its arguments are not those of phalanx plan",
            shown_path(path)
        ))
    })?;
    let scene = PathBuf::from(&plan.scene);
    refuse_special(&scene)?;
    let scene_input = SceneInput::load(&scene, &asked.beside, asked.picture.wanted(), threads)?;
    let settings = asked.picture.settings(&scene_input.scene);
    let now = RenderKey::of(&scene_input.scene, &settings);
    if plan.picture == now {
        return Ok((scene_input, settings));
    }
    let differences = plan.picture.differences(&now);
    let differences: Vec<String> = differences.iter().map(KeyDifference::to_string).collect();
    Err(CliError::Usage(format!(
        "{}: the plan is of another picture: {}; make the plan again",
        shown_path(path),
        differences.join(", ")
    )))
}

fn tile_encoding(output: &OutputFile) -> TileEncoding {
    let Exposure { stops, encoding } = output.file.exposure;
    TileEncoding {
        exposure: stops,
        srgb: encoding.transfer == Transfer::Srgb,
        round: encoding.quantize == Quantize::Round,
        bits: match output.file.depth {
            Depth::Eight => 8,
            Depth::Sixteen => 16,
        },
    }
}

/// The picture of a plan as a file of this name.
pub fn target(
    plan: &RenderPlan,
    path: PathBuf,
    format: ImageFormat,
) -> Result<OutputFile, CliError> {
    let TileEncoding {
        exposure,
        srgb,
        round,
        bits,
    } = plan.developing;
    let transfer = match srgb {
        true => Transfer::Srgb,
        false => Transfer::None,
    };
    let quantize = match round {
        true => Quantize::Round,
        false => Quantize::Floor,
    };
    let depth = match bits {
        16 => Depth::Sixteen,
        _ => Depth::Eight,
    };
    let exposure = Exposure {
        stops: exposure,
        encoding: OutputEncoding { transfer, quantize },
    };
    let mut output = OutputFile::for_picture(
        path,
        format,
        exposure,
        depth,
        plan.picture.window(),
        (plan.aovs(), plan.picture.origin),
    )?;
    set_header(&mut output, plan.header.clone());
    Ok(output)
}
