//! Content of the page.

use super::fixture::{self, FAMILIES, compare};
use super::parsed::{Parsed, parse};
use phalanx::report::BenchRecord;
use phalanx::report::html::{ScenePictures, comparison_page, page, page_against};
use std::sync::LazyLock;

fn parsed(record: &BenchRecord) -> Parsed {
    parse(&page(record, &fixture::pictures(record)))
}

/// The page of a suite, used by most tests.
static SUITE: LazyLock<Parsed> = LazyLock::new(|| parsed(&fixture::suite()));

#[test]
fn a_suite_has_every_section_scene_and_picture() {
    let record = fixture::suite();
    let page = &*SUITE;
    for scene in &record.scenes {
        assert!(page.text.contains(&scene.name), "{} is missing", scene.name);
    }
    let heats = record.scenes.len() - record.scenes.len() / 5;
    assert_eq!(page.named("img").count(), record.scenes.len() + heats);
    // In short 2; rates of 7 kinds on 2 thread counts; threads 1; sizes of 7 kinds.
    let charts = page.named("svg").filter(|svg| {
        let width = &svg.attributes["width"];
        width == "360"
    });
    assert_eq!(charts.count(), 2 + 7 * 2 + 1 + 7);
    for family in FAMILIES {
        assert!(page.text.contains(family));
    }
    assert_eq!(page.named("script").count(), 0);
}

#[test]
fn links_lead_to_sections() {
    for record in [fixture::suite(), fixture::minimal(), fixture::empty()] {
        let page = parse(&page(&record, &[]));
        let ids: Vec<&str> = page.values("id").collect();
        assert_eq!(page.named("a").count(), 5);
        for link in page.named("a") {
            let target = link.attributes["href"].trim_start_matches('#');
            assert!(ids.contains(&target), "{target} leads nowhere");
        }
    }
}

/// The file is self-contained: nothing is fetched.
#[test]
fn nothing_comes_from_elsewhere() {
    let record = fixture::suite();
    let text = page(&record, &fixture::pictures(&record));
    assert!(!text.contains("http"), "an address");
    let page = parse(&text);
    for source in page.values("src") {
        assert!(source.starts_with("data:image/png;base64,"));
    }
    for link in page.values("href") {
        assert!(link.starts_with('#') || link == "data:,", "{link}");
    }
    for word in ["url(", "@import"] {
        assert!(!page.style.contains(word), "{word}");
    }
}

#[test]
fn charts_take_their_colours_from_the_style_sheet() {
    let page = &*SUITE;
    let mut colours = 0;
    for tint in page.values("fill").chain(page.values("stroke")) {
        let property = tint.strip_prefix("var(").and_then(|t| t.strip_suffix(')'));
        match property {
            // Once for light and once for dark.
            Some(property) => assert_eq!(page.style.matches(&format!("{property}:")).count(), 2),
            None => assert_eq!(tint, "none"),
        }
        colours += usize::from(property.is_some());
    }
    assert!(colours > 1000, "{colours} coloured elements");
}

#[test]
fn those_who_do_not_see_it_are_told() {
    let page = &*SUITE;
    for svg in page.named("svg") {
        assert_eq!(svg.attributes["role"], "img");
        assert!(!svg.attributes["aria-label"].is_empty());
    }
    for image in page.named("img") {
        assert!(image.attributes["alt"].len() > 10);
    }
    assert_eq!(page.named("table").count(), page.named("caption").count());
    assert_eq!(page.named("h1").count(), 1);
}

#[test]
fn what_the_record_lacks_is_said_in_a_line() {
    let text = parsed(&fixture::minimal()).text;
    for line in [
        "Rates were taken on 1\u{202f}thread alone",
        "No family of scenes was measured in two sizes",
        "Neither the oracle nor a peer took part",
    ] {
        assert!(text.contains(line), "{line}");
    }
    assert!(!text.contains("Beware"));
    let text = parsed(&fixture::empty()).text;
    assert!(text.contains("The record has no rates."));
    assert!(text.contains("The record has no scenes."));
}

#[test]
fn what_to_beware_of_is_said_at_the_top() {
    let text = &SUITE.text;
    for words in [
        "2026-11-21 17:30:04 UTC, in 11.9",
        "differed from the commit",
        "governor was powersave",
        "(KVM)",
        "embree packet16 coherent is inexact in",
        "0.4\u{202f}%",
    ] {
        assert!(text.contains(words), "{words}");
    }
    assert!(!text.contains("embree single is inexact"));
}

