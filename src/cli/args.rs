//! The arguments, and their conversion to the library's types.

use super::bench::BenchArgs;
use super::frames::FrameArgs;
use super::job_args::{KeepArgs, MergeArgs, PlanArgs, SubmitTo};
use super::live_preview::SightArgs;
use super::manual::{CompletionsArgs, ManArgs};
use super::output_file::GradeArgs;
use super::picture_args::PictureArgs;
use super::progress::ProgressMode;
use super::scene_args::SceneArgs;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum, value_parser};
use phalanx::frame::{BuildSettings, CoreAffinity, Engine, Kernel, Quality, Settings};
use phalanx::isa;
use std::path::PathBuf;
use std::sync::LazyLock;

/// Version and the instruction-set level compiled for.
static VERSION: LazyLock<String> =
    LazyLock::new(|| format!("{} ({})", env!("CARGO_PKG_VERSION"), isa::compiled_level()));

/// A SIMD packet ray tracer: renders scene files, and proves its pictures bit by bit.
#[derive(Debug, Parser)]
#[command(
    name = "phalanx",
    version = VERSION.as_str(),
    arg_required_else_help = true,
    max_term_width = 100,
    after_help = "Exit codes: 0 done, 1 files or runtime, 2 usage, 3 scene error, 4 mismatch, 5 slower,\n\
                  6 shards missing, 130 and 143 interrupted.\n\n\
                  Example: phalanx render scenes/first.test -o first.png"
)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to a picture
    #[command(
        after_help = "Mrays/s of a kind are the rays of that kind divided by the wall seconds of the whole render, \
                      so that the kinds add up to the total.\n\n\
                      Example: phalanx render scene.test -o picture.png --size 1280x960 --threads 4"
    )]
    Render(RenderArgs),
    /// Render with both engines and compare every bit
    #[command(
        after_help = "Example: phalanx verify scene1.test scene2.test --threads 1,2,3 --kernel all"
    )]
    Verify(VerifyArgs),
    /// Cut a picture into shards, which many machines render
    #[command(
        after_help = "Every machine has to see the scene and the plan's folder under the same names.\n\n\
                      Example: phalanx plan scene.test --shards 8 -o poster.png --plan poster.json --size 40000x30000"
    )]
    Plan(PlanArgs),
    /// Hand a plan to a scheduler
    #[command(subcommand, after_help = "Example: phalanx submit slurm poster.json")]
    Submit(SubmitTo),
    /// Put the shards of a plan together
    #[command(
        after_help = "The picture is that of phalanx render to the last byte. Exit code 6 if there are shards missing, which are named.\n\n\
                      Example: phalanx merge poster.json"
    )]
    Merge(MergeArgs),
    /// Compare two PNG pictures
    #[command(after_help = "Example: phalanx compare before.png after.png --heat difference.png")]
    Compare(CompareArgs),
    /// Tell what is in a scene
    #[command(after_help = "Example: phalanx info scene.test --json")]
    Info(InfoArgs),
    /// List the standard scenes, which need no file
    #[command(
        after_help = "Example: phalanx scenes\n\nThen, for one of them: phalanx render standard:terrain:2M"
    )]
    Scenes(ScenesArgs),
    /// Write a standard scene to a file
    #[command(after_help = "Example: phalanx generate terrain --size 2M -o terrain.ply")]
    Generate(GenerateArgs),
    /// Store a scene and its tree in a cache, which opens at once
    #[command(
        after_help = "A cache takes the place of the scene file in every command. It belongs to the version of phalanx \
                      that wrote it, and is taken not to change while it is in use.\n\n\
                      Example: phalanx build dragon.ply -o dragon.phx --quality best"
    )]
    Build(BuildArgs),
    /// Measure rays per second, beside other tracers, for the right answers only
    #[command(
        after_help = "Rays of every kind but primary start where the primary rays hit, whatever the material there; see perf/README.md. \
                      An answer that differs from the oracle's, or from the suite's, ends the run with exit code 4; a regression \
                      beyond --fail-above with 5.\n\n\
                      Example: phalanx bench --quick --against embree --html report.html"
    )]
    Bench(Box<BenchArgs>),
    /// Print a script with which a shell completes arguments
    #[command(
        after_help = "Example: phalanx completions bash > ~/.local/share/bash-completion/completions/phalanx"
    )]
    Completions(CompletionsArgs),
    /// Print the manual's page, or write those of all commands
    #[command(after_help = "Example: phalanx man | man -l -")]
    Man(ManArgs),
}

