//! Mutated plans, tile files and lists of frames: nothing panics, hangs, or allocates memory by an
//! unchecked number. A file is either refused or leads to the right picture, because damaged tiles
//! are rendered again.
//!
//! Some hundreds of each by default, some thousands with `PHALANX_FULL`;
//! `PHALANX_FUZZ_MUTANTS=30000 cargo test --release --test allocation fuzz_jobs::` for more. A
//! failing mutant is written to the system's temporary folder; the message has its path.

mod forge;
mod picture;

use crate::allocator::{alone, forget, largest};
use crate::common::full_or;
use crate::common::rng::Rng;
use crate::mutate::mutated;
use phalanx::frame::Tile;
use phalanx::jobs::{FinishedFrames, FrameState, PlannedFrames, RenderPlan, ShardBy, TileFile};
use picture::FuzzedPicture;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time limit for one mutant, on a machine with other load.
const PATIENCE: Duration = Duration::from_secs(10);

/// Limit on a single request for a file of a given length: its own bytes, plus the needs of
/// rendering the small picture.
fn most_memory(length: usize) -> usize {
    length * 64 + (16 << 20)
}

fn mutants(usual: usize) -> usize {
    let given = std::env::var("PHALANX_FUZZ_MUTANTS").ok();
    given
        .and_then(|n| n.parse().ok())
        .unwrap_or(full_or(usual, usual / 8))
}

/// Checks a mutant, its time and its requests; returns a word for the table.
fn watched(mutant: &[u8], look: impl FnOnce() -> &'static str) -> &'static str {
    forget();
    let start = Instant::now();
    let looked = catch_unwind(AssertUnwindSafe(|| {
        let word = look();
        let (largest, most) = (largest(), most_memory(mutant.len()));
        assert!(
            largest <= most,
            "{largest} bytes were asked for at once: at most {most}"
        );
        word
    }));
    let time = start.elapsed();
    match looked {
        Ok(word) if time < PATIENCE => word,
        _ => {
            let path =
                std::env::temp_dir().join(format!("finding-{:08x}", crc32fast::hash(mutant)));
            std::fs::write(&path, mutant).unwrap();
            panic!("{} took {time:?} or failed", path.display());
        }
    }
}

fn tell(what: &str, count: usize, start: Instant, words: &BTreeMap<&str, usize>) {
    let seconds = start.elapsed().as_secs_f64();
    println!("{what}: {count} mutants in {seconds:.1} s, no finding: {words:?}");
}

/// A damaged or forged file of tiles.
fn tiles(picture: &FuzzedPicture, folder: &Path) {
    let path = folder.join("mutant.tiles");
    let seeds = picture.tile_files(folder);
    let count = mutants(4000);
    let mut rng = Rng::new(count as u64);
    let (start, mut words) = (Instant::now(), BTreeMap::new());
    for _ in 0..count {
        let forged = rng.once_in(2);
        let mutant =
            if forged { forge::tiles(&seeds, &mut rng) } else { mutated(&seeds, &mut rng) };
        let word = watched(&mutant, || {
            std::fs::write(&path, &mutant).unwrap();
            let merged = picture.merged(&path);
            std::fs::write(&path, &mutant).unwrap();
            let resumed = picture.resumed(&path);
            for film in [&merged, &resumed].into_iter().flatten() {
                // Valid checksums allow forged pixels, but only within the picture.
                assert!(forged || *film == picture.film, "another picture");
                assert_eq!((film.width, film.height), picture.size());
            }
            if resumed.is_some() {
                let complete = picture.merged(&path);
                assert!(complete.is_some_and(|film| forged || film == picture.film));
            }
            match (merged, resumed) {
                (Some(_), _) => "merged",
                (None, Some(_)) => "resumed",
                (None, None) => "refused",
            }
        });
        *words.entry(word).or_default() += 1;
    }
    tell("tile files", count, start, &words);
}

/// A damaged or forged plan, with good tiles.
fn plans(picture: &FuzzedPicture, folder: &Path) {
    let path = folder.join("mutant.json");
    let good: PathBuf = folder.join("good.tiles");
    std::fs::write(&good, &picture.tile_files(folder)[0]).unwrap();
    let seeds = [
        picture.plan(1),
        picture.plan(3),
        picture.sequence_plan(3, ShardBy::Frame),
        picture.sequence_plan(2, ShardBy::Tile),
    ];
    let seeds = seeds.map(|plan| serde_json::to_vec(&plan).unwrap());
    let count = mutants(10_000);
    let mut rng = Rng::new(!(count as u64));
    let (start, mut words) = (Instant::now(), BTreeMap::new());
    for _ in 0..count {
        let mutant = if rng.once_in(3) {
            mutated(&seeds, &mut rng)
        } else {
            forge::json(&seeds, &mut rng)
        };
        let word = watched(&mutant, || {
            std::fs::write(&path, &mutant).unwrap();
            let Ok(plan) = RenderPlan::read(&path) else {
                return "refused";
            };
            used(picture, &plan, &path, &good)
        });
        *words.entry(word).or_default() += 1;
    }
    tell("plans", count, start, &words);
}

/// Processes a plan as `render --plan` and `merge` do.
fn used(picture: &FuzzedPicture, plan: &RenderPlan, path: &Path, good: &Path) -> &'static str {
    if let Ok(output) = plan.picture_path(path) {
        let folder = path.parent().unwrap().canonicalize().unwrap();
        let place = output.parent().unwrap().canonicalize().ok();
        // Nothing can be written to a missing folder.
        assert!(
            place.is_none_or(|place| place.starts_with(folder)),
            "{output:?}"
        );
    }
    used_frames(&PlannedFrames::of(plan), path);
    let window = plan.window();
    assert!(window.pixels() > 0 && window.within(Tile::whole(65_536, 65_536)) == window);
    assert!(plan.share(plan.shards).is_err());
    if window.pixels() < 1 << 16 {
        let tiles = plan.tiles();
        let dealt = (0..plan.shards).map(|shard| plan.share_of(&tiles, shard).count());
        assert_eq!(dealt.sum::<usize>(), tiles.len());
    }
    match TileFile::read(good, &plan.key()) {
        Ok(file) => {
            let film = picture::merge(plan, file);
            assert!(film.is_none_or(|film| film == picture.film));
            "merged"
        }
        Err(_) => "of another picture",
    }
}

