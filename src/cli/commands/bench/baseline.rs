//! `bench --baseline`: compares this run with an earlier one.

use super::args::RunArgs;
use super::bar::BenchProgressBar;
use super::measure::{BenchScene, measure_scene, record};
use super::program::this_program;
use crate::cli::output::{self, CliError};
use phalanx::bench::{BenchPlan, RayKind};
use phalanx::frame::Control;
use phalanx::report::{
    BenchRecord, Changes, CountDifference, IncompatibleRecords, RETAKES, RecordError, RowKey,
    changes_table, counters, counters_table, regressions_table,
};
use std::path::Path;

/// An earlier run.
pub struct Baseline(pub BenchRecord);

/// Reads a record.
pub fn load(path: &Path) -> Result<BenchRecord, CliError> {
    output::reads("the record", path)?;
    phalanx::report::load(path).map_err(|error| match error {
        RecordError::Io { .. } => CliError::Runtime(error.to_string()),
        other => CliError::Usage(other.to_string()),
    })
}

/// The error for incompatible records, with a hint if `--force` allows them.
fn refused(refusal: IncompatibleRecords) -> CliError {
    let error = CliError::Usage(refusal.to_string());
    if refusal.can_be_forced() {
        error.with_hint("use --force to compare anyway")
    } else {
        error
    }
}

impl Baseline {
    /// Refuses a baseline that is incompatible with this plan, before anything is measured.
    pub fn check(
        &self,
        args: &RunArgs,
        plan: &BenchPlan,
        scenes: &[BenchScene],
    ) -> Result<(), CliError> {
        if args.counters_only {
            return Ok(());
        }
        let run = plan.run_info(String::new(), Vec::new(), 0.0);
        let now = phalanx::bench::record(this_program(), run, Vec::new());
        let names: Vec<&str> = scenes.iter().map(|scene| &*scene.info.name).collect();
        phalanx::report::check_baseline(&self.0, &now, &names, args.force).map_err(refused)
    }

    /// Reads a record to compare with.
    pub fn load(path: &Path) -> Result<Baseline, CliError> {
        load(path).map(Baseline)
    }

    /// The changes to a run, for its page; `None` if the records are incompatible, which
    /// [`Baseline::judge`] reports.
    pub fn changes(&self, args: &RunArgs, now: &BenchRecord) -> Option<Changes> {
        phalanx::report::compare(&self.0, now, args.force).ok()
    }

    /// Prints the changes. Exit code 5 if a rate is lower, or a count higher, than `--fail-above`
    /// allows. Rates that look slower are measured again first: see
    /// [`phalanx::report::Changes::regressions`].
    pub fn judge(
        &self,
        args: &RunArgs,
        plan: &BenchPlan,
        scenes: &[BenchScene],
        now: &BenchRecord,
    ) -> Result<(), CliError> {
        if args.counters_only {
            return self.judge_counters(args, now);
        }
        let changes = phalanx::report::compare(&self.0, now, args.force).map_err(refused)?;
        let threshold = args.fail_above.unwrap_or(DEFAULT_THRESHOLD);
        output::print(&changes_table(&changes, threshold))?;
        let Some(threshold) = args.fail_above else {
            return Ok(());
        };
        let mut again = Vec::new();
        while again.len() < RETAKES {
            let suspects = changes.suspects(&again, threshold);
            if suspects.is_empty() {
                break;
            }
            let retake = self.again(args, plan, scenes, &suspects, now)?;
            again.push(phalanx::report::compare(&self.0, &retake, args.force).map_err(refused)?);
        }
        let regressions = changes.regressions(&again, threshold);
        output::print(&regressions_table(&regressions, threshold))?;
        if regressions.is_empty() { Ok(()) } else { Err(CliError::Slower) }
    }

    /// Measures the scenes and kinds of rays of suspected regressions again.
    fn again(
        &self,
        args: &RunArgs,
        plan: &BenchPlan,
        scenes: &[BenchScene],
        suspects: &[RowKey],
        now: &BenchRecord,
    ) -> Result<BenchRecord, CliError> {
        let of = |scene: &&BenchScene| suspects.iter().any(|s| s.scene == scene.info.name);
        let scenes: Vec<&BenchScene> = scenes.iter().filter(of).collect();
        output::status(&format!(
            "{} rates look slower: measuring {} scenes again",
            suspects.len(),
            scenes.len()
        ));
        let control = Control::default();
        let mut bar = BenchProgressBar::new(scenes.len(), &control, None);
        let mut all = Vec::new();
        for scene in scenes {
            let has = |rays: &str| {
                let mut of_scene = suspects.iter().filter(|s| s.scene == scene.info.name);
                of_scene.any(|s| s.rays == rays)
            };
            let again = plan.restricted(|kind: &RayKind| has(kind.name()), has("frame"));
            all.push(measure_scene(&again, scene, &mut bar)?.0);
        }
        bar.finish();
        Ok(record(plan, all, now.run.started.clone(), 0.0))
    }

    fn judge_counters(&self, args: &RunArgs, now: &BenchRecord) -> Result<(), CliError> {
        let [old, new] = [&self.0, now].map(|record| &record.run.quality);
        if old != new {
            output::note(&format!(
                "the baseline used BVH quality {old}, this run {new} (see --quality)"
            ));
        }
        let mut changes = counters(&self.0, now);
        // If only a part of the suite was run, only that part of the baseline is compared.
        changes.retain(|change| now.scenes.iter().any(|scene| scene.name == change.scene));
        if changes.is_empty() {
            return output::print("work: all counts equal to the baseline\n");
        }
        output::print(&counters_table(&changes))?;
        let allowed = |old: u64| old as f64 * (1.0 + args.fail_above.unwrap_or(f64::INFINITY));
        let more = changes.iter().any(|change| match change.difference {
            CountDifference::Count { old, new, .. } => new as f64 > allowed(old),
            CountDifference::OnlyOld | CountDifference::OnlyNew => false,
        });
        if more { Err(CliError::Slower) } else { Ok(()) }
    }
}

/// Smallest change that the table marks without `--fail-above`.
const DEFAULT_THRESHOLD: f64 = 0.03;
