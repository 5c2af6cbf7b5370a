//! Arguments of `phalanx bench`.

use crate::cli::options::{
    KernelSet, OUTPUT, SceneArgs, kernels_parser, name_parser, parse_number, parse_size,
    parse_thread_count,
};
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand, ValueEnum};
use phalanx::bench::{BenchPlan, FRAME, RayKind};
use phalanx::bvh::Quality;
use regex_lite::Regex;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
#[command(mut_arg("environment", |arg| arg.hide_short_help(true)))]
#[command(mut_arg("camera_name", |arg| arg.hide_short_help(true)))]
pub struct BenchArgs {
    #[command(subcommand)]
    pub command: Option<BenchCommand>,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// Compare records: ranks, geometric means and changed rates
    #[command(
        after_help = "Example: phalanx bench compare perf/records/*-quick.json --filter 'primary|frame'"
    )]
    Compare(RecordCompareArgs),
    /// Write an HTML report of saved records
    #[command(
        name = "report",
        after_help = "One record gives the page that bench --html writes. Several are shown side by side; the first is the baseline.\n\n\
                      Example: phalanx bench report perf/records/*-quick.json -o machines.html"
    )]
    Page(RecordReportArgs),
}

#[derive(Debug, Args)]
pub struct RecordCompareArgs {
    /// Records of bench --json; the first is the baseline
    #[arg(required = true, num_args = 2.., value_name = "RECORD.json")]
    pub records: Vec<PathBuf>,
    /// Compare only matching rates, as in room.*primary
    ///
    /// The name of a rate consists of scene, kind of rays, engine and kernel, separated by spaces.
    #[arg(long, value_name = "REGEX", value_parser = parse_pattern)]
    pub filter: Option<Regex>,
    /// Smallest change to report [default: 3%]
    ///
    /// A rate counts if its whole confidence interval is beyond this, a kernel if its median is and
    /// its interval is clear of zero.
    #[arg(long, value_name = "PERCENT", default_value = "3%", hide_default_value = true, value_parser = parse_percent)]
    pub threshold: f64,
    /// Show every rate of every kernel, not only changes
    #[arg(long)]
    pub all: bool,
    /// Also write an HTML page with charts and tables
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Print the comparison as JSON
    #[arg(long)]
    pub json: bool,
    /// Print the comparison as Markdown
    #[arg(long, conflicts_with = "json")]
    pub markdown: bool,
}

