//! Damage of every kind is detected and named.

use super::{CacheFolder, bytes_of, scene};
use phalanx::bvh::Bvh;
use phalanx::cache::{CacheError, CacheFault};
use phalanx::scene::Scene;
use std::io::ErrorKind;

fn fault(room: &CacheFolder, bytes: &[u8]) -> CacheFault {
    match room.open(bytes) {
        Err(CacheError::Refused { fault, .. }) => fault,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("taken"),
    }
}

/// Checksums cover everything except the header's own fields, which are validated individually.
#[test]
fn every_flipped_bit_is_refused() {
    let room = CacheFolder::new();
    let (scene, bvh) = scene(7, 4);
    let bytes = bytes_of(&scene, &bvh);
    for offset in 0..bytes.len() {
        // Each byte, and each bit of some.
        let bits = if offset % 16 == 0 || offset < 64 { 0..8 } else { offset % 8..offset % 8 + 1 };
        for bit in bits {
            let mut bad = bytes.clone();
            bad[offset] ^= 1 << bit;
            let fault = fault(&room, &bad);
            let named = match offset {
                0..8 => fault == CacheFault::NotACache,
                12..16 => matches!(fault, CacheFault::Version(_)),
                20..24 => matches!(fault, CacheFault::Damaged(_) | CacheFault::Truncated { .. }),
                _ => matches!(fault, CacheFault::Damaged(_) | CacheFault::Surplus(_)),
            };
            assert!(named, "bit {bit} of byte {offset}: {fault}");
        }
    }
}

#[test]
fn every_truncation_is_refused() {
    let room = CacheFolder::new();
    let bytes = bytes_of(&Scene::default(), &Bvh::default());
    assert_eq!(fault(&room, &[]), CacheFault::NotACache);
    for length in 1..bytes.len() {
        let fault = fault(&room, &bytes[..length]);
        let CacheFault::Truncated {
            length: had,
            needed,
        } = fault
        else {
            panic!("{length}: {fault}")
        };
        assert!(had == length as u64 && needed > had, "{fault}");
    }
    let longer = [&bytes[..], &[0]].concat();
    assert_eq!(fault(&room, &longer), CacheFault::Surplus("after its end"));
}

#[test]
fn foreign_files_are_named() {
    let room = CacheFolder::new();
    for foreign in [
        &b"size 640 480\n"[..],
        b"ply\n",
        b"\x93NUMPY",
        b"PHX",
        &[0; 4096],
    ] {
        assert_eq!(fault(&room, foreign), CacheFault::NotACache);
    }
    let bytes = bytes_of(&Scene::default(), &Bvh::default());
    let with = |offset: usize, word: u32| {
        let mut other = bytes.clone();
        other[offset..offset + 4].copy_from_slice(&word.to_le_bytes());
        other
    };
    let order = u32::from_le_bytes(bytes[8..12].try_into().unwrap());
    assert_eq!(
        fault(&room, &with(8, order.swap_bytes())),
        CacheFault::ByteOrder
    );
    assert_eq!(fault(&room, &with(12, 999)), CacheFault::Version(999));
    let mut other = with(16, 12345);
    super::hostile::fix(&mut other);
    assert_eq!(fault(&room, &other), CacheFault::Layout);
}

#[test]
fn files_that_cannot_be_read_are_told_from_bad_ones() {
    let room = CacheFolder::new();
    let Err(CacheError::Io { source, .. }) = phalanx::cache::open(&room.path) else {
        panic!("there is no file")
    };
    assert_eq!(source.kind(), ErrorKind::NotFound);
    let folder = room.path.parent().unwrap();
    assert!(matches!(
        phalanx::cache::open(folder),
        Err(CacheError::Io { .. })
    ));
}
