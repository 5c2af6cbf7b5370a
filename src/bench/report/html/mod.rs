//! A record as a page to look at: one HTML file that needs no network and no script.
//!
//! Charts are SVG in the page's own colours, so that they follow the reader's choice of light or
//! dark.

mod axis;
mod dots;
mod number_format;
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

pub use scenes::ScenePictures;

use super::BenchRecord;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use view::RecordView;

const STYLE: &str = include_str!("style.css");

/// The page of a record. Where the record lacks data, the section has a note or is left out. No
/// record is rejected.
pub fn page(record: &BenchRecord, pictures: &[ScenePictures]) -> String {
    let view = RecordView::new(record);
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                // Browsers ask for an icon otherwise.
                link rel="icon" href="data:,";
                title { "phalanx bench " (day(record)) }
                style { (PreEscaped(STYLE)) }
            }
            body { (body(&view, pictures)) }
        }
    };
    printable(&markup.into_string())
}

fn body(view: &RecordView<'_>, pictures: &[ScenePictures]) -> Markup {
    let sections = [
        ("headline", "In short", "In short", summary::headline(view)),
        ("rates", "Rates", "Rates", rates::section(view)),
        (
            "threads",
            "Threads",
            "Scaling over threads",
            threads::section(view),
        ),
        (
            "sizes",
            "Sizes",
            "Scaling over scene size",
            sizes::section(view),
        ),
        ("roofline", "Roofline", "Roofline", roofline::section(view)),
        (
            "scenes",
            "Scenes",
            "Scenes",
            scenes::section(view, pictures),
        ),
    ];
    html! {
        header {
            h1 { "phalanx bench " span.day { (day(view.record)) } }
            (summary::facts(view.record))
            nav aria-label="Sections" {
                @for (id, name, ..) in &sections { a href={ "#" (id) } { (name) } }
            }
        }
        main {
            (summary::warnings(view))
            @for (id, _, title, content) in &sections {
                section id=(id) { h2 { (title) } (content) }
            }
        }
    }
}

fn day(record: &BenchRecord) -> &str {
    record.run.started.split('T').next().unwrap_or_default()
}

/// Control characters, which HTML forbids, replaced.
fn printable(page: &str) -> String {
    let forbidden = |c: char| c.is_control() && c != '\n';
    page.replace(forbidden, "\u{fffd}")
}
