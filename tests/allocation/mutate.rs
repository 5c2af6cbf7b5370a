//! Mutations that have broken readers before.

use crate::common::rng::Rng;

/// Words for text files.
const WORDS: [&str; 40] = [
    "nan",
    "inf",
    "-1",
    "0",
    "1",
    "3",
    "4",
    "1e39",
    "1e-46",
    "3.4e38",
    "-3.4e38",
    "1e20",
    "99999999999999999999",
    "4294967295",
    "2147483648",
    "-2147483648",
    "1.5",
    "#",
    "\n",
    "\r",
    "\r\n",
    "\\\n",
    "\u{feff}",
    "\0",
    "é",
    "/",
    "//",
    "1/1/1",
    "-1//-1",
    "f",
    "v",
    "usemtl",
    "list",
    "property",
    "end_header",
    "endfacet",
    "vertex",
    "1e7",
    "1e-12",
    " ",
];
/// Numbers for binary files, truncated to one, two, four or eight bytes.
const NUMBERS: [u64; 12] = [
    0,
    1,
    3,
    0x7f,
    0xff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    u64::MAX,
    0x7f80_0000, // infinity
    0x7fc0_0000, // NaN
    0x0100_0000,
];

/// One of the inputs with a few changes.
pub fn mutated(corpus: &[Vec<u8>], rng: &mut Rng) -> Vec<u8> {
    let mut input = corpus[rng.below(corpus.len())].clone();
    for _ in 0..1 + rng.below(4) {
        change(&mut input, corpus, rng);
    }
    input
}

fn change(input: &mut Vec<u8>, corpus: &[Vec<u8>], rng: &mut Rng) {
    let offset = rng.below(input.len() + 1);
    match rng.below(11) {
        0 => input.truncate(offset),
        1 => {
            if let Some(byte) = input.get_mut(offset) {
                *byte ^= 1 << rng.below(8);
            }
        }
        2 => {
            if let Some(byte) = input.get_mut(offset) {
                *byte = rng.bits() as u8;
            }
        }
        3 => drop(input.drain(span(input, offset, rng))),
        4 => {
            let copy = input[span(input, offset, rng)].to_vec();
            let most = if rng.once_in(50) { 300 } else { 3 };
            let times = 1 + rng.below(most);
            insert(input, rng, &copy.repeat(times));
        }
        5 => {
            let other = &corpus[rng.below(corpus.len())];
            let start = rng.below(other.len() + 1);
            let part = other[span(other, start, rng)].to_vec();
            insert(input, rng, &part);
        }
        6 | 7 => number(input, offset, rng),
        8 => {
            let word = WORDS[rng.below(WORDS.len())];
            input.splice(offset..offset, word.bytes());
        }
        _ => replace_word(input, offset, rng),
    }
}

/// Up to a few dozen bytes from a position.
fn span(input: &[u8], offset: usize, rng: &mut Rng) -> std::ops::Range<usize> {
    let magnitude = 1 + rng.below(7);
    let length = 1 + rng.below(1 << magnitude);
    offset..(offset + length).min(input.len())
}

fn insert(input: &mut Vec<u8>, rng: &mut Rng, part: &[u8]) {
    let offset = rng.below(input.len() + 1);
    input.splice(offset..offset, part.iter().copied());
}

/// Overwrites bytes with a number in either order.
fn number(input: &mut [u8], offset: usize, rng: &mut Rng) {
    let number = NUMBERS[rng.below(NUMBERS.len())];
    let size = 1 << rng.below(4);
    let mut bytes = number.to_le_bytes()[..size].to_vec();
    if rng.once_in(2) {
        bytes.reverse();
    }
    for (byte, new) in input.iter_mut().skip(offset).zip(bytes) {
        *byte = new;
    }
}

/// Replaces the word around `offset`.
fn replace_word(input: &mut Vec<u8>, offset: usize, rng: &mut Rng) {
    let blank = |b: &u8| *b <= b' ';
    let start = input[..offset].iter().rposition(blank).map_or(0, |i| i + 1);
    let end = input[offset..]
        .iter()
        .position(blank)
        .map_or(input.len(), |i| offset + i);
    let word = WORDS[rng.below(WORDS.len())];
    input.splice(start..end, word.bytes());
}
