//! The roofline (Williams, Waterman and Patterson, CACM 2009): operations a second against
//! operations per byte, below what the machine's arithmetic and each level of its memory can give.

use super::axis::{Axis, paint_axes};
use super::dots::WIDTH;
use super::operations;
use super::svg::{
    MarkerShape, MarkerStyle, Point, Tint, draw, figure, legend, line, marker, named, text,
};
use super::tables::cell;
use super::view::{RecordView, kind_text, row_name, threads_text};
use crate::numbers::{measured, percent, short};
use crate::report_table::ReportTable;
use crate::{AUTO, CounterRow, ThreadLimits};
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

/// Sizes of scenes in the suite with their looks; scenes without one come last.
const STEPS: [(&str, MarkerStyle); 4] = [
    ("small", (Tint::Series(3), MarkerShape::Triangle)),
    ("medium", (Tint::Series(2), MarkerShape::Square)),
    ("large", (Tint::Series(0), MarkerShape::Disc)),
    ("other scenes", (Tint::Series(4), MarkerShape::Diamond)),
];

/// A scene's point in the roofline.
struct Spot<'a> {
    scene: &'a str,
    /// Name of the scene beside its marker.
    short: String,
    kind: &'a str,
    /// Operations per ray; `bytes` are the bytes per ray.
    operations: f64,
    bytes: f64,
    /// Operations a byte.
    intensity: f64,
    /// 10⁹ operations a second.
    rate: f64,
    /// Index of its step.
    step: usize,
}

/// The section; a note where limits or counters are missing.
pub(super) fn section(view: &RecordView<'_>) -> Markup {
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
    let steps = STEPS.iter().enumerate();
    let steps = steps.filter(|(step, _)| spots.iter().any(|spot| spot.step == *step));
    let keys: Vec<_> = steps
        .map(|(_, &(name, look))| (look, name.to_owned()))
        .collect();
    html! {
        p {
            "What " code { "auto" } " does on " (threads_text(limits.threads)) ", each marker a scene. Slanted rules are "
            "measured reading bandwidths, the level rule is the measured peak of additions and multiplications ("
            (measured(limits.gflops)) "\u{202f}" "Gop/s). A marker above the rule of a level gets most of its bytes from "
            "faster ones. Bytes are those of nodes and primitives that packets touch; operations are counted from the code "
            "of each test, as a lower bound: " (short(operations::BOX)) " a box, " (short(operations::TRIANGLE))
            " a triangle, " (short(operations::SPHERE)) " a sphere."
        }
        @if keys.len() > 1 { (legend(keys, html! {})) }
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
    let of = |kind| {
        let scenes = view.scenes.iter();
        scenes.filter_map(move |scene| spot(view, scene, kind, threads))
    };
    view.kinds.iter().flat_map(|kind| of(*kind)).collect()
}

fn spot<'a>(
    view: &RecordView<'a>,
    scene: &'a str,
    kind: &'a str,
    threads: u32,
) -> Option<Spot<'a>> {
    let row = view.index.get(AUTO, scene, kind, threads)?;
    let counters = counters_of(view, scene, kind, row.same_as.as_deref())?;
    let rays = counters.ray_count as f64;
    let known = view.scene(scene);
    let operations = operations::operations(&counters.work, known) / rays;
    let bytes = counters.work.bytes as f64 / rays;
    let spot = Spot {
        scene,
        short: view.short_name(scene),
        kind,
        operations,
        bytes,
        intensity: operations / bytes,
        rate: row.mrays_per_s.median * operations * 1e-3,
        step: step_index(known.and_then(|s| s.step.as_deref())),
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
    let find = |kernel| {
        let mut counters = view.record.counters.iter();
        counters.find(|c| (&*c.scene, &*c.rays, &*c.kernel) == (scene, kind, kernel))
    };
    find(AUTO).or_else(|| find(same_as?))
}

/// Index of a scene's step in [`STEPS`].
fn step_index(step: Option<&str>) -> usize {
    let position = |step| STEPS.iter().position(|of| of.0 == step);
    step.and_then(position).unwrap_or(STEPS.len() - 1)
}

/// One kind of rays; all kinds have the same axes, so that they can be compared.
fn chart(kind: &str, all: &[Spot<'_>], limits: &ThreadLimits, levels: &[(&str, f64)]) -> Markup {
    let spots: Vec<&Spot<'_>> = all.iter().filter(|s| s.kind == kind).collect();
    let ridges = levels.iter().map(|l| limits.gflops / l.1);
    let intensities = all.iter().map(|s| s.intensity);
    let x = Axis::log(intensities.chain(ridges), LEFT, WIDTH - 14.0);
    let heights = all.iter().map(|s| s.rate).chain([limits.gflops * 1.5]);
    let y = Axis::log(heights, FLOOR, TOP);
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
    let points = spots
        .iter()
        .map(|spot| (x.at(spot.intensity), y.at(spot.rate)));
    let points: Vec<Point> = points.collect();
    let content = html! {
        (paint_axes((&x, &y), "operations per byte", FLOOR))
        (paint_roofs((&x, &y), limits.gflops, levels))
        @for (spot, &point) in spots.iter().zip(&points) {
            (named(&spot.name(), marker(point, STEPS[spot.step].1, 3.4)))
        }
        @for (spot, position) in spots.iter().zip(name_positions(&spots, &points)) {
            @if let Some((at, anchor)) = position {
                (text(at, anchor, (Tint::Muted, NAME_SIZE), &spot.short))
            }
        }
    };
    figure(
        kind,
        ", Gop/s",
        draw((WIDTH, FLOOR + 40.0), &label, content),
    )
}

impl Spot<'_> {
    fn name(&self) -> String {
        let [rate, intensity] = [self.rate, self.intensity].map(measured);
        let scene = self.scene;
        format!("{scene}: {rate} Gop/s, {intensity} operations a byte")
    }
}

