//! The tables of rates in the README and in `perf/rates.md`, as Markdown.

use super::text::{counted, day, markdown, markdown_row, rate, short_commit};
use super::{AUTO, BenchRecord, ORACLE, RecordIndex};
use crate::ray_kind::RayKind;

/// Text in the place of a table where a record has no rates.
const NO_RATES: &str = "The record has no rates.\n";

/// Geometric means over a record's scenes as Markdown, by kind of rays on the fewest threads: our
/// rates (`auto`), their ratios to each peer's best mode with exact results and to the oracle, and
/// our rates on all threads. Then comes the machine.
pub fn readme_table(record: &BenchRecord) -> String {
    let table = ReadmeTable::of(record);
    if table.kinds.is_empty() {
        return NO_RATES.to_owned();
    }
    let scenes = counted(record.scenes.len(), "scene");
    let threads = counted(table.fewest as usize, "thread");
    let head = table.head(&format!("geometric means of {scenes}, {threads}"));
    head + &table.means() + "\n" + &source(record) + ".\n"
}

/// Rates in each scene of a record as Markdown, by kind of rays on the fewest threads: ours
/// (`auto`), each peer's best mode with exact results, the oracle's, and the ratio of ours to
/// theirs. Then come the machine and the command.
pub fn scene_table(record: &BenchRecord) -> String {
    let table = ReadmeTable::of(record);
    if table.kinds.is_empty() {
        return NO_RATES.to_owned();
    }
    let head = table.head(&counted(table.fewest as usize, "thread"));
    let command = record.run.arguments.join(" ").replace('`', "'");
    head + &table.scenes() + "\n" + &source(record) + &format!(", `phalanx {command}`.\n")
}

struct ReadmeTable<'a> {
    record: &'a BenchRecord,
    index: RecordIndex<'a>,
    kinds: Vec<&'static str>,
    fewest: u32,
    most: u32,
}

impl<'a> ReadmeTable<'a> {
    fn of(record: &'a BenchRecord) -> ReadmeTable<'a> {
        let index = RecordIndex::of(&record.rows);
        let kinds = RayKind::names().filter(|kind| index.kinds.contains(kind));
        ReadmeTable {
            record,
            kinds: kinds.collect(),
            fewest: index.threads.first().copied().unwrap_or(1),
            most: index.threads.last().copied().unwrap_or(1),
            index,
        }
    }

    fn head(&self, first: &str) -> String {
        let kinds: Vec<String> = self.kinds.iter().map(ToString::to_string).collect();
        let rule = "---:|".repeat(kinds.len());
        line(&format!("Mrays/s, {first}"), &kinds) + "|---|" + &rule + "\n"
    }

    /// The other entrants with their names in the table, peers first.
    fn others(&self) -> impl Iterator<Item = (&'a str, String)> {
        let peers = self.index.peers();
        let peers = peers.map(|name| (name, format!("{}, best exact mode", markdown(name))));
        peers.chain([(ORACLE, "scalar oracle".to_owned())])
    }

    fn means(&self) -> String {
        let ours = |threads| -> Vec<String> {
            let mean = |kind: &&str| self.index.mean(AUTO, kind, threads);
            let kinds = self.kinds.iter();
            kinds
                .map(|kind| mean(kind).map_or(nothing(), rate))
                .collect()
        };
        let bold = |cell: String| format!("**{cell}**");
        let fewest: Vec<String> = ours(self.fewest).into_iter().map(bold).collect();
        let mut text = line("**phalanx**", &fewest);
        for (name, shown) in self.others() {
            let kinds = self.kinds.iter();
            let cells: Vec<String> = kinds.map(|kind| self.mean_ratio(name, kind)).collect();
            text += &line(&format!("phalanx ÷ {shown}"), &cells);
        }
        if self.most > self.fewest {
            let threads = counted(self.most as usize, "thread");
            text += &line(&format!("phalanx, {threads}"), &ours(self.most));
        }
        text
    }

    fn mean_ratio(&self, name: &str, kind: &str) -> String {
        let Some(over) = self.index.over(name, kind, self.fewest) else {
            return nothing();
        };
        // Not every peer supports every scene: a ratio covers the scenes that both have.
        let scenes = self.index.scenes.iter();
        let ours = scenes.filter(|scene| self.rate(AUTO, scene, kind).is_some());
        let of = match over.scenes < ours.count() {
            true => format!(" (of {})", over.scenes),
            false => String::new(),
        };
        format!("× {}{of}", rate(over.mean))
    }

    fn scenes(&self) -> String {
        let mut text = String::new();
        for scene in &self.record.scenes {
            let (name, count) = (markdown(&scene.name), primitives(scene.primitive_count));
            let of = |name: &str, cell: &dyn Fn(f64, &str) -> String| -> Vec<String> {
                let rate = |kind| self.rate(name, &scene.name, kind);
                let kinds = self.kinds.iter();
                kinds
                    .map(|&kind| rate(kind).map_or(nothing(), |r| cell(r, kind)))
                    .collect()
            };
            let ours = of(AUTO, &|r, _| format!("**{}**", rate(r)));
            text += &line(&format!("**{name}**, {count}: phalanx"), &ours);
            for (name, shown) in self.others() {
                let theirs = of(name, &|r, kind| {
                    let ours = self.rate(AUTO, &scene.name, kind);
                    rate(r) + &ours.map_or(String::new(), |ours| format!(" (× {})", rate(ours / r)))
                });
                if theirs.iter().any(|cell| *cell != nothing()) {
                    text += &line(&shown, &theirs);
                }
            }
        }
        text
    }

    /// A rate on the fewest threads.
    fn rate(&self, name: &str, scene: &str, kind: &str) -> Option<f64> {
        self.index.rate(name, scene, kind, self.fewest)
    }
}

/// Source of the numbers: machine, program and day.
fn source(record: &BenchRecord) -> String {
    let (machine, program, run) = (&record.machine, &record.program, &record.run);
    let mut facts = vec![markdown(&machine.cpu)];
    facts.push(counted(machine.threads as usize, "hardware thread"));
    facts.extend(match machine.hypervisor.as_deref() {
        None | Some("") => None,
        Some(name) => Some(format!("virtualised ({})", markdown(name))),
    });
    let mut built = format!("phalanx {}", program.version);
    if let Some(revision) = &program.git_revision {
        let short = short_commit(revision);
        let dirty = if program.git_dirty == Some(true) {
            ", changed"
        } else {
            ""
        };
        built += &format!(" ({short}{dirty})");
    }
    let (isa, quality) = (&program.isa_compiled, &run.quality);
    built += &format!(" for {isa}, kernel {AUTO}, {quality} trees");
    let parts = [built]
        .into_iter()
        .chain(program.rustc.clone())
        .chain(run.peers.iter().cloned());
    let parts: Vec<String> = parts.map(|part| markdown(&part)).collect();
    let day = day(&run.started);
    let [width, height] = run.size;
    format!(
        "Medians, millions of rays a second, {width}×{height} unless a scene says otherwise; {}; {}; {day}",
        facts.join(", "),
        parts.join(", "),
    )
}

fn nothing() -> String {
    "–".to_owned()
}

fn line(first: &str, cells: &[String]) -> String {
    markdown_row(&[&[first.to_owned()], cells].concat())
}

/// 1,234,567 as 1.2 M.
fn primitives(count: u64) -> String {
    match count {
        0..1_000 => counted(count as usize, "primitive"),
        1_000..1_000_000 => format!("{:.0} k primitives", count as f64 / 1e3),
        _ => format!("{:.1} M primitives", count as f64 / 1e6),
    }
}
