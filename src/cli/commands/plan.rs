//! `phalanx plan`: splits a picture or a sequence into shards for several machines.

use crate::cli::options::{
    FrameArgs, LONG_RENDERS, OUTPUT, SceneArgs, SceneInput, Sequence, TileArgs, WantedPicture,
    exposure_row, name_parser, picture_file, read_keys, resolve_exposure,
};
use crate::cli::output::{
    self, CliError, Output, OutputFile, absolute_path, format_of, interrupt, lines,
};
use clap::{Args, value_parser};
use phalanx::files::{quoted_text, shell_path, shown_path};
use phalanx::formats::{DefaultLights, EnvironmentSource};
use phalanx::frame::Settings;
use phalanx::image::ImageFormat;
use phalanx::jobs::spec::AsText;
use phalanx::jobs::{
    EncodingSpec, ExposureSpec, KeyDifference, MAX_SHARDS, PixelSpec, PlannedCamera, PlannedFrames,
    PlannedWork, RenderKey, RenderPlan, SequencePlan, ShardBy, kept_output,
};
use phalanx::open::standard_name;
use phalanx::scene::{CameraPath, Scene, View};
use serde::Serialize;
use std::io;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct PlanArgs {
    #[arg(help = "Scene file, cache (.phx), or standard:NAME[:SIZE]")]
    pub scene: PathBuf,
    /// Number of shards
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_SHARDS)))]
    pub shards: u32,
    /// Picture that the shards are merged into
    ///
    /// The extension gives the format. If the picture is outside the plan's folder, merge needs -o
    /// again. With --shard-by frame, it must be inside, because the shards write the frames
    /// themselves.
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT, display_order = 0)]
    pub output: PathBuf,
    /// Plan to write; shards are stored next to it
    #[arg(long, value_name = "PLAN", help_heading = OUTPUT, display_order = 1)]
    pub plan: PathBuf,
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Split by frame (default) or by tile
    ///
    /// frame assigns whole frames to the shards in turn; tile splits each frame into tiles, for a
    /// few frames that take long.
    #[arg(long, value_name = "BY", hide_possible_values = true, help_heading = LONG_RENDERS, value_parser = name_parser(&ShardBy::ALL), requires = "path")]
    pub shard_by: Option<ShardBy>,
    #[command(flatten)]
    pub pixels: PixelSpec,
    #[command(flatten)]
    pub encoding: EncodingSpec,
    #[command(flatten)]
    pub tiles: TileArgs,
    #[command(flatten)]
    pub scene_args: SceneArgs,
    /// Print the report as JSON
    #[arg(long, help_heading = OUTPUT, display_order = 900)]
    pub json: bool,
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
    shard_by: Option<ShardBy>,
    /// The exposure in stops; `None` for 0.
    exposure: Option<ExposureSpec>,
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
            "a plan cannot use stdin or stdout, because its shards run later: give file names"
                .to_owned(),
        ));
    }
    args.scene_args.no_picture()?;
    let format = format_of(&args.output, None, "--output")?;
    text(&args.plan)?;
    output::check_place(&args.plan, Some("--plan"))?;
    output::check_place(&args.output, args.frames.origin("--output"))?;
    interrupt::listen()?;
    refuse_special(&args.scene)?;
    let picture = args.frames.wanted(&args.pixels);
    let mut scene_input = SceneInput::load(&args.scene, &args.scene_args, picture, 0)?;
    let settings = args.pixels.settings(&scene_input.scene);
    let region = args.pixels.check_region(&settings);
    region.map_err(CliError::Usage)?;
    let name = match standard_name(&args.scene) {
        Some(name) => name.to_owned(),
        None => text(&absolute_path(&args.scene)?)?,
    };
    let mut spec = (args.scene_args).picture(name, &args.pixels, &args.encoding)?;
    if let Some(AsText(EnvironmentSource::File(path))) = &mut spec.overrides.environment {
        *path = absolute_path(path)?;
    }
    let output = text(&absolute_path(&args.output)?)?;
    let target = picture_file(output.into(), format, &spec, &scene_input.scene)?;
    let sequence = args.frames.sequence(&scene_input.scene)?;
    let (encoding, path) = (&mut spec.encoding, sequence.as_ref());
    resolve_exposure(encoding, &mut scene_input, path, None, &settings)?;
    let scene = &scene_input.scene;
    let spec = spec.resolve(scene);
    let header = spec.header(scene, false);
    let output = kept_output(&args.plan, &args.output)
        .map_err(|e| CliError::not_located(&args.output, e))?;
    let key = RenderKey::of(scene, &settings);
    let mut plan = RenderPlan::new(spec, key, output, args.shards);
    plan.header = header;
    plan.work = PlannedWork {
        tile: args.tiles.tile,
        max_memory: args.scene_args.max_memory,
    };
    let sequence = sequence.map(|sequence| sequence_plan(args, &sequence, scene));
    plan.sequence = sequence.transpose()?;
    plan.check()
        .map_err(|error| CliError::Usage(format!("the plan's {error}")))?;
    if plan.sequence.is_some() {
        check_frames(args, &PlannedFrames::of(&plan))?;
    }
    interrupt::write_file(&args.plan, |out| {
        serde_json::to_writer_pretty(out, &plan).map_err(io::Error::other)
    })?;
    print_plan(args, &plan, &target.path)
}

