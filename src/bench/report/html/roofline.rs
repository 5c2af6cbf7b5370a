//! The roofline (Williams, Waterman and Patterson, CACM 2009): operations a second against
//! operations per byte, below what the machine's arithmetic and each level of its memory can give.

use super::axis::{LogAxis, paint_axes};
use super::dots::WIDTH;
use super::svg::{Anchor, Canvas, DrawError, MarkerShape, Tint, draw, key};
use super::tables::{HtmlTable, cell};
use super::view::{RecordView, kind_text, row_name, threads_text};
use super::{number_format, operations};
use crate::report::{CounterRow, ThreadLimits};
use maud::{Markup, html};

const LEFT: f64 = 38.0;
const FLOOR: f64 = 240.0;
const TOP: f64 = 12.0;

/// Levels of memory from the fastest on, and their names.
const LEVELS: [(&str, &str); 4] = [
    ("l1", "L1"),
    ("l2", "L2"),
    ("l3", "L3"),
    ("memory", "memory"),
];

/// Sizes of scenes in the suite, in the order of their colours; scenes without one come last.
const STEPS: [&str; 3] = ["small", "medium", "large"];

/// A scene's point in the roofline.
struct Spot<'a> {
    scene: &'a str,
    kind: &'a str,
    /// Operations per ray; `bytes` are the bytes per ray.
    operations: f64,
    bytes: f64,
    /// Operations a byte.
    intensity: f64,
    /// 10⁹ operations a second.
    rate: f64,
    /// Index of its colour and shape.
    style: usize,
}

/// The section; a note where limits or counters are missing.
pub(super) fn section(view: &RecordView<'_>) -> Markup {
    html! {
        section #roofline {
            h2 { "Roofline" }
            (inside(view))
        }
    }
}

fn inside(view: &RecordView<'_>) -> Markup {
    if view.record.counters.is_empty() {
        return html! { p.note { "Work was not counted in this run, so there is no roofline." } };
    }
    let limits = view.record.limits.iter().flat_map(|l| &l.threads);
    let limits = limits.filter(|l| view.threads.contains(&l.threads) && l.gflops > 0.0);
    let Some(limits) = limits.max_by_key(|l| l.threads) else {
        return html! { p.note { "The machine's limits were not measured on the threads of this run, so there is no roofline." } };
    };
    let spots = spots(view, limits.threads);
    let levels = levels(limits);
    if spots.is_empty() || levels.is_empty() {
        return html! { p.note { "No row of this run has both a rate and counted work, so there is no roofline." } };
    }
    let styles = styles(&spots);
    html! {
        p {
            "What " code { "auto" } " does on " (threads_text(limits.threads)) ", each marker a scene. Slanted rules are "
            "measured reading bandwidths, the level rule is the measured peak of additions and multiplications ("
            (number_format::measured(limits.gflops)) "\u{202f}" "Gop/s). A marker above the rule of a level gets most of its bytes from "
            "faster ones. Bytes are those of nodes and primitives that packets touch; operations are counted from the code "
            "of each test, as a lower bound: " (number_format::short(operations::BOX)) " a box, " (number_format::short(operations::TRIANGLE))
            " a triangle, " (number_format::short(operations::SPHERE)) " a sphere."
        }
        @if styles.len() > 1 {
            ul.legend { @for style in &styles { (key(look(*style), style_name(*style))) } }
        }
        div.grid {
            @for kind in &view.kinds { (chart(kind, &spots, limits, &levels)) }
        }
        (table(&spots, limits, &levels).folded())
    }
}

/// Measured bandwidths, GB/s.
fn levels(limits: &ThreadLimits) -> Vec<(&'static str, f64)> {
    let level = |(key, name): (&str, &'static str)| Some((name, *limits.bandwidth.get(key)?));
    let levels = LEVELS.into_iter().filter_map(level);
    levels.filter(|l| l.1.is_finite() && l.1 > 0.0).collect()
}

fn spots<'a>(view: &RecordView<'a>, threads: u32) -> Vec<Spot<'a>> {
    let mut spots = Vec::new();
    for kind in &view.kinds {
        for scene in &view.scenes {
            spots.extend(spot(view, scene, kind, threads));
        }
    }
    spots
}

fn spot<'a>(
    view: &RecordView<'a>,
    scene: &'a str,
    kind: &'a str,
    threads: u32,
) -> Option<Spot<'a>> {
    let row = view.auto(scene, kind, threads)?;
    let counters = counters_of(view, scene, kind, row.same_as.as_deref())?;
    let rays = counters.ray_count as f64;
    let known = view.scene(scene);
    let operations = operations::operations(&counters.work, known) / rays;
    let bytes = counters.work.bytes as f64 / rays;
    let spot = Spot {
        scene,
        kind,
        operations,
        bytes,
        intensity: operations / bytes,
        rate: row.mrays_per_s.median * operations * 1e-3,
        style: step_style(known.and_then(|s| s.step.as_deref())),
    };
    let good = [spot.intensity, spot.rate]
        .iter()
        .all(|v| v.is_finite() && *v > 0.0);
    good.then_some(spot)
}

/// The work of `auto`, under its own name or under that of the kernel that it selects.
fn counters_of<'a>(
    view: &RecordView<'a>,
    scene: &str,
    kind: &str,
    same_as: Option<&str>,
) -> Option<&'a CounterRow> {
    let of_scene = || {
        view.record
            .counters
            .iter()
            .filter(|c| c.scene == scene && c.rays == kind)
    };
    let auto = of_scene().find(|c| c.kernel == "auto");
    auto.or_else(|| of_scene().find(|c| Some(c.kernel.as_str()) == same_as))
}

