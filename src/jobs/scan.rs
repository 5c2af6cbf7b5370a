//! Reads a tile file from its beginning to its end, whatever has become of it.

use super::identity::Identity;
use super::record::{self, HEAD, Head};
use super::tile_file::{BEFORE, MAGIC, head};
use crate::frame::Tile;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};

/// Whose tiles a file holds.
pub(super) enum Owner {
    /// It is empty.
    Nobody,
    Ours,
    /// Another picture's.
    Other(Identity),
    /// It is no tile file.
    Unknown,
}

/// What a file holds.
pub(super) struct Scan {
    pub(super) owner: Owner,
    /// Whole tiles, by where their records begin.
    pub(super) tiles: Vec<(Tile, u64)>,
    /// Tiles that are there, but not as they were written.
    pub(super) damaged: usize,
    /// The end of the last record whose head is sound, and which is as long as that says.
    pub(super) end: u64,
}

impl Scan {
    pub(super) fn run(file: &File, identity: &Identity) -> io::Result<Scan> {
        let length = file.metadata()?.len();
        let mut reader = BufReader::with_capacity(1 << 20, file);
        reader.seek(SeekFrom::Start(0))?;
        let mut scan = Scan {
            owner: Owner::Nobody,
            tiles: Vec::new(),
            damaged: 0,
            end: 0,
        };
        let start = scan.head(&mut reader, length, identity)?;
        if matches!(scan.owner, Owner::Other(_)) || length == 0 {
            return Ok(scan);
        }
        scan.records(&mut reader, start, length, identity)?;
        if scan.tiles.is_empty() && scan.damaged == 0 && matches!(scan.owner, Owner::Unknown) {
            return Ok(scan);
        }
        scan.owner = Owner::Ours;
        Ok(scan)
    }

    /// Reads the beginning; where the records may begin.
    fn head(
        &mut self,
        reader: &mut BufReader<&File>,
        length: u64,
        identity: &Identity,
    ) -> io::Result<u64> {
        let mut before = [0; BEFORE];
        self.owner = Owner::Unknown;
        if length < BEFORE as u64 {
            // A file of which not even this was written; anything else of that size is somebody's.
            let mut all = Vec::new();
            reader.read_to_end(&mut all)?;
            if head(identity).starts_with(&all) {
                self.owner = Owner::Nobody;
            }
            return Ok(length);
        }
        reader.read_exact(&mut before)?;
        let [bytes, checksum] = [8, 12].map(|at: usize| {
            let four = before[at..at + 4].first_chunk();
            four.map_or(0, |four| u32::from_le_bytes(*four))
        });
        let end = BEFORE as u64 + u64::from(bytes);
        if before[..8] != MAGIC || end > length {
            if before[..8] == MAGIC && length < head(identity).len() as u64 {
                self.owner = Owner::Nobody;
            }
            return Ok(0);
        }
        let mut text = vec![0; bytes as usize];
        reader.read_exact(&mut text)?;
        if crc32fast::hash(&text) != checksum {
            return Ok(0);
        }
        if let Ok(theirs) = serde_json::from_slice::<Identity>(&text) {
            self.owner = match theirs == *identity {
                true => Owner::Ours,
                false => Owner::Other(theirs),
            };
            self.end = end;
            return Ok(end);
        }
        Ok(0)
    }

    /// Reads records from a place on; where there is none, looks for the next.
    fn records(
        &mut self,
        reader: &mut BufReader<&File>,
        mut at: u64,
        length: u64,
        identity: &Identity,
    ) -> io::Result<()> {
        let ours = identity.checksum();
        let mut bytes = Vec::new();
        while at + HEAD as u64 <= length {
            go_to(reader, at)?;
            bytes.resize(HEAD, 0);
            reader.read_exact(&mut bytes)?;
            let head = Head::read(&bytes);
            let Some(head) = head.filter(|head| head.identity == ours) else {
                at = next_magic(reader, at + 1)?.unwrap_or(length);
                continue;
            };
            let end = at + (HEAD + head.content_bytes()) as u64;
            if end > length {
                // Cut off; or its content was, and other records came after it.
                at += 1;
                continue;
            }
            bytes.resize(head.content_bytes(), 0);
            reader.read_exact(&mut bytes)?;
            let whole = crc32fast::hash(&bytes) == head.content;
            if whole {
                self.tiles.push((head.tile, at));
                (at, self.end) = (end, end);
            } else {
                // Its content may have been cut off, with another record where it went on: only as much as is known is skipped.
                self.damaged += 1;
                at = next_magic(reader, at + HEAD as u64)?.unwrap_or(length);
            }
        }
        Ok(())
    }
}

/// Moves without throwing away what has been read ahead.
fn go_to(reader: &mut BufReader<&File>, at: u64) -> io::Result<()> {
    let from = reader.stream_position()?;
    reader.seek_relative(at as i64 - from as i64)
}

/// The first place from `from` on where a record may begin.
fn next_magic(reader: &mut BufReader<&File>, from: u64) -> io::Result<Option<u64>> {
    let finder = memchr::memmem::Finder::new(&record::MAGIC);
    go_to(reader, from)?;
    let (mut at, mut bytes) = (from, Vec::new());
    loop {
        let kept = bytes.len();
        let got = reader.by_ref().take(1 << 20).read_to_end(&mut bytes)?;
        if let Some(found) = finder.find(&bytes) {
            return Ok(Some(at + found as u64));
        }
        if got == 0 {
            return Ok(None);
        }
        // The last bytes may be the first ones of a magic.
        let keep = (record::MAGIC.len() - 1).min(kept + got);
        let gone = bytes.len() - keep;
        bytes.drain(..gone);
        at += gone as u64;
    }
}
