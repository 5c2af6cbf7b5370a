//! Arguments of `phalanx bench`.

use crate::cli::options::{
    KernelSet, SceneArgs, kernels_parser, name_parser, parse_number, parse_size, parse_thread_count,
};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand, ValueEnum};
use phalanx::bench::RayKind;
use phalanx::bvh::Quality;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct BenchArgs {
    #[command(subcommand)]
    pub command: Option<BenchCommand>,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// Show several records side by side
    Compare {
        /// Records that `phalanx bench --json` wrote; rates are relative to the first
        #[arg(required = true, num_args = 2.., value_name = "RECORD.json")]
        records: Vec<PathBuf>,
    },
}

#[derive(Debug, Args)]
pub struct RunArgs {
    #[arg(
        value_name = "SCENE",
        help = "Scene files, caches (.phx), standard:NAME[:SIZE], or - for stdin [default: the standard suite]"
    )]
    pub scenes: Vec<PathBuf>,
    /// Two minutes: six scenes of the suite
    #[arg(long)]
    pub quick: bool,
    /// Only scenes of the suite whose name contains this
    #[arg(long, value_name = "TEXT", conflicts_with = "scenes")]
    pub filter: Option<String>,
    /// Kinds of rays, separated by commas [default: all]
    #[arg(long, value_name = "KIND,…", value_delimiter = ',', value_parser = kinds_parser())]
    pub rays: Vec<MeasuredKind>,
    /// Picture size that the rays are of; frames have half its sides
    /// [default: the suite's, 512x512]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Thread counts, separated by commas; `all` is one per CPU this process may use
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_value = "1,all", value_parser = parse_threads)]
    pub threads: Vec<ThreadCount>,
    /// Samples of every row [default: the suite's, 11]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repeat: Option<u32>,
    /// Seconds that the samples of a row take together at least [default: the suite's, 0.03]
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    pub min_time: Option<f64>,
    /// Bind workers to cores even where there are fewer of them than cores
    #[arg(long)]
    pub pin: bool,
    /// Traversal kernels to measure beside `auto`
    /// [default: packets as wide as this build's; all with --counters-only]
    #[arg(long, value_name = "NAME", value_parser = kernels_parser())]
    pub kernel: Option<KernelSet>,
    /// Quality of our BVH; peers build the best that they can
    #[arg(long, value_name = "NAME", default_value = "best", value_parser = name_parser(&Quality::ALL))]
    pub quality: Quality,
    /// Other tracers to measure on the same rays, separated by commas
    #[arg(long, value_enum, value_name = "PEER,…", value_delimiter = ',')]
    pub against: Vec<PeerArg>,
    /// Embree's library, or a folder with it [default: looked for]
    #[arg(long, value_name = "PATH")]
    pub embree: Option<PathBuf>,
    /// Write the record
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the rows as comma-separated values
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write a page with charts, pictures and tables
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Write the rays, for other tracers to replay; takes one scene. Nothing is measured
    #[arg(long, value_name = "FILE")]
    pub dump_rays: Option<PathBuf>,
    /// Compare with an earlier record
    #[arg(long, value_name = "RECORD.json")]
    pub baseline: Option<PathBuf>,
    /// Exit with 5 if anything is slower than the baseline by more than this, as in 3%
    #[arg(long, value_name = "PERCENT", requires = "baseline", value_parser = parse_percent)]
    pub fail_above: Option<f64>,
    /// Compare with a baseline of another machine or instruction set, too
    #[arg(long, requires = "baseline")]
    pub force: bool,
    /// Count work and time nothing; with --baseline, compare the counts
    #[arg(long)]
    pub counters_only: bool,
    #[command(flatten)]
    pub beside: SceneArgs,
    /// Write the suite with the answers found, after a change of the scenes or of the rays
    #[arg(long, value_name = "SUITE.toml", hide = true)]
    pub update_suite: Option<PathBuf>,
}

/// A kind of measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasuredKind {
    /// A kind of rays.
    Rays(RayKind),
    /// Whole frames.
    Frame,
}

fn kinds_parser() -> impl TypedValueParser<Value = MeasuredKind> {
    PossibleValuesParser::new(RayKind::names()).map(|name| {
        let kind = RayKind::ALL.into_iter().find(|kind| kind.name() == name);
        kind.map_or(MeasuredKind::Frame, MeasuredKind::Rays)
    })
}

/// A number of threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThreadCount {
    /// Exactly this number.
    Exactly(usize),
    /// One per CPU.
    All,
}

fn parse_threads(text: &str) -> Result<ThreadCount, String> {
    match text {
        "all" => Ok(ThreadCount::All),
        _ => match parse_thread_count(text) {
            Ok(count) => Ok(ThreadCount::Exactly(count)),
            Err(error) => Err(format!("{error}, or `all`")),
        },
    }
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    let good = |seconds: &f64| (0.0..=3600.0).contains(seconds);
    parse_number(text, good, "seconds, from 0 to 3600")
}

fn parse_percent(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('%').unwrap_or(text).trim_end();
    let good = |percent: &f64| (0.0..100.0).contains(percent);
    let percent = parse_number(number, good, "a percentage from 0 to below 100, as in 3%")?;
    Ok(percent / 100.0)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PeerArg {
    /// Intel's Embree, from its shared library
    Embree,
    /// The traversal of obvhs
    Obvhs,
}

impl RunArgs {
    /// Numbers of threads, each once, ascending.
    pub fn thread_counts(&self) -> Vec<usize> {
        let all = std::thread::available_parallelism().map_or(1, |n| n.get());
        let count = |threads: &ThreadCount| match threads {
            ThreadCount::Exactly(count) => *count,
            ThreadCount::All => all,
        };
        let mut counts: Vec<usize> = self.threads.iter().map(count).collect();
        counts.sort_unstable();
        counts.dedup();
        counts
    }

    /// Kinds of rays, in the order of the list.
    pub fn kinds(&self) -> Vec<RayKind> {
        let asked =
            |kind: &RayKind| self.rays.is_empty() || self.rays.contains(&MeasuredKind::Rays(*kind));
        RayKind::ALL.into_iter().filter(asked).collect()
    }

    /// Returns true if whole frames are measured.
    pub fn frames(&self) -> bool {
        self.rays.is_empty() || self.rays.contains(&MeasuredKind::Frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentages_are_shares() {
        assert_eq!(parse_percent("3%"), Ok(0.03));
        assert_eq!(parse_percent("8"), Ok(0.08));
        for bad in ["", "%", "-1%", "100%", "three", "nan"] {
            assert!(parse_percent(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn threads_are_numbers_or_all() {
        assert_eq!(parse_threads("2"), Ok(ThreadCount::Exactly(2)));
        assert_eq!(parse_threads("all"), Ok(ThreadCount::All));
        assert!(parse_threads("0").unwrap_err().contains("`all`"));
    }
}