/// Size of names in the chart, in pixels, and the width of a letter.
const NAME_SIZE: f64 = 10.5;
const LETTER: f64 = 6.2;

/// Maximum number of names in a chart. Where there are more scenes, the pointer shows their names.
const MAX_NAMES: usize = 10;

/// Position of a name, and the end of it that is there.
type NamePosition = (Point, &'static str);

/// Positions of names beside their markers, where they are clear of other markers and names and of
/// the chart's edges.
fn name_positions(spots: &[&Spot<'_>], points: &[Point]) -> Vec<Option<NamePosition>> {
    let mut taken: Vec<[f64; 4]> = points
        .iter()
        .map(|&(x, y)| [x - 4.0, y - 4.0, x + 4.0, y + 4.0])
        .collect();
    let mut position = |(spot, &(x, y)): (&&Spot<'_>, &Point)| {
        let wide = LETTER * spot.short.chars().count() as f64;
        let candidates = [0.0, -9.0, 9.0].into_iter().flat_map(|dy| {
            let right = ((x + 6.0, y + dy), "start", x + 6.0);
            let left = ((x - 6.0, y + dy), "end", x - 6.0 - wide);
            [right, left]
        });
        let mut candidates = candidates
            .map(|(at, anchor, from)| (at, anchor, [from, at.1 - 5.5, from + wide, at.1 + 5.5]));
        let free = |area: &[f64; 4]| {
            let inside = area[0] > LEFT && area[2] < WIDTH && area[1] > TOP && area[3] < FLOOR;
            let meets = |other: &[f64; 4]| {
                area[0] < other[2] && other[0] < area[2] && area[1] < other[3] && other[1] < area[3]
            };
            inside && !taken.iter().any(meets)
        };
        let (at, anchor, area) = candidates.find(|(.., area)| free(area))?;
        taken.push(area);
        Some((at, anchor))
    };
    if spots.len() <= MAX_NAMES {
        spots.iter().zip(points).map(&mut position).collect()
    } else {
        Vec::new()
    }
}

/// The peak's rule, and a bandwidth's from where it enters the picture, at its left end or its
/// floor, up to the peak.
fn paint_roofs((x, y): (&Axis, &Axis), peak: f64, levels: &[(&str, f64)]) -> Markup {
    let ((left, right), (floor, _)) = (x.ends(), y.ends());
    let small = (Tint::Ink, 10.5);
    let top = y.at(peak);
    let ridges = levels.iter().map(|l| peak / l.1);
    let first_ridge = ridges.fold(right, f64::min).max(left);
    html! {
        (line(&[(x.at(first_ridge), top), (x.at(right), top)], Tint::Ink, 1.5))
        (text((x.at(right), top - 8.0), "end", small, "peak"))
        @for (name, bandwidth) in levels {
            @let (start, ridge) = (left.max(floor / bandwidth), peak / bandwidth);
            @let (from, to) = (x.at(start), y.at(start * bandwidth));
            @if start < ridge {
                (line(&[(from, to), (x.at(ridge), top)], Tint::Ink, 1.0))
                // Clear of the numbers below the axis.
                (text((from + 16.0, to - 5.0), "start", small, name))
            }
        }
    }
}

fn table(spots: &[Spot<'_>], limits: &ThreadLimits, levels: &[(&str, f64)]) -> ReportTable<Markup> {
    let title = "Operations, bytes and shares of the machine's limits";
    let head = "scene | rays | operations/ray | bytes/ray | operations/byte | Gop/s | of peak";
    let mut table = ReportTable::new(title, head, 2);
    let of_levels = levels
        .iter()
        .map(|(name, _)| format!("of {name} bandwidth"));
    table.head.extend(of_levels);
    table.with(spots.iter().map(|spot| {
        let mut cells = vec![row_name(spot.scene), cell(spot.kind)];
        let numbers = [spot.operations, spot.bytes, spot.intensity, spot.rate];
        cells.extend(numbers.map(|n| cell(measured(n))));
        cells.push(cell(percent(spot.rate / limits.gflops)));
        let read = spot.rate / spot.intensity;
        cells.extend(levels.iter().map(|l| cell(percent(read / l.1))));
        cells
    }))
}
