//! Comparison of a run with its baseline, and what makes `bench --fail-above` fail.

use super::fixture::{estimate, record, scale};
use phalanx::report::*;

const THRESHOLD: f64 = 0.08;

fn compare_at(old: &BenchRecord, new: &BenchRecord, threshold: f64) -> RecordComparison {
    let options = ComparisonOptions {
        threshold,
        all: false,
        any_machine: false,
    };
    RecordComparison::new(&[("old.json", old), ("this run", new)], options)
}

fn compare(old: &BenchRecord, new: &BenchRecord) -> RecordComparison {
    compare_at(old, new, THRESHOLD)
}

/// Asserts that nothing is slower, nor looks so.
fn assert_equal(comparison: &RecordComparison) {
    assert_eq!(comparison.suspects(&[]), Vec::<&ComparedRate>::new());
    assert!(comparison.regressions(&[]).is_empty());
}

#[test]
fn the_same_run_has_not_changed() {
    let comparison = compare(&record(6), &record(6));
    assert_equal(&comparison);
    assert_eq!(comparison.groups, []);
    let text = regressions_text(
        &compare_at(&record(1), &record(1), 0.0005),
        &Regressions::default(),
    );
    assert_eq!(text, "Nothing is slower by more than 0.05 %.\n");
}

#[test]
fn a_slower_machine_is_no_regression() {
    let mut slow = record(6);
    scale(&mut slow, 0.5, |_| true);
    assert_equal(&compare(&record(6), &slow));
    // Without another tracer, the machine's change is in every rate, and no group decides.
    slow.rows.retain(|row| row.engine == "phalanx");
    let comparison = compare(&record(6), &slow);
    assert!(comparison.regressions(&[]).is_empty());
    assert_eq!(comparison.suspects(&[]).len(), slow.rows.len());
}

/// A baseline of another machine that `--force` accepts: other tracers show the difference.
#[test]
fn another_machine_may_count_as_the_same() {
    let mut other = record(6);
    other.machine.cpu = "Other".into();
    scale(&mut other, 0.5, |_| true);
    assert!(compare(&record(6), &other).records[1].machine.is_none());
    let options = ComparisonOptions {
        threshold: THRESHOLD,
        all: false,
        any_machine: true,
    };
    let records = [("old.json", &record(6)), ("this run", &other)];
    assert_equal(&RecordComparison::new(&records, options));
}

#[test]
fn rates_of_other_parts_of_the_rays_show_no_machine() {
    let mut part = record(1);
    let others = part.rows.iter_mut().filter(|row| row.engine != "phalanx");
    others.for_each(|row| row.rays_timed = 10);
    assert!(compare(&record(1), &part).records[1].machine.is_none());
}

/// Groups that are slower in a record, by kernel, scene and rays.
fn slower_groups(comparison: &RecordComparison) -> Vec<(&str, Option<&str>, Option<&str>)> {
    let groups = comparison.groups.iter();
    let slower = groups.filter(|group| group.change.by < 0.0);
    let names = slower.map(|g| (&*g.kernel, g.scene.as_deref(), g.rays.as_deref()));
    names.collect()
}

#[test]
fn a_slower_kernel_is_a_regression() {
    let mut new = record(6);
    scale(&mut new, 0.85, |row| {
        row.kernel == "packet16" && row.rays == "shadow"
    });
    let comparison = compare(&record(6), &new);
    let shadow = ("packet16", None, Some("shadow"));
    assert_eq!(
        slower_groups(&comparison),
        [shadow, shadow],
        "one and two threads"
    );
    let regressions = comparison.regressions(&[]);
    assert_eq!((regressions.groups.len(), regressions.rates.len()), (2, 0));
    let change = regressions.groups[0].change;
    assert!((change.by + 0.15).abs() < 1e-9 && change.high < -THRESHOLD);
    let text = regressions_text(&comparison, &regressions);
    assert!(text.contains("packet16  all    shadow"), "{text}");
    assert!(
        compare_at(&record(6), &new, 0.2)
            .regressions(&[])
            .is_empty()
    );
    // Faster is not a regression.
    let back = compare(&new, &record(6));
    assert_eq!(back.groups.len(), 2);
    assert_equal(&back);
}

/// A part of a slower kernel is listed where it is slower still.
#[test]
fn a_part_changes_beyond_its_kernel() {
    let mut new = record(6);
    scale(&mut new, 0.85, |row| row.kernel == "packet8");
    let all = ("packet8", None, None);
    assert_eq!(slower_groups(&compare(&record(6), &new)), [all, all]);
    scale(&mut new, 0.7, |row| {
        row.kernel == "packet8" && row.rays == "diffuse"
    });
    let diffuse = ("packet8", None, Some("diffuse"));
    assert_eq!(
        slower_groups(&compare(&record(6), &new)),
        [all, diffuse, all, diffuse]
    );
}

/// A kernel counts by its median, though its interval need not be beyond the whole threshold.
#[test]
fn a_kernel_slower_by_less_than_the_threshold_is_no_regression() {
    let mut new = record(6);
    scale(&mut new, 0.95, |row| row.kernel == "packet8");
    assert_eq!(slower_groups(&compare_at(&record(6), &new, 0.06)), []);
    assert_eq!(slower_groups(&compare_at(&record(6), &new, 0.04)).len(), 2);
}

