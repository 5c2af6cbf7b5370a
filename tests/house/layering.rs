//! Layering: allowed imports, the owners of dependencies, and what may not appear in the sources.
//!
//! Cargo keeps crates apart; these tables define which crates may depend on each other, and the
//! same for modules within a crate. Checked in the text of `src`: comments and string literals are
//! blanked first, then every path that starts with `crate::` is looked up.

use crate::imports::import_paths;
use crate::source::{code_of, imported, imported_crate, places, sources};

/// Crates beneath `src`, the crates that each may depend on, and the reason for the limit.
pub const CRATES: [(&str, &[&str], &str); 13] = [
    ("scene", &[], "what is traced does not depend on how"),
    (
        "trace",
        &["scene"],
        "finds hits; what they look like is not its business",
    ),
    (
        "oracle",
        &["scene"],
        "a proof must not share what it proves",
    ),
    ("files", &[], "files and their names, whatever is in them"),
    (
        "image",
        &["scene", "files"],
        "writes films by the scene's tone",
    ),
    (
        "look",
        &["scene", "files"],
        "what a scene lacks and a command changes, whatever the scene came from",
    ),
    (
        "formats",
        &["scene", "files", "image"],
        "bytes become a scene, no more",
    ),
    (
        "standard",
        &["scene", "formats"],
        "a generator is a reader without a file",
    ),
    (
        "io",
        &["scene", "trace", "files", "look", "formats", "standard"],
        "opens scenes and trees, and knows no renderer",
    ),
    (
        "render",
        &["scene", "trace", "oracle"],
        "paints tiles, whatever becomes of them",
    ),
    (
        "jobs",
        &["scene", "render", "image", "files", "look", "formats", "io"],
        "keeps what frames are made of; how a tile is painted is not its business",
    ),
    (
        "report",
        &["files"],
        "numbers to files and pages, whoever measured them",
    ),
    (
        "bench",
        &["scene", "trace", "oracle", "files", "render", "report"],
        "opens no files: scenes are given",
    ),
];

/// Modules within a crate, and the modules that each may import.
const ROOMS: [(&str, &[&str], &str); 18] = [
    (
        "scene/sampling",
        &["fork_safe_once"],
        "a definition both engines share",
    ),
    ("scene/film", &["NO_PRIM"], "a picture, whatever is in it"),
    ("trace/simd", &[], "numbers know nothing of rays"),
    (
        "trace/packet",
        &["simd"],
        "columns of lanes, whatever they are for",
    ),
    (
        "trace/bvh",
        &["simd", "prefetch"],
        "a tree of boxes, whoever walks it; its blocks are as wide as lanes",
    ),
    (
        "trace/intersect",
        &["simd", "packet", "bvh"],
        "the definition of a hit does not depend on the way to it",
    ),
    (
        "trace/traverse",
        &[
            "simd",
            "packet",
            "bvh",
            "intersect",
            "isa",
            "prefetch",
            "stopwatch",
        ],
        "asks packets and trees, and nothing above",
    ),
    (
        "trace/cast",
        &["simd", "packet", "prefetch", "bvh", "traverse"],
        "what embedders call: columns to packets and back, and no kernels of its own",
    ),
    (
        "formats/diagnostics",
        &[],
        "places in a file, whatever it holds",
    ),
    (
        "formats/text",
        &["diagnostics", "memory"],
        "bytes to words and numbers, whatever they mean",
    ),
    (
        "formats/folder",
        &["diagnostics", "memory"],
        "files that a scene names, whatever they hold",
    ),
    (
        "formats/texture",
        &["diagnostics", "folder"],
        "pictures of any format's materials",
    ),
    (
        "formats/mesh",
        &[
            "diagnostics",
            "text",
            "memory",
            "options",
            "origin",
            "read_scene",
        ],
        "faces of any format",
    ),
    (
        "io/cache",
        &[],
        "columns and tree as they are, whatever they came from",
    ),
    (
        "render/shade",
        &[],
        "emits queues and never traces: data goes forward only",
    ),
    (
        "bench/peers",
        &[],
        "other tracers on our rays: they share none of our trees",
    ),
    (
        "cli",
        &["cli", "view"],
        "sees the library from outside, as phalanx::",
    ),
    ("view", &["view"], "a scene is given to it, and nobody told"),
];

