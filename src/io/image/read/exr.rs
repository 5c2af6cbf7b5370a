//! OpenEXR files, by bands: of each band only the blocks that touch it are read.

use super::super::format::ImageFormat;
use super::bytes::PictureBytes;
use super::layout::{
    PictureChannel, PictureLayout, RowReader, SampleKind, SamplePlanes, TOO_SHORT, check_sides,
};
use exr::block::UncompressedBlock;
use exr::block::chunk::Chunk;
use exr::error::Error;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::{Compression, f16};
use phalanx_scene::film::current_channel_name;
use rayon::prelude::*;
use std::collections::HashSet;
use std::io::ErrorKind;
use std::ops::Range;

/// Most channels of a file.
const MAX_CHANNELS: usize = 1024;
/// Most bytes of a block, which is decompressed as a whole.
const MAX_BLOCK_BYTES: u64 = 256 << 20;
/// Bytes of the blocks that are decompressed at once, by all threads.
const BATCH_BYTES: u64 = 64 << 20;

/// Reads the rows of an OpenEXR file.
pub(super) struct ExrRows {
    bytes: PictureBytes,
    width: usize,
    /// Number of blocks that are decompressed at once.
    batch: usize,
}

/// Reads the header of an OpenEXR file. Parts of the same size are one picture.
pub(super) fn open_exr(bytes: PictureBytes) -> Result<(PictureLayout, ExrRows), String> {
    let reader = exr::block::read(bytes.reader()?, false).map_err(plain)?;
    let headers = reader.headers();
    let first = headers.first().ok_or("it has no parts")?;
    let Vec2(width, height) = first.layer_size;
    let (width, height) = check_sides(width as u64, height as u64)?;
    let mut channels = Vec::new();
    let mut largest_block = 1;
    for header in headers {
        if header.layer_size != first.layer_size {
            return Err("its parts differ in size, which is not read: save one of them".into());
        }
        largest_block = check_blocks(header, bytes.len()?)?.max(largest_block);
        push_channels(header, &mut channels)?;
    }
    let names: HashSet<&str> = channels.iter().map(|c| c.name.as_str()).collect();
    if names.len() != channels.len() {
        return Err("two of its channels have the same name".into());
    }
    let layout = PictureLayout {
        format: ImageFormat::Exr,
        width,
        height,
        channels,
    };
    let rows = ExrRows {
        bytes,
        width: width as usize,
        batch: (BATCH_BYTES / largest_block).clamp(1, 256) as usize,
    };
    Ok((layout, rows))
}

/// Checks the blocks of a part before anything is allocated by their size, which is returned. Each
/// has an entry in a table.
fn check_blocks(header: &Header, file: u64) -> Result<u64, String> {
    if header.deep {
        return Err("it holds deep data, which are not read: flatten it first".into());
    }
    // Decoders of the lossy kinds allocate by counts of the file, and rely on sums that wrap.
    const READ: [Compression; 6] = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
    ];
    if !READ.contains(&header.compression) {
        return Err("it is compressed by a kind that is not read: save it with ZIP".into());
    }
    let area = match header.blocks {
        BlockDescription::Tiles(tiles) => {
            (tiles.tile_size.0 as u64).checked_mul(tiles.tile_size.1 as u64)
        }
        BlockDescription::ScanLines => {
            let rows = header.compression.scan_lines_per_block();
            (header.layer_size.0 as u64).checked_mul(rows as u64)
        }
    };
    let pixel = header.channels.bytes_per_pixel as u64;
    let bytes = area.and_then(|area| area.checked_mul(pixel));
    let bytes = bytes.filter(|bytes| *bytes <= MAX_BLOCK_BYTES);
    let bytes = bytes.ok_or("its tiles or rows are larger than 256 MiB")?;
    match (header.chunk_count as u64).saturating_mul(8) > file {
        true => Err(TOO_SHORT.into()),
        false => Ok(bytes.max(1)),
    }
}

/// Adds the channels of a part, whose name is part of theirs unless they begin with it already.
fn push_channels(header: &Header, channels: &mut Vec<PictureChannel>) -> Result<(), String> {
    let part = header.own_attributes.layer_name.as_ref();
    let part = part.map(|name| format!("{name}."));
    for channel in &header.channels.list {
        if channel.sampling != Vec2(1, 1) {
            return Err(format!(
                "its channel `{}` has not a sample for each pixel, which is not read",
                channel.name
            ));
        }
        // Files of earlier versions have other names for the same layers.
        let own = current_channel_name(&channel.name.to_string()).to_owned();
        let name = match &part {
            Some(part) if !own.starts_with(&part[..]) => format!("{part}{own}"),
            _ => own,
        };
        let kind = match channel.sample_type {
            SampleType::U32 => SampleKind::Integer,
            SampleType::F16 | SampleType::F32 => SampleKind::Float,
        };
        channels.push(PictureChannel { name, kind });
    }
    match channels.len() > MAX_CHANNELS {
        true => Err(format!("it has more than {MAX_CHANNELS} channels")),
        false => Ok(()),
    }
}

