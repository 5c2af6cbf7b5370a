//! The tables of rates in the README and in `perf/rates.md`, as Markdown.

use super::text::{counted, rate};
use super::{AUTO, BenchRecord, RateRow, geometric_mean};
use crate::ray_kind::RayKind;
use std::collections::BTreeSet;

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

/// Source of a rate in the table.
#[derive(Clone, Copy, PartialEq)]
enum RateSource<'a> {
    Auto,
    /// A peer's best exact mode.
    Peer(&'a str),
    Oracle,
}

struct ReadmeTable<'a> {
    record: &'a BenchRecord,
    kinds: Vec<&'static str>,
    peers: Vec<&'a str>,
    fewest: u32,
    most: u32,
}

impl<'a> ReadmeTable<'a> {
    fn of(record: &'a BenchRecord) -> ReadmeTable<'a> {
        let ours = || record.rows.iter().filter(|row| RateSource::Auto.is(row));
        let threads: BTreeSet<u32> = ours().map(|row| row.threads).collect();
        let kinds = RayKind::names();
        let peers: BTreeSet<&str> = record.rows.iter().map(|row| row.engine.as_str()).collect();
        let peers = peers
            .into_iter()
            .filter(|name| !["phalanx", "oracle"].contains(name));
        ReadmeTable {
            record,
            kinds: kinds
                .filter(|kind| ours().any(|row| row.rays == *kind))
                .collect(),
            peers: peers.collect(),
            fewest: threads.first().copied().unwrap_or(1),
            most: threads.last().copied().unwrap_or(1),
        }
    }

    fn head(&self, first: &str) -> String {
        let kinds: Vec<String> = self.kinds.iter().map(ToString::to_string).collect();
        let rule = "---:|".repeat(kinds.len());
        line(&format!("Mrays/s, {first}"), &kinds) + "|---|" + &rule + "\n"
    }

    /// The other sources, peers first.
    fn others(&self) -> impl Iterator<Item = RateSource<'a>> {
        let peers = self.peers.iter().map(|&name| RateSource::Peer(name));
        peers.chain([RateSource::Oracle])
    }

    fn means(&self) -> String {
        let by_kind = |of: &dyn Fn(&str) -> String| -> Vec<String> {
            self.kinds.iter().map(|kind| of(kind)).collect()
        };
        let ours = |threads| {
            by_kind(&|kind| {
                let rates = self
                    .scene_names()
                    .filter_map(|s| self.rate(RateSource::Auto, s, kind, threads));
                geometric_mean(rates).map_or(nothing(), rate)
            })
        };
        let bold =
            |cells: Vec<String>| cells.iter().map(|c| format!("**{c}**")).collect::<Vec<_>>();
        let mut text = line("**phalanx**", &bold(ours(self.fewest)));
        for who in self.others() {
            let cells = by_kind(&|kind| {
                let ratios: Vec<f64> = self
                    .scene_names()
                    .filter_map(|scene| self.ratio(who, scene, kind))
                    .collect();
                // Not every peer supports every scene: a ratio covers the scenes that both have.
                let missing =
                    ratios.len() < self.scene_names().filter(|s| self.has(s, kind)).count();
                let of = if missing {
                    format!(" (of {})", ratios.len())
                } else {
                    String::new()
                };
                geometric_mean(ratios).map_or(nothing(), |mean| format!("× {}{of}", rate(mean)))
            });
            text += &line(&format!("phalanx ÷ {}", who.text()), &cells);
        }
        if self.most > self.fewest {
            let threads = counted(self.most as usize, "thread");
            text += &line(&format!("phalanx, {threads}"), &ours(self.most));
        }
        text
    }

