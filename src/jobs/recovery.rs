//! Reads a tile file from beginning to end, regardless of its state and origin.
//!
//! The time is proportional to the file's length, and memory is allocated only for data in the
//! file. The numbers of a header are checked against the picture and the file before they are used.
//! Bytes that damaged tiles claim are read again a bounded number of times.

use super::file_header::{self, FileHeader, TILES};
use super::kept_file::KeptFileError;
use super::render_key::RenderKey;
use super::tile_record::{self, HEADER_BYTES, RecordHeader};
use memchr::memmem::Finder;
use phalanx_render::frame::Tile;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// Number of bytes of damaged tiles that are searched for other records, as a multiple of the
/// file's length. Overlapping headers could claim the same bytes again and again. Beyond this, a
/// damaged tile is skipped as a whole.
const MAX_SEARCHED_PER_BYTE: u64 = 4;

/// The content of a file.
pub(super) struct Recovery {
    /// Whole tiles, each with the offset where its record begins.
    pub(super) tiles: Vec<(Tile, u64)>,
    /// Tiles that are present, but damaged.
    pub(super) damaged: usize,
    /// The end of the last whole record; 0 if there is none, nor a header.
    pub(super) end: u64,
}

impl Recovery {
    /// Reads the file at `path`, which must be of this picture's tiles, or empty.
    pub(super) fn run(
        path: &Path,
        file: &File,
        key: &RenderKey,
    ) -> Result<Recovery, KeptFileError> {
        let io = |source| KeptFileError::io(path, source);
        let length = file.metadata().map_err(io)?.len();
        let mut places = ForwardReader::new(file).map_err(io)?;
        let header = file_header::read(&mut places, length, key, path)?;
        let start = match header {
            FileHeader::Ours(start) => start,
            FileHeader::Empty | FileHeader::Unknown => 0,
        };
        let mut recovery = Recovery {
            tiles: Vec::new(),
            damaged: 0,
            end: start,
        };
        let read = recovery.records(&mut places, start, length, key);
        read.map_err(io)?;
        let nothing = recovery.tiles.is_empty() && recovery.damaged == 0;
        match header {
            FileHeader::Unknown if nothing => Err(KeptFileError::other(path, TILES.name)),
            _ => Ok(recovery),
        }
    }

    /// Reads records from an offset on; where there is none, searches for the next.
    fn records(
        &mut self,
        places: &mut ForwardReader,
        mut offset: u64,
        length: u64,
        key: &RenderKey,
    ) -> io::Result<()> {
        let (identity, planes) = (key.checksum(), tile_record::planes(key));
        let window = key.pixels.window();
        let is_ours = |head: &RecordHeader| {
            let is_inside = head.tile.within(window) == head.tile;
            head.identity == identity && head.planes == planes && is_inside
        };
        let mut left = length.saturating_mul(MAX_SEARCHED_PER_BYTE);
        let mut bytes = [0; HEADER_BYTES];
        while offset + HEADER_BYTES as u64 <= length {
            places.seek_forward(offset)?;
            places.read_exact(&mut bytes)?;
            let head = RecordHeader::read(&bytes).filter(is_ours);
            // A tile that was cut off may have other records after it.
            let record =
                head.map(|head| (head, offset + (HEADER_BYTES + head.content_bytes()) as u64));
            let Some((head, end)) = record.filter(|(_, end)| *end <= length) else {
                offset = places.next_magic(offset + 1)?.unwrap_or(length);
                continue;
            };
            // The content is no longer than the file.
            let mut content = vec![0; head.content_bytes()];
            places.read_exact(&mut content)?;
            if crc32fast::hash(&content) == head.content {
                self.tiles.push((head.tile, offset));
                (offset, self.end) = (end, end);
                continue;
            }
            // The content may have been cut off, with another record where it would have continued:
            // only the part that certainly belongs to it is skipped.
            self.damaged += 1;
            offset = match left.checked_sub(content.len() as u64) {
                Some(rest) => {
                    left = rest;
                    places
                        .next_magic(offset + HEADER_BYTES as u64)?
                        .unwrap_or(length)
                }
                None => end,
            };
        }
        Ok(())
    }
}

/// A file that is read at various positions, mostly forward.
struct ForwardReader<'a> {
    reader: BufReader<&'a File>,
    offset: u64,
    magic: Finder<'static>,
}

impl ForwardReader<'_> {
    fn new(file: &File) -> io::Result<ForwardReader<'_>> {
        let mut reader = BufReader::with_capacity(1 << 20, file);
        io::Seek::rewind(&mut reader)?;
        Ok(ForwardReader {
            reader,
            offset: 0,
            magic: Finder::new(&tile_record::MAGIC),
        })
    }

    /// Seeks without discarding data that has been read ahead.
    fn seek_forward(&mut self, offset: u64) -> io::Result<()> {
        self.reader
            .seek_relative(offset as i64 - self.offset as i64)?;
        self.offset = offset;
        Ok(())
    }

    /// The first offset from `from` on where a record may begin.
    fn next_magic(&mut self, from: u64) -> io::Result<Option<u64>> {
        self.seek_forward(from)?;
        loop {
            let bytes = self.reader.fill_buf()?;
            if bytes.is_empty() {
                return Ok(None);
            }
            // The last bytes of the data may be the first of a magic number.
            let cut_off = || {
                let lengths = (1..tile_record::MAGIC.len()).rev();
                let mut cut = lengths.filter(|&n| bytes.ends_with(&tile_record::MAGIC[..n]));
                Some(bytes.len() - cut.next()?)
            };
            if let Some(position) = self.magic.find(bytes).or_else(cut_off) {
                return Ok(Some(self.offset + position as u64));
            }
            let all = bytes.len();
            self.reader.consume(all);
            self.offset += all as u64;
        }
    }
}

impl Read for ForwardReader<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let got = self.reader.read(bytes)?;
        self.offset += got as u64;
        Ok(got)
    }
}
