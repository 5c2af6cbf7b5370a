//! Records as pages to look at, one or several side by side: an HTML file that needs no network and
//! no script.
//!
//! Charts are SVG in the page's own colours, so that they follow the reader's choice of light or
//! dark.

mod axis;
mod comparison;
mod dots;
mod rates;
mod scenes;
mod sizes;
mod summary;
mod svg;
mod tables;
mod threads;
mod view;

pub use scenes::ScenePictures;

use crate::numbers::page_counted;
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

/// The page of a record, with the changes from an earlier one where it is given with their
/// comparison.
pub fn page_against(
    record: &BenchRecord,
    pictures: &[ScenePictures],
    baseline: Option<(&BenchRecord, &RecordComparison)>,
) -> String {
    let view = RecordView::new(record);
    let mut sections = vec![
        ("headline", ["In short"; 2], summary::headline(&view)),
        ("rates", ["Rates"; 2], rates::section(&view)),
        (
            "threads",
            ["Threads", "Scaling over threads"],
            threads::section(&view),
        ),
        (
            "sizes",
            ["Sizes", "Scaling over scene size"],
            sizes::section(&view),
        ),
        ("scenes", ["Scenes"; 2], scenes::section(&view, pictures)),
    ];
    if let Some((earlier, changes)) = baseline {
        let records = [("", earlier), ("", record)];
        let changes = comparison::baseline(&ComparedRecords::new(&records, changes));
        sections.insert(1, ("baseline", ["Baseline"; 2], changes));
    }
    let header = html! {
        h1 { "phalanx bench " span.day { (day(record)) } }
        (summary::facts(record))
    };
    document(day(record), header, summary::warnings(&view), &sections)
}

/// The page of several records, which come with a name each. The first is the baseline.
pub fn comparison_page(records: &[(&str, &BenchRecord)], comparison: &RecordComparison) -> String {
    let compared = ComparedRecords::new(records, comparison);
    let sections = [
        ("headline", ["In short"; 2], comparison::headline(&compared)),
        ("machines", ["Machines"; 2], comparison::machines(&compared)),
        ("rates", ["Rates"; 2], comparison::rates(&compared)),
        (
            "tracers",
            ["Other tracers"; 2],
            comparison::ratios(&compared),
        ),
        ("scenes", ["Scenes"; 2], comparison::scenes(&compared)),
        ("baseline", ["Baseline"; 2], comparison::baseline(&compared)),
    ];
    let count = page_counted(records.len(), "record");
    let header = html! { h1 { "phalanx bench " span.day { (count) } } };
    document(&count, header, html! {}, &sections)
}

/// A section: its id, its name in the navigation and its title, and its content.
type PageSection = (&'static str, [&'static str; 2], Markup);

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
                        @for (id, [name, _], _) in sections { a href={ "#" (id) } { (name) } }
                    }
                }
                main {
                    (before)
                    @for (id, [_, title], content) in sections {
                        section id=(id) { h2 { (title) } (content) }
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