    fn scenes(&self) -> String {
        let mut text = String::new();
        for scene in &self.record.scenes {
            let (name, count) = (escaped(&scene.name), primitives(scene.primitive_count));
            let of = |who, cell: &dyn Fn(f64, &str) -> String| -> Vec<String> {
                let rate = |kind| self.rate(who, &scene.name, kind, self.fewest);
                let kinds = self.kinds.iter();
                kinds
                    .map(|&kind| rate(kind).map_or(nothing(), |r| cell(r, kind)))
                    .collect()
            };
            let ours = of(RateSource::Auto, &|r, _| format!("**{}**", rate(r)));
            text += &line(&format!("**{name}**, {count}: phalanx"), &ours);
            for who in self.others() {
                let theirs = of(who, &|r, kind| {
                    let ratio = self.ratio(who, &scene.name, kind);
                    rate(r) + &ratio.map_or(String::new(), |ratio| format!(" (× {})", rate(ratio)))
                });
                if theirs.iter().any(|cell| *cell != nothing()) {
                    text += &line(&who.text(), &theirs);
                }
            }
        }
        text
    }

    fn scene_names(&self) -> impl Iterator<Item = &'a str> {
        self.record.scenes.iter().map(|scene| scene.name.as_str())
    }

    fn has(&self, scene: &str, kind: &str) -> bool {
        self.rate(RateSource::Auto, scene, kind, self.fewest)
            .is_some()
    }

    /// The best median of the rows that count.
    fn rate(&self, who: RateSource, scene: &str, kind: &str, threads: u32) -> Option<f64> {
        let of_set = |row: &&RateRow| {
            (row.scene == scene, row.threads) == (true, threads) && row.rays == kind
        };
        let rows = self.record.rows.iter().filter(of_set);
        let rates = rows
            .filter(|row| row.exact && who.is(row))
            .map(|row| row.mrays_per_s.median);
        rates.filter(|&rate| rate > 0.0).max_by(f64::total_cmp)
    }

    /// Our rate as a multiple of theirs, on the fewest threads.
    fn ratio(&self, who: RateSource, scene: &str, kind: &str) -> Option<f64> {
        let rate = |who| self.rate(who, scene, kind, self.fewest);
        Some(rate(RateSource::Auto)? / rate(who)?)
    }
}

impl RateSource<'_> {
    fn is(&self, row: &RateRow) -> bool {
        match self {
            RateSource::Auto => row.engine == "phalanx" && row.kernel == "auto",
            RateSource::Peer(name) => row.engine == *name,
            RateSource::Oracle => row.engine == "oracle",
        }
    }

    fn text(&self) -> String {
        match self {
            RateSource::Auto => "phalanx".to_owned(),
            RateSource::Peer(name) => format!("{}, best exact mode", escaped(name)),
            RateSource::Oracle => "scalar oracle".to_owned(),
        }
    }
}

/// Source of the numbers: machine, program and day.
fn source(record: &BenchRecord) -> String {
    let (machine, program, run) = (&record.machine, &record.program, &record.run);
    let mut facts = vec![escaped(&machine.cpu)];
    facts.push(counted(machine.threads as usize, "hardware thread"));
    facts.extend(match machine.hypervisor.as_deref() {
        None | Some("") => None,
        Some(name) => Some(format!("virtualised ({})", escaped(name))),
    });
    let mut built = format!("phalanx {}", program.version);
    if let Some(revision) = &program.git_revision {
        let short: String = revision.chars().take(8).collect();
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
    let parts: Vec<String> = parts.map(|part| escaped(&part)).collect();
    let day = run.started.split('T').next().unwrap_or_default();
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
    format!("| {first} | {} |\n", cells.join(" | "))
}

/// 1,234,567 as 1.2 M.
fn primitives(count: u64) -> String {
    match count {
        0..1_000 => counted(count as usize, "primitive"),
        1_000..1_000_000 => format!("{:.0} k primitives", count as f64 / 1e3),
        _ => format!("{:.1} M primitives", count as f64 / 1e6),
    }
}

/// Text with Markdown's special characters escaped.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '<' | '>' => out.extend(['\\', c]),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
