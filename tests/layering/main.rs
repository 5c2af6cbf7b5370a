//! Who may import whom, which file owns which crate, and what may not stand in the sources at all.
//!
//! Read from the text of `src`: comments and string literals are blanked out first, then every path that starts with
//! `crate::` (or, in the binary, `phalanx::`) is looked up in the table.

mod source;

use source::{code_of, imported, imported_crate, places, sources};

/// A room, what it may import, and why no more.
struct Row {
    room: &'static str,
    may: &'static [&'static str],
    why: &'static str,
}

const fn row(room: &'static str, may: &'static [&'static str], why: &'static str) -> Row {
    Row { room, may, why }
}

const TABLE: [Row; 22] = [
    row("scene", &[], "what is traced does not depend on how"),
    row("lanes", &[], "numbers know nothing of rays"),
    row("sampling", &[], "a definition both engines share"),
    row("formats", &["scene"], "bytes become a scene, no more"),
    row(
        "standard",
        &["scene"],
        "a generator is a reader without a file",
    ),
    row(
        "bvh",
        &["scene", "lanes"],
        "a tree of boxes, whoever walks it; its blocks are as wide as lanes",
    ),
    row(
        "cache",
        &["scene", "bvh"],
        "columns and tree as they are, whatever they came from",
    ),
    row(
        "open",
        &["scene", "bvh", "formats", "standard", "cache"],
        "the one place that knows everything a scene comes from",
    ),
    row(
        "camera",
        &["scene", "lanes"],
        "rays of a view, scalar and eight-wide",
    ),
    row(
        "packet",
        &["lanes"],
        "columns of lanes, whatever they are for",
    ),
    row(
        "trace",
        &["bvh", "scene", "packet", "lanes", "isa"],
        "finds hits; what they look like is not its business",
    ),
    row(
        "shade",
        &["scene", "packet", "lanes", "sampling"],
        "emits queues and never traces: data goes forward only",
    ),
    row(
        "render",
        &[
            "scene", "camera", "bvh", "packet", "trace", "shade", "lanes", "sampling",
        ],
        "the one place where the stages meet; reads no files, knows no oracle",
    ),
    row(
        "oracle",
        &["scene", "camera", "sampling"],
        "a proof must not share what it proves",
    ),
    row(
        "frame",
        &[
            "scene", "camera", "bvh", "render", "oracle", "trace", "sampling",
        ],
        "chooses an engine and runs it",
    ),
    row(
        "image",
        &["scene", "render"],
        "writes films by the scene's tone",
    ),
    row(
        "jobs",
        &["scene", "cache", "frame", "render", "image"],
        "keeps what frames are made of; how a tile is painted is not its business",
    ),
    row("isa", &[], "asks the processor"),
    row(
        "peers",
        &["scene", "lanes", "packet"],
        "other tracers on our rays: they share none of our trees",
    ),
    row(
        "report",
        &["isa"],
        "numbers to files and pages, whoever measured them",
    ),
    row(
        "bench",
        &[
            "scene", "camera", "bvh", "lanes", "packet", "trace", "render", "oracle", "frame",
            "peers", "report", "sampling",
        ],
        "runs everything beside everything else, on the same rays",
    ),
    row("cli", &[], "sees the library from outside, as phalanx::"),
];

/// Crates that only some rooms (or files) may name.
const OWNERS: [(&str, &[&str], &str); 18] = [
    (
        "libc",
        &["bvh/pages.rs", "cli/bus_error.rs", "cli/heap.rs"],
        "the system is asked for pages in one place, and told in others what answers a fault and what memory goes back",
    ),
    (
        "memmap2",
        &["cache/mapping.rs"],
        "files become memory in one place",
    ),
    (
        "crc32fast",
        &["cache/", "jobs/", "bench/answer.rs", "bench/fingerprint.rs"],
        "checksums are part of three file formats",
    ),
    (
        "wide",
        &["lanes/types.rs"],
        "the vector crate can be exchanged in one file",
    ),
    (
        "obvhs",
        &["bvh/", "peers/"],
        "builders can be exchanged in one room",
    ),
    (
        "libloading",
        &["peers/embree/api.rs"],
        "foreign code comes in at one place",
    ),
    (
        "image",
        &["image.rs", "image/"],
        "encoders can be exchanged in one room",
    ),
    (
        "exr",
        &["image/exr.rs"],
        "files of linear radiance are written in one file",
    ),
    (
        "png",
        &[
            "image/png.rs",
            "image/mod.rs",
            "formats/picture.rs",
            "formats/picture_tests.rs",
            "formats/texture.rs",
        ],
        "pictures are written row by row in one file, and textures read so in another",
    ),
    (
        "signal_hook",
        &["cli/interrupt.rs"],
        "signals come in at one place",
    ),
    (
        "zune_jpeg",
        &["formats/picture.rs"],
        "one decoder, with its SIMD off, gives every build the same texels",
    ),
    ("zune_core", &["formats/picture.rs"], "zune_jpeg's options"),
    (
        "base64",
        &["formats/gltf/", "report/html/"],
        "only glTF carries files as text, and a page its pictures",
    ),
    (
        "maud",
        &["report/html/"],
        "markup that escapes what it is given, in one room",
    ),
    (
        "plotters",
        &["report/html/svg.rs"],
        "charts can be drawn by another crate, through one file",
    ),
    (
        "core_affinity",
        &["render/workers.rs"],
        "threads are pinned in one place",
    ),
    (
        "raw_cpuid",
        &["isa.rs", "report/machine.rs"],
        "what the CPU has, and what it is",
    ),
    (
        "sysinfo",
        &["report/machine.rs"],
        "the system is asked in one place",
    ),
];

/// What breaks the same bits on every machine, which files may have it all the same, and what to use instead.
const BANNED: [(&str, &[&str], &str); 13] = [
    ("mul_add", &[], "fuses or not by build: write a * b + c"),
    ("mul_sub", &BOUNDS, "fuses or not by build: write a * b - c"),
    (
        "times_less",
        &BOUNDS,
        "fuses or not by build: write a * b - c",
    ),
    (".recip(", &[], "an approximation in vector crates: divide"),
    ("recip_sqrt", &[], "an approximation: divide by the root"),
    ("powf", &[], "the system's libm: sampling::pow"),
    (
        "powi",
        &[],
        "order of products not specified: write them out",
    ),
    (".sin(", &[], "the system's libm: libm::sin in f64"),
    (".cos(", &[], "the system's libm: libm::cos in f64"),
    (".tan(", &[], "the system's libm: libm::tan in f64"),
    (".sin_cos(", &[], "the system's libm: libm::sincos in f64"),
    (
        "lerp",
        &[],
        "fuses or not by build for SIMD-backed types: write it out",
    ),
    ("algebraic_", &[], "may be reassociated"),
];

/// The lanes, and what only bounds where hits are.
const BOUNDS: [&str; 4] = [
    "lanes/mod.rs",
    "lanes/types.rs",
    "trace/beam/look.rs",
    "trace/cull.rs",
];

/// Files that may hold `unsafe`.
const UNSAFE_FILES: [&str; 14] = [
    "bvh/pages.rs",
    "cache/mapping.rs",
    // Open files are known by their numbers alone.
    "image/descriptor.rs",
    "cli/bus_error.rs",
    // The allocator takes numbers through its C interface alone.
    "cli/heap.rs",
    "trace/beam/descend.rs",
    "trace/beam/pairs.rs",
    "trace/beam/waiting.rs",
    "trace/order.rs",
    "trace/packet.rs",
    "trace/prefetch.rs",
    "trace/single/mod.rs",
    // A C interface, and the control register that it wants otherwise.
    "peers/embree/api.rs",
    "peers/embree/mxcsr.rs",
];

#[test]
fn rooms_import_what_the_table_allows() {
    let mut wrong = Vec::new();
    for source in sources().iter().filter(|s| !s.is_root()) {
        let room = source.room();
        let Some(row) = TABLE.iter().find(|row| row.room == room) else {
            wrong.push(format!("{}: no room of the table", source.path));
            continue;
        };
        for other in imported(&source.code, "crate") {
            let known = TABLE.iter().any(|row| row.room == other);
            let binary = room == "cli" && (other == "cli" || !known);
            if other != room && !row.may.contains(&other.as_str()) && !binary {
                let why = row.why;
                wrong.push(format!("{}: {room} imports {other} ({why})", source.path));
            }
        }
        let outside = !imported(&source.code, "phalanx").is_empty();
        if outside && room != "cli" {
            wrong.push(format!("{}: names its own crate", source.path));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A room above another's cannot be reached through `super` either.
#[test]
fn super_stays_within_its_room() {
    for source in sources().iter().filter(|s| !s.is_root()) {
        let room_depth = source.path.matches('/').count();
        let inner = source.code.contains("mod tests {");
        let module = source.path.ends_with("mod.rs");
        let levels = room_depth - usize::from(module) + usize::from(inner);
        let up = "super::".repeat(levels + 1);
        assert!(
            !source.code.contains(&up),
            "{} climbs out of its room",
            source.path
        );
    }
}

#[test]
fn crates_have_one_owner() {
    let mut wrong = Vec::new();
    for source in &sources() {
        for (name, owners, why) in OWNERS {
            let owned = owners.iter().any(|owner| source.path.starts_with(owner));
            let used = imported_crate(&source.code, name);
            if used && !owned {
                wrong.push(format!("{} names {name}: {why}", source.path));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn nothing_that_differs_between_machines() {
    let mut wrong = Vec::new();
    for source in &sources() {
        for (word, owners, instead) in BANNED {
            if owners.contains(&source.path.as_str()) {
                continue;
            }
            for line in source.lines_with(word) {
                wrong.push(format!("{}:{line}: {word}: {instead}", source.path));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn unsafe_stands_in_the_files_named_for_it() {
    for source in &sources() {
        let lines = source.lines_with("unsafe");
        let named = UNSAFE_FILES.contains(&source.path.as_str());
        assert!(
            named || lines.is_empty(),
            "{}: unsafe on {lines:?}",
            source.path
        );
        assert!(
            !named || !lines.is_empty(),
            "{} is named for nothing",
            source.path
        );
    }
}

#[test]
fn the_table_reads_paths_as_the_compiler_does() {
    let code = code_of(
        "use crate::{bvh::Bvh, scene::{self, Prim}};\n// crate::shade\nlet s = \"crate::trace\";\n\
         /* crate::oracle /* nested */ crate::camera */ r#\"crate::frame\"# + '\"' + crate :: lanes::F;",
    );
    let found = imported(&code, "crate");
    let found: Vec<&str> = found.iter().map(String::as_str).collect();
    assert_eq!(found, ["bvh", "lanes", "scene"]);
    assert_eq!(places("unsafe_code unsafe", "unsafe"), [12]);
    assert!(imported_crate("use wide::{f32x8};", "wide"));
    assert!(!imported_crate("self.wide(3); crate::wide::x", "wide"));
    assert!(imported_crate("let c = image::open(p);", "image"));
    assert!(!imported_crate("use crate::image::write;", "image"));
}