fn side_by_side(records: &[(&'static str, BenchRecord)]) -> Parsed {
    let pairs: Vec<(&str, &BenchRecord)> = records.iter().map(|(name, r)| (*name, r)).collect();
    parse(&comparison_page(&pairs, &compare(&pairs)))
}

#[test]
fn machines_stand_side_by_side() {
    let page = side_by_side(&fixture::machines());
    for words in [
        "Machines and programs",
        "Neoverse-N1",
        "perf/records/2026-11-21-epyc-2core.json",
        "The baseline is A: AMD EPYC 9B45 96-Core Processor, 2026-11-21",
        "against embree",
    ] {
        assert!(page.text.contains(words), "{words}");
    }
    let ids: Vec<&str> = page.values("id").collect();
    assert_eq!(page.named("a").count(), 6);
    for link in page.named("a") {
        assert!(ids.contains(&link.attributes["href"].trim_start_matches('#')));
    }
    assert_eq!(page.named("table").count(), page.named("caption").count());
    assert_eq!(page.named("script").count(), 0);
}

/// All markers are in named groups, in every kind of chart.
#[test]
fn every_dot_has_a_name() {
    for page in [&*SUITE, &side_by_side(&fixture::machines())] {
        let names = page.named("g").count();
        let charts = page
            .named("svg")
            .filter(|svg| svg.attributes["width"] == "360");
        assert!(charts.count() > 10 && names > 300, "{names}");
        // The page's own title, then one for each group.
        assert_eq!(page.named("title").count(), 1 + names);
        let keys = page
            .named("svg")
            .filter(|svg| svg.attributes["width"] == "14");
        let markers = page.named("circle").count() + page.named("polygon").count();
        assert!(markers <= names + keys.count(), "{markers} of {names}");
    }
    let text = &SUITE.text;
    assert!(text.contains("phalanx auto, balls small: "), "{text}");
}

#[test]
fn a_baseline_has_a_section() {
    let record = fixture::suite();
    let mut earlier = fixture::suite();
    for row in earlier
        .rows
        .iter_mut()
        .filter(|row| row.engine == "phalanx")
    {
        for figure in [
            &mut row.mrays_per_s.median,
            &mut row.mrays_per_s.low,
            &mut row.mrays_per_s.high,
        ] {
            *figure *= 1.25;
        }
    }
    let changes = compare(&[("", &earlier), ("", &record)]);
    let page = parse(&page_against(&record, &[], Some((&earlier, &changes))));
    assert_eq!(page.named("a").count(), 6);
    assert!(page.text.contains("-20.0\u{202f}%"), "{}", page.text);
    assert!(page.text.contains("-20.0 ± "), "{}", page.text);
    assert!(!SUITE.text.contains("The baseline is"));
}

/// The headline is the geometric mean of ours over the best exact peer; inexact modes do not count.
#[test]
fn an_inexact_mode_is_not_the_best() {
    let mut record = fixture::minimal();
    let ours = record.rows[0].clone();
    for (kernel, factor, exact) in [("single", 0.5, true), ("packet16", 2.0, false)] {
        let mut row = ours.clone();
        (row.engine, row.kernel, row.exact) = ("embree".to_owned(), kernel.to_owned(), exact);
        row.mrays_per_s.median = ours.mrays_per_s.median * factor;
        record.rows.push(row);
    }
    let text = parsed(&record).text;
    let headline =
        "On 1\u{202f}thread, phalanx is 2.00× as fast as the best exact peer for primary rays (";
    assert!(text.contains(headline), "{text}");
}

#[test]
fn odd_records_make_pages_too() {
    let record = fixture::odd();
    let page = parsed(&record);
    for words in ["NaN", "inf"] {
        assert!(!page.text.contains(words), "{words}");
    }
    for attribute in [
        "points", "x", "y", "x1", "x2", "y1", "y2", "cx", "cy", "width", "height",
    ] {
        for value in page.values(attribute) {
            assert!(!value.contains("NaN") && !value.contains("inf"), "{value}");
        }
    }
}

#[test]
fn names_are_text_whatever_they_say() {
    let evil = "<script>alert(1)</script>\"'&\u{0}\u{1b}.test";
    let mut record = fixture::suite();
    let rename = |name: &mut String| {
        if *name == "standard:balls:small" {
            *name = evil.to_owned();
        }
    };
    record.scenes.iter_mut().for_each(|s| rename(&mut s.name));
    record.rows.iter_mut().for_each(|r| rename(&mut r.scene));
    record
        .counters
        .iter_mut()
        .for_each(|c| rename(&mut c.scene));
    record.scenes[0].family = None;
    record.scenes[1].family = Some("\"#010200\" opacity=\"1\" <b>".to_owned());
    record.rows[0].engine = "<i onload=x>".to_owned();
    record.machine.cpu = "<script src=//x>".to_owned();
    record
        .run
        .arguments
        .push("</style></title><script>".to_owned());
    let pictures = [ScenePictures {
        scene: evil.to_owned(),
        thumbnail_png: b"no picture".to_vec(),
        heat_png: Some(Vec::new()),
        heat_legend: "<script>".to_owned(),
    }];
    let page = parse(&page(&record, &pictures));
    assert_eq!(page.named("script").count(), 0);
    assert_eq!(page.named("b").count() + page.named("i").count(), 0);
    assert_eq!(page.named("img").count(), 0);
    assert!(
        page.text
            .contains("<script>alert(1)</script>\"'&\u{fffd}\u{fffd}.test")
    );
    assert_eq!(page.values("onload").count(), 0);
}
