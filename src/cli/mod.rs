//! The command line: the table of commands, and their dispatch. It uses only the library's public
//! API.
//!
//! Three layers: [`commands`], each with its own file or folder; [`options`], shared by several
//! commands; and [`output`], the reports and messages. Each layer uses only those after it.
//!
//! Results go to stdout; progress, warnings and errors go to stderr. The exit codes are in
//! [`output::CliError`].

mod commands;
mod options;
mod output;

use clap::builder::Styles;
use clap::{Args, CommandFactory, Parser, Subcommand};
use commands::bench::{self, BenchArgs};
use commands::build::{self, BuildArgs};
use commands::compare::{self, CompareArgs};
use commands::generate::{self, GenerateArgs};
use commands::info::{self, InfoArgs};
use commands::manual::{self, CompletionsArgs, ManArgs};
use commands::merge::{self, MergeArgs};
use commands::plan::{self, PlanArgs};
use commands::render::{self, RenderArgs};
use commands::scenes::{self, ScenesArgs};
use commands::submit::{self, SubmitTo};
use commands::verify::{self, VerifyArgs};
#[cfg(feature = "view")]
use commands::view::{self, ViewArgs};
use options::{Deferred, OUTPUT, suggest};
use output::Verbosity;
use phalanx::files::steers;
use phalanx::{isa, set_pool_threads, thread_count};
use std::ffi::OsString;
use std::process::ExitCode;
use std::sync::LazyLock;

/// Version and the instruction-set level compiled for.
static VERSION: LazyLock<String> =
    LazyLock::new(|| format!("{} ({})", env!("CARGO_PKG_VERSION"), isa::compiled_level()));

/// A SIMD packet ray tracer: renders scene files, and verifies its pictures bit by bit.
#[derive(Debug, Parser)]
#[command(
    name = "phalanx",
    version = VERSION.as_str(),
    arg_required_else_help = true,
    max_term_width = 100,
    after_help = "Exit codes: 0 success, 1 file or runtime error, 2 usage error, 3 scene error, 4 mismatch, \
                  5 slower than the baseline, 6 shards or frames missing, 129, 130 and 143 interrupted.\n\n\
                  Example (writes balls.png, needs no scene file):\n  phalanx render standard:balls"
)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub verbosity: VerbosityArgs,
}

/// Amount of output, for every command.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = OUTPUT)]
pub struct VerbosityArgs {
    /// Print only warnings and errors
    #[arg(
        short,
        long,
        global = true,
        conflicts_with = "verbose",
        display_order = 901
    )]
    quiet: bool,
    /// Print all figures: rays, BVH, memory
    #[arg(short, long, global = true, display_order = 902)]
    verbose: bool,
}

