//! The options that say how a scene's tree is built, and who traces it.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use phalanx::frame::{BuildSettings, CoreAffinity, Engine, Kernel, Quality, Settings};

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
