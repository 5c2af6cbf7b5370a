//! Reads a tile file from its beginning to its end, whatever has become of it, and whoever made it.
//!
//! The time is in proportion to the file's length, and no memory is asked for that the file does not fill: a head's numbers are
//! held against the picture and the file before they are used, and bytes that damaged tiles claim are read again a bounded number
//! of times.

use super::beginning::{self, Owner};
use super::identity::Identity;
use super::record::{self, HEAD, Head};
use crate::frame::Tile;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};

/// Bytes of damaged tiles that are searched for other records, in lengths of the file: heads that overlap could claim the same bytes
/// again and again. After that, a damaged tile is skipped whole.
const SEARCHED: u64 = 4;

/// What a file holds.
pub(super) struct Scan {
    pub(super) owner: Owner,
    /// Whole tiles, by where their records begin.
    pub(super) tiles: Vec<(Tile, u64)>,
    /// Tiles that are there, but not as they were written.
    pub(super) damaged: usize,
    /// The end of the last whole record.
    pub(super) end: u64,
}

impl Scan {
    pub(super) fn run(file: &File, identity: &Identity) -> io::Result<Scan> {
        let length = file.metadata()?.len();
        let mut places = Places::new(file)?;
        let (owner, start) = beginning::read(&mut places, length, identity)?;
        let mut scan = Scan {
            owner,
            tiles: Vec::new(),
            damaged: 0,
            end: start,
        };
        if matches!(scan.owner, Owner::Other(_) | Owner::Layout(_)) || length == 0 {
            return Ok(scan);
        }
        if !matches!(scan.owner, Owner::Ours) {
            scan.end = 0;
        }
        scan.records(&mut places, start, length, identity)?;
        if scan.tiles.is_empty() && scan.damaged == 0 && matches!(scan.owner, Owner::Unknown) {
            return Ok(scan);
        }
        scan.owner = Owner::Ours;
        Ok(scan)
    }

    /// Reads records from a place on; where there is none, looks for the next.
    fn records(
        &mut self,
        places: &mut Places,
        mut at: u64,
        length: u64,
        identity: &Identity,
    ) -> io::Result<()> {
        let ours = Ours::of(identity);
        let mut left = length.saturating_mul(SEARCHED);
        let mut bytes = Vec::new();
        while at + HEAD as u64 <= length {
            places.go_to(at)?;
            bytes.resize(HEAD, 0);
            places.read_exact(&mut bytes)?;
            let head = Head::read(&bytes).filter(|head| ours.holds(head));
            // A tile that was cut off may have other records after it.
            let record = head.map(|head| (head, at + (HEAD + head.content_bytes()) as u64));
            let Some((head, end)) = record.filter(|(_, end)| *end <= length) else {
                at = places.next_magic(at + 1)?.unwrap_or(length);
                continue;
            };
            // No more than the file has.
            bytes.resize(head.content_bytes(), 0);
            places.read_exact(&mut bytes)?;
            if crc32fast::hash(&bytes) == head.content {
                self.tiles.push((head.tile, at));
                (at, self.end) = (end, end);
                continue;
            }
            // Its content may have been cut off, with another record where it went on: only as much as is known is skipped.
            self.damaged += 1;
            at = match left.checked_sub(bytes.len() as u64) {
                Some(rest) => {
                    left = rest;
                    places.next_magic(at + HEAD as u64)?.unwrap_or(length)
                }
                None => end,
            };
        }
        Ok(())
    }
}

/// Properties of every record of a picture's file.
struct Ours {
    identity: u32,
    window: Tile,
    planes: u32,
}

impl Ours {
    fn of(identity: &Identity) -> Ours {
        Ours {
            identity: identity.checksum(),
            window: identity.window(),
            planes: record::planes(identity),
        }
    }

    fn holds(&self, head: &Head) -> bool {
        head.identity == self.identity
            && head.planes == self.planes
            && head.tile.within(self.window) == head.tile
    }
}

/// A file that is read here and there, mostly onward.
struct Places<'a> {
    reader: BufReader<&'a File>,
    at: u64,
}

impl Places<'_> {
    fn new(file: &File) -> io::Result<Places<'_>> {
        let mut reader = BufReader::with_capacity(1 << 20, file);
        io::Seek::rewind(&mut reader)?;
        Ok(Places { reader, at: 0 })
    }

    /// Moves without throwing away what has been read ahead.
    fn go_to(&mut self, at: u64) -> io::Result<()> {
        self.reader.seek_relative(at as i64 - self.at as i64)?;
        self.at = at;
        Ok(())
    }

    /// The first place from `from` on where a record may begin.
    fn next_magic(&mut self, from: u64) -> io::Result<Option<u64>> {
        let finder = memchr::memmem::Finder::new(&record::MAGIC);
        self.go_to(from)?;
        loop {
            let bytes = self.reader.fill_buf()?;
            if bytes.is_empty() {
                return Ok(None);
            }
            // The last bytes that are there may be the first of a magic.
            let cut_off = || {
                let lengths = (1..record::MAGIC.len()).rev();
                let mut cut = lengths.filter(|&n| bytes.ends_with(&record::MAGIC[..n]));
                Some(bytes.len() - cut.next()?)
            };
            if let Some(found) = finder.find(bytes).or_else(cut_off) {
                return Ok(Some(self.at + found as u64));
            }
            let all = bytes.len();
            self.reader.consume(all);
            self.at += all as u64;
        }
    }
}

impl Read for Places<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let got = self.reader.read(bytes)?;
        self.at += got as u64;
        Ok(got)
    }
}
