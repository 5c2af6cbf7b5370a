//! The tables of rates in the README and in `perf/rates.md`, as Markdown.

use phalanx::report::{
    AUTO, BenchRecord, NONE, ORACLE, RayKind, RecordIndex, ReportTable, commit, counted, day,
    markdown, rate,
};

/// Geometric means over a record's scenes of triangles as Markdown, by kind of rays on the fewest
/// threads: our rates (`auto`), their ratios to each peer's best mode with exact results and to the
/// oracle, and our rates on all threads. Then ours in each other scene, with their ratios to the
/// best peer, and the machine.
pub fn readme_table(record: &BenchRecord) -> String {
    let table = ReadmeTable::new(record);
    let scenes = format!("geometric means of {}, ", table.index.averaged_words());
    table.text(&scenes, ReadmeTable::means, ".")
}

/// Rates in each scene of a record as Markdown, by kind of rays on the fewest threads: ours
/// (`auto`), each peer's best mode with exact results, the oracle's, and the ratio of ours to
/// theirs. Then come the machine and the command.
pub fn scene_table(record: &BenchRecord) -> String {
    let command = record.run.arguments.join(" ").replace('`', "'");
    let end = format!(", `phalanx {command}`.");
    ReadmeTable::new(record).text("", ReadmeTable::scenes, &end)
}

struct ReadmeTable<'a> {
    record: &'a BenchRecord,
    index: RecordIndex<'a>,
    kinds: Vec<&'static str>,
    fewest: u32,
    most: u32,
}

