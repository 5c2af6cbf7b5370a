//! Comparison of one record with another.

use super::fixture::{estimate, record, scale};
use phalanx::report::*;

const THRESHOLD: f64 = 0.08;

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

#[test]
fn the_same_run_has_not_changed() {
    let changes = compare(&record(6), &record(6), false).expect("comparable");
    // Two kernels; `auto` is one of them.
    assert_eq!(changes.rows.len(), 6 * 3 * 2 * 2);
    assert!(changes.rows.iter().all(|row| close(row.change.by, 0.0)));
    assert!(
        changes
            .rows
            .iter()
            .all(|row| row.normalised == Normalisation::SameThreads)
    );
    assert_eq!(changes.groups.len(), 2 * (3 * 2 + 6));
    assert_eq!(changes.suspects(&[], THRESHOLD), []);
    assert_eq!(changes.regressions(&[], THRESHOLD), []);
}

#[test]
fn a_slower_machine_is_no_regression() {
    let mut slow = record(6);
    scale(&mut slow, 0.5, |_| true);
    let changes = compare(&record(6), &slow, false).expect("comparable");
    assert!(changes.rows.iter().all(|row| close(row.change.by, 0.0)));
    // Rows without a yardstick.
    slow.rows.retain(|row| row.engine != "oracle");
    let changes = compare(&record(6), &slow, false).expect("comparable");
    assert!(
        changes
            .rows
            .iter()
            .all(|row| row.normalised == Normalisation::No)
    );
    assert!(changes.rows.iter().all(|row| close(row.change.by, -0.5)));
    let table = changes_table(&changes, THRESHOLD);
    assert_heads(&table);
    assert!(table.contains("-50.0 % *"), "{table}");
    // Groups affected by the machine's fluctuations do not decide.
    assert_eq!(changes.regressions(&[], THRESHOLD), []);
}

#[test]
fn the_oracle_on_one_thread_serves_where_there_is_no_other() {
    let mut old = record(1);
    old.rows
        .retain(|row| row.engine != "oracle" || row.threads == 1);
    let changes = compare(&old, &record(1), false).expect("comparable");
    let rows_on = |threads| {
        changes
            .rows
            .iter()
            .filter(move |row| row.key.threads == threads)
    };
    assert!(rows_on(1).all(|row| row.normalised == Normalisation::SameThreads));
    assert!(rows_on(2).all(|row| row.normalised == Normalisation::OneThread));
    // An oracle timed on another part of the rays is not a yardstick.
    let mut part = record(1);
    let oracles = part.rows.iter_mut().filter(|row| row.engine == "oracle");
    oracles.for_each(|row| row.rays_timed = 10);
    let changes = compare(&record(1), &part, false).expect("comparable");
    assert!(
        changes
            .rows
            .iter()
            .all(|row| row.normalised == Normalisation::No)
    );
}

#[test]
fn a_slower_kernel_is_a_regression() {
    let mut new = record(6);
    scale(&mut new, 0.85, |row| {
        row.kernel == "packet16" && row.rays == "shadow"
    });
    let changes = compare(&record(6), &new, false).expect("comparable");
    let regressions = changes.regressions(&[], THRESHOLD);
    assert_eq!(regressions.len(), 2, "{regressions:?}");
    for regression in &regressions {
        let Regression::Group(group) = regression else {
            panic!("{regression:?}");
        };
        assert_eq!(group.kernel, "packet16");
        assert!(matches!(&group.over, Grouping::Scenes { rays, .. } if rays == "shadow"));
        assert!(close(group.change.by, -0.15) && group.change.high < -THRESHOLD);
    }
    assert!(changes.regressions(&[], 0.2).is_empty());
    // Faster is not a regression.
    let back = compare(&new, &record(6), false).expect("comparable");
    assert_eq!(back.regressions(&[], THRESHOLD), []);
}

#[test]
fn a_row_counts_only_when_it_stays_slow() {
    let mut new = record(6);
    let one = |row: &RateRow| {
        let kind = (row.kernel.as_str(), row.rays.as_str(), row.threads);
        row.scene == "standard:scene3:small" && kind == ("packet8", "primary", 2)
    };
    scale(&mut new, 0.8, one);
    let slow = compare(&record(6), &new, false).expect("comparable");
    let fine = compare(&record(6), &record(6), false).expect("comparable");
    let suspects = slow.suspects(&[], THRESHOLD);
    assert_eq!(suspects.len(), 1);
    assert_eq!(
        (suspects[0].kernel.as_str(), suspects[0].threads),
        ("packet8", 2)
    );
    let again = |retakes: &[&Changes]| {
        let retakes: Vec<Changes> = retakes.iter().map(|&c| c.clone()).collect();
        slow.regressions(&retakes, THRESHOLD).len()
    };
    assert_eq!(again(&[]), 0);
    assert_eq!(again(&[&slow]), 0);
    assert_eq!(again(&[&slow, &fine]), 0);
    assert_eq!(again(&[&fine, &slow]), 0);
    assert_eq!(again(&[&slow, &slow]), 1);
    assert_eq!(slow.suspects(std::slice::from_ref(&fine), THRESHOLD), []);
}