/// How the packet engine's tree is built.
#[derive(Debug, Args)]
pub struct TreeArgs {
    /// BVH quality: better trees take longer to build and less time to trace
    /// [default: medium]
    #[arg(long, value_name = "NAME", value_parser = quality_parser())]
    pub quality: Option<Quality>,
}

impl TreeArgs {
    /// Build settings on `threads` threads; 0 for one per CPU.
    pub fn settings(&self, threads: usize) -> BuildSettings {
        BuildSettings {
            quality: self.quality.unwrap_or_default(),
            threads,
        }
    }
}

#[derive(Debug, Args)]
pub struct BuildArgs {
    /// Scene file, standard:NAME[:SIZE], or - for stdin
    pub scene: PathBuf,
    /// Cache to write
    #[arg(short, long, value_name = "OUT.phx")]
    pub output: PathBuf,
    #[command(flatten)]
    pub beside: SceneArgs,
    #[command(flatten)]
    pub tree: TreeArgs,
    /// Threads that read and build [default: one per CPU this process may use]
    #[arg(long, value_name = "N", value_parser = parse_thread_count)]
    pub threads: Option<usize>,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct RenderArgs {
    /// Scene file, cache (.phx), standard:NAME[:SIZE], or - for stdin (see --format)
    #[arg(required_unless_present = "plan")]
    pub scene: Option<PathBuf>,
    /// Picture to write, a PNG, JPEG, OpenEXR, Radiance HDR or PFM file by its ending, or - for
    /// stdout (a PNG, if --format does not say otherwise; the table then goes to stderr) [default:
    /// the scene's `output`, else its stem + .png, in the current folder]
    #[arg(short, long, value_name = "OUT.png")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub grade: GradeArgs,
    #[command(flatten)]
    pub beside: SceneArgs,
    #[command(flatten)]
    pub tree: TreeArgs,
    #[command(flatten)]
    pub work: WorkArgs,
    #[command(flatten)]
    pub keep: KeepArgs,
    #[command(flatten)]
    pub frames: FrameArgs,
    #[command(flatten)]
    pub sight: SightArgs,
    /// How progress is told
    #[arg(long, value_enum, value_name = "MODE", default_value_t = ProgressMode::Auto)]
    pub progress: ProgressMode,
    /// Write a second picture, of what each pixel's camera ray costs to trace: nodes (visited),
    /// prims (tested), or time
    #[arg(long, num_args = 2, value_names = ["nodes|prims|time", "OUT.png"], conflicts_with = "frames")]
    pub heat: Option<Vec<String>>,
    /// Print one JSON document instead of the table
    #[arg(long)]
    pub json: bool,
}

/// Who does the work.
#[derive(Debug, Args)]
pub struct WorkArgs {
    /// Worker threads [default: one per CPU this process may use]
    #[arg(long, value_name = "N", value_parser = parse_thread_count)]
    pub threads: Option<usize>,
    /// Bind workers to cores [default: cores if there is a worker for each, else none]
    #[arg(long, value_enum, value_name = "MODE")]
    pub pin: Option<PinArg>,
    /// Which tracer makes the picture; both give the same bits
    #[arg(long, value_enum, default_value_t = EngineArg::Simd)]
    pub engine: EngineArg,
    /// Traversal kernel of the packet engine
    #[arg(long, value_name = "NAME", default_value = "auto", value_parser = kernel_parser())]
    pub kernel: Kernel,
}

impl WorkArgs {
    /// Settings with these workers.
    pub fn apply(&self, settings: Settings) -> Settings {
        // Number of CPUs of the process's affinity mask, not of the machine.
        let available = std::thread::available_parallelism().map_or(1, |n| n.get());
        let threads = self.threads.unwrap_or(available);
        // With fewer workers than cores, several runs side by side would all be pinned to the first
        // cores.
        let pin = match self.pin {
            Some(pin) => pin.into(),
            None if threads >= available => CoreAffinity::Cores,
            None => CoreAffinity::None,
        };
        Settings {
            threads,
            pin,
            engine: self.engine.into(),
            kernel: self.kernel,
            ..settings
        }
    }
}

#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// Scene files, caches (.phx), standard:NAME[:SIZE], or - for stdin
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub beside: SceneArgs,
    #[command(flatten)]
    pub tree: TreeArgs,
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Thread counts to render with, separated by commas
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "1,2,3", value_parser = parse_thread_count)]
    pub threads: Vec<usize>,
    /// Traversal kernel of the packet engine, or all of them in turn
    #[arg(long, value_name = "NAME", default_value = "auto", value_parser = kernels_parser())]
    pub kernel: KernelSet,
    /// Keep per-pixel hashes of hits and radiance in this file
    #[arg(long, value_name = "FILE", conflicts_with = "frames")]
    pub record: Option<PathBuf>,
    /// Compare with the hashes kept in this file
    #[arg(long, value_name = "FILE", conflicts_with = "frames")]
    pub against: Option<PathBuf>,
    /// How progress is told
    #[arg(long, value_enum, value_name = "MODE", default_value_t = ProgressMode::Auto)]
    pub progress: ProgressMode,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// First picture
    pub a: PathBuf,
    /// Second picture
    pub b: PathBuf,
    /// Write a picture of the differences: black where equal, then red, yellow, white
    #[arg(long, value_name = "OUT.png")]
    pub heat: Option<PathBuf>,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Scene file, cache (.phx), standard:NAME[:SIZE], or - for stdin
    pub scene: PathBuf,
    #[command(flatten)]
    pub beside: SceneArgs,
    #[command(flatten)]
    pub tree: TreeArgs,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct ScenesArgs {
    /// Print one JSON document instead of the table
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct GenerateArgs {
    /// Name of a standard scene, as `phalanx scenes` lists them
    pub name: String,
    /// Its size, a whole number; k and M may follow for thousands and millions
    /// [default: the scene's]
    #[arg(long, value_name = "N")]
    pub size: Option<String>,
    /// File to write: .nff, .ply (binary) or .test
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Make spheres and cones of triangles first: 12 N² for a sphere, 8 N for a cone
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=1000))]
    pub tessellate: Option<u32>,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum PinArg {
    /// The system places them
    None,
    /// One core each
    Cores,
}