/// Processes a plan's frames as `render --plan` and `merge` do before they render or write.
fn used_frames(frames: &PlannedFrames, path: &Path) {
    let plan = frames.plan;
    for frame in frames.all().take(9) {
        if let (Ok(view), Ok(key)) = (frames.view(frame), frames.key(frame)) {
            let sound = view.is_none_or(|view| view.basis().is_ok());
            assert!(sound && key.check().is_ok(), "{view:?}");
            assert!(frames.identity(frame).is_ok());
        }
        if let Ok(output) = frames.picture_path(path, frame) {
            let folder = path.parent().unwrap().canonicalize().unwrap();
            let place = output.parent().unwrap().canonicalize().ok();
            assert!(
                place.is_none_or(|place| place.starts_with(folder)),
                "{output:?}"
            );
        }
    }
    if frames.is_by_frame() && frames.all().nth(1 << 12).is_none() {
        let dealt = (0..plan.shards).map(|shard| frames.of_shard(shard).count());
        assert_eq!(dealt.sum::<usize>(), frames.all().count());
    }
}

/// Lists of finished frames.
fn lists(picture: &FuzzedPicture, folder: &Path) {
    let path = folder.join("mutant.frames");
    let plan = picture.sequence_plan(2, ShardBy::Frame);
    let frames = PlannedFrames::of(&plan);
    let (frame, shown) = (frames.identity(0).unwrap(), folder.join("frame.png"));
    std::fs::write(&shown, "pixels").unwrap();
    let open = || FinishedFrames::open(&path, &plan.key(), &frames.path_checksum());
    let mut list = open().unwrap();
    for number in 0..3 {
        list.add(frames.identity(number).unwrap(), &shown).unwrap();
    }
    drop(list);
    let seeds = [std::fs::read(&path).unwrap()];
    let count = mutants(1000);
    let mut rng = Rng::new(count as u64 + 1);
    let (start, mut words) = (Instant::now(), BTreeMap::new());
    for _ in 0..count {
        let mutant = mutated(&seeds, &mut rng);
        let word = watched(&mutant, || {
            std::fs::write(&path, &mutant).unwrap();
            let Ok(mut list) = open() else {
                return "refused";
            };
            // Whatever the list contained, an added frame is in it.
            list.add(frame, &shown).unwrap();
            drop(list);
            let list = open().unwrap();
            assert_eq!(list.state(frame, &shown).unwrap(), FrameState::Finished);
            "taken"
        });
        *words.entry(word).or_default() += 1;
    }
    tell("lists of frames", count, start, &words);
}

#[test]
fn mutants_of_plans_and_of_tiles() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let picture = FuzzedPicture::new();
    tiles(&picture, folder.path());
    plans(&picture, folder.path());
    lists(&picture, folder.path());
}
