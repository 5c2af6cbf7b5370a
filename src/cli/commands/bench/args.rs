//! Arguments of `phalanx bench`.

use crate::cli::options::{
    KernelSet, OUTPUT, SceneArgs, kernels_parser, name_parser, parse_number, parse_size,
    parse_thread_count,
};
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand, ValueEnum};
use phalanx::bench::{FRAME, RayKind};
use phalanx::bvh::Quality;
use regex_lite::Regex;
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
    /// Compare records: ranks, geometric means, and the rates that differ
    #[command(
        after_help = "Example: phalanx bench compare perf/records/*-quick.json --filter 'primary|frame'"
    )]
    Compare(RecordCompareArgs),
    /// Make a page of records that were saved before
    #[command(
        name = "report",
        after_help = "One record gets the page that bench --html writes. Several are shown side by side; the first is the baseline.\n\n\
                      Example: phalanx bench report perf/records/*-quick.json -o machines.html"
    )]
    Page(RecordReportArgs),
}

#[derive(Debug, Args)]
pub struct RecordCompareArgs {
    /// Records of bench --json; the first is the baseline
    #[arg(required = true, num_args = 2.., value_name = "RECORD.json")]
    pub records: Vec<PathBuf>,
    /// Only rates whose name matches, as in room.*primary
    ///
    /// Compare only rates whose name matches: scene, kind of rays, engine, kernel, in this order,
    /// with a blank between them.
    #[arg(long, value_name = "REGEX", value_parser = parse_pattern)]
    pub filter: Option<Regex>,
    /// Change that counts as one [default: 3%]
    ///
    /// Rates differ where the whole interval of the difference is beyond this. [default: 3%]
    #[arg(long, value_name = "PERCENT", default_value = "3%", hide_default_value = true, value_parser = parse_percent)]
    pub threshold: f64,
    /// Every rate of every kernel, not just changes
    #[arg(long)]
    pub all: bool,
    /// Write a page with charts and tables, too
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
    /// Print Markdown
    #[arg(long, conflicts_with = "json")]
    pub markdown: bool,
}

