//! Records as pages to look at, one or several side by side: an HTML file that needs no network and
//! no script.
//!
//! Charts are SVG in the page's own colours, so that they follow the reader's choice of light or
//! dark.

mod axis;
mod changes;
mod comparison;
mod dots;
mod operations;
mod rates;
mod roofline;
mod scenes;
mod sizes;
mod summary;
mod svg;
mod tables;
mod threads;
mod view;

pub use changes::PageBaseline;
pub use scenes::ScenePictures;

use crate::numbers::plural;
use crate::{BenchRecord, RecordComparison};
use comparison::ComparedRecords;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use view::{RecordView, day};

const STYLE: &str = include_str!("style.css");

/// The page of a record. Where the record lacks data, the section has a note or is omitted. No
/// record is rejected.
pub fn page(record: &BenchRecord, pictures: &[ScenePictures]) -> String {
    page_against(record, pictures, None)
}

/// The page of a record, with the changes from a baseline where there is one.
pub fn page_against(
    record: &BenchRecord,
    pictures: &[ScenePictures],
    baseline: Option<&PageBaseline<'_>>,
) -> String {
    let view = RecordView::new(record);
    let mut sections = vec![
        section("headline", "In short", summary::headline(&view)),
        section("rates", "Rates", rates::section(&view)),
        PageSection {
            title: "Scaling over threads",
            ..section("threads", "Threads", threads::section(&view))
        },
        PageSection {
            title: "Scaling over scene size",
            ..section("sizes", "Sizes", sizes::section(&view))
        },
        section("roofline", "Roofline", roofline::section(&view)),
        section("scenes", "Scenes", scenes::section(&view, pictures)),
    ];
    if let Some(baseline) = baseline {
        let changes = changes::section(baseline);
        sections.insert(1, section("baseline", "Baseline", changes));
    }
    let header = html! {
        h1 { "phalanx bench " span.day { (day(record)) } }
        (summary::facts(record))
    };
    document(day(record), header, summary::warnings(&view), &sections)
}

/// The page of several records, which come with a name each. The first is the baseline.
pub fn comparison_page(records: &[(&str, &BenchRecord)], comparison: &RecordComparison) -> String {
    let of = ComparedRecords::new(records, comparison);
    let sections = [
        section("headline", "In short", comparison::headline(&of)),
        section("machines", "Machines", comparison::machines(&of)),
        section("rates", "Rates", comparison::rates(&of)),
        section("tracers", "Other tracers", comparison::ratios(&of)),
        section("scenes", "Scenes", comparison::scenes(&of)),
        section("baseline", "Baseline", comparison::baseline(&of)),
    ];
    let count = plural(records.len(), "record");
    let header = html! { h1 { "phalanx bench " span.day { (count) } } };
    document(&count, header, html! {}, &sections)
}

/// A section, and its name in the navigation.
struct PageSection {
    id: &'static str,
    name: &'static str,
    title: &'static str,
    content: Markup,
}

fn section(id: &'static str, name: &'static str, content: Markup) -> PageSection {
    PageSection {
        id,
        name,
        title: name,
        content,
    }
}

fn document(title: &str, header: Markup, before: Markup, sections: &[PageSection]) -> String {
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                // Browsers ask for an icon otherwise.
                link rel="icon" href="data:,";
                title { "phalanx bench " (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    (header)
                    nav aria-label="Sections" {
                        @for section in sections { a href={ "#" (section.id) } { (section.name) } }
                    }
                }
                main {
                    (before)
                    @for section in sections {
                        section id=(section.id) { h2 { (section.title) } (section.content) }
                    }
                }
            }
        }
    };
    printable(&markup.into_string())
}

/// Characters that HTML forbids or that steer others replaced.
fn printable(page: &str) -> String {
    let forbidden = |c: char| phalanx_files::steers(c) && c != '\n';
    page.replace(forbidden, "\u{fffd}")
}
