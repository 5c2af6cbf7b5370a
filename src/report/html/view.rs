//! A record arranged for reading: its scenes, kinds and thread counts, and the rows that belong
//! together.

use crate::numbers::page_counted;
use crate::record_index::{first_of_each, in_order};
use crate::text;
use crate::{BenchRecord, FRAME, RayKind, RecordIndex, SceneRecord};
use maud::{Markup, html};
use std::collections::BTreeSet;

/// A record, arranged.
pub(super) struct RecordView<'a> {
    pub(super) record: &'a BenchRecord,
    /// Scenes in the record's order, then those that only rows name.
    pub(super) scenes: Vec<&'a str>,
    /// Kinds of rays that have a row or counters.
    pub(super) kinds: Vec<&'a str>,
    /// Thread counts that have a row, fewest first.
    pub(super) threads: Vec<u32>,
    pub(super) index: RecordIndex<'a>,
}

impl<'a> RecordView<'a> {
    pub(super) fn new(record: &'a BenchRecord) -> RecordView<'a> {
        let rows = &record.rows;
        let counters = &record.counters;
        let names = record.scenes.iter().map(|s| s.name.as_str());
        let scenes = names.chain(rows.iter().map(|r| r.scene.as_str()));
        let scenes = scenes.chain(counters.iter().map(|c| c.scene.as_str()));
        let kinds = rows.iter().map(|r| r.rays.as_str());
        let kinds = kinds.chain(counters.iter().map(|c| c.rays.as_str()));
        let order: Vec<&str> = RayKind::names().collect();
        let threads: BTreeSet<u32> = rows.iter().map(|r| r.threads).collect();
        RecordView {
            record,
            scenes: first_of_each(scenes),
            kinds: in_order(kinds.map(|kind| (kind, kind)), &order),
            threads: threads.into_iter().collect(),
            index: RecordIndex::new(&record.scenes, rows),
        }
    }

    /// The record's data of a scene.
    pub(super) fn scene(&self, name: &str) -> Option<&'a SceneRecord> {
        self.record.scenes.iter().find(|s| s.name == name)
    }

    /// A scene's name as the axes have it: a standard scene's family and size.
    pub(super) fn short_name(&self, name: &str) -> String {
        text::short_name(name, 18).replace(':', " ")
    }
}

/// A scene's name for the first column of a table: without parts that are obvious, and shortened if
/// too long.
pub(super) fn row_name(name: &str) -> Markup {
    let short = text::short_name(name, 24);
    html! { span title=[(short != name).then_some(name)] { (short) } }
}

/// A kind of rays in words; `frame` is everything that a picture takes.
pub(super) fn kind_text(kind: &str) -> String {
    match kind {
        FRAME => "whole frames".to_owned(),
        _ => format!("{kind} rays"),
    }
}

/// The day of a run.
pub(super) fn day(record: &BenchRecord) -> &str {
    text::day(&record.run.started)
}

/// `2 threads` or `1 thread`.
pub(super) fn threads_text(threads: u32) -> String {
    page_counted(threads as usize, "thread")
}
