//! Several records side by side.

use super::fixture::{KINDS, record, scale};
use phalanx::report::*;

fn comparison(records: &[&BenchRecord], all: bool) -> RecordComparison {
    let names = ["a.json", "b.json", "c.json"];
    let records: Vec<(&str, &BenchRecord)> =
        names.into_iter().zip(records.iter().copied()).collect();
    let options = ComparisonOptions {
        threshold: 0.03,
        all,
        any_machine: false,
    };
    RecordComparison::new(&records, options)
}

/// The text, which must fit the width.
fn text(comparison: &RecordComparison, width: usize) -> String {
    let text = comparison_text(comparison, width);
    for line in text.lines() {
        assert!(line.chars().count() <= width, "{width}: {line}");
    }
    text
}

#[test]
fn ranks_come_first_and_then_what_differs() {
    let (first, mut second) = (record(2), record(2));
    scale(&mut second, 1.25, |row| row.engine == "phalanx");
    scale(&mut second, 0.5, |row| {
        row.kernel == "packet8 coherent" && row.rays == "primary"
    });
    second.machine.cpu = "Other".into();
    second.run.quality = "fast".into();
    let compared = comparison(&[&first, &second], false);
    let ranks: Vec<(usize, &str)> = compared
        .ranks
        .iter()
        .map(|rank| (rank.record, rank.engine.as_str()))
        .collect();
    // Ours in B, ours in A, then Embree, which B has slower.
    assert_eq!(
        ranks[..4],
        [(1, "phalanx"), (0, "phalanx"), (0, "embree"), (1, "embree")]
    );
    let slowdown = |i: usize| compared.ranks[i].slowdown;
    assert!((slowdown(0) - 1.0).abs() < 1e-9 && (slowdown(1) - 1.25).abs() < 1e-9);
    // Two scenes, three kinds, two numbers of threads.
    assert_eq!((compared.ranked_rates, compared.ranked_scenes), (12, 2));
    // Ours in all of them, and Embree's primary rays; the oracle has not changed.
    assert_eq!((compared.differing, compared.compared), (12 + 4, 36));
    assert_eq!(
        compared.rates[0].engine, "embree",
        "the largest difference first"
    );
    assert_eq!(compared.means[0].mrays_per_s.len(), 2);
    let text = text(&compared, 80);
    let place = |part: &str| {
        text.find(part)
            .unwrap_or_else(|| panic!("{part} in\n{text}"))
    };
    assert!(
        place("ranks over 12 rates of 2 scenes") < place("16 of 36 single rates"),
        "{text}"
    );
    for part in [
        "Other, 2 hardware threads",
        "trees of quality fast, best in A",
        "+25.0 ±",
    ] {
        place(part);
    }
}

#[test]
fn rates_that_do_not_differ_are_listed_on_request() {
    let (first, second) = (record(2), record(2));
    let brief = text(&comparison(&[&first, &second], false), 80);
    assert!(brief.contains("None of 36 rates differs"), "{brief}");
    assert!(!brief.contains("packet8 coherent"), "{brief}");
    let all = comparison(&[&first, &second], true);
    assert_eq!(all.rates.len(), first.rows.len());
    let all = text(&all, 80);
    assert_eq!(all.matches("packet8 coherent").count(), 12, "{all}");
}

#[test]
fn records_without_a_rate_in_common_have_no_tables() {
    let (first, mut second) = (record(2), record(2));
    second.rows.clear();
    let compared = comparison(&[&first, &second], false);
    assert!(compared.ranks.is_empty() && compared.means.is_empty());
    assert!(compared.rates.is_empty());
    text(&compared, 80);
}

#[test]
fn more_records_than_fit_get_further_blocks() {
    let records = [record(1), record(1), record(1)];
    let compared = comparison(&records.each_ref(), true);
    let narrow = text(&compared, 80);
    assert!(narrow.contains("\n  C  c.json"), "{narrow}");
    text(&compared, 60);
    text(&compared, 200);
}

