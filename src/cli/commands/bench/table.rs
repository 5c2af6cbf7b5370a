//! Tables of rates for the terminal: for each scene, and over all scenes.

use crate::cli::output::grouped;
use phalanx::bench::Measured;
use phalanx::report::{
    AUTO, BenchRecord, RecordIndex, ReportTable, SceneRecord, quotable_line, rate, wrapped,
};

/// Minimum width for showing the peers' own rates and modes.
const WIDE: usize = 120;

/// Text between a ratio and its number of scenes, if that is not all of them.
const OF: &str = " of ";

/// The heading and the table of a scene's rates, or of its work if nothing was timed, in `width`
/// columns.
pub fn scene(measured: &Measured, width: usize) -> String {
    let table = if measured.rows.is_empty() {
        work(measured, width)
    } else {
        rates(&RecordIndex::new(&[], &measured.rows), width)
    };
    heading(&measured.scene, width) + &table + "\n"
}

/// Geometric means over several scenes, the machine, and a line to quote. Empty if nothing was
/// timed.
pub fn summary(record: &BenchRecord, width: usize) -> String {
    let Some(line) = quotable_line(record) else {
        return String::new();
    };
    let mut text = String::new();
    if record.scenes.len() > 1 {
        let index = RecordIndex::new(&record.scenes, &record.rows);
        text += &format!("geometric means over {}\n", index.averaged_words());
        let means = rates(&index, width);
        text += &means;
        if means.contains(OF) {
            text += "  of N: mean over the N scenes that this tracer supports\n";
        }
        text.push('\n');
    }
    let (machine, run) = (&record.machine, &record.run);
    let threads = format!("{} hardware threads", machine.threads);
    let build = format!("built for {}", record.program.isa_compiled);
    let mut facts = vec![machine.cpu.clone(), threads, build];
    facts.extend(run.peers.iter().cloned());
    facts.push(format!("{:.0} s", run.seconds));
    facts.extend(run.partial.then(|| "partial: ended early".to_owned()));
    text + &wrapped(&facts.join(", "), "", width) + &line + "\n"
}

fn heading(scene: &SceneRecord, width: usize) -> String {
    let kinds = scene.primitives.iter().rev();
    let kinds: Vec<String> = kinds
        .map(|(kind, count)| format!("{} {kind}", grouped(*count)))
        .collect();
    let built = scene.build_seconds.iter();
    let built = built.map(|(engine, seconds)| format!("{engine} {}", short_time(*seconds)));
    let times = format!(
        "loaded in {}, built in: {}",
        short_time(scene.load_seconds),
        built.collect::<Vec<_>>().join(", ")
    );
    let name = format!("{}: {}\n", scene.name, kinds.join(", "));
    name + &wrapped(&times, "  ", width)
}

/// Seconds, or milliseconds below one.
fn short_time(seconds: f64) -> String {
    match seconds {
        s if s < 0.0995 => format!("{:.1} ms", 1e3 * s),
        s if s < 0.9995 => format!("{:.0} ms", 1e3 * s),
        s => format!("{s:.2} s"),
    }
}

/// Rates of `auto` by kind of rays and threads, whole frames first, and its speedup over each other
/// entrant. Over several scenes, these are geometric means.
fn rates(best: &RecordIndex, width: usize) -> String {
    let wide = width >= WIDE && best.scenes.len() == 1;
    let peers = || best.peers().filter(|_| wide);
    let row = |kind: &str, threads: u32| {
        let mut cells = vec![kind.to_owned(), threads.to_string()];
        cells.push(ours(best, kind, threads)?);
        let others = best.others.iter();
        cells.extend(others.map(|name| ratio(best, name, kind, threads)));
        cells.extend(peers().map(|peer| best_mode(best, peer, kind, threads)));
        Some(cells)
    };
    let kinds = best.kinds.iter();
    let rows = kinds.flat_map(|kind| best.threads.iter().filter_map(|on| row(kind, *on)));
    let mut table = ReportTable::new("", "rays | threads | Mrays/s", 1);
    table.names = 2;
    let others = best.others.iter().map(|name| format!("× {name}"));
    table.head.extend(others);
    let peers = peers().map(|peer| format!("{peer}, best mode"));
    table.head.extend(peers);
    table.with(rows).fitted(width)
}

/// The rate of `auto`; for a single scene with half its interval.
fn ours(best: &RecordIndex, kind: &str, threads: u32) -> Option<String> {
    let mean = best.mean(AUTO, kind, threads)?;
    let spread = |scene: &str| {
        let rate = best.get(AUTO, scene, kind, threads)?.mrays_per_s;
        Some(50.0 * (rate.high - rate.low) / rate.median)
    };
    let spread = match best.scenes[..] {
        [scene] => spread(scene),
        _ => None,
    };
    let spread = spread.map_or(String::new(), |spread| format!(" ±{spread:>2.0} %"));
    Some(rate(mean) + &spread)
}

fn ratio(best: &RecordIndex, name: &str, kind: &str, threads: u32) -> String {
    let Some(over) = best.over(name, kind, threads) else {
        return "-".to_owned();
    };
    // A peer that cannot trace every scene is compared on the others.
    let scenes = if over.scenes < best.averaged.len() {
        format!("{OF}{}", over.scenes)
    } else {
        String::new()
    };
    format!("{:.2}{scenes}", over.mean)
}

/// A peer's own rate in a scene, and the mode that reached it.
fn best_mode(best: &RecordIndex, peer: &str, kind: &str, threads: u32) -> String {
    let row = best
        .scenes
        .first()
        .and_then(|scene| best.get(peer, scene, kind, threads));
    row.map_or("-".to_owned(), |row| {
        format!("{} {}", rate(row.mrays_per_s.median), row.kernel)
    })
}

/// Counted work per kernel and kind of rays.
fn work(measured: &Measured, width: usize) -> String {
    let rows = measured.counters.iter().map(|row| {
        let (work, rays) = (&row.work, row.ray_count.max(1) as f64);
        let lanes = (8 * work.packets).max(1) as f64;
        let occupancy = 100.0 * work.active_lanes as f64 / lanes;
        let mut cells = vec![row.rays.clone(), row.kernel.clone()];
        cells.extend([grouped(row.ray_count), format!("{occupancy:.1} %")]);
        let counts = [
            work.node_visits,
            work.box_tests,
            work.prim_tests,
            work.bytes,
        ];
        cells.extend(counts.map(|count| format!("{:.2}", count as f64 / rays)));
        cells
    });
    let head = "rays | kernel | traced | lanes | nodes | boxes | prims | bytes";
    let title = "  counted work; nodes, boxes, prims and bytes are per ray\n";
    title.to_owned() + &ReportTable::new("", head, 2).with(rows).fitted(width)
}