/// Layers of the program, and the layers that each may import.
const FLOORS: [(&str, &[&str], &str); 3] = [
    (
        "cli/commands",
        &["options", "output"],
        "the table of commands names them, not they the table",
    ),
    (
        "cli/options",
        &["output"],
        "what several commands share knows none of them",
    ),
    ("cli/output", &[], "what users are told, whoever tells them"),
];

/// Crates that only certain modules (or files) may name.
const OWNERS: [(&str, &[&str], &str); 20] = [
    (
        "libc",
        &[
            "scene/huge_pages.rs",
            "cli/options/bus_error.rs",
            "cli/options/heap.rs",
            "levels/load.rs",
        ],
        "the system is asked for pages in one place, and told in others what answers a fault and what memory goes back; a level is loaded in one",
    ),
    (
        "httparse",
        &["view/connection.rs"],
        "what comes from a network is read in one file",
    ),
    (
        "getrandom",
        &["view/guard.rs"],
        "nothing but a secret is random",
    ),
    (
        "memmap2",
        &["io/cache/mapping.rs"],
        "files become memory in one place",
    ),
    (
        "crc32fast",
        &[
            "io/cache/",
            "jobs/",
            "bench/answer.rs",
            "bench/fingerprint.rs",
        ],
        "checksums are part of three file formats",
    ),
    (
        "wide",
        &["trace/simd/types.rs"],
        "the vector crate can be exchanged in one file",
    ),
    (
        "obvhs",
        &["trace/bvh/", "bench/peers/"],
        "builders can be exchanged in one room",
    ),
    (
        "libloading",
        &["bench/peers/embree/api.rs"],
        "foreign code comes in at one place",
    ),
    (
        "image",
        &["image/", "formats/texture/picture/others.rs"],
        "encoders can be exchanged in one room, and decoders of textures in one file",
    ),
    (
        "exr",
        &["image/exr.rs", "image/exr_header.rs", "image/read/exr.rs"],
        "files of linear radiance are written in one file, their headers in another, and read in a third",
    ),
    (
        "png",
        &[
            "image/png.rs",
            "image/lib.rs",
            "image/read/",
            "image/decoders/",
            "formats/texture/picture/",
            "formats/texture/tests.rs",
        ],
        "pictures are written row by row in one file, read so in another, and textures in a third; one opens the files of both",
    ),
    (
        "signal_hook",
        &["cli/output/sinks/interrupt.rs"],
        "signals come in at one place",
    ),
    (
        "jpeg_decoder",
        &["image/decoders/jpeg.rs", "formats/texture/picture/jpeg.rs"],
        "one decoder, without SIMD, gives every build the same texels and samples",
    ),
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
        "core_affinity",
        &["render/workers.rs"],
        "threads are pinned in one place",
    ),
    (
        "raw_cpuid",
        &["trace/isa.rs", "bench/machine.rs"],
        "what the CPU has, and what it is",
    ),
    ("pyo3", &["python/"], "the library knows no interpreter"),
    (
        "numpy",
        &["python/"],
        "the library takes slices, whoever owns them",
    ),
    (
        "sysinfo",
        &["bench/machine.rs"],
        "the system is asked in one place",
    ),
];

/// Operations that may give different bits on different machines, and a second index of a record's
/// rows; the files that may have them nevertheless, and their replacements.
const BANNED: [(&str, &[&str], &str); 14] = [
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
    (
        ", &'a RateRow>",
        &["report/record_index.rs"],
        "rows by their keys: RecordIndex",
    ),
];

/// The lane types, and code that only computes bounds.
const BOUNDS: [&str; 4] = [
    "trace/simd/mod.rs",
    "trace/simd/types.rs",
    "trace/traverse/beam/shadow_cull.rs",
    "trace/intersect/slab_conservative.rs",
];