/// Rates missing in one record are omitted, and counted.
#[test]
fn records_of_other_rays_share_what_they_have() {
    let (first, mut second) = (record(2), record(2));
    second.rows.retain(|row| row.rays != "shadow");
    second.scenes[0].hash = "deadbeef".into();
    let compared = comparison(&[&first, &second], false);
    assert!(compared.means.iter().all(|mean| mean.rays != "shadow"));
    assert_eq!(compared.left_out, first.rows.len() / 3);
    let text = text(&compared, 80);
    assert!(text.contains("not the same rays"), "{text}");
    assert!(text.contains("left out: up to"), "{text}");
}

#[test]
fn markdown_has_the_same_tables() {
    let (first, mut second) = (record(2), record(2));
    scale(&mut second, 0.5, |row| row.engine == "phalanx");
    second.machine.cpu = "A|B".into();
    let compared = comparison(&[&first, &second], false);
    let text = comparison_markdown(&compared);
    assert!(
        text.contains("| rank | record | tracer | slowdown | Mrays/s |\n|---|---|---|---:|---:|\n"),
        "{text}"
    );
    assert!(
        text.contains("A\\|B") && text.contains("| -50.0 ± "),
        "{text}"
    );
    assert_eq!(
        text.matches("\n|---").count(),
        comparison_tables(&compared).len()
    );
}

#[test]
fn nothing_is_nothing() {
    let compared = comparison(&[], false);
    assert!(compared.ranks.is_empty() && comparison_tables(&compared).is_empty());
}

#[test]
fn a_slower_machine_is_told_from_a_slower_kernel_and_a_slower_oracle() {
    let measured = |speed: f64, slower: fn(&RateRow) -> bool, share: f64| {
        let (first, mut second) = (record(2), record(2));
        scale(&mut second, speed, |_| true);
        scale(&mut second, share, slower);
        comparison(&[&first, &second], true)
    };
    let machine =
        |compared: &RecordComparison| compared.records[1].machine.expect("the same machine").by;
    // Everything alike, the oracle, too.
    let slow = measured(0.75, |_| false, 1.0);
    assert!((machine(&slow) + 0.25).abs() < 1e-3, "{}", machine(&slow));
    assert_eq!((slow.differing, slow.groups.len()), (0, 0));
    assert!(text(&slow, 80).contains("the machine itself: -25.0 % against A"));
    // One kernel on such a machine, with every rate within its interval.
    let kernel = measured(0.75, |row| row.kernel == "packet8", 0.95);
    let names: Vec<(&str, u32)> = (kernel.groups.iter())
        .map(|group| (&*group.kernel, group.threads))
        .collect();
    assert_eq!(names, [("packet8", 1), ("packet8", 2)]);
    assert!(text(&kernel, 80).contains("packet8"));
    // The oracle alone is not the machine.
    let oracle = measured(1.0, |row| row.engine == "oracle", 0.75);
    assert!(machine(&oracle).abs() < 1e-3, "{}", machine(&oracle));
    assert_eq!(oracle.groups.len(), 0);
    // Ours, all of them.
    let ours = measured(1.0, |row| row.engine == "phalanx", 0.9);
    assert!(machine(&ours).abs() < 1e-3, "{}", machine(&ours));
    assert_eq!(ours.groups.len(), 6);
}

/// Other load slows all tracers in a measurement, each by a different share.
#[test]
fn a_slower_kernel_is_found_under_load() {
    let (first, mut second) = (record(6), record(6));
    let names: Vec<String> = second
        .scenes
        .iter()
        .map(|scene| scene.name.clone())
        .collect();
    for (i, name) in names.iter().enumerate() {
        for (k, kind) in KINDS.into_iter().enumerate() {
            let share = 1.0 - 0.08 * ((3 * i + 2 * k) % 7) as f64;
            scale(&mut second, share, |row| {
                row.scene == *name && row.rays == kind
            });
        }
    }
    let changed = |second: &BenchRecord| {
        let compared = comparison(&[&first, second], true);
        let names = compared.groups.iter().map(|group| group.kernel.clone());
        names.collect::<Vec<String>>()
    };
    assert_eq!(changed(&second), Vec::<String>::new());
    scale(&mut second, 0.95, |row| row.kernel == "packet8");
    assert_eq!(changed(&second), ["packet8", "packet8"]);
}