#[derive(Debug, Args)]
pub struct RecordReportArgs {
    /// Records of bench --json
    #[arg(required = true, value_name = "RECORD.json")]
    pub records: Vec<PathBuf>,
    /// HTML page to write
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// Heading of the options that select what to measure.
const MEASUREMENT: &str = "Measurement";

/// Heading of the options for comparing with an earlier run.
const BASELINE: &str = "Baseline";

#[derive(Debug, Args)]
pub struct RunArgs {
    #[arg(
        value_name = "SCENE",
        help = "Scene files, caches, standard:NAME[:SIZE], or -",
        long_help = "Scene files, scene caches (.phx), standard scenes (standard:NAME[:SIZE]), or - for stdin [default: the standard suite]"
    )]
    pub scenes: Vec<PathBuf>,
    /// Measure only eight scenes (at most four minutes)
    ///
    /// Also takes fewer samples per rate. Four minutes is the time on two cores with both other
    /// tracers.
    #[arg(long, help_heading = MEASUREMENT)]
    pub quick: bool,
    /// Measure only scenes whose name contains TEXT
    #[arg(long, value_name = "TEXT", help_heading = MEASUREMENT, conflicts_with = "scenes")]
    pub filter: Option<String>,
    /// primary, shadow, diffuse, …, frame [default: all]
    ///
    /// Kinds of rays to measure, separated by commas.
    #[arg(long, value_name = "KIND,…", help_heading = MEASUREMENT, value_delimiter = ',', hide_possible_values = true, value_parser = PossibleValuesParser::new(RayKind::names()))]
    pub rays: Vec<String>,
    /// Other tracers, as in embree,obvhs
    ///
    /// They are measured on the same rays.
    #[arg(long, value_enum, value_name = "PEER,…", help_heading = MEASUREMENT, value_delimiter = ',', hide_possible_values = true)]
    pub against: Vec<PeerArg>,
    /// Embree library, or a folder with it [default: search for it]
    #[arg(long, value_name = "PATH", help_heading = MEASUREMENT, hide_short_help = true)]
    pub embree: Option<PathBuf>,
    /// Additional kernel, as in beam16, or all
    ///
    /// Traversal kernel to measure in addition to auto and to one ray a call: packet8, packet16,
    /// beam8, beam16, single, or all. [default: packets of this build's width; all with
    /// --counters-only]
    #[arg(long, value_name = "NAME", help_heading = MEASUREMENT, hide_possible_values = true, value_parser = kernels_parser())]
    pub kernel: Option<KernelSet>,
    /// BVH quality: fast, medium, best [default: best]
    ///
    /// Other tracers build theirs alike.
    #[arg(long, value_name = "NAME", help_heading = MEASUREMENT, default_value = "best", hide_default_value = true, hide_possible_values = true, value_parser = name_parser(&Quality::ALL))]
    pub quality: Quality,
    /// Picture size of the rays [default: 512x512]
    ///
    /// Frames are rendered at half this width and height.
    #[arg(long, value_name = "WxH", help_heading = MEASUREMENT, hide_short_help = true, value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Samples per rate [default: 11; 5 with --quick]
    #[arg(long, value_name = "N", help_heading = MEASUREMENT, hide_short_help = true, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repeat: Option<u32>,
    /// Minimum total time of the samples of a rate, in seconds [default: 0.03]
    #[arg(long, value_name = "SECONDS", help_heading = MEASUREMENT, hide_short_help = true, value_parser = parse_seconds)]
    pub min_time: Option<f64>,
    /// Take no more samples after this time, as in 120
    ///
    /// The record then has the rates that were measured until then, and is marked as partial. So it
    /// is after Ctrl-C or SIGTERM.
    #[arg(long, value_name = "SECONDS", help_heading = MEASUREMENT, hide_short_help = true, value_parser = parse_seconds)]
    pub time_limit: Option<f64>,
    /// Count work instead of measuring time
    ///
    /// With --baseline, compares the counts.
    #[arg(long, help_heading = MEASUREMENT)]
    pub counters_only: bool,
    /// Thread counts [default: 1,all]
    ///
    /// Separated by commas; all means one per available CPU.
    #[arg(long, value_name = "N,…", help_heading = MEASUREMENT, value_delimiter = ',', default_value = "1,all", hide_default_value = true, value_parser = parse_threads)]
    pub threads: Vec<usize>,
    /// Pin threads to cores even if there are fewer threads than cores
    #[arg(long, help_heading = MEASUREMENT, hide_short_help = true)]
    pub pin: bool,
    /// Write a record, for bench compare and report
    ///
    /// Without a FILE, to stdout; tables are then printed on stderr.
    #[arg(long, value_name = "FILE", help_heading = OUTPUT, num_args = 0..=1, default_missing_value = "-")]
    pub json: Option<PathBuf>,
    /// Write comma-separated values, one sample per line
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub csv: Option<PathBuf>,
    /// Write an HTML page with charts, pictures and tables
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub html: Option<PathBuf>,
    /// Write the rays, for other tracers to replay
    ///
    /// Takes a single scene, and measures nothing.
    #[arg(long, value_name = "FILE", help_heading = OUTPUT, hide_short_help = true)]
    pub dump_rays: Option<PathBuf>,
    /// Compare with an earlier record
    #[arg(long, value_name = "FILE", help_heading = BASELINE)]
    pub baseline: Option<PathBuf>,
    /// Exit with 5 if slower by more, as in 3%
    ///
    /// Compares rates with the baseline's, or counts with --counters-only. Rates that look slower
    /// are measured again first.
    #[arg(long, value_name = "PERCENT", help_heading = BASELINE, requires = "baseline", value_parser = parse_percent)]
    pub fail_above: Option<f64>,
    /// Accept a baseline of another machine or instruction set
    #[arg(long, help_heading = BASELINE, hide_short_help = true, requires = "baseline")]
    pub force: bool,
    #[command(flatten)]
    pub scene_args: SceneArgs,
    /// Write the suite with the answers of this run, after a change of its scenes or rays
    #[arg(long, value_name = "SUITE.toml", hide = true)]
    pub update_suite: Option<PathBuf>,
}

fn parse_threads(text: &str) -> Result<usize, String> {
    match text {
        "all" => Ok(BenchPlan::all_threads()),
        _ => parse_thread_count(text).map_err(|error| format!("{error}, or `all`")),
    }
}

fn parse_pattern(text: &str) -> Result<Regex, String> {
    let help = "a regular expression such as 'room.*primary'";
    Regex::new(text).map_err(|error| format!("{error}: expected {help}"))
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    let good = |seconds: &f64| (0.0..=86_400.0).contains(seconds);
    parse_number(text, good, "a time from 0 to 86400 seconds")
}

fn parse_percent(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('%').unwrap_or(text).trim_end();
    let good = |percent: &f64| (0.0..100.0).contains(percent);
    let expected = "a percentage from 0 to less than 100, as in 3%";
    Ok(parse_number(number, good, expected)? / 100.0)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PeerArg {
    /// Intel's Embree, from its shared library: its fastest mode and its robust one
    Embree,
    /// The traversal of obvhs
    Obvhs,
}

impl RunArgs {
    /// Numbers of threads, each once, ascending.
    pub fn thread_counts(&self) -> Vec<usize> {
        let mut counts = self.threads.clone();
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
        self.rays.is_empty() || self.rays.iter().any(|name| name == kind)
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
        assert_eq!(parse_threads("2"), Ok(2));
        assert_eq!(parse_threads("all"), Ok(BenchPlan::all_threads()));
        assert!(parse_threads("0").unwrap_err().contains("`all`"));
    }
}
