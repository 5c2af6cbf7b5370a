//! `phalanx plan`: a picture or a sequence cut into shards, for many machines.

use crate::cli::options::{
    FrameArgs, GradeArgs, LONG_RENDERS, NamedScene, OUTPUT, PictureArgs, SceneArgs, SceneInput,
    Sequence, name_parser, read_keys, set_header,
};
use crate::cli::output::{
    self, CliError, Output, OutputFile, absolute_path, format_of, interrupt, lines,
};
use clap::{Arg, ArgAction, Args, FromArgMatches, value_parser};
use phalanx::files::shown_path;
use phalanx::frame::Settings;
use phalanx::image::{Depth, Exposure, ImageFormat};
use phalanx::jobs::{
    KeyDifference, MAX_SHARDS, PlannedCamera, PlannedFrames, RenderKey, RenderPlan, SequencePlan,
    ShardBy, TileEncoding, kept_output,
};
use phalanx::open::standard_name;
use phalanx::scene::{CameraPath, OutputEncoding, Quantize, Scene, Transfer};
use serde::Serialize;
use std::io;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct PlanArgs {
    #[arg(help = "Scene file, cache (.phx), or standard:NAME[:SIZE]")]
    pub scene: PathBuf,
    /// Number of shards
    ///
    /// How many shards to cut the picture or the sequence into.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_SHARDS)))]
    pub shards: u32,
    /// Picture that the shards are merged into
    ///
    /// Picture that the shards will be merged into; its ending says what is written. If it lies
    /// outside the plan's folder, merge wants to be told again; whole frames, which shards write
    /// themselves, have to lie in it.
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT, display_order = 0)]
    pub output: PathBuf,
    /// Plan to write; shards become files beside it
    #[arg(long, value_name = "PLAN", help_heading = OUTPUT, display_order = 1)]
    pub plan: PathBuf,
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Shards of whole frames (default), or of tiles
    ///
    /// Cut a sequence into whole frames, dealt out in turn (frame, the default), or into the tiles
    /// of each frame, for few frames that take long (tile).
    #[arg(long, value_name = "BY", hide_possible_values = true, help_heading = LONG_RENDERS, value_parser = name_parser(&ShardBy::ALL), requires = "path")]
    pub shard_by: Option<ShardBy>,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub grade: GradeArgs,
    #[command(flatten)]
    pub beside: SceneArgs,
    /// Print one JSON document instead of lines
    #[arg(long, help_heading = OUTPUT, display_order = 900)]
    pub json: bool,
}