/// The sequence given by the arguments, in the form that the plan stores.
fn sequence_plan(
    args: &PlanArgs,
    sequence: &Sequence,
    scene: &Scene,
) -> Result<SequencePlan, CliError> {
    args.frames.note_camera(&args.scene_args);
    let file = args.frames.keyframes.as_deref();
    let file = file.map(|file| text(&absolute_path(file)?)).transpose()?;
    Ok(SequencePlan {
        frames: [*sequence.frames.start(), *sequence.frames.end()],
        shard_by: args.shard_by.unwrap_or(ShardBy::Frame),
        view: scene.view,
        camera: PlannedCamera::new(&sequence.path, file.unwrap_or_default()),
    })
}

/// Refuses frames without a valid view, and frame names that cannot be written.
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

/// Path of a frame that a shard writes, for the plan in the file `path`.
pub fn frame_path(frames: &PlannedFrames, path: &Path, frame: u32) -> Result<PathBuf, CliError> {
    frames.picture_path(path, frame).map_err(|error| {
        CliError::Usage(format!(
            "{error}; shards of whole frames write only there: plan them with such a name, or use --shard-by tile"
        ))
    })
}

/// Refuses a scene that cannot be read more than once.
fn refuse_special(scene: &Path) -> Result<(), CliError> {
    let file = standard_name(scene).is_none();
    match std::fs::metadata(scene) {
        Ok(metadata) if file && !metadata.is_file() && !metadata.is_dir() => {
            Err(CliError::Usage(format!(
                "{} is not a regular file, but every shard must read the scene again",
                shown_path(scene)
            )))
        }
        _ => Ok(()),
    }
}

fn print_plan(args: &PlanArgs, plan: &RenderPlan, picture: &Path) -> Result<(), CliError> {
    let array = format!("0-{}", plan.shards - 1);
    let mut merge = format!("phalanx merge {}", shell_path(&args.plan));
    let by_frame = PlannedFrames::of(plan).is_by_frame();
    if !by_frame && plan.picture_path(&args.plan).is_err() {
        let picture = shown_path(&args.output);
        output::note(&format!(
            "{picture} lies outside the plan's folder: pass -o to the merge, too"
        ));
        merge.push_str(&format!(" -o {}", shell_path(&args.output)));
    }
    let document = PlanDocument {
        plan: &args.plan,
        shards: plan.shards,
        tile: plan.tile,
        output: picture,
        scene_hash: &plan.stamp.scene,
        frames: plan.sequence.as_ref().map(|sequence| sequence.frames),
        shard_by: (plan.sequence.as_ref()).map(|sequence| sequence.shard_by),
        exposure: plan.spec.encoding.exposure,
        array,
        merge,
    };
    output::print_output(&document, args.json)
}