impl From<PinArg> for CoreAffinity {
    fn from(pin: PinArg) -> CoreAffinity {
        match pin {
            PinArg::None => CoreAffinity::None,
            PinArg::Cores => CoreAffinity::Cores,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum EngineArg {
    /// Eight-wide packets
    Simd,
    /// The scalar oracle
    Scalar,
}

impl From<EngineArg> for Engine {
    fn from(engine: EngineArg) -> Engine {
        match engine {
            EngineArg::Simd => Engine::Simd,
            EngineArg::Scalar => Engine::Scalar,
        }
    }
}

/// One kernel, or all of them.
#[derive(Clone, Debug)]
pub struct KernelSet(pub Vec<(&'static str, Kernel)>);

fn kernel_names() -> impl Iterator<Item = &'static str> {
    Kernel::ALL.iter().map(|(name, _)| *name)
}

fn kernel_parser() -> impl TypedValueParser<Value = Kernel> {
    PossibleValuesParser::new(kernel_names()).map(|name| {
        let named = Kernel::ALL.iter().find(|(n, _)| *n == name);
        named.map_or(Kernel::Auto, |(_, kernel)| *kernel)
    })
}

pub fn kernels_parser() -> impl TypedValueParser<Value = KernelSet> {
    PossibleValuesParser::new(kernel_names().chain(["all"])).map(|name| {
        let meant = Kernel::ALL
            .iter()
            .filter(|(n, _)| *n == name || name == "all");
        KernelSet(meant.copied().collect())
    })
}

pub fn quality_parser() -> impl TypedValueParser<Value = Quality> {
    PossibleValuesParser::new(Quality::ALL.map(|(name, _)| name)).map(|name| {
        let named = Quality::ALL.iter().find(|(n, _)| *n == name);
        named.map_or_else(Quality::default, |(_, quality)| *quality)
    })
}

/// Most worker threads: a larger number is a typing error.
const MAX_THREADS: usize = 4096;

pub fn parse_thread_count(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|n| (1..=MAX_THREADS).contains(n));
    count.ok_or_else(|| format!("expected a number of threads from 1 to {MAX_THREADS}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn kernels_are_those_of_the_library() {
        for (name, kernel) in Kernel::ALL {
            let line = ["phalanx", "render", "a.test", "--kernel", name];
            match Arguments::try_parse_from(line).unwrap().command {
                Command::Render(args) => assert_eq!(args.work.kernel, kernel),
                other => panic!("{other:?}"),
            }
            assert_eq!(kernel.name(), name);
        }
        let line = ["phalanx", "verify", "a.test", "--kernel", "all"];
        match Arguments::try_parse_from(line).unwrap().command {
            Command::Verify(args) => assert_eq!(args.kernel.0, Kernel::ALL),
            other => panic!("{other:?}"),
        }
    }
}
