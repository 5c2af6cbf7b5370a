//! The scenes: their pictures, the cost of their pixels, their primitives, and the time to load
//! them and build their trees.

use super::number_format;
use super::tables::{cell, folded_table};
use super::view::{RecordView, kind_text, row_name};
use crate::SceneRecord;
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
        (answers(view))
        @for kind in &view.kinds { (work_table(view, kind)) }
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
    let number = |at: usize| {
        let bytes = header.get(at..at + 4)?;
        Some(u32::from_be_bytes(bytes.try_into().ok()?))
    };
    (header.get(4..8)? == b"IHDR").then_some((number(8)?, number(12)?))
}

fn facts(scene: &SceneRecord) -> Markup {
    let parts = scene.primitives.iter().filter(|(_, count)| **count > 0);
    let parts: Vec<String> = parts
        .map(|(kind, count)| format!("{} {kind}", number_format::count(*count)))
        .collect();
    let builds = scene.build_seconds.iter();
    let builds: Vec<String> = builds
        .map(|(engine, seconds)| format!("{engine} {}", number_format::seconds(*seconds)))
        .collect();
    let [width, height] = scene.size;
    html! {
        dl {
            dt { "Primitives" }
            dd {
                @if parts.is_empty() { (number_format::count(scene.primitive_count)) } @else { (number_format::listed(&parts)) }
            }
            dt { "Load" } dd { (number_format::seconds(scene.load_seconds)) }
            @if !builds.is_empty() { dt { "Build" } dd { (builds.join(", ")) } }
            dt { "Tree" } dd { (number_format::bytes(scene.tree_bytes)) }
            dt { "Picture" } dd { (width) "×" (height) }
            dt { "Hash" } dd { code { (scene.hash) } }
        }
    }
}

/// Results of the rays, which are the evidence for the rates.
fn answers(view: &RecordView<'_>) -> Markup {
    let mut rows = Vec::new();
    for scene in &view.record.scenes {
        for (kind, set) in &scene.rays {
            rows.push(vec![
                row_name(&scene.name),
                cell(kind),
                html! { code { (set.checksum) } },
                cell(number_format::count(set.rays)),
                cell(number_format::count(set.hits)),
                cell(number_format::percent(set.hits as f64 / set.rays as f64)),
            ]);
        }
    }
    let head = ["scene", "rays", "checksum", "number", "hits", "share"];
    folded_table("Rays and their answers", &head, 3, rows)
}

/// Table of counted work of a kind of rays.
fn work_table(view: &RecordView<'_>, kind: &str) -> Markup {
    let counters = view.record.counters.iter().filter(|c| c.rays == kind);
    let rows = counters.map(|counter| {
        let work = &counter.work;
        let per_ray = |count: u64| {
            cell(number_format::measured(
                count as f64 / counter.ray_count as f64,
            ))
        };
        let lanes = work.packets as f64 * 8.0;
        vec![
            row_name(&counter.scene),
            cell(&counter.kernel),
            cell(number_format::count(counter.ray_count)),
            cell(number_format::count(work.packets)),
            cell(number_format::percent(work.active_lanes as f64 / lanes)),
            per_ray(work.node_visits),
            per_ray(work.box_tests),
            per_ray(work.leaf_visits),
            per_ray(work.prim_tests),
            per_ray(work.bytes),
        ]
    });
    let head = [
        "scene",
        "kernel",
        "rays",
        "packets",
        "occupancy",
        "node visits/ray",
        "box tests/ray",
        "leaf visits/ray",
        "primitive tests/ray",
        "bytes/ray",
    ];
    let caption = format!("Work of {}", kind_text(kind));
    folded_table(&caption, &head, 2, rows.collect())
}