impl<'a> ReadmeTable<'a> {
    fn new(record: &'a BenchRecord) -> ReadmeTable<'a> {
        let index = RecordIndex::new(&record.scenes, &record.rows);
        let kinds = RayKind::names().filter(|kind| index.kinds.contains(kind));
        ReadmeTable {
            record,
            kinds: kinds.collect(),
            fewest: index.threads.first().copied().unwrap_or(1),
            most: index.threads.last().copied().unwrap_or(1),
            index,
        }
    }

    /// The table with what its rates are of, and a line for their source.
    fn text(&self, scenes: &str, rows: fn(&Self) -> Vec<Vec<String>>, end: &str) -> String {
        if self.kinds.is_empty() {
            return "The record has no rates.\n".to_owned();
        }
        let threads = counted(self.fewest as usize, "thread");
        let mut table = ReportTable::new("", &format!("Mrays/s, {scenes}{threads}"), 1);
        let kinds = self.kinds.iter().map(ToString::to_string);
        table.head.extend(kinds);
        let table = table.with(rows(self)).markdown_rows(str::to_owned);
        format!("{table}\n{}{end}\n", source(self.record))
    }

    /// A row with a cell for each kind of rays.
    fn row(&self, first: String, cell: impl Fn(&str) -> Option<String>) -> Vec<String> {
        let cells = self.kinds.iter().map(|kind| cell(kind));
        let cells = cells.map(|cell| cell.unwrap_or(NONE.to_owned()));
        std::iter::once(first).chain(cells).collect()
    }

    /// The other entrants with their names in the table, peers first.
    fn others(&self) -> impl Iterator<Item = (&'a str, String)> {
        let peers = self.index.peers();
        let peers = peers.map(|name| (name, format!("{}, best exact mode", markdown(name))));
        peers.chain([(ORACLE, "scalar oracle".to_owned())])
    }

    fn means(&self) -> Vec<Vec<String>> {
        let mean = |kind: &str, threads| self.index.mean(AUTO, kind, threads).map(rate);
        let bold = |cell: Option<String>| format!("**{}**", cell.as_deref().unwrap_or(NONE));
        let ours = |kind: &str| Some(bold(mean(kind, self.fewest)));
        let mut rows = vec![self.row("**phalanx**".to_owned(), ours)];
        for (name, shown) in self.others() {
            let ratio = |kind: &str| self.mean_ratio(name, kind);
            rows.push(self.row(format!("phalanx ÷ {shown}"), ratio));
        }
        if self.most > self.fewest {
            let first = format!("phalanx, {}", counted(self.most as usize, "thread"));
            rows.push(self.row(first, |kind| mean(kind, self.most)));
        }
        let averaged = &self.index.averaged;
        let apart = self.record.scenes.iter();
        for scene in apart.filter(|scene| !averaged.contains(&&*scene.name)) {
            let name = markdown(&scene.name);
            let has_peer = |peer: &str| {
                self.kinds
                    .iter()
                    .any(|kind| self.rate(peer, &scene.name, kind).is_some())
            };
            let first = if self.index.peers().any(has_peer) {
                format!("{name} (÷ best peer)")
            } else {
                name
            };
            rows.push(self.row(first, |kind| {
                let ours = self.rate(AUTO, &scene.name, kind)?;
                let peers = self.index.peers();
                let peers = peers.filter_map(|peer| self.rate(peer, &scene.name, kind));
                let best = peers.max_by(f64::total_cmp);
                let ratio = best.map(|best| format!(" (×{})", rate(ours / best)));
                Some(rate(ours) + &ratio.unwrap_or_default())
            }));
        }
        rows
    }

    fn mean_ratio(&self, name: &str, kind: &str) -> Option<String> {
        let over = self.index.over(name, kind, self.fewest)?;
        // Not every peer supports every scene: a ratio covers the scenes that both have.
        let scenes = self.index.averaged.iter();
        let ours = scenes.filter(|scene| self.rate(AUTO, scene, kind).is_some());
        let share = if over.scenes < ours.count() {
            format!(" (of {})", over.scenes)
        } else {
            String::new()
        };
        Some(format!("× {}{share}", rate(over.mean)))
    }

    fn scenes(&self) -> Vec<Vec<String>> {
        let mut rows = Vec::new();
        for scene in &self.record.scenes {
            let (name, count) = (markdown(&scene.name), primitives(scene.primitive_count));
            let ours = |kind: &str| self.rate(AUTO, &scene.name, kind);
            rows.push(self.row(format!("**{name}**, {count}: phalanx"), |kind| {
                Some(format!("**{}**", rate(ours(kind)?)))
            }));
            for (name, shown) in self.others() {
                let theirs = |kind: &str| {
                    let theirs = self.rate(name, &scene.name, kind)?;
                    let ratio = ours(kind).map(|ours| format!(" (× {})", rate(ours / theirs)));
                    Some(rate(theirs) + &ratio.unwrap_or_default())
                };
                if self.kinds.iter().any(|kind| theirs(kind).is_some()) {
                    rows.push(self.row(shown, theirs));
                }
            }
        }
        rows
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
    let hypervisor = machine.hypervisor.as_ref().filter(|name| !name.is_empty());
    facts.extend(hypervisor.map(|name| format!("virtualised ({})", markdown(name))));
    let (version, isa, quality) = (&program.version, &program.isa_compiled, &run.quality);
    let commit = commit(program).map_or(String::new(), |commit| format!(" ({commit})"));
    let built = format!("phalanx {version}{commit} for {isa}, kernel {AUTO}, {quality} trees");
    let parts = std::iter::once(&built).chain(&program.rustc);
    let parts = parts.chain(&run.peers).map(|part| markdown(part));
    let parts: Vec<String> = parts.collect();
    let day = day(&run.started);
    let [width, height] = run.size;
    format!(
        "Medians, millions of rays a second, {width}×{height} unless a scene says otherwise; {}; {}; {day}",
        facts.join(", "),
        parts.join(", "),
    )
}

/// 1,234,567 as 1.2 M.
fn primitives(count: u64) -> String {
    match count {
        0..1_000 => counted(count as usize, "primitive"),
        1_000..1_000_000 => format!("{:.0} k primitives", count as f64 / 1e3),
        _ => format!("{:.1} M primitives", count as f64 / 1e6),
    }
}