impl Output for PlanDocument<'_> {
    fn table(&self) -> String {
        let render = format!(
            "phalanx render --plan {} --shard I, I from {}",
            shell_path(self.plan),
            self.array
        );
        let path = shown_path(self.plan);
        let mut rows = vec![("plan", format!("{path}, {} shards", self.shards))];
        if let Some([first, last]) = self.frames {
            let shard = match self.shard_by {
                Some(ShardBy::Tile) => "each shard renders tiles of every frame".to_owned(),
                _ => format!("each shard renders every {}", ordinal(self.shards)),
            };
            rows.push(("frames", format!("{first} to {last}, {shard}")));
        }
        rows.extend(exposure_row(self.exposure));
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

/// A name in the form used by plans and by scripts that render them.
fn text(path: &Path) -> Result<String, CliError> {
    text_for("a plan", path)
}

/// A word for use in a plan or a script (`file`). Control characters are refused.
pub fn text_for(file: &str, word: &Path) -> Result<String, CliError> {
    match word.to_str() {
        Some(text) if !text.contains(char::is_control) => Ok(text.to_owned()),
        _ => Err(CliError::Usage(format!(
            "{} cannot be used in {file}: it has control characters, or is not valid UTF-8; rename it",
            quoted_text(&word.to_string_lossy())
        ))),
    }
}

/// Reads a plan. No output may replace it or its scene.
pub fn read(path: &Path) -> Result<RenderPlan, CliError> {
    output::reads("the plan", path)?;
    let plan = RenderPlan::read(path)?;
    SceneInput::note_all([&plan.spec.scene])?;
    Ok(plan)
}

/// A plan's picture, opened again.
pub struct ReopenedPicture {
    pub scene_input: SceneInput,
    pub settings: Settings,
    /// The scene's own view.
    start: View,
    lights: DefaultLights,
}

impl ReopenedPicture {
    /// Sets the camera of a frame.
    pub fn set_frame(&mut self, frames: &PlannedFrames, frame: u32) -> Result<(), CliError> {
        let view = frames.view(frame)?.unwrap_or(self.start);
        self.lights.move_camera(&mut self.scene_input.scene, view);
        Ok(())
    }

    /// A file with the header of the current frame.
    pub fn with_frame_header(&self, plan: &RenderPlan, file: &OutputFile) -> OutputFile {
        let scene = &self.scene_input.scene;
        let is_moved = scene.view != self.start || scene.defaulted.view;
        file.with_header(plan.spec.header(scene, is_moved))
    }
}

/// Reopens a plan's picture: its scene, which must not have changed, and its settings.
pub fn reopen(path: &Path, plan: &RenderPlan, threads: usize) -> Result<ReopenedPicture, CliError> {
    let scene = PathBuf::from(&plan.spec.scene);
    refuse_special(&scene)?;
    let camera = plan.sequence.as_ref().map(|sequence| &sequence.camera);
    let picture = WantedPicture {
        size: plan.spec.pixels.size,
        turntable: matches!(camera, Some(PlannedCamera::Turntable { .. })),
    };
    let scene_input = SceneInput::load(&scene, &SceneArgs::of_plan(plan), picture, threads)?;
    let tiles = TileArgs {
        tile: plan.work.tile,
    };
    let settings = tiles.apply(plan.spec.pixels.settings(&scene_input.scene));
    let (planned, now) = (plan.key(), RenderKey::of(&scene_input.scene, &settings));
    if planned != now {
        let differences = planned.differences(&now);
        let differences: Vec<String> = differences.iter().map(KeyDifference::to_string).collect();
        return Err(other_picture(path, &differences.join(", ")));
    }
    if let Some(sequence) = &plan.sequence {
        check_camera(path, sequence, &scene_input.scene)?;
    }
    let start = scene_input.scene.view;
    let lights = DefaultLights::of(&scene_input.scene, threads);
    Ok(ReopenedPicture {
        scene_input,
        settings,
        start,
        lights,
    })
}

/// Refuses a camera path that differs from the plan's. The plan stores its key frames; their file
/// need not exist any more.
fn check_camera(path: &Path, sequence: &SequencePlan, scene: &Scene) -> Result<(), CliError> {
    if sequence.view != scene.view {
        return Err(other_picture(path, "the scene's camera has changed"));
    }
    let Some(file) = sequence.keyframes().map(Path::new) else {
        return Ok(());
    };
    // Without the file (on another machine, or if it was a pipe), nothing can have changed.
    if !file.is_file() {
        return Ok(());
    }
    let now = match read_keys(file, scene) {
        Ok(keys) => PlannedCamera::new(&CameraPath::Keys(keys), file.display().to_string()),
        Err(CliError::Runtime(_)) => return Ok(()),
        Err(_) => PlannedCamera::Turntable { frames: 1 },
    };
    if now == sequence.camera {
        Ok(())
    } else {
        let changed = format!("the key frames in {} have changed", shown_path(file));
        Err(other_picture(path, &changed))
    }
}

/// Error for a plan whose scene has changed.
fn other_picture(path: &Path, differences: &str) -> CliError {
    CliError::Usage(format!(
        "{}: the plan is for another picture: {differences}; make the plan again",
        shown_path(path)
    ))
}

/// The file of this name for a plan's picture.
pub fn target(
    plan: &RenderPlan,
    path: PathBuf,
    format: ImageFormat,
) -> Result<OutputFile, CliError> {
    let output = OutputFile::for_picture(path, format, &plan.spec, plan.stamp.origin)?;
    Ok(output.with_header(plan.header.clone()))
}
