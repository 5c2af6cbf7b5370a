//! Options for building the BVH, and for the threads and kernels that trace it.

use super::parsers::{described_name_parser, name_parser};
use crate::cli::output;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, value_parser};
use phalanx::frame::{BuildSettings, CoreAffinity, Engine, Kernel, Quality, Settings};
use phalanx::jobs::spec::headings::MACHINE;
use phalanx::jobs::spec::parse_number;
use phalanx::thread_count;

/// Options for building the packet engine's BVH.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = MACHINE)]
pub struct TreeArgs {
    /// BVH quality: fast, medium (default) or best
    ///
    /// Better BVHs take longer to build and less time to trace. The picture does not depend on this
    /// option.
    #[arg(long, value_name = "NAME", hide_possible_values = true, value_parser = name_parser(&Quality::ALL))]
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

/// Options for dividing the picture into tiles.
#[derive(Debug, Args)]
#[command(next_help_heading = MACHINE)]
pub struct TileArgs {
    /// Tile size in pixels [default: 32]
    ///
    /// Side of the tiles that threads render: 8 to 1024, rounded up to a multiple of 8. The picture
    /// does not depend on this option.
    #[arg(long, value_name = "N", hide_short_help = true, value_parser = value_parser!(u32).range(8..=1024))]
    pub tile: Option<u32>,
}

impl TileArgs {
    /// Settings with these tiles applied.
    pub fn apply(&self, settings: Settings) -> Settings {
        let tile = self.tile.unwrap_or(settings.tile);
        Settings { tile, ..settings }
    }
}

/// Names of `--pin`.
const PINS: &[(&str, &str, CoreAffinity)] = &[
    ("none", "Left to the system", CoreAffinity::None),
    ("cores", "One core per thread", CoreAffinity::Cores),
];

/// Names of `--engine`.
const ENGINES: &[(&str, &str, Engine)] = &[
    ("simd", "SIMD packet engine", Engine::Simd),
    (
        "scalar",
        "Scalar reference engine (the oracle)",
        Engine::Scalar,
    ),
];

/// Threads, engine and kernel.
#[derive(Debug, Args)]
#[command(next_help_heading = MACHINE)]
pub struct WorkArgs {
    /// Number of threads [default: one per available CPU]
    #[arg(long, value_name = "N", value_parser = parse_thread_count)]
    pub threads: Option<usize>,
    /// Pin threads to cores [default: cores if there is a thread for each, else none]
    #[arg(long, value_name = "MODE", hide_short_help = true, value_parser = described_name_parser(PINS))]
    pub pin: Option<CoreAffinity>,
    /// Rendering engine; both produce the same bits
    #[arg(long, hide_short_help = true, default_value = "simd", value_parser = described_name_parser(ENGINES))]
    pub engine: Engine,
    /// Traversal kernel of the simd engine
    #[arg(long, value_name = "NAME", hide_short_help = true, default_value = "auto", value_parser = name_parser(&Kernel::ALL))]
    pub kernel: Kernel,
}

impl WorkArgs {
    /// Settings with these options applied.
    pub fn apply(&self, settings: Settings) -> Settings {
        // CPUs in the affinity mask of the process, not of the machine.
        let available = thread_count(0);
        let threads = self.threads.unwrap_or(available);
        if threads > available {
            output::note(&format!(
                "--threads {threads} is more than the {available} CPUs available to this process; threads will share them"
            ));
        }
        // With fewer workers than cores, several runs side by side would all be pinned to the first
        // cores.
        let pin = match self.pin {
            Some(pin) => pin,
            None if threads >= available => CoreAffinity::Cores,
            None => CoreAffinity::None,
        };
        Settings {
            threads,
            pin,
            engine: self.engine,
            kernel: self.kernel,
            ..settings
        }
    }
}

/// One kernel, or all of them.
#[derive(Clone, Debug)]
pub struct KernelSet(pub Vec<Kernel>);

pub fn kernels_parser() -> impl TypedValueParser<Value = KernelSet> {
    PossibleValuesParser::new(Kernel::ALL.map(|(name, _)| name).into_iter().chain(["all"])).map(
        |name| {
            let meant = Kernel::ALL
                .iter()
                .filter(|(n, _)| *n == name || name == "all");
            KernelSet(meant.map(|(_, kernel)| *kernel).collect())
        },
    )
}

/// Maximum number of threads; a larger one is a typing error.
const MAX_THREADS: usize = 4096;

pub fn parse_thread_count(text: &str) -> Result<usize, String> {
    let good = |count: &usize| (1..=MAX_THREADS).contains(count);
    let expected = format!("a number of threads from 1 to {MAX_THREADS}");
    parse_number(text, good, expected)
}
