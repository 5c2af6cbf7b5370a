//! The scenes: their pictures, the cost of their pixels, their primitives, and the time to load
//! them and build their trees.

use super::tables::cell;
use super::view::{RecordView, kind_text, row_name};
use crate::SceneRecord;
use crate::numbers::{count, decimal_bytes, measured, percent, seconds};
use crate::report_table::ReportTable;
use crate::text::listed;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

/// Pictures of a scene. Data that is not PNG is omitted.
pub struct ScenePictures {
    /// [`SceneRecord::name`].
    pub scene: String,
    /// The scene rendered, some 200 to 400 pixels wide.
    pub thumbnail_png: Vec<u8>,
    /// The cost of each pixel in false colours.
    pub heat_png: Option<Vec<u8>>,
    /// Explanation of its colours, in words.
    pub heat_legend: String,
}

/// The section: a card for each scene, then the results of their rays.
pub(super) fn section(view: &RecordView<'_>, pictures: &[ScenePictures]) -> Markup {
    if view.scenes.is_empty() {
        return html! { p.note { "The record has no scenes." } };
    }
    html! {
        div.cards {
            @for name in &view.scenes {
                @let pictures = pictures.iter().find(|p| p.scene == *name);
                (card(name, view.scene(name), pictures))
            }
        }
        (answers(view).folded())
        @for kind in &view.kinds { (work_table(view, kind).folded()) }
    }
}

fn card(name: &str, scene: Option<&SceneRecord>, pictures: Option<&ScenePictures>) -> Markup {
    html! {
        article.card {
            h3 { (name) }
            @if let Some(pictures) = pictures { (both(name, pictures)) }
            @match scene {
                Some(scene) => (facts(scene)),
                None => p.note { "The record says nothing else of it." },
            }
        }
    }
}

/// Thumbnail and heat map next to each other.
fn both(name: &str, pictures: &ScenePictures) -> Markup {
    let heat = pictures.heat_png.as_deref().unwrap_or_default();
    html! {
        div.pictures {
            (picture(&pictures.thumbnail_png, &format!("The scene {name}, rendered"), ""))
            (picture(heat, &format!("Traversal cost of each pixel of {name}"), &pictures.heat_legend))
        }
    }
}

/// A picture with its size, so that the page does not jump; nothing where it is no PNG.
fn picture(png: &[u8], alt: &str, caption: &str) -> Markup {
    let Some((width, height)) = png_size(png) else {
        return html! {};
    };
    let source = format!("data:image/png;base64,{}", STANDARD.encode(png));
    html! {
        figure {
            img src=(source) alt=(alt) width=(width) height=(height) decoding="async";
            @if !caption.is_empty() { figcaption { (caption) } }
        }
    }
}

/// Width and height in the header of a PNG file.
fn png_size(png: &[u8]) -> Option<(u32, u32)> {
    let header = png.strip_prefix(b"\x89PNG\r\n\x1a\n")?;
    let number = |start: usize| {
        let bytes = header.get(start..start + 4)?;
        Some(u32::from_be_bytes(bytes.try_into().ok()?))
    };
    (header.get(4..8)? == b"IHDR").then_some((number(8)?, number(12)?))
}

fn facts(scene: &SceneRecord) -> Markup {
    let parts = scene.primitives.iter().filter(|(_, count)| **count > 0);
    let parts: Vec<String> = parts
        .map(|(kind, number)| format!("{} {kind}", count(*number)))
        .collect();
    let builds = scene.build_seconds.iter();
    let builds: Vec<String> = builds
        .map(|(engine, time)| format!("{engine} {}", seconds(*time)))
        .collect();
    let [width, height] = scene.size;
    html! {
        dl {
            dt { "Primitives" }
            dd {
                @if parts.is_empty() { (count(scene.primitive_count)) } @else { (listed(&parts)) }
            }
            dt { "Load" } dd { (seconds(scene.load_seconds)) }
            @if !builds.is_empty() { dt { "Build" } dd { (builds.join(", ")) } }
            dt { "Tree" } dd { (decimal_bytes(scene.tree_bytes)) }
            dt { "Picture" } dd { (width) "×" (height) }
            dt { "Hash" } dd { code { (scene.hash) } }
        }
    }
}

/// Results of the rays, which are the evidence for the rates.
fn answers(view: &RecordView<'_>) -> ReportTable<Markup> {
    let scenes = view.record.scenes.iter();
    let sets = scenes.flat_map(|scene| scene.rays.iter().map(move |set| (scene, set)));
    let rows = sets.map(|(scene, (kind, set))| {
        vec![
            row_name(&scene.name),
            cell(kind),
            html! { code { (set.checksum) } },
            cell(count(set.rays)),
            cell(count(set.hits)),
            cell(percent(set.hits as f64 / set.rays as f64)),
        ]
    });
    let head = "scene | rays | checksum | number | hits | share";
    ReportTable::new("Rays and their answers", head, 3).with(rows)
}

/// Table of counted work of a kind of rays.
fn work_table(view: &RecordView<'_>, kind: &str) -> ReportTable<Markup> {
    let counters = view.record.counters.iter().filter(|c| c.rays == kind);
    let rows = counters.map(|counter| {
        let work = &counter.work;
        let lanes = work.packets as f64 * 8.0;
        let mut cells = vec![
            row_name(&counter.scene),
            cell(&counter.kernel),
            cell(count(counter.ray_count)),
            cell(count(work.packets)),
            cell(percent(work.active_lanes as f64 / lanes)),
        ];
        let counts = [
            work.node_visits,
            work.box_tests,
            work.leaf_visits,
            work.prim_tests,
            work.bytes,
        ];
        let per_ray = |total: u64| measured(total as f64 / counter.ray_count as f64);
        cells.extend(counts.map(|total| cell(per_ray(total))));
        cells
    });
    let head = "scene | kernel | rays | packets | occupancy | node visits/ray | box tests/ray | \
                leaf visits/ray | primitive tests/ray | bytes/ray";
    ReportTable::new(format!("Work of {}", kind_text(kind)), head, 2).with(rows)
}
