//! The rates of one scene, for the terminal.

use crate::cli::output::{aligned, grouped};
use phalanx::bench::Measured;
use phalanx::report::{RateRow, SceneRecord};
use std::collections::BTreeSet;

/// A heading line and the table of a scene's rates, or of its work if nothing was timed.
pub fn scene(measured: &Measured) -> String {
    let mut text = heading(&measured.scene);
    let table = match measured.rows.is_empty() {
        true => work(measured),
        false => rates(&measured.rows),
    };
    for line in aligned(&table) {
        text.push_str(&format!("  {}\n", line.trim_end()));
    }
    text.push('\n');
    text
}

fn heading(scene: &SceneRecord) -> String {
    let kinds = scene.primitives.iter().rev();
    let kinds: Vec<String> = kinds
        .map(|(kind, count)| format!("{} {kind}", grouped(*count)))
        .collect();
    let built = |engine: &str| scene.build_seconds.get(engine).copied().unwrap_or(0.0);
    let others = scene.build_seconds.iter();
    let others = others.filter(|(engine, _)| *engine != "phalanx");
    let others: Vec<String> = others
        .map(|(engine, seconds)| format!("{engine} {seconds:.3} s"))
        .collect();
    format!(
        "{}: {}; loaded in {:.3} s, built in {:.3} s ({})\n",
        scene.name,
        kinds.join(", "),
        scene.load_seconds,
        built("phalanx"),
        others.join(", ")
    )
}

fn rates(rows: &[RateRow]) -> Vec<Vec<String>> {
    let ours = names(rows, |row| row.engine == "phalanx" && row.kernel != "auto");
    let peers = names(rows, |row| row.difference.is_some());
    let mut head = vec![
        "Mrays/s".to_owned(),
        "threads".to_owned(),
        "auto".to_owned(),
    ];
    head.extend(ours.iter().cloned());
    head.extend(["oracle".to_owned(), "auto/oracle".to_owned()]);
    for peer in &peers {
        head.extend([format!("{peer}, best mode"), format!("auto/{peer}")]);
    }
    let mut table = vec![head];
    let mut seen: Vec<(&str, u32)> = Vec::new();
    for row in rows {
        let group = (row.rays.as_str(), row.threads);
        if seen.contains(&group) {
            continue;
        }
        seen.push(group);
        let of_group: Vec<&RateRow> = rows
            .iter()
            .filter(|r| (r.rays.as_str(), r.threads) == group)
            .collect();
        table.push(line(&of_group, &ours, &peers));
    }
    table
}

/// Names of the kernels, or of the engines of peers, that occur in the wanted rows.
fn names(rows: &[RateRow], wanted: impl Fn(&RateRow) -> bool) -> Vec<String> {
    let name = |row: &RateRow| match row.difference {
        None => row.kernel.clone(),
        Some(_) => row.engine.clone(),
    };
    let names: BTreeSet<String> = rows.iter().filter(|row| wanted(row)).map(name).collect();
    names.into_iter().collect()
}

fn line(rows: &[&RateRow], ours: &[String], peers: &[String]) -> Vec<String> {
    let find = |engine: &str, kernel: &str| {
        let found = rows
            .iter()
            .find(|r| r.engine == engine && r.kernel == kernel);
        found.map(|row| row.mrays_per_s)
    };
    let auto = find("phalanx", "auto");
    let median = |rate: Option<phalanx::report::Estimate>| {
        rate.map_or("-".to_owned(), |rate| format!("{:.2}", rate.median))
    };
    let ratio = |other: f64| {
        let ratio = auto
            .map(|auto| auto.median / other)
            .filter(|r| r.is_finite());
        ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"))
    };
    let spread = auto.map_or(0.0, |a| 50.0 * (a.high - a.low) / a.median);
    let mut cells = vec![
        rows[0].rays.clone(),
        rows[0].threads.to_string(),
        format!("{} ±{spread:.0}%", median(auto)),
    ];
    cells.extend(ours.iter().map(|kernel| median(find("phalanx", kernel))));
    let oracle = find("oracle", "scalar");
    cells.push(median(oracle));
    cells.push(ratio(oracle.map_or(f64::NAN, |rate| rate.median)));
    for peer in peers {
        let modes = rows.iter().filter(|r| r.engine == *peer && r.exact);
        let best = modes.max_by(|a, b| a.mrays_per_s.median.total_cmp(&b.mrays_per_s.median));
        cells.extend(match best {
            Some(best) => [
                format!("{:.2} {}", best.mrays_per_s.median, best.kernel),
                ratio(best.mrays_per_s.median),
            ],
            None => ["-".to_owned(), "-".to_owned()],
        });
    }
    cells
}

fn work(measured: &Measured) -> Vec<Vec<String>> {
    let head = [
        "rays",
        "kernel",
        "rays traced",
        "occupancy",
        "nodes/ray",
        "boxes/ray",
        "prims/ray",
        "bytes/ray",
    ];
    let mut table = vec![head.map(str::to_owned).to_vec()];
    for row in &measured.counters {
        let per_ray = |count: u64| format!("{:.2}", count as f64 / row.ray_count.max(1) as f64);
        let lanes = (8 * row.work.packets).max(1);
        table.push(vec![
            row.rays.clone(),
            row.kernel.clone(),
            grouped(row.ray_count),
            format!(
                "{:.1} %",
                100.0 * row.work.active_lanes as f64 / lanes as f64
            ),
            per_ray(row.work.node_visits),
            per_ray(row.work.box_tests),
            per_ray(row.work.prim_tests),
            per_ray(row.work.bytes),
        ]);
    }
    table
}
