use super::*;
use phalanx_render::frame::Settings;
use phalanx_scene::Scene;
use phalanx_scene::film::tiles;
use std::fs;

const SIDE: u32 = 16;

fn identity(width: u32) -> RenderKey {
    let scene = Scene::default();
    let region = Tile {
        x: 5,
        y: 3,
        width: 60,
        height: 50,
    };
    let settings = Settings {
        width,
        height: 70,
        region: Some(region),
        ..Settings::of(&scene)
    };
    RenderKey::of(&scene, &settings)
}

fn ours() -> RenderKey {
    identity(80)
}

/// A colour that encodes the pixel's position.
fn color(x: u32, y: u32) -> [f32; 3] {
    [x as f32, y as f32, (x * y) as f32]
}

fn add(file: &TileFile, tile: Tile) {
    let mut pixels = TileBuffer::new(false);
    pixels.fit(tile);
    for y in 0..tile.height {
        for x in 0..tile.width {
            pixels.set(x, y, color(tile.x + x, tile.y + y));
        }
    }
    file.append(tile, &pixels).unwrap();
}

fn all() -> Vec<Tile> {
    tiles(ours().pixels.window(), SIDE)
}

/// Writes a file of these tiles.
fn write(path: &Path, tiles: &[Tile]) {
    let file = TileFile::open(path, &ours()).unwrap();
    tiles.iter().for_each(|tile| add(&file, *tile));
    file.sync().unwrap();
}

/// The tiles that a file has, after asserting that all of their pixels are unchanged.
fn held(file: &TileFile) -> Vec<Tile> {
    let window = ours().pixels.window();
    let mut film = Film::new(window.width, window.height, false);
    file.restore(window, &mut film).unwrap();
    let (has, hasnt): (Vec<Tile>, Vec<Tile>) = all().iter().partition(|t| file.has(**t));
    let pixel = |x, y| film.pixel(x - window.x, y - window.y);
    for (tile, there) in has
        .iter()
        .map(|t| (t, true))
        .chain(hasnt.iter().map(|t| (t, false)))
    {
        for y in tile.y..tile.y + tile.height {
            for x in tile.x..tile.x + tile.width {
                let want = if there { color(x, y) } else { [0.0; 3] };
                assert_eq!(pixel(x, y), want, "({x}, {y})");
            }
        }
    }
    assert_eq!(file.pixels(), has.iter().map(Tile::pixels).sum::<u64>());
    has
}

#[test]
fn what_was_added_is_there_when_it_is_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let all = all();
    write(&path, &all[..3]);
    let again = TileFile::open(&path, &ours()).unwrap();
    assert_eq!(held(&again), all[..3]);
    // After some were restored, new tiles go to the end.
    add(&again, all[3]);
    drop(again);
    let file = TileFile::read(&path, &ours()).unwrap();
    assert_eq!((held(&file), file.damaged()), (all[..4].to_vec(), 0));
}

#[test]
fn a_file_that_is_cut_off_has_what_is_whole_and_goes_on_from_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let all = all();
    write(&path, &all[..3]);
    let bytes = fs::read(&path).unwrap();
    let beginning = file_header::bytes(&ours()).len();
    let mut ends = vec![beginning];
    for tile in &all[..3] {
        ends.push(ends[ends.len() - 1] + HEADER_BYTES + 12 * tile.pixels() as usize);
    }
    assert_eq!(ends[3], bytes.len());
    let around = |end: &usize| {
        [
            end - 1,
            *end,
            end + 1,
            end + HEADER_BYTES - 1,
            end + HEADER_BYTES + 7,
        ]
    };
    let cuts = ends.iter().flat_map(around).chain([0, 1, 7, 8, 15, 16, 17]);
    for cut in cuts.filter(|cut| *cut <= bytes.len()) {
        fs::write(&path, &bytes[..cut]).unwrap();
        let file = TileFile::open(&path, &ours()).unwrap();
        let complete = ends[1..].iter().filter(|end| **end <= cut).count();
        assert_eq!(held(&file), all[..complete], "cut at {cut}");
        add(&file, all[4]);
        drop(file);
        let file = TileFile::read(&path, &ours()).unwrap();
        assert_eq!(held(&file).len(), complete + 1, "cut at {cut}");
        assert!(file.has(all[4]));
    }
}

#[test]
fn a_byte_that_has_changed_costs_its_tile_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let all = all();
    write(&path, &all[..4]);
    let bytes = fs::read(&path).unwrap();
    let beginning = file_header::bytes(&ours()).len();
    let mut ends = vec![beginning];
    for tile in &all[..4] {
        ends.push(ends[ends.len() - 1] + HEADER_BYTES + 12 * tile.pixels() as usize);
    }
    for offset in (0..bytes.len())
        .step_by(97)
        .chain(0..40)
        .chain(ends[1]..ends[1] + HEADER_BYTES)
    {
        let mut changed = bytes.clone();
        changed[offset] ^= 0x10;
        fs::write(&path, &changed).unwrap();
        let file = TileFile::open(&path, &ours()).unwrap();
        let hurt = ends.windows(2).position(|e| (e[0]..e[1]).contains(&offset));
        let left: Vec<Tile> = (0..4)
            .filter(|k| Some(*k) != hurt)
            .map(|k| all[k])
            .collect();
        assert_eq!(held(&file), left, "byte {offset}");
        // The damaged tile is rendered again, and then all are there.
        if let Some(hurt) = hurt {
            add(&file, all[hurt]);
        }
        drop(file);
        let file = TileFile::read(&path, &ours()).unwrap();
        assert_eq!(held(&file), all[..4], "byte {offset}");
    }
}

