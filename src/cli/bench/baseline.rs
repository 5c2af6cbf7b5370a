//! `bench --baseline`: this run against an earlier one.

use super::super::failure::Failure;
use super::super::output;
use super::args::RunArgs;
use super::bar::Bar;
use super::{Course, one, record};
use phalanx::bench::{Kind, Plan};
use phalanx::report::{
    CounterChange, Difference, RETAKES, Record, RecordError, RowKey, changes_table, counters,
    counters_table, regressions_table,
};
use std::path::Path;

/// An earlier run.
pub struct Baseline(Record);

/// Reads a record.
pub fn load(path: &Path) -> Result<Record, Failure> {
    phalanx::report::load(path).map_err(|error| match error {
        RecordError::Io { .. } => Failure::Runtime(error.to_string()),
        other => Failure::Usage(other.to_string()),
    })
}

impl Baseline {
    /// Reads a record to compare with.
    pub fn load(path: &Path) -> Result<Baseline, Failure> {
        load(path).map(Baseline)
    }

    /// Prints what changed; exit code 5 if something is slower (or more work) than `--fail-above` allows. What looks slower is
    /// measured again first: see [`phalanx::report::Changes::regressions`].
    pub fn judge(
        &self,
        args: &RunArgs,
        plan: &Plan,
        courses: &[Course],
        now: &Record,
    ) -> Result<(), Failure> {
        if args.counters_only {
            return self.judge_counters(args, now);
        }
        let refused = |refusal: phalanx::report::Refusal| {
            let forceable = refusal.can_be_forced();
            let failure = Failure::Usage(refusal.to_string());
            match forceable {
                true => failure.and("compare all the same with --force"),
                false => failure,
            }
        };
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
            let retake = self.again(args, plan, courses, &suspects, now)?;
            again.push(phalanx::report::compare(&self.0, &retake, args.force).map_err(refused)?);
        }
        let regressions = changes.regressions(&again, threshold);
        output::print(&regressions_table(&regressions))?;
        match regressions.is_empty() {
            true => Ok(()),
            false => Err(Failure::Slower),
        }
    }

    /// Measures the scenes and kinds of rays of the suspects again.
    fn again(
        &self,
        args: &RunArgs,
        plan: &Plan,
        courses: &[Course],
        suspects: &[RowKey],
        now: &Record,
    ) -> Result<Record, Failure> {
        let of = |course: &&Course| suspects.iter().any(|s| s.scene == course.heading.name);
        let courses: Vec<&Course> = courses.iter().filter(of).collect();
        output::note(&format!(
            "{} rates look slower: measuring {} scenes again",
            suspects.len(),
            courses.len()
        ));
        let mut bar = Bar::new(courses.len());
        let mut all = Vec::new();
        for course in courses {
            let kinds = |kind: &Kind| {
                let mut of_scene = suspects.iter().filter(|s| s.scene == course.heading.name);
                of_scene.any(|s| s.rays == kind.name())
            };
            let frames = suspects
                .iter()
                .any(|s| s.scene == course.heading.name && s.rays == "frame");
            let again = plan.restricted(kinds, frames);
            all.push(one(args, &again, course, &mut bar)?.0);
        }
        bar.finish();
        Ok(record(args, plan, all, now.run.started.clone(), 0.0))
    }

    fn judge_counters(&self, args: &RunArgs, now: &Record) -> Result<(), Failure> {
        let [old, new] = [&self.0, now].map(|record| &record.run.quality);
        if old != new {
            output::note(&format!(
                "note: the baseline counts trees of quality {old}, this run of {new}: see --quality"
            ));
        }
        let changes = counters(&self.0, now);
        let scene = |name: &str| now.scenes.iter().any(|scene| scene.name == name);
        // A part of the suite is compared with that part of the baseline.
        let changes: Vec<CounterChange> = changes
            .into_iter()
            .filter(|change| scene(&change.scene))
            .collect();
        if changes.is_empty() {
            return output::print("work: the baseline's, count by count\n");
        }
        output::print(&counters_table(&changes))?;
        let allowed = |old: u64| old as f64 * (1.0 + args.fail_above.unwrap_or(f64::INFINITY));
        let more = changes.iter().any(|change| match change.difference {
            Difference::Count { old, new, .. } => new as f64 > allowed(old),
            Difference::OnlyOld | Difference::OnlyNew => false,
        });
        match more {
            true => Err(Failure::Slower),
            false => Ok(()),
        }
    }
}

/// What the table calls a change where `--fail-above` does not say.
const DEFAULT_THRESHOLD: f64 = 0.03;