#[derive(Debug, Args)]
pub struct RecordReportArgs {
    /// Records of bench --json
    #[arg(required = true, value_name = "RECORD.json")]
    pub records: Vec<PathBuf>,
    /// The page
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// Heading of the options that say what is measured.
const MEASUREMENT: &str = "Measurement";

/// Heading of the options that compare a run with an earlier one.
const BASELINE: &str = "Baseline";

#[derive(Debug, Args)]
pub struct RunArgs {
    #[arg(
        value_name = "SCENE",
        help = "Scene files, caches, standard:NAME[:SIZE], or -",
        long_help = "Scene files, scene caches (.phx), standard scenes as standard:NAME[:SIZE], or - for stdin. [default: the standard suite]"
    )]
    pub scenes: Vec<PathBuf>,
    /// About a minute: seven scenes of the suite
    ///
    /// Seven scenes of the suite and fewer samples of each rate, which takes about a minute on two
    /// cores with one other tracer.
    #[arg(long, help_heading = MEASUREMENT)]
    pub quick: bool,
    /// Only scenes of the suite with this in their name
    #[arg(long, value_name = "TEXT", help_heading = MEASUREMENT, conflicts_with = "scenes")]
    pub filter: Option<String>,
    /// primary, shadow, diffuse, …, frame [default: all]
    ///
    /// Kinds of rays, separated by commas. [default: all]
    #[arg(long, value_name = "KIND,…", help_heading = MEASUREMENT, value_delimiter = ',', hide_possible_values = true, value_parser = PossibleValuesParser::new(RayKind::names()))]
    pub rays: Vec<String>,
    /// Other tracers, as in embree,obvhs
    ///
    /// Other tracers to measure on the same rays, separated by commas.
    #[arg(long, value_enum, value_name = "PEER,…", help_heading = MEASUREMENT, value_delimiter = ',', hide_possible_values = true)]
    pub against: Vec<PeerArg>,
    /// Embree's library, or a folder with it [default: looked for]
    #[arg(long, value_name = "PATH", help_heading = MEASUREMENT, hide_short_help = true)]
    pub embree: Option<PathBuf>,
    /// Kernel beside auto, as in beam16, or all
    ///
    /// Traversal kernel to measure beside `auto`: packet8, packet16, beam8, beam16, single, or all.
    /// [default: packets as wide as this build's; all with --counters-only]
    #[arg(long, value_name = "NAME", help_heading = MEASUREMENT, hide_possible_values = true, value_parser = kernels_parser())]
    pub kernel: Option<KernelSet>,
    /// Quality of our BVH [default: best]
    ///
    /// Quality of our BVH; peers build the best that they can. [default: best]
    #[arg(long, value_name = "NAME", help_heading = MEASUREMENT, default_value = "best", hide_default_value = true, hide_possible_values = true, value_parser = name_parser(&Quality::ALL))]
    pub quality: Quality,
    /// Picture size of the rays [default: 512x512]
    ///
    /// Picture size that the rays are of; frames have half its sides. [default: the suite's,
    /// 512x512]
    #[arg(long, value_name = "WxH", help_heading = MEASUREMENT, hide_short_help = true, value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Samples of a rate [default: 11; 5 with --quick]
    ///
    /// Samples of every row. [default: the suite's: 11, and 5 with --quick]
    #[arg(long, value_name = "N", help_heading = MEASUREMENT, hide_short_help = true, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repeat: Option<u32>,
    /// Seconds that the samples of a row take together at least [default: the suite's, 0.03]
    #[arg(long, value_name = "SECONDS", help_heading = MEASUREMENT, hide_short_help = true, value_parser = parse_seconds)]
    pub min_time: Option<f64>,
    /// Count work and time nothing
    ///
    /// Count work and time nothing; with --baseline, compare the counts.
    #[arg(long, help_heading = MEASUREMENT)]
    pub counters_only: bool,
    /// Thread counts [default: 1,all]
    ///
    /// Thread counts, separated by commas; `all` is one per CPU this process may use. [default:
    /// 1,all]
    #[arg(long, value_name = "N,…", help_heading = MEASUREMENT, value_delimiter = ',', default_value = "1,all", hide_default_value = true, value_parser = parse_threads)]
    pub threads: Vec<ThreadCount>,
    /// Bind workers to cores even where there are fewer of them than cores
    #[arg(long, help_heading = MEASUREMENT, hide_short_help = true)]
    pub pin: bool,
    /// Record of the run, for compare and report
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub json: Option<PathBuf>,
    /// Comma-separated values, one sample a line
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub csv: Option<PathBuf>,
    /// Page with charts, pictures and tables
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub html: Option<PathBuf>,
    /// Rays for other tracers to replay
    ///
    /// Write the rays, for other tracers to replay; takes one scene. Nothing is measured.
    #[arg(long, value_name = "FILE", help_heading = OUTPUT, hide_short_help = true)]
    pub dump_rays: Option<PathBuf>,
    /// Compare with an earlier record
    #[arg(long, value_name = "FILE", help_heading = BASELINE)]
    pub baseline: Option<PathBuf>,
    /// Exit with 5 if slower by more, as in 3%
    ///
    /// Exit with 5 if anything is slower than the baseline by more than this, as in 3%.
    #[arg(long, value_name = "PERCENT", help_heading = BASELINE, requires = "baseline", value_parser = parse_percent)]
    pub fail_above: Option<f64>,
    /// Compare with another machine's baseline, too
    ///
    /// Compare with a baseline of another machine or instruction set, too.
    #[arg(long, help_heading = BASELINE, hide_short_help = true, requires = "baseline")]
    pub force: bool,
    #[command(flatten)]
    pub scene_args: SceneArgs,
    /// Write the suite with the answers found, after a change of the scenes or of the rays
    #[arg(long, value_name = "SUITE.toml", hide = true)]
    pub update_suite: Option<PathBuf>,
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

fn parse_pattern(text: &str) -> Result<Regex, String> {
    let help = "a pattern such as 'room.*primary'; \\ before a sign that is meant as it is";
    Regex::new(text).map_err(|error| format!("{error}: expected {help}"))
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
        let measured = |kind: &RayKind| self.measures(kind.name());
        RayKind::ALL.into_iter().filter(measured).collect()
    }

    /// Returns true if whole frames are measured.
    pub fn frames(&self) -> bool {
        self.measures(FRAME)
    }

    fn measures(&self, kind: &str) -> bool {
        self.rays.is_empty() || self.rays.iter().any(|asked| asked == kind)
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