impl VerbosityArgs {
    fn verbosity(self) -> Verbosity {
        match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (false, true) => Verbosity::Verbose,
            (false, false) => Verbosity::Normal,
        }
    }
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to a picture
    #[command(
        after_help = "Example: phalanx render standard:street -o street.png --size 1280x960 --spp 4",
        after_long_help = "With --verbose, Mrays/s of a kind of ray is its count divided by the wall time of the whole render, \
                      so that the kinds add up to the total.\n\n\
                      Examples:\n  \
                      phalanx render standard:street -o street.png --size 1280x960 --spp 4\n  \
                      phalanx render dragon.ply --camera 0,.15,.4 0,.1,0 0,1,0 35 --light 1,2,2\n  \
                      phalanx render scene.test -o poster.png --size 40000x30000 --checkpoint poster.ckpt"
    )]
    Render(Deferred<RenderArgs>),
    /// Look around a scene in the browser
    #[cfg(feature = "view")]
    #[command(
        after_help = "Example: phalanx view dragon.ply --open",
        after_long_help = "Prints the address of a page on this machine, and serves it until it is interrupted. The page turns the scene, \
                      shows what lies under a pixel and what it costs, and gives the command that renders what is seen.\n\n\
                      Through ssh, forward a port first:\n  \
                      ssh -L 8000:localhost:8000 USER@HOST\n  \
                      phalanx view scene.gltf --address 127.0.0.1:8000\n\n\
                      Example: phalanx view dragon.ply --open"
    )]
    View(Deferred<ViewArgs>),
    /// Render with both engines and compare every bit
    #[command(
        after_help = "Example: phalanx verify scene1.test scene2.test --threads 1,2,3 --kernel all"
    )]
    Verify(Deferred<VerifyArgs>),
    /// Split a picture or a sequence into shards for several machines
    #[command(
        after_help = "Example: phalanx plan scene.test --shards 8 -o poster.png --plan poster.json",
        after_long_help = "Every machine must see the scene and the plan's folder at the same paths.\n\n\
                      Examples:\n  phalanx plan scene.test --shards 8 -o poster.png --plan poster.json --size 40000x30000\n  \
                      phalanx plan scene.test --shards 5 -o turn.png --plan turn.json --frames 0..119 --turntable 120"
    )]
    Plan(Deferred<PlanArgs>),
    /// Submit a plan to a scheduler
    #[command(subcommand, after_help = "Example: phalanx submit slurm poster.json")]
    Submit(SubmitTo),
    /// Merge a plan's shards, or check its frames
    #[command(
        after_help = "Example: phalanx merge poster.json",
        after_long_help = "The picture, or each frame, is byte for byte the one that phalanx render writes. If shards or frames are missing, \
                      they are listed, and the exit code is 6.\n\n\
                      Example: phalanx merge poster.json"
    )]
    Merge(Deferred<MergeArgs>),
    /// Compare two pictures (PNG, JPEG, EXR with all layers, HDR, PFM)
    #[command(
        after_help = "Example: phalanx compare a.exr b.exr --tolerance 0.05 --max-differing 5%",
        after_long_help = "The exit code is 0 if the pictures are identical, or differ within --tolerance and --max-differing; it is 4 if \
                      they differ by more, or if an EXR file lacks a layer of the other. PNG and JPEG hold display values; EXR, HDR \
                      and PFM hold linear radiance. Only formats of the same kind can be compared. HDR and PFM hold only colours; \
                      other layers of an EXR file are ignored in comparisons with them.\n\n\
                      PSNR uses a peak of 255, or the largest linear sample (at least 1). SSIM and FLIP (67 pixels per degree, 0 means \
                      equal) use the red, green and blue that a screen shows (sRGB). NaN equals only NaN, and infinity only the same \
                      infinity; both are counted, and excluded from the other figures.\n\n\
                      To try it:\n  \
                      phalanx render standard:balls -o a.exr\n  \
                      phalanx render standard:balls -o b.exr --spp 4\n\n\
                      Example: phalanx compare a.exr b.exr --tolerance 0.05 --max-differing 5% --side-by-side both.png"
    )]
    Compare(Deferred<CompareArgs>),
    /// Show what a scene contains
    #[command(after_help = "Example: phalanx info scene.test --json")]
    Info(Deferred<InfoArgs>),
    /// List the standard scenes (built in, no file needed)
    #[command(
        after_help = "Example: phalanx scenes\n\nTo render one of them: phalanx render standard:terrain:2M"
    )]
    Scenes(Deferred<ScenesArgs>),
    /// Write a standard scene to a file
    #[command(after_help = "Example: phalanx generate terrain --size 2M -o terrain.ply")]
    Generate(Deferred<GenerateArgs>),
    /// Store a scene and its BVH in a cache that opens instantly
    #[command(
        after_help = "Every command accepts a cache in place of a scene file. Only the version of phalanx that wrote a cache \
                      can open it, and it must not change while in use.\n\n\
                      Example: phalanx build dragon.ply -o dragon.phx --quality best"
    )]
    Build(Deferred<BuildArgs>),
    /// Measure rays per second, and compare with other tracers
    #[command(
        after_help = "Example: phalanx bench --quick --against embree --html report.html",
        after_long_help = "All rays but primary ones start at the primary hits, regardless of the material; see perf/README.md. \
                      The exit code is 4 if an answer differs from the oracle's or the suite's, which ends the run, and 5 after a \
                      regression beyond --fail-above.\n\n\
                      Example: phalanx bench --quick --against embree --html report.html"
    )]
    Bench(Deferred<BenchArgs>),
    /// Print a shell completion script
    #[command(
        after_help = "Example: phalanx completions bash > ~/.local/share/bash-completion/completions/phalanx"
    )]
    Completions(Deferred<CompletionsArgs>),
    /// Print the man page, or write one for every command
    #[command(after_help = "Example: phalanx man | man -l -")]
    Man(Deferred<ManArgs>),
}