/// Files that may contain `unsafe`.
const UNSAFE_FILES: [&str; 32] = [
    "trace/simd/compact.rs",
    "trace/simd/mask_bits.rs",
    "scene/huge_pages.rs",
    "io/cache/mapping.rs",
    // Open files are known by their numbers alone.
    "files/descriptor.rs",
    "cli/options/bus_error.rs",
    // The allocator takes numbers through its C interface alone.
    "cli/options/heap.rs",
    "trace/traverse/beam/state.rs",
    "trace/traverse/beam/traverse.rs",
    "trace/traverse/beam/pairs.rs",
    "trace/traverse/beam/deferred.rs",
    "trace/traverse/wide_stack.rs",
    "trace/traverse/leaf_slots.rs",
    "trace/traverse/packet.rs",
    "trace/prefetch.rs",
    "trace/traverse/single_ray/mod.rs",
    "trace/traverse/single_ray/one_ray.rs",
    // A C interface, and the control register that it wants otherwise.
    "bench/peers/embree/api.rs",
    "bench/peers/embree/mxcsr.rs",
    // Memory of callers in C.
    "capi/batch.rs",
    "capi/columns.rs",
    "capi/files.rs",
    "capi/hits.rs",
    "capi/ray.rs",
    "capi/rows.rs",
    "capi/scene.rs",
    "capi/status.rs",
    "capi/table.rs",
    "capi/tree.rs",
    // Libraries that a program contains, and memory that goes back to them.
    "levels/level.rs",
    "levels/lib.rs",
    "levels/load.rs",
];

/// Crates of ours that crate `name` depends on, in alphabetical order.
pub fn dependencies(name: &str) -> Vec<String> {
    let path = format!("{}/src/{name}/Cargo.toml", env!("CARGO_MANIFEST_DIR"));
    let manifest = std::fs::read_to_string(&path).expect("a manifest");
    let rest = manifest
        .lines()
        .filter_map(|line| line.strip_prefix("phalanx-"));
    let mut names: Vec<String> = rest
        .filter_map(|line| line.split(['.', ' ']).next().map(str::to_owned))
        .collect();
    names.sort();
    names
}

#[test]
fn crates_depend_on_what_the_table_allows() {
    for (name, may, why) in CRATES {
        for other in dependencies(name) {
            assert!(may.contains(&&*other), "{name} depends on {other}: {why}");
        }
    }
}

#[test]
fn rooms_import_what_the_table_allows() {
    let mut wrong = Vec::new();
    for source in &sources() {
        let Some((room, may, why)) = ROOMS.iter().find(|row| source.is_in(row.0)) else {
            continue;
        };
        let own = room.rsplit('/').next().unwrap_or_default();
        for other in imported(&source.code, "crate") {
            // Tests of every room may ask for their size.
            let allowed = [own, "full_or"].contains(&&*other) || may.contains(&&*other);
            if !allowed {
                wrong.push(format!("{}: {room} imports {other} ({why})", source.path));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn floors_of_the_program_import_those_beneath() {
    let mut wrong = Vec::new();
    for source in &sources() {
        let Some((floor, may, why)) = FLOORS.iter().find(|row| source.is_in(row.0)) else {
            continue;
        };
        let own = floor.rsplit('/').next().unwrap_or_default();
        for import in import_paths(&source.code) {
            if !import
                .segments
                .starts_with(&["crate", "cli"].map(str::to_owned))
            {
                continue;
            }
            let other = import.segments.get(2).map_or("", String::as_str);
            if other != own && !may.contains(&other) {
                let path = import.segments.join("::");
                wrong.push(format!("{}: {floor} imports {path} ({why})", source.path));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Paths through `super` must stay within their module, too.
#[test]
fn super_stays_within_its_room() {
    for source in &sources() {
        let Some((room, ..)) = FLOORS.iter().chain(&ROOMS).find(|row| source.is_in(row.0)) else {
            continue;
        };
        let depth = source.path.matches('/').count() - room.matches('/').count();
        let inner = source.code.contains("mod tests {");
        let module = source.path.ends_with("mod.rs");
        let levels = depth - usize::from(module) + usize::from(inner);
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
fn banned_code_stands_in_the_files_that_own_it() {
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
    let rooms = imported(&code, "crate");
    let rooms: Vec<&str> = rooms.iter().map(String::as_str).collect();
    assert_eq!(rooms, ["bvh", "lanes", "scene"]);
    assert_eq!(places("unsafe_code unsafe", "unsafe"), [12]);
    assert!(imported_crate("use wide::{f32x8};", "wide"));
    assert!(!imported_crate("self.wide(3); crate::wide::x", "wide"));
    assert!(imported_crate("let c = image::open(p);", "image"));
    assert!(!imported_crate("use crate::image::write;", "image"));
}