/// Rows of a picture that blocks are put in.
struct BandTarget<'a> {
    width: usize,
    rows: Range<usize>,
    planes: &'a mut SamplePlanes,
    /// Blocks that have been put: part and position.
    put: HashSet<(usize, usize, usize)>,
    /// Pixels of all parts that have been put.
    pixels: usize,
}

impl RowReader for ExrRows {
    fn read(&mut self, rows: Range<u32>, planes: &mut SamplePlanes) -> Result<(), String> {
        let rows = rows.start as usize..rows.end as usize;
        let reader = exr::block::read(self.bytes.reader()?, false).map_err(plain)?;
        let touches = |top: usize, height: usize| top < rows.end && top + height > rows.start;
        let mut chunks = reader
            .filter_chunks(false, |_, tile, block| {
                let full = tile.level_index == Vec2(0, 0);
                full && touches(block.pixel_position.1, block.pixel_size.1)
            })
            .map_err(plain)?;
        let meta = exr::block::reader::ChunksReader::meta_data(&chunks).clone();
        for plane in planes.iter_mut() {
            plane.resize(self.width * rows.len(), 0);
        }
        let mut target = BandTarget {
            width: self.width,
            rows: rows.clone(),
            planes,
            put: HashSet::new(),
            pixels: 0,
        };
        loop {
            let batch: exr::error::Result<Vec<Chunk>> = chunks.by_ref().take(self.batch).collect();
            let batch = batch.map_err(plain)?;
            if batch.is_empty() {
                break;
            }
            let blocks: exr::error::Result<Vec<UncompressedBlock>> = batch
                .into_par_iter()
                .map(|chunk| UncompressedBlock::decompress_chunk(chunk, &meta, false))
                .collect();
            for block in blocks.map_err(plain)? {
                target.put(&meta.headers, &block)?;
            }
        }
        match target.pixels == self.width * rows.len() * meta.headers.len() {
            true => Ok(()),
            false => Err("it is broken: some of its pixels are missing".into()),
        }
    }
}

impl BandTarget<'_> {
    /// Copies those rows of a block that are in the band. A block says itself where it lies.
    fn put(&mut self, headers: &[Header], block: &UncompressedBlock) -> Result<(), String> {
        const MISPLACED: &str = "it is broken: a block is not where its table says";
        let index = block.index;
        let (Vec2(left, top), Vec2(width, height)) = (index.pixel_position, index.pixel_size);
        let header = headers.get(index.layer).ok_or(MISPLACED)?;
        let first = headers[..index.layer]
            .iter()
            .map(|header| header.channels.list.len())
            .sum::<usize>();
        let fits = left + width <= self.width && index.level == Vec2(0, 0);
        let size = width * height * header.channels.bytes_per_pixel;
        if !fits || block.data.len() != size || !self.put.insert((index.layer, left, top)) {
            return Err(MISPLACED.into());
        }
        let mut at = 0;
        for y in top..top + height {
            let inside = self.rows.contains(&y);
            for (c, channel) in header.channels.list.iter().enumerate() {
                let bytes = width * channel.sample_type.bytes_per_sample();
                if inside {
                    let start = (y - self.rows.start) * self.width + left;
                    let target = &mut self.planes[first + c][start..start + width];
                    copy_samples(target, &block.data[at..at + bytes], channel.sample_type);
                }
                at += bytes;
            }
            self.pixels += if inside { width } else { 0 };
        }
        Ok(())
    }
}

/// Copies samples in the order of bytes of this machine, as 32 bits each.
fn copy_samples(target: &mut [u32], data: &[u8], kind: SampleType) {
    match kind {
        SampleType::F16 => {
            let words = data.as_chunks::<2>().0.iter();
            for (target, word) in target.iter_mut().zip(words) {
                *target = f16::from_ne_bytes(*word).to_f32().to_bits();
            }
        }
        SampleType::F32 | SampleType::U32 => {
            let words = data.as_chunks::<4>().0.iter();
            for (target, word) in target.iter_mut().zip(words) {
                *target = u32::from_ne_bytes(*word);
            }
        }
    }
}

/// The crate's message in plain words.
fn plain(error: Error) -> String {
    match error {
        Error::Io(e) if e.kind() == ErrorKind::UnexpectedEof => TOO_SHORT.into(),
        Error::Io(e) => e.to_string(),
        Error::NotSupported(what) => format!("it is of a kind that is not read: {what}"),
        Error::Invalid(what) => format!("it is broken: {what}"),
        Error::Aborted => "its decoder stopped".into(),
    }
}