/// Indices of the colours and shapes of small, medium and large scenes, and of scenes that are none
/// of them.
fn step_style(step: Option<&str>) -> usize {
    let place = step.and_then(|step| STEPS.iter().position(|s| *s == step));
    place.unwrap_or(STEPS.len())
}

fn look(style: usize) -> (Tint, MarkerShape) {
    const LOOKS: [(Tint, MarkerShape); 4] = [
        (Tint::Series(3), MarkerShape::Triangle),
        (Tint::Series(2), MarkerShape::Square),
        (Tint::Series(0), MarkerShape::Disc),
        (Tint::Series(4), MarkerShape::Diamond),
    ];
    LOOKS[style % LOOKS.len()]
}

fn style_name(style: usize) -> &'static str {
    STEPS.get(style).copied().unwrap_or("other scenes")
}

fn styles(spots: &[Spot<'_>]) -> Vec<usize> {
    let mut styles: Vec<usize> = spots.iter().map(|s| s.style).collect();
    styles.sort_unstable();
    styles.dedup();
    styles
}

/// One kind of rays; all kinds have the same axes, so that they can be compared.
fn chart(kind: &str, all: &[Spot<'_>], limits: &ThreadLimits, levels: &[(&str, f64)]) -> Markup {
    let spots: Vec<&Spot<'_>> = all.iter().filter(|s| s.kind == kind).collect();
    let ridges = levels.iter().map(|l| limits.gflops / l.1);
    let x = LogAxis::over(
        all.iter().map(|s| s.intensity).chain(ridges),
        LEFT,
        WIDTH - 14.0,
    );
    let heights = all.iter().map(|s| s.rate).chain([limits.gflops * 1.5]);
    let y = LogAxis::over(heights, FLOOR, TOP);
    let (Some(x), Some(y)) = (x, y) else {
        return html! {};
    };
    if spots.is_empty() {
        return html! {};
    }
    let label = format!(
        "Roofline of {}, a marker for each scene; the table below holds the numbers.",
        kind_text(kind)
    );
    let paint = |canvas: &Canvas<'_>| {
        paint_axes(canvas, (&x, &y), "operations per byte", FLOOR)?;
        paint_roofs(canvas, (&x, &y), limits.gflops, levels)?;
        for spot in &spots {
            let place = (x.at(spot.intensity), y.at(spot.rate));
            canvas.marker(place, look(spot.style), 3.4)?;
        }
        Ok(())
    };
    html! {
        figure {
            figcaption { strong { (kind) } ", Gop/s" }
            (draw((WIDTH, FLOOR + 40.0), &label, paint))
        }
    }
}

fn paint_roofs(
    canvas: &Canvas<'_>,
    (x, y): (&LogAxis, &LogAxis),
    peak: f64,
    levels: &[(&str, f64)],
) -> Result<(), DrawError> {
    let (left, right) = x.ends();
    let (floor, _) = y.ends();
    let small = (Tint::Ink, 10.5);
    let end = (x.at(right), y.at(peak));
    let first_ridge = levels
        .iter()
        .map(|l| peak / l.1)
        .fold(right, f64::min)
        .max(left);
    canvas.line(&[(x.at(first_ridge), y.at(peak)), end], Tint::Ink, 1.5)?;
    canvas.text((end.0, end.1 - 8.0), Anchor::End, small, "peak")?;
    for (name, bandwidth) in levels {
        // The line begins where it enters the picture, at its left end or its floor, and goes up to
        // the peak.
        let start = left.max(floor / bandwidth);
        let ridge = peak / bandwidth;
        if start >= ridge {
            continue;
        }
        let from = (x.at(start), y.at(start * bandwidth));
        canvas.line(&[from, (x.at(ridge), y.at(peak))], Tint::Ink, 1.0)?;
        // Clear of the numbers below the axis.
        canvas.text((from.0 + 16.0, from.1 - 5.0), Anchor::Start, small, name)?;
    }
    Ok(())
}

fn table(spots: &[Spot<'_>], limits: &ThreadLimits, levels: &[(&str, f64)]) -> HtmlTable {
    let mut head: Vec<String> = [
        "scene",
        "rays",
        "operations/ray",
        "bytes/ray",
        "operations/byte",
        "Gop/s",
    ]
    .map(str::to_owned)
    .to_vec();
    head.push("of peak".to_owned());
    head.extend(
        levels
            .iter()
            .map(|(name, _)| format!("of {name} bandwidth")),
    );
    let rows = spots.iter().map(|spot| {
        let mut cells = vec![row_name(spot.scene), cell(spot.kind)];
        let numbers = [spot.operations, spot.bytes, spot.intensity, spot.rate];
        cells.extend(numbers.map(|n| cell(number_format::measured(n))));
        cells.push(cell(number_format::percent(spot.rate / limits.gflops)));
        let read = spot.rate / spot.intensity;
        cells.extend(
            levels
                .iter()
                .map(|l| cell(number_format::percent(read / l.1))),
        );
        cells
    });
    HtmlTable {
        caption: "Operations, bytes and shares of the machine's limits".to_owned(),
        head,
        texts: 2,
        rows: rows.collect(),
    }
}
