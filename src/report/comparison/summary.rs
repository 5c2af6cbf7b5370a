//! Ranks and geometric means of several records.

use crate::record_index::some_or_all;
use crate::{AUTO, PHALANX, RecordIndex, geometric_mean};
use serde::Serialize;
use std::collections::BTreeSet;

/// An engine of a record, by how fast it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EngineRank {
    /// Position, from 1.
    pub rank: usize,
    /// Index of the record.
    pub record: usize,
    /// Engine: ours by its kernel `auto`, a peer by its best exact mode of each measurement.
    pub engine: String,
    /// Geometric mean of the fastest rate of each measurement divided by this engine's: 1 for an
    /// engine that is always the fastest.
    pub slowdown: f64,
    /// Geometric mean of its rates.
    pub mrays_per_s: f64,
}

/// Geometric means of our rates over scenes of triangles, or over all where there are none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeanRates {
    /// Kind of rays.
    pub rays: String,
    /// Threads.
    pub threads: u32,
    /// Number of scenes that all records have.
    pub scenes: usize,
    /// The mean of each record.
    pub mrays_per_s: Vec<f64>,
}

/// Our rates divided by another engine's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeanRatios {
    /// The other engine.
    pub engine: String,
    /// Threads.
    pub threads: u32,
    /// Geometric mean over all scenes and kinds of rays of each record that it took part in.
    pub ratios: Vec<Option<f64>>,
}

/// Ranks, and what they are of.
#[derive(Default)]
pub(super) struct Ranking {
    pub rates: usize,
    pub scenes: usize,
    pub ranks: Vec<EngineRank>,
}

/// Ranks the engines of all records on the measurements that all of them have, as rebar does for
/// regex engines.
pub(super) fn ranking(records: &[RecordIndex]) -> Ranking {
    let best: Vec<_> = records.iter().map(RecordIndex::by_engine).collect();
    let engines = best
        .iter()
        .map(|rows| rows.keys().map(|key| key.2).collect());
    let engines: Vec<BTreeSet<&str>> = engines.collect();
    let entrants = engines.iter().enumerate();
    let entrants =
        entrants.flat_map(|(record, names)| names.iter().map(move |engine| (record, *engine)));
    let entrants: Vec<(usize, &str)> = entrants.collect();
    let rate = |&(record, engine): &(usize, &str), set: &(&str, &str, u32)| {
        let row = best[record].get(&(set.0, set.1, engine, set.2));
        row.map_or(f64::NAN, |row| row.mrays_per_s.median)
    };
    let rates = best
        .iter()
        .flat_map(|rows| rows.keys().map(|key| (key.0, key.1, key.3)));
    let mut shared: BTreeSet<(&str, &str, u32)> = rates.collect();
    shared.retain(|set| entrants.iter().all(|entrant| !rate(entrant, set).is_nan()));
    let scenes: Vec<&str> = shared.iter().map(|set| set.0).collect();
    let averaged = some_or_all(&scenes, |scene| records[0].averaged.contains(scene));
    shared.retain(|set| averaged.contains(&set.0));
    if engines.iter().any(BTreeSet::is_empty) || shared.is_empty() {
        return Ranking::default();
    }
    let fastest = |set| entrants.iter().map(|e| rate(e, set)).fold(0.0, f64::max);
    let rank = |entrant: &(usize, &str)| {
        let slowdown = geometric_mean(shared.iter().map(|set| fastest(set) / rate(entrant, set)))?;
        Some(EngineRank {
            rank: 0,
            record: entrant.0,
            engine: entrant.1.to_owned(),
            slowdown,
            mrays_per_s: geometric_mean(shared.iter().map(|set| rate(entrant, set)))?,
        })
    };
    let mut ranks: Vec<EngineRank> = entrants.iter().filter_map(rank).collect();
    ranks.sort_by(|a, b| a.slowdown.total_cmp(&b.slowdown));
    for (i, rank) in ranks.iter_mut().enumerate() {
        rank.rank = i + 1;
    }
    let scenes: BTreeSet<&str> = shared.iter().map(|set| set.0).collect();
    Ranking {
        rates: shared.len(),
        scenes: scenes.len(),
        ranks,
    }
}

/// Means of our rates by kind of rays and threads, over the scenes that all records have.
pub(super) fn means(records: &[RecordIndex]) -> Vec<MeanRates> {
    let Some(first) = records.first() else {
        return Vec::new();
    };
    let means = |kind: &str, threads: u32| {
        let shared = first.scenes.iter().filter(|scene| {
            let has = |best: &RecordIndex| best.get(AUTO, scene, kind, threads).is_some();
            records.iter().all(has)
        });
        let shared: Vec<&str> = shared.copied().collect();
        let shared = some_or_all(&shared, |scene| first.averaged.contains(scene));
        let mean = |best: &RecordIndex| {
            let scenes = shared.iter();
            geometric_mean(scenes.filter_map(|scene| best.rate(AUTO, scene, kind, threads)))
        };
        Some(MeanRates {
            rays: kind.to_owned(),
            threads,
            scenes: shared.len(),
            mrays_per_s: records.iter().map(mean).collect::<Option<_>>()?,
        })
    };
    let kinds = first.kinds.iter();
    let all = kinds.flat_map(|kind| first.threads.iter().map(move |&threads| (*kind, threads)));
    all.filter_map(|(kind, threads)| means(kind, threads))
        .collect()
}

/// Our rates over those of the oracle and of each peer, by threads.
pub(super) fn ratios(records: &[RecordIndex]) -> Vec<MeanRatios> {
    let engines = records.iter().flat_map(|best| best.engines.iter().copied());
    let engines: BTreeSet<&str> = engines.filter(|name| *name != PHALANX).collect();
    let threads = records.iter().flat_map(|best| best.threads.clone());
    let threads: BTreeSet<u32> = threads.collect();
    let pairs = engines
        .iter()
        .flat_map(|engine| threads.iter().map(move |count| (*engine, *count)));
    let ratios = pairs.map(|(engine, threads)| MeanRatios {
        engine: engine.to_owned(),
        threads,
        ratios: records
            .iter()
            .map(|best| best.over_all(engine, threads))
            .collect(),
    });
    let known = ratios.filter(|means| means.ratios.iter().any(Option::is_some));
    known.collect()
}
