//! Several records beside each other.

use super::baseline::of_rays;
use super::text::{aligned, percent, rate};
use super::{BenchRecord, RateRow, geometric_mean};
use std::collections::BTreeMap;

type RateKey<'a> = (&'a str, &'a str, &'a str, &'a str, u32);

/// The medians of every rate that all records have, as a table. The first record is 100 %;
/// geometric means over scenes and kinds of rays are at the end. Records come with a name each,
/// such as the file's. Records of another machine or of other rays are shown all the same, with a
/// remark.
pub fn compare_table(records: &[(&str, &BenchRecord)]) -> String {
    let Some((&(_, first), others)) = records.split_first() else {
        return String::new();
    };
    let rates: Vec<BTreeMap<RateKey, f64>> = records.iter().map(|(_, r)| rates(r)).collect();
    let common: Vec<RateKey> = rates[0]
        .keys()
        .filter(|key| rates.iter().all(|r| r.contains_key(*key)))
        .copied()
        .collect();
    let mut head = vec!["scene", "rays", "engine", "kernel", "threads"];
    head.extend(records.iter().map(|(name, _)| *name));
    let mut lines: Vec<Vec<String>> = Vec::new();
    let mut together: BTreeMap<(&str, &str, u32), Vec<RateKey>> = BTreeMap::new();
    for &key in &common {
        let (scene, rays, engine, kernel, threads) = key;
        together
            .entry((engine, kernel, threads))
            .or_default()
            .push(key);
        let mut cells = [scene, rays, engine, kernel].map(str::to_owned).to_vec();
        cells.push(threads.to_string());
        cells.extend(shares(&rates.iter().map(|r| r[&key]).collect::<Vec<_>>()));
        lines.push(cells);
    }
    for ((engine, kernel, threads), keys) in together {
        let mut cells = ["geometric mean", "", engine, kernel]
            .map(str::to_owned)
            .to_vec();
        cells.push(threads.to_string());
        let mean = |r: &BTreeMap<RateKey, f64>| geometric_mean(keys.iter().map(|key| r[key]));
        cells.extend(shares(&rates.iter().filter_map(mean).collect::<Vec<_>>()));
        lines.push(cells);
    }
    let mut text = aligned(&head, &lines, 4);
    for (name, other) in others {
        text += &remarks(name, first, other);
    }
    let only = rates.iter().map(BTreeMap::len).max().unwrap_or(0) - common.len();
    if only > 0 {
        text += &format!("rows that not all of them have: up to {only}, left out\n");
    }
    text
}

/// Medians of a record's rows by their keys; rows without a median are left out.
fn rates<'a>(record: &'a BenchRecord) -> BTreeMap<RateKey<'a>, f64> {
    let measured = record
        .rows
        .iter()
        .filter(|row| row.mrays_per_s.median > 0.0);
    let named = |r: &'a RateRow| {
        let key: RateKey = (&r.scene, &r.rays, &r.engine, &r.kernel, r.threads);
        (key, r.mrays_per_s.median)
    };
    measured.map(named).collect()
}

/// The first rate as it is, the others with their difference from it in percent.
fn shares(rates: &[f64]) -> Vec<String> {
    let share = |(i, &r): (usize, &f64)| match i {
        0 => rate(r),
        _ => format!("{} {:>8}", rate(r), percent(r / rates[0] - 1.0)),
    };
    rates.iter().enumerate().map(share).collect()
}

/// Remarks on the differences that make a record's rates incomparable with the first one's.
fn remarks(name: &str, first: &BenchRecord, other: &BenchRecord) -> String {
    let mut text = String::new();
    if first.machine.cpu != other.machine.cpu {
        text += &format!("{name}: another CPU, {}\n", other.machine.cpu);
    }
    if first.program.isa_compiled != other.program.isa_compiled {
        text += &format!("{name}: compiled for {}\n", other.program.isa_compiled);
    }
    if first.run.quality != other.run.quality {
        text += &format!("{name}: trees of quality {}\n", other.run.quality);
    }
    let differ = of_rays(first, other);
    if let Some(one) = differ.first() {
        text += &format!("{name}: not the same rays: {one}");
        text += &match differ.len() {
            1 => "\n".to_owned(),
            more => format!(", and {} more\n", more - 1),
        };
    }
    text
}
