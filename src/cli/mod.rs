//! The command line: arguments, and one file per subcommand. It uses only the library's public API.
//!
//! Results go to stdout; progress, warnings and errors go to stderr. The exit codes are in
//! [`error`].

#[allow(
    rustdoc::broken_intra_doc_links,
    reason = "help texts have brackets of their own"
)]
mod args;
mod bench;
mod budget;
mod build;
#[allow(unsafe_code, reason = "a signal handler has no safe name")]
mod bus_error;
mod compare;
mod diagnose;
mod error;
mod file_coordinates;
mod format_args;
mod frames;
mod generate;
#[allow(unsafe_code, reason = "the allocator's settings have no safe name")]
mod heap;
mod heatmap;
mod info;
mod interrupt;
#[allow(
    rustdoc::broken_intra_doc_links,
    reason = "help texts have brackets of their own"
)]
mod job_args;
mod live_preview;
mod manual;
mod memory_stats;
mod merge;
mod output;
mod output_file;
mod picture_args;
mod pixel_diff;
mod pixel_hashes;
mod plan;
mod preview;
mod progress;
mod render;
mod render_report;
mod render_summary;
mod scene_args;
mod scene_input;
mod scenes;
mod shard;
mod shard_index;
mod stats;
mod submit;
mod verify;

use args::{Arguments, Command};
use clap::Parser;
use job_args::SubmitTo;
use std::ffi::OsString;
use std::process::ExitCode;

/// Runs the command of the arguments. Not inlined into `main`, which must contain no instructions
/// that the guard checks for.
#[inline(never)]
pub fn run() -> ExitCode {
    // On a usage error, and after --help and --version, this ends the process: 2, and 0.
    let arguments = Arguments::try_parse().unwrap_or_else(|error| refuse(&error));
    let done = match arguments.command {
        Command::Render(args) => render::run(&args),
        Command::Verify(args) => verify::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Scenes(args) => scenes::run(&args),
        Command::Generate(args) => generate::run(&args),
        Command::Build(args) => build::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Plan(args) => plan::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Completions(args) => manual::completions(&args),
        Command::Man(args) => manual::man(&args),
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

/// Ends the process with clap's message, without colours if an argument could contain its own.
fn refuse(error: &clap::Error) -> ! {
    let steers = |text: OsString| text.to_string_lossy().contains(char::is_control);
    if error.use_stderr() && std::env::args_os().any(steers) {
        output::note(error.render().to_string().trim_end());
        std::process::exit(error.exit_code());
    }
    error.exit()
}

/// Prints a line on stderr if this build leaves instructions of this CPU unused.
fn advise() {
    if let Some(advice) = phalanx::isa::advice() {
        output::note(&format!("note: {advice}"));
    }
}
