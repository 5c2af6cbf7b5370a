//! Forged files: valid checksums, hostile numbers.

use crate::common::rng::Rng;
use serde_json::{Value, json};

const MAGIC: &[u8; 8] = b"\xf7PHXTILE";

const NUMBERS: [u32; 14] = [
    0,
    1,
    7,
    8,
    9,
    16,
    24,
    40,
    1023,
    1024,
    1025,
    65_536,
    0x7fff_ffff,
    u32::MAX,
];

fn places(file: &[u8]) -> Vec<usize> {
    let windows = file.windows(8).enumerate();
    windows
        .filter(|(_, w)| w == MAGIC)
        .map(|(offset, _)| offset)
        .collect()
}

fn set(file: &mut [u8], offset: usize, number: u32) {
    file[offset..offset + 4].copy_from_slice(&number.to_le_bytes());
}

/// Recomputes the checksum of a record's header.
fn seal(file: &mut [u8], offset: usize) {
    let sum = crc32fast::hash(&file[offset..offset + 36]);
    set(file, offset + 36, sum);
}

/// One of the files with changed numbers in its headers, a changed beginning, or reordered records.
pub fn tiles(seeds: &[Vec<u8>], rng: &mut Rng) -> Vec<u8> {
    let mut file = seeds[rng.below(seeds.len())].clone();
    for _ in 0..1 + rng.below(3) {
        let places = places(&file);
        let offset = places[rng.below(places.len())];
        match rng.below(5) {
            // Its position, size, planes or picture; and whether its content is what was written.
            0 | 1 => {
                set(&mut file, offset + 8 + 4 * rng.below(7), rng.pick(&NUMBERS));
                seal(&mut file, offset);
            }
            // Numbers that are plausible for a tile.
            2 => {
                let small = 8 * rng.below(6) as u32;
                set(&mut file, offset + 8 + 4 * rng.below(4), small);
                seal(&mut file, offset);
            }
            3 => {
                let end = places.iter().find(|p| **p > offset).copied();
                let record = file[offset..end.unwrap_or(file.len())].to_vec();
                let to = places[rng.below(places.len())];
                file.splice(to..to, record);
            }
            _ => file = begun(&file, rng),
        }
    }
    file
}

/// The file with another beginning, with matching length and checksum.
fn begun(file: &[u8], rng: &mut Rng) -> Vec<u8> {
    let length = u32::from_le_bytes(file[8..12].try_into().unwrap()) as usize;
    let text = json(&[file[16..16 + length].to_vec()], rng);
    let mut new = file[..8].to_vec();
    new.extend((text.len() as u32).to_le_bytes());
    new.extend(crc32fast::hash(&text).to_le_bytes());
    new.extend(&text);
    new.extend(&file[16 + length..]);
    new
}

/// One of the documents with changed values.
pub fn json(seeds: &[Vec<u8>], rng: &mut Rng) -> Vec<u8> {
    let seed = &seeds[rng.below(seeds.len())];
    let mut document: Value = serde_json::from_slice(seed).unwrap();
    for _ in 0..1 + rng.below(3) {
        change(&mut document, rng);
    }
    document.to_string().into_bytes()
}

fn change(value: &mut Value, rng: &mut Rng) {
    match value {
        Value::Object(fields) if !fields.is_empty() && !rng.once_in(12) => {
            let name = fields.keys().nth(rng.below(fields.len())).unwrap().clone();
            match rng.below(16) {
                0 => drop(fields.remove(&name)),
                1 => drop(fields.insert("more".to_owned(), nasty(rng))),
                _ => change(&mut fields[&name], rng),
            }
        }
        Value::Array(all) if !all.is_empty() && !rng.once_in(4) => {
            let offset = rng.below(all.len());
            match rng.below(6) {
                0 => drop(all.remove(offset)),
                1 => all.push(all[offset].clone()),
                _ => change(&mut all[offset], rng),
            }
        }
        _ => *value = nasty(rng),
    }
}

fn nasty(rng: &mut Rng) -> Value {
    match rng.below(4) {
        0 | 1 => json!(rng.pick(&NUMBERS)),
        2 => {
            let all = [
                json!(-1),
                json!(0.5),
                json!(1e38),
                json!(-1e300),
                json!(u64::MAX),
                json!(null),
                json!(true),
                json!([]),
                json!({}),
                json!([[[[]]]]),
                json!(16),
                json!(2),
                json!(100_000),
                json!(64),
            ];
            all[rng.below(all.len())].clone()
        }
        _ => {
            let all = [
                "",
                "a",
                "/",
                "..",
                "../x.png",
                "/tmp/x.png",
                "a/b.png",
                "./x.png",
                "x/../../y.png",
                "\n",
                "\u{1b}[2J",
                "depth",
                "cost",
                "box",
                "tent",
                "ao",
                "ffffffffffffffff",
                "1.0.0",
            ];
            json!(all[rng.below(all.len())])
        }
    }
}
