//! `bench --baseline`: compares this run with an earlier one.

use super::args::RunArgs;
use super::bar::BenchProgressBar;
use super::measure::{BenchScene, measure_scene, record};
use super::program::this_program;
use crate::cli::output::{self, CliError};
use phalanx::bench::{BenchPlan, FRAME, RayKind};
use phalanx::frame::Control;
use phalanx::report::{
    BenchRecord, ComparedRate, ComparisonOptions, CountDifference, IncompatibleRecords, RETAKES,
    RecordComparison, RecordError, check_run, comparison_text, counted, counters, counters_table,
    regressions_text,
};
use std::path::Path;

/// An earlier run.
pub struct Baseline {
    pub record: BenchRecord,
    /// Name of its file.
    name: String,
}

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
    /// Reads a record to compare with.
    pub fn load(path: &Path) -> Result<Baseline, CliError> {
        Ok(Baseline {
            record: load(path)?,
            name: path.display().to_string(),
        })
    }

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
        let forced = phalanx::report::check_baseline(&self.record, &now, &names, args.force)
            .map_err(refused)?;
        for mismatch in forced {
            output::note(&format!("compared nevertheless: {mismatch}"));
        }
        Ok(())
    }

    /// The comparison with a run.
    ///
    /// # Errors
    /// The reasons why the records are incompatible.
    pub fn compare(
        &self,
        args: &RunArgs,
        now: &BenchRecord,
    ) -> Result<RecordComparison, IncompatibleRecords> {
        check_run(&self.record, now, args.force)?;
        let options = ComparisonOptions {
            threshold: args.fail_above.unwrap_or(DEFAULT_THRESHOLD),
            all: false,
            any_machine: args.force,
        };
        let records = [(&*self.name, &self.record), ("this run", now)];
        Ok(RecordComparison::new(&records, options))
    }

    /// Prints the comparison. Exit code 5 if a rate is lower, or a count higher, than
    /// `--fail-above` allows. Rates that look slower are measured again first: see
    /// [`RecordComparison::regressions`].
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
        let comparison = self.compare(args, now).map_err(refused)?;
        let text = comparison_text(&comparison, output::stdout_columns());
        output::print(&format!("\n{text}"))?;
        if args.fail_above.is_none() {
            return Ok(());
        }
        let mut retakes = Vec::new();
        while retakes.len() < RETAKES {
            let suspects = comparison.suspects(&retakes);
            if suspects.is_empty() {
                break;
            }
            let retake = measure_again(plan, scenes, &suspects, now)?;
            retakes.push(self.compare(args, &retake).map_err(refused)?);
        }
        let regressions = comparison.regressions(&retakes);
        output::print(&format!(
            "\n{}",
            regressions_text(&comparison, &regressions)
        ))?;
        if regressions.is_empty() { Ok(()) } else { Err(CliError::Slower) }
    }

    fn judge_counters(&self, args: &RunArgs, now: &BenchRecord) -> Result<(), CliError> {
        let [old, new] = [&self.record, now].map(|record| &record.run.quality);
        if old != new {
            output::note(&format!(
                "the baseline used BVH quality {old}, this run {new} (see --quality)"
            ));
        }
        let mut changes = counters(&self.record, now);
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

/// Measures the scenes and kinds of rays of suspected regressions again.
fn measure_again(
    plan: &BenchPlan,
    scenes: &[BenchScene],
    suspects: &[&ComparedRate],
    now: &BenchRecord,
) -> Result<BenchRecord, CliError> {
    let is_suspect = |scene: &&BenchScene| suspects.iter().any(|s| s.scene == scene.info.name);
    let scenes: Vec<&BenchScene> = scenes.iter().filter(is_suspect).collect();
    output::status(&format!(
        "{} look slower: measuring {} again",
        counted(suspects.len(), "rate"),
        counted(scenes.len(), "scene")
    ));
    let control = Control::default();
    let mut bar = BenchProgressBar::new(scenes.len(), &control, None);
    let mut all = Vec::new();
    for scene in scenes {
        let has = |rays: &str| {
            let mut in_scene = suspects.iter().filter(|s| s.scene == scene.info.name);
            in_scene.any(|s| s.rays == rays)
        };
        let again = plan.restricted(|kind: &RayKind| has(kind.name()), has(FRAME));
        all.push(measure_scene(&again, scene, &mut bar)?.0);
    }
    bar.finish();
    Ok(record(plan, all, now.run.started.clone(), 0.0))
}

/// Smallest change that counts without `--fail-above`.
const DEFAULT_THRESHOLD: f64 = 0.03;