#[test]
fn other_files_are_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let long = "my notes, and what else I wanted to say ".repeat(20);
    for text in ["x", "my notes", &long] {
        fs::write(&path, text).unwrap();
        let refused = TileFile::open(&path, &ours()).unwrap_err();
        assert!(matches!(refused, KeptFileError::Other { .. }), "{refused}");
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
    }
    fs::remove_file(&path).unwrap();
    write(&path, &all()[..2]);
    let before = fs::read(&path).unwrap();
    let refused = TileFile::open(&path, &identity(81)).unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("--size is 80x70 there and 81x70 here"),
        "{refused}"
    );
    assert_eq!(fs::read(&path).unwrap(), before);
    let held = TileFile::open(&path, &ours()).unwrap();
    let refused = TileFile::open(&path, &ours()).unwrap_err();
    assert!(matches!(refused, KeptFileError::InUse { .. }), "{refused}");
    drop(held);
    TileFile::open(&path, &ours()).unwrap();
}

/// A picture whose tiles may be as large as any.
fn large() -> RenderKey {
    let scene = Scene::default();
    let settings = Settings {
        width: 2048,
        height: 2048,
        ..Settings::of(&scene)
    };
    RenderKey::of(&scene, &settings)
}

fn seconds_to_read(path: &Path, bytes: &[u8], key: &RenderKey) -> (f64, TileFile) {
    fs::write(path, bytes).unwrap();
    let start = Instant::now();
    let file = TileFile::read(path, key).unwrap();
    (start.elapsed().as_secs_f64(), file)
}

/// A record header without its content, or with another.
fn claim(key: &RenderKey, tile: Tile, planes: usize) -> Vec<u8> {
    let plane = vec![0.5; tile.pixels() as usize];
    let mut bytes = Vec::new();
    tile_record::write(&mut bytes, tile, key.checksum(), &vec![&plane[..]; planes]);
    bytes.truncate(HEADER_BYTES);
    bytes
}

/// Overlapping headers: read once for each of them, the claimed bytes would be terabytes.
#[test]
fn heads_that_claim_the_same_bytes_cost_no_more_than_their_file_is_long() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let key = large();
    let head = claim(&key, Tile::whole(1024, 1024), 3);
    let mut bytes = file_header::bytes(&key);
    bytes.extend(head.repeat(700_000));
    let (seconds, file) = seconds_to_read(&path, &bytes, &key);
    assert!(seconds < 20.0, "{seconds} seconds");
    assert_eq!(file.pixels(), 0);
    assert!(file.damaged() > 0);
}

#[test]
fn beginnings_of_heads_cost_no_more_than_their_file_is_long() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let key = large();
    for ending in [&b""[..], b"\xf7PHX"] {
        let mut bytes = file_header::bytes(&key);
        bytes.extend(tile_record::MAGIC.repeat(1 << 20));
        bytes.extend(ending);
        let (seconds, file) = seconds_to_read(&path, &bytes, &key);
        assert!(seconds < 20.0, "{seconds} seconds");
        assert_eq!((file.pixels(), file.damaged()), (0, 0));
    }
}

#[test]
fn records_that_the_picture_cannot_have_count_for_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let tile = |x, y, width, height| Tile {
        x,
        y,
        width,
        height,
    };
    for (tile, planes) in [
        // Valid tiles have three planes, and lie in 60x50 pixels from (5, 3).
        (tile(8, 8, 8, 8), 2),
        (tile(8, 8, 8, 8), 4),
        (tile(0, 0, 8, 8), 3),
        (tile(64, 8, 8, 8), 3),
        (tile(8, 8, 8, 1000), 3),
        (tile(u32::MAX, u32::MAX, 8, 8), 3),
        (tile(u32::MAX - 4, 8, 8, 8), 3),
    ] {
        let plane = vec![0.5; tile.pixels() as usize];
        let mut record = Vec::new();
        tile_record::write(
            &mut record,
            tile,
            ours().checksum(),
            &vec![&plane[..]; planes],
        );
        write(&path, &all()[..2]);
        let mut bytes = fs::read(&path).unwrap();
        let first = file_header::bytes(&ours()).len();
        bytes.splice(first..first, record);
        fs::write(&path, &bytes).unwrap();
        let file = TileFile::open(&path, &ours()).unwrap();
        assert_eq!(held(&file), all()[..2], "{tile:?} {planes}");
        drop(file);
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn a_tile_that_is_there_twice_counts_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let all = all();
    write(&path, &[all[0], all[1], all[0], all[0]]);
    let file = TileFile::open(&path, &ours()).unwrap();
    assert_eq!((held(&file), file.damaged()), (all[..2].to_vec(), 0));
}