#[test]
fn a_rate_counts_only_when_it_stays_slow() {
    let mut new = record(6);
    let one = |row: &RateRow| {
        let kind = (row.kernel.as_str(), row.rays.as_str(), row.threads);
        row.scene == "standard:scene3:small" && kind == ("packet8", "primary", 2)
    };
    scale(&mut new, 0.8, one);
    let slow = compare(&record(6), &new);
    let fine = compare(&record(6), &record(6));
    let suspects = slow.suspects(&[]);
    assert_eq!(suspects.len(), 1);
    assert_eq!(
        (&*suspects[0].kernels[1], suspects[0].threads),
        ("packet8", 2)
    );
    let again = |retakes: &[&RecordComparison]| {
        let retakes: Vec<RecordComparison> = retakes.iter().map(|&c| c.clone()).collect();
        slow.regressions(&retakes).rates.len()
    };
    assert_eq!(again(&[]), 0);
    assert_eq!(again(&[&slow]), 0);
    assert_eq!(again(&[&slow, &fine]), 0);
    assert_eq!(again(&[&fine, &slow]), 0);
    assert_eq!(again(&[&slow, &slow]), 1);
    assert!(slow.suspects(std::slice::from_ref(&fine)).is_empty());
}

#[test]
fn few_samples_say_little() {
    let few = |count: usize, share: f64| {
        let mut record = record(1);
        for row in &mut record.rows {
            row.samples.truncate(count);
            row.mrays_per_s = estimate(&row.samples);
        }
        scale(&mut record, share, |row| row.engine == "phalanx");
        record
    };
    let two = compare(&few(2, 1.0), &few(2, 0.5));
    assert!(two.suspects(&[]).is_empty());
    let four = compare(&few(4, 1.0), &few(4, 0.5));
    assert_eq!(four.suspects(&[]).len(), 3 * 2 * 3, "every rate of ours");
    // Rows that lost their samples are counted.
    let none = compare(&few(4, 1.0), &few(0, 1.0));
    assert_eq!(none.left_out, record(1).rows.len());
}

/// Refused comparisons, their reasons, and the effect of force.
#[test]
fn other_machines_and_other_rays_are_refused() {
    type Case = (&'static str, bool, fn(&mut BenchRecord));
    let cases: [Case; 12] = [
        ("another CPU", true, |r| r.machine.cpu = "Other".into()),
        ("hardware threads", true, |r| r.machine.threads = 4),
        ("other caches", true, |r| r.machine.caches[0].bytes *= 2),
        ("hypervisor: none", true, |r| {
            r.machine.hypervisor = Some(String::new())
        }),
        ("instruction set", true, |r| {
            r.program.isa_compiled = "x86-64".into()
        }),
        ("trees of another quality: fast in", true, |r| {
            r.run.quality = "fast".into()
        }),
        ("another scene", false, |r| {
            r.scenes[0].hash = "00000000".into()
        }),
        ("another size: 640×480", false, |r| {
            r.scenes[0].size = [640, 480]
        }),
        ("number of rays", false, |r| {
            r.scenes[0].rays.get_mut("shadow").expect("a set").rays = 7;
        }),
        ("other answers", false, |r| {
            r.scenes[0].rays.get_mut("shadow").expect("a set").checksum = "11111111".into();
        }),
        ("number of rays", false, |r| {
            r.rows.iter_mut().for_each(|row| row.rays_timed = 5);
        }),
        ("no rate", false, |r| r.rows.clear()),
    ];
    for (reason, forcible, change) in cases {
        let mut old = record(1);
        change(&mut old);
        let refusal = check_run(&old, &record(1), false).expect_err(reason);
        assert!(refusal.to_string().contains(reason), "{refusal}");
        assert_eq!(refusal.can_be_forced(), forcible, "{reason}");
        let forced = check_run(&old, &record(1), true);
        assert_eq!(forced.is_ok(), forcible, "{reason}");
    }
}

#[test]
fn counters_are_compared_exactly() {
    let old = record(2);
    assert_eq!(counters(&old, &old), []);
    let mut new = record(2);
    new.counters[0].work.node_visits += 1;
    new.counters[1].work.bytes -= 1;
    new.counters.remove(5);
    let changes = counters(&old, &new);
    let differences: Vec<CountDifference> = changes.iter().map(|c| c.difference).collect();
    let count = |counter, old, new| CountDifference::Count { counter, old, new };
    assert_eq!(differences.len(), 3, "{changes:?}");
    assert!(differences.contains(&count("node_visits", 4000, 4001)));
    assert!(differences.contains(&count("bytes", 270_000, 269_999)));
    assert!(differences.contains(&CountDifference::OnlyOld));
    assert_eq!(counters(&new, &old).len(), 3);
    let table = counters_table(&changes);
    assert!(
        table.contains("node_visits     4000    4001    +1\n"),
        "{table}"
    );
}
