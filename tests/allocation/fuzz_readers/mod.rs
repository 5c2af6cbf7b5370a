//! Mutated files: no reader panics, hangs, or allocates memory by an unchecked count, and its
//! messages refer to positions in the file.
//!
//! Each format has seeds in `corpus/<ending>`. A fifth of a second each by default, a second with
//! `PHALANX_FULL`; `PHALANX_FUZZ_SECONDS=600 cargo test --release --test allocation fuzz_readers::`
//! for more. Mutants that cause new messages join the corpus of the run. A failing input is written
//! to the system's temporary folder; the message has its path.

use crate::allocator::{alone, forget, largest};
use crate::common::full_or;
use crate::common::rng::Rng;
use crate::mutate::mutated;
use phalanx::formats::{
    Diagnostic, Loaded, MAX_DIAGNOSTICS, Options, ReadOptions, endings, read_bytes,
};
use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Limit on a single request for a file of a given length: the size of its columns, plus room for
/// small tables.
fn most_memory(length: usize) -> usize {
    length * 64 + (1 << 20)
}

/// Time limit for one small file, on a machine with other load.
const PATIENCE: Duration = Duration::from_secs(20);
/// Maximum length of an input.
const MAX_LENGTH: usize = 1 << 16;
/// Maximum number of inputs in the run's corpus.
const MAX_CORPUS: usize = 2000;

fn duration() -> Duration {
    let given = std::env::var("PHALANX_FUZZ_SECONDS").ok();
    let usual = Duration::from_millis(full_or(1000, 200));
    given
        .and_then(|s| s.parse().ok())
        .map_or(usual, Duration::from_secs)
}

fn seeds(ending: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/allocation/fuzz_readers/corpus")
        .join(ending);
    let Ok(entries) = std::fs::read_dir(&folder) else {
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
        .iter()
        .map(|path| std::fs::read(path).unwrap())
        .collect()
}

/// Feeds mutants of the seeds to the reader of files with that extension.
fn fuzz(ending: &str) {
    let mut corpus = seeds(ending);
    if corpus.is_empty() {
        println!("skipped: {ending} has no seeds");
        return;
    }
    let mut messages = HashSet::new();
    for seed in &corpus {
        messages.insert(checked(ending, seed));
    }
    // A longer run is a different run; each is reproducible.
    let mut rng = Rng::new(duration().as_millis() as u64);
    let end = Instant::now() + duration();
    let (mut executions, seed_count) = (0u64, corpus.len());
    while Instant::now() < end {
        let mut mutant = mutated(&corpus, &mut rng);
        mutant.truncate(MAX_LENGTH);
        executions += 1;
        if messages.insert(checked(ending, &mutant)) && corpus.len() < MAX_CORPUS {
            corpus.push(mutant);
        }
    }
    let rate = executions as f64 / duration().as_secs_f64();
    let new = corpus.len() - seed_count;
    println!(
        "{ending}: {executions} executions, {rate:.0} a second, {seed_count} seeds, {new} new inputs, no finding"
    );
}

/// Reads the input, checks what must hold for any input, and returns a digest of the messages.
fn checked(ending: &str, input: &[u8]) -> u64 {
    let options = Options {
        read: ReadOptions {
            threads: 1 + input.len() % 2,
            ..ReadOptions::default()
        },
        ..Options::default()
    };
    forget();
    let start = Instant::now();
    let read = catch_unwind(AssertUnwindSafe(|| {
        let read = read_bytes(ending, input, &options).expect("a known ending");
        let largest = largest();
        let most = most_memory(input.len());
        assert!(
            largest <= most,
            "{largest} bytes were asked for at once: at most {most}"
        );
        check(input, &read);
        digest(&read)
    }));
    let time = start.elapsed();
    match read {
        Ok(digest) if time < PATIENCE => digest,
        _ => {
            let path = std::env::temp_dir().join(format!("finding-{:x}.{ending}", hash(input)));
            std::fs::write(&path, input).unwrap();
            panic!("{} took {time:?} or failed", path.display());
        }
    }
}

fn check(input: &[u8], read: &Result<Loaded, Vec<Diagnostic>>) {
    let messages = match read {
        Ok(loaded) => {
            loaded.scene.validate().expect("what loads is valid");
            &loaded.warnings
        }
        Err(errors) => {
            assert!(!errors.is_empty(), "refused without a reason");
            errors
        }
    };
    assert!(
        messages.len() <= MAX_DIAGNOSTICS,
        "{} diagnostics",
        messages.len()
    );
    for d in messages {
        // In text that is not UTF-8, a byte may be shown as U+FFFD, which has three bytes.
        let shown = String::from_utf8_lossy(input).len();
        assert!(
            d.offset.saturating_add(d.length) <= shown,
            "{d:?} lies outside"
        );
        let lines = input.split(|&b| b == b'\n').count();
        assert!(d.line <= lines && (d.line == 0) == (d.column == 0), "{d:?}");
    }
}

/// Digest of a result: its messages without their numbers, and its approximate size. A new digest
/// indicates a new path in the reader.
fn digest(read: &Result<Loaded, Vec<Diagnostic>>) -> u64 {
    let words = |all: &[Diagnostic]| -> Vec<String> {
        let plain = |d: &Diagnostic| {
            d.message
                .chars()
                .filter(char::is_ascii_alphabetic)
                .take(24)
                .collect()
        };
        all.iter().map(plain).take(3).collect()
    };
    match read {
        Ok(loaded) => {
            let size = |n: usize| n.checked_ilog2();
            let t = &loaded.scene.triangles;
            hash(&(
                true,
                words(&loaded.warnings),
                size(loaded.scene.prim_count()),
                t.normals.is_empty(),
                t.uvs.is_empty(),
            ))
        }
        Err(errors) => hash(&(false, words(errors))),
    }
}

fn hash(value: &(impl Hash + ?Sized)) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

#[test]
fn mutants_of_every_format() {
    let _alone = alone();
    let only = std::env::var("PHALANX_FUZZ_FORMAT").ok();
    for ending in endings().filter(|ending| only.as_deref().is_none_or(|only| only == *ending)) {
        fuzz(ending);
    }
}