impl PlanArgs {
    /// The arguments that these words of a command line, `plan` first, give.
    fn of_words(words: &[String]) -> Option<PlanArgs> {
        // Every command has these, before its name or behind it.
        let told = [("quiet", 'q'), ("verbose", 'v')];
        let flag = |(name, letter)| Arg::new(name).short(letter).long(name);
        let told = told.map(|told| flag(told).action(ArgAction::SetTrue));
        let begin = words.iter().position(|word| !word.starts_with('-'))?;
        let words = &words[begin..];
        if words.first()? != "plan" {
            return None;
        }
        let command = PlanArgs::augment_args(clap::Command::new("plan")).args(told);
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
    /// The first and the last frame of a sequence.
    frames: Option<[u32; 2]>,
    /// Meaning of a shard of a sequence.
    shard_by: Option<&'static str>,
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
    output::check_place(&args.plan, Some("--plan"))?;
    output::check_place(&args.output, args.frames.origin("--output"))?;
    interrupt::listen()?;
    refuse_special(&args.scene)?;
    let wanted = args.frames.wanted(&args.picture);
    let scene_input = SceneInput::load(&args.scene, &args.beside, wanted, 0)?;
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
    let sequence = args.frames.sequence(scene)?;
    let plan = match &sequence {
        Some(sequence) => plan.with_sequence(sequence_plan(args, sequence, scene)?),
        None => plan,
    };
    plan.check()
        .map_err(|error| CliError::Usage(format!("the plan's {error}")))?;
    if let Some(frames) = PlannedFrames::of(&plan) {
        check_frames(args, &frames)?;
    }
    interrupt::write_file(&args.plan, |out| {
        serde_json::to_writer_pretty(out, &plan).map_err(io::Error::other)
    })?;
    print_plan(args, &plan, &target.path)
}

/// The sequence of the arguments, as it is kept in the plan.
fn sequence_plan(
    args: &PlanArgs,
    sequence: &Sequence,
    scene: &Scene,
) -> Result<SequencePlan, CliError> {
    args.frames.note_camera(&args.beside);
    let file = args.frames.keyframes.as_deref();
    let file = file.map(|file| text(&absolute_path(file)?)).transpose()?;
    Ok(SequencePlan {
        frames: [*sequence.frames.start(), *sequence.frames.end()],
        shard_by: args.shard_by.unwrap_or(ShardBy::Frame),
        view: scene.view.into(),
        camera: PlannedCamera::new(&sequence.path, file.unwrap_or_default()),
    })
}

/// Refuses frames without a view, and names of frames that cannot be written as files.
fn check_frames(args: &PlanArgs, frames: &PlannedFrames) -> Result<(), CliError> {
    for frame in frames.all() {
        frames.view(frame)?;
        let name = frames.name(&args.output, frame);
        output::check_kind(&name, "--output")?;
        if frames.is_by_frame() {
            frame_path(frames, &args.plan, frame)?;
        }
    }
    Ok(())
}

/// The path of a frame that a shard writes, for a plan in the file `path`.
pub fn frame_path(frames: &PlannedFrames, path: &Path, frame: u32) -> Result<PathBuf, CliError> {
    frames.picture_path(path, frame).map_err(|error| {
        CliError::Usage(format!(
            "{error}; shards of whole frames write there and nowhere else: plan them with such a name, or --shard-by tile"
        ))
    })
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
    let by_frame = PlannedFrames::of(plan).is_some_and(|frames| frames.is_by_frame());
    if !by_frame && plan.picture_path(&args.plan).is_err() {
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
        frames: plan.sequence.as_ref().map(|sequence| sequence.frames),
        shard_by: (plan.sequence.as_ref()).map(|sequence| sequence.shard_by.name()),
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
        let mut rows = vec![("plan", format!("{path}, {} shards", self.shards))];
        if let Some([first, last]) = self.frames {
            let shard = match self.shard_by {
                Some("tile") => "each shard renders tiles of all".to_owned(),
                _ => format!("each shard renders every {}", ordinal(self.shards)),
            };
            rows.push(("frames", format!("{first} to {last}, {shard}")));
        }
        rows.extend([("render", render), ("merge", self.merge.clone())]);
        lines(&rows)
    }
}

/// Every frame, every 2nd, every 3rd.
fn ordinal(shards: u32) -> String {
    let ending = match (shards % 10, shards % 100 / 10) {
        _ if shards == 1 => return "frame".to_owned(),
        (1, tens) if tens != 1 => "st",
        (2, tens) if tens != 1 => "nd",
        (3, tens) if tens != 1 => "rd",
        _ => "th",
    };
    format!("{shards}{ending}")
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

/// Reads a plan; a result may replace neither it nor the scene that it names.
pub fn read(path: &Path) -> Result<RenderPlan, CliError> {
    output::reads("the plan", path)?;
    let plan = RenderPlan::read(path)?;
    SceneInput::note_all([&plan.scene])?;
    Ok(plan)
}

/// A plan's picture, opened again.
pub struct ReopenedPicture {
    pub scene_input: SceneInput,
    pub settings: Settings,
    /// Options beside the scene.
    beside: SceneArgs,
}

impl ReopenedPicture {
    /// A file with the header of a frame, whose view the scene has.
    pub fn with_frame_header(
        &self,
        frames: &PlannedFrames,
        file: &OutputFile,
    ) -> Result<OutputFile, CliError> {
        let (name, start) = (&frames.plan().scene, frames.sequence().scene_view());
        let scene = &self.scene_input.scene;
        let named = NamedScene::of_frame(name.as_ref(), &self.beside, scene, &start);
        named.with_header(file, &self.settings)
    }
}

/// Opens a plan's picture again: its scene, and its settings, which must still be those of the
/// plan.
pub fn reopen(path: &Path, plan: &RenderPlan, threads: usize) -> Result<ReopenedPicture, CliError> {
    let asked = PlanArgs::of_words(&plan.arguments).ok_or_else(|| {
        CliError::Runtime(format!(
            "{}: its arguments are not those of phalanx plan",
            shown_path(path)
        ))
    })?;
    let scene = PathBuf::from(&plan.scene);
    refuse_special(&scene)?;
    let wanted = asked.frames.wanted(&asked.picture);
    let scene_input = SceneInput::load(&scene, &asked.beside, wanted, threads)?;
    let settings = asked.picture.settings(&scene_input.scene);
    let now = RenderKey::of(&scene_input.scene, &settings);
    if plan.picture != now {
        let differences = plan.picture.differences(&now);
        let differences: Vec<String> = differences.iter().map(KeyDifference::to_string).collect();
        return Err(other_picture(path, &differences.join(", ")));
    }
    if let Some(sequence) = &plan.sequence {
        check_camera(path, sequence, &scene_input.scene)?;
    }
    Ok(ReopenedPicture {
        scene_input,
        settings,
        beside: asked.beside,
    })
}

/// Refuses a camera's path that is no longer the plan's. The plan's own key frames are rendered;
/// the file that they came from need not be there.
fn check_camera(path: &Path, sequence: &SequencePlan, scene: &Scene) -> Result<(), CliError> {
    if sequence.scene_view() != scene.view {
        return Err(other_picture(path, "the scene's view has changed"));
    }
    let Some(file) = sequence.keyframes().map(Path::new) else {
        return Ok(());
    };
    // Where others see the plan's folder alone, or where it was a pipe, nothing can have changed.
    if !file.is_file() {
        return Ok(());
    }
    let now = match read_keys(file, scene) {
        Ok(keys) => PlannedCamera::new(&CameraPath::Keys(keys), file.display().to_string()),
        Err(CliError::Runtime(_)) => return Ok(()),
        Err(_) => PlannedCamera::Turntable { frames: 1 },
    };
    match now == sequence.camera {
        true => Ok(()),
        false => {
            let changed = format!("the key frames in {} have changed", shown_path(file));
            Err(other_picture(path, &changed))
        }
    }
}

/// Error for a plan whose picture is not the one that its scene gives now.
fn other_picture(path: &Path, differences: &str) -> CliError {
    CliError::Usage(format!(
        "{}: the plan is of another picture: {differences}; make the plan again",
        shown_path(path)
    ))
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
        (
            plan.picture.window(),
            (plan.picture.width, plan.picture.height),
        ),
        (plan.aovs(), plan.picture.origin),
    )?;
    set_header(&mut output, plan.header.clone());
    Ok(output)
}