#[test]
fn few_samples_say_little() {
    let few = |count: usize, factor: f64| {
        let mut record = record(1);
        for row in &mut record.rows {
            row.samples.truncate(count);
            row.mrays_per_s = estimate(&row.samples);
        }
        scale(&mut record, factor, |row| row.engine == "phalanx");
        record
    };
    let two = compare(&few(2, 1.0), &few(2, 0.5), false).expect("comparable");
    assert!(
        two.rows
            .iter()
            .all(|row| close(row.change.by, -0.5) && !row.change.is_known())
    );
    assert_eq!(two.suspects(&[], THRESHOLD), []);
    assert!(changes_table(&two, THRESHOLD).contains("too few samples"));
    let four = compare(&few(4, 1.0), &few(4, 0.5), false).expect("comparable");
    assert_eq!(four.suspects(&[], THRESHOLD).len(), four.rows.len());
    // A row that lost its samples is listed.
    let none = compare(&few(4, 1.0), &few(0, 1.0), false).expect("comparable");
    assert_eq!((none.rows.len(), none.empty.len()), (0, 3 * 2 * 2));
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
        let refusal = compare(&old, &record(1), false).expect_err(reason);
        assert!(refusal.to_string().contains(reason), "{refusal}");
        assert_eq!(refusal.can_be_forced(), forcible, "{reason}");
        match compare(&old, &record(1), true) {
            Ok(changes) => {
                assert!(forcible && changes.forced.len() == 1, "{reason}");
                let table = changes_table(&changes, THRESHOLD);
                assert!(table.contains("compared nevertheless: "), "{table}");
            }
            Err(again) => assert!(!forcible && again == refusal, "{reason}"),
        }
    }
}

#[test]
fn rows_that_only_one_has_are_listed() {
    let mut old = record(2);
    old.rows.retain(|row| row.rays != "diffuse");
    let changes = compare(&old, &record(2), false).expect("comparable");
    assert_eq!(
        (changes.only_old.len(), changes.only_new.len()),
        (0, 2 * 2 * 3)
    );
    let changes = compare(&record(2), &old, false).expect("comparable");
    assert_eq!(
        (changes.only_old.len(), changes.only_new.len()),
        (2 * 2 * 3, 0)
    );
    let table = changes_table(&changes, THRESHOLD);
    assert!(table.contains("12 rows only in the baseline, first standard:scene0:small, diffuse"));
}

#[test]
fn counters_are_compared_exactly() {
    let old = record(2);
    assert_eq!(counters(&old, &old), []);
    let mut new = record(2);
    new.counters[0].work.node_visits += 1;
    new.counters[1].work.bytes -= 1;
    new.counters.remove(5);
    let actual = counters(&old, &new);
    let differences: Vec<CountDifference> = actual.iter().map(|c| c.difference).collect();
    let count = |counter, old, new| CountDifference::Count { counter, old, new };
    assert_eq!(differences.len(), 3, "{actual:?}");
    assert!(differences.contains(&count("node_visits", 4000, 4001)));
    assert!(differences.contains(&count("bytes", 270_000, 269_999)));
    assert!(differences.contains(&CountDifference::OnlyOld));
    assert_eq!(counters(&new, &old).len(), 3);
    let table = counters_table(&actual);
    assert!(
        table.contains("node_visits     4000    4001    +1\n"),
        "{table}"
    );
}

/// Checks that kinds of rays, scenes and kernels are listed below their headings.
fn assert_heads(table: &str) {
    let mut lines = table.lines();
    for (title, heads) in [
        ("Change of each kernel", ["rays", "kernel"]),
        ("The scenes", ["scene", "kernel"]),
        ("The rows", ["scene", "kernel"]),
    ] {
        assert!(lines.any(|line| line.starts_with(title)), "{title}");
        let head = lines.next().unwrap_or_default();
        let first: Vec<&str> = head.split_whitespace().take(2).collect();
        assert_eq!(first, heads, "{title}");
        let row = lines.next().unwrap_or_default();
        let kernel = row.split_whitespace().nth(1);
        let known = |name| ["auto", "scalar"].contains(&name) || name.starts_with("packet");
        assert!(kernel.is_some_and(known), "{title}: {row}");
    }
}

#[test]
fn no_regression_is_a_sentence() {
    let none = regressions_table(&[], 0.0005);
    assert_eq!(none, "Nothing is slower by more than 0.05 %.\n");
}