/// Runs the command given by the arguments. Not inlined into `main`, which must contain no
/// instructions that the guard checks for.
#[inline(never)]
pub fn run() -> ExitCode {
    // On a usage error, and after --help and --version, this ends the process: 2, and 0.
    let arguments = Arguments::try_parse().unwrap_or_else(|error| refuse(error));
    output::set_verbosity(arguments.verbosity.verbosity());
    if let Some(threads) = arguments.command.threads() {
        // Files are encoded and checked on them.
        set_pool_threads(threads.min(thread_count(0)));
    }
    let done = match arguments.command {
        Command::Render(args) => render::run(&args),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(&args),
        Command::Verify(args) => verify::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Scenes(args) => scenes::run(&args),
        Command::Generate(args) => generate::run(&args),
        Command::Build(args) => build::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Plan(args) => plan::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Completions(args) => manual::completions(&args, Arguments::command()),
        Command::Man(args) => manual::man(&args, &Arguments::command()),
        Command::Submit(SubmitTo::Slurm(args)) => submit::slurm(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.report();
            ExitCode::from(failure.code())
        }
    }
}

impl Command {
    /// Number of threads requested for the command's work; `None` for one per CPU.
    fn threads(&self) -> Option<usize> {
        match self {
            Command::Render(args) => args.work.threads,
            #[cfg(feature = "view")]
            Command::View(args) => args.work.threads,
            Command::Build(args) => args.threads,
            Command::Generate(args) => args.threads,
            _ => None,
        }
    }
}

/// Ends the process with clap's message. If an argument contains control characters, they are
/// escaped, and the message has no colours.
fn refuse(mut error: clap::Error) -> ! {
    if !error.use_stderr() {
        // Help and version are whole as they are.
        error.exit();
    }
    let steer = |text: OsString| text.to_string_lossy().contains(steers);
    let is_plain = std::env::args_os().any(steer);
    let mut program = Arguments::command();
    if is_plain {
        program = program.styles(Styles::plain());
        error = program.clone().try_get_matches().err().unwrap_or(error);
    }
    program.build();
    let mut words = std::env::args_os().skip(1);
    let command = words.find_map(|word| program.find_subcommand(word).cloned());
    suggest(&mut error, command);
    if is_plain {
        output::message(error.render().ansi().to_string().trim_end());
        std::process::exit(error.exit_code());
    }
    error.exit()
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx::frame::Kernel;

    #[test]
    fn the_definition_is_sound() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn threads_are_those_of_the_option() {
        let threads = |line: &str| {
            let line = ["phalanx"].into_iter().chain(line.split(' '));
            Arguments::try_parse_from(line).unwrap().command.threads()
        };
        assert_eq!(threads("render a.test"), None);
        assert_eq!(threads("render a.test --threads 3"), Some(3));
        assert_eq!(threads("build a.test -o a.phx --threads 3"), Some(3));
        if cfg!(feature = "view") {
            assert_eq!(threads("view a.test --threads 3"), Some(3));
        }
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
            Command::Verify(args) => {
                assert_eq!(args.kernel.0, Kernel::ALL.map(|(_, kernel)| kernel))
            }
            other => panic!("{other:?}"),
        }
    }
}
