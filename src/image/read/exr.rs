//! OpenEXR files, by bands: for each band only the blocks that touch it are read. The picture is
//! the content of the display window; outside the data window of a part, its samples are 0
//! ("Technical Introduction to OpenEXR", overscan and cropping).

use super::super::format::ImageFormat;
use super::bytes::PictureBytes;
use super::layout::{
    OpenedPicture, PictureChannel, PictureLayout, RowReader, SampleKind, SamplePlanes, check_sides,
};
use crate::decoders::{TOO_SHORT, io_reason};
use exr::block::UncompressedBlock;
use exr::block::chunk::Chunk;
use exr::error::Error;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::{Compression, f16};
use phalanx_scene::film::current_channel_name;
use phalanx_scene::map_on_pool;
use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

/// Maximum number of channels of a file.
const MAX_CHANNELS: usize = 1024;
/// Maximum number of bytes of a block, which is decompressed as a whole.
const MAX_BLOCK_BYTES: u64 = 256 << 20;
/// Number of bytes of the blocks that are decompressed at once, by all threads.
const BATCH_BYTES: u64 = 64 << 20;

/// Reads the rows of an OpenEXR file.
pub(super) struct ExrRows {
    bytes: PictureBytes,
    width: usize,
    /// Number of blocks that are decompressed at once.
    batch: usize,
}

/// Reads the header of an OpenEXR file. All parts are one picture.
pub(super) fn open_exr(bytes: PictureBytes) -> OpenedPicture {
    let reader = exr::block::read(bytes.reader()?, false).map_err(plain)?;
    let headers = reader.headers();
    let first = headers.first().ok_or("it has no parts")?;
    let window = first.shared_attributes.display_window;
    let Vec2(width, height) = window.size;
    let (width, height) = check_sides(width as u64, height as u64)?;
    let mut channels = Vec::new();
    let mut largest_block = 1;
    for header in headers {
        check_sides(header.layer_size.0 as u64, header.layer_size.1 as u64)?;
        largest_block = check_blocks(header, bytes.len()?)?.max(largest_block);
        push_channels(header, &mut channels)?;
    }
    name_colors(&mut channels);
    let names: HashSet<&str> = channels.iter().map(|c| c.name.as_str()).collect();
    if names.len() != channels.len() {
        return Err("two of its channels have the same name".into());
    }
    let layout = PictureLayout {
        format: ImageFormat::Exr,
        width,
        height,
        corner: (window.position.0, window.position.1),
        channels,
    };
    let rows = ExrRows {
        bytes,
        width: width as usize,
        batch: (BATCH_BYTES / largest_block).clamp(1, 256) as usize,
    };
    Ok((layout, Box::new(rows)))
}

/// Checks the blocks of a part before anything is allocated by size, and returns their size. Each
/// has an entry in a table.
fn check_blocks(header: &Header, file: u64) -> Result<u64, String> {
    if header.deep {
        return Err("it holds deep data, which are not read: flatten it first".into());
    }
    // Decoders of the lossy kinds allocate by counts in the file, and rely on wrapping sums.
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
    if (header.chunk_count as u64).saturating_mul(8) > file {
        Err(TOO_SHORT.into())
    } else {
        Ok(bytes.max(1))
    }
}

/// A name as other programs write it.
fn utf8(name: &Text) -> String {
    String::from_utf8_lossy(name.bytes()).into_owned()
}

/// Adds the channels of a part, whose name is prepended unless they already begin with it.
fn push_channels(header: &Header, channels: &mut Vec<PictureChannel>) -> Result<(), String> {
    let part = header.own_attributes.layer_name.as_ref();
    let part = part.map(|name| format!("{}.", utf8(name)));
    for channel in &header.channels.list {
        if channel.sampling != Vec2(1, 1) {
            return Err(format!(
                "its channel `{}` has not a sample for each pixel, which is not read",
                channel.name
            ));
        }
        // Files of earlier versions have other names for the same layers.
        let own = current_channel_name(&utf8(&channel.name)).to_owned();
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
    if channels.len() > MAX_CHANNELS {
        Err(format!("it has more than {MAX_CHANNELS} channels"))
    } else {
        Ok(())
    }
}

/// Column and row of the picture in which a part begins, which may lie outside of it.
fn place(header: &Header) -> (i64, i64) {
    let picture = header.shared_attributes.display_window.position;
    let part = header.own_attributes.layer_position;
    let off = |part: i32, picture: i32| i64::from(part) - i64::from(picture);
    (off(part.0, picture.0), off(part.1, picture.1))
}

/// Number of samples in the rows of a part that are rows of the picture, including samples beyond
/// its sides.
fn samples(header: &Header, rows: &Range<usize>) -> usize {
    let top = place(header).1;
    let bottom = top + header.layer_size.1 as i64;
    let rows = bottom.min(rows.end as i64) - top.max(rows.start as i64);
    header.layer_size.0 * rows.max(0) as usize
}

/// Last part of the name of the layer with the picture's colours, in lower case, if several layers
/// have colours: empty, or a name used by renderers.
const COLOR_LAYERS: [&str; 6] = ["", "rgba", "rgb", "beauty", "combined", "color"];

/// Renames the colours to R, G, B and A if the file only has them under other names: `.R` (V-Ray),
/// `ViewLayer.Combined.R` (Blender), `beauty.red`, `r`. They are those of the only layer with red,
/// green and blue, or of the only one with a common name for colours.
fn name_colors(channels: &mut [PictureChannel]) {
    let split = |name: &str| {
        let (layer, channel) = name.rsplit_once('.').unwrap_or(("", name));
        let color = match &channel.to_ascii_lowercase()[..] {
            "r" | "red" => Some("R"),
            "g" | "green" => Some("G"),
            "b" | "blue" => Some("B"),
            "a" | "alpha" => Some("A"),
            _ => None,
        };
        (layer.to_owned(), color)
    };
    let mut names = channels.iter().map(|channel| &*channel.name);
    if names.any(|name| ["R", "G", "B"].contains(&name)) {
        return;
    }
    let mut colors: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for channel in channels.iter() {
        if let (layer, Some(color)) = split(&channel.name) {
            colors.entry(layer).or_default().push(color);
        }
    }
    colors.retain(|_, layers| ["R", "G", "B"].iter().all(|color| layers.contains(color)));
    let usual = |layer: &&String| {
        let last = layer.rsplit('.').next().unwrap_or_default();
        colors.len() == 1 || COLOR_LAYERS.contains(&&*last.to_ascii_lowercase())
    };
    let layers: Vec<&String> = colors.keys().filter(usual).collect();
    if let [layer] = layers[..] {
        for channel in channels {
            if let (layer_name, Some(color)) = split(&channel.name)
                && layer_name == *layer
            {
                channel.name = color.to_owned();
            }
        }
    }
}

/// Rows of a picture, filled with blocks.
struct BandTarget<'a> {
    width: usize,
    rows: Range<usize>,
    planes: &'a mut SamplePlanes,
    /// Blocks that have been copied: part and position.
    put: HashSet<(usize, usize, usize)>,
    /// Number of copied pixels of all parts.
    pixels: usize,
}

impl RowReader for ExrRows {
    fn read(&mut self, rows: Range<u32>, planes: &mut SamplePlanes) -> Result<(), String> {
        let rows = rows.start as usize..rows.end as usize;
        let reader = exr::block::read(self.bytes.reader()?, false).map_err(plain)?;
        let mut chunks = reader
            .filter_chunks(false, |meta, tile, block| {
                let top = place(&meta.headers[block.layer]).1 + block.pixel_position.1 as i64;
                let touches =
                    top < rows.end as i64 && top + block.pixel_size.1 as i64 > rows.start as i64;
                tile.level_index == Vec2(0, 0) && touches
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
            let block = |chunk| UncompressedBlock::decompress_chunk(chunk, &meta, false);
            for block in map_on_pool(batch, block) {
                target.put(&meta.headers, &block.map_err(plain)?)?;
            }
        }
        let expected: usize = meta.headers.iter().map(|part| samples(part, &rows)).sum();
        if target.pixels == expected {
            Ok(())
        } else {
            Err("it is broken: some of its pixels are missing".into())
        }
    }
}

impl BandTarget<'_> {
    /// Copies the rows of a block that are in the band. Blocks contain their own position.
    fn put(&mut self, headers: &[Header], block: &UncompressedBlock) -> Result<(), String> {
        const MISPLACED: &str = "it is broken: a block is not where its table says";
        let index = block.index;
        let (Vec2(left, top), Vec2(width, height)) = (index.pixel_position, index.pixel_size);
        let header = headers.get(index.layer).ok_or(MISPLACED)?;
        let first = headers[..index.layer]
            .iter()
            .map(|header| header.channels.list.len())
            .sum::<usize>();
        let fits = left + width <= header.layer_size.0 && index.level == Vec2(0, 0);
        let size = width * height * header.channels.bytes_per_pixel;
        if !fits || block.data.len() != size || !self.put.insert((index.layer, left, top)) {
            return Err(MISPLACED.into());
        }
        let (x, y) = place(header);
        let (x, y) = (x + left as i64, y + top as i64);
        // The columns of the block within the picture.
        let begin = (-x).clamp(0, width as i64) as usize;
        let end = (self.width as i64 - x).clamp(begin as i64, width as i64) as usize;
        let mut offset = 0;
        for y in y..y + height as i64 {
            let row = usize::try_from(y).ok().filter(|y| self.rows.contains(y));
            for (c, channel) in header.channels.list.iter().enumerate() {
                let sample = channel.sample_type.bytes_per_sample();
                if let (Some(row), true) = (row, begin < end) {
                    let start = (row - self.rows.start) * self.width + (x + begin as i64) as usize;
                    let target = &mut self.planes[first + c][start..start + end - begin];
                    let data = &block.data[offset + begin * sample..offset + end * sample];
                    copy_samples(target, data, channel.sample_type);
                }
                offset += width * sample;
            }
            self.pixels += row.map_or(0, |_| width);
        }
        Ok(())
    }
}

/// Copies samples in this machine's byte order, as 32 bits each.
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
        Error::Io(e) => io_reason(&e),
        Error::NotSupported(what) => format!("it is of a kind that is not read: {what}"),
        Error::Invalid(what) => format!("it is broken: {what}"),
        Error::Aborted => "its decoder stopped".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colours_are_found_by_the_names_of_other_programs() {
        let named = |names: &[&str]| {
            let channel = |name: &&str| PictureChannel {
                name: (*name).to_owned(),
                kind: SampleKind::Float,
            };
            let mut channels: Vec<_> = names.iter().map(channel).collect();
            name_colors(&mut channels);
            channels
                .into_iter()
                .map(|channel| channel.name)
                .collect::<Vec<_>>()
        };
        assert_eq!(named(&[".B", ".G", ".R"]), ["B", "G", "R"]);
        assert_eq!(named(&["b", "g", "r", "a"]), ["B", "G", "R", "A"]);
        let blender = [
            "V.Combined.A",
            "V.Combined.B",
            "V.Combined.G",
            "V.Combined.R",
            "V.Depth.Z",
        ];
        assert_eq!(named(&blender), ["A", "B", "G", "R", "V.Depth.Z"]);
        let several = [
            "beauty.blue",
            "beauty.green",
            "beauty.red",
            "albedo.R",
            "albedo.G",
            "albedo.B",
        ];
        assert_eq!(named(&several)[..3], ["B", "G", "R"]);
        assert_eq!(named(&several)[3..], several[3..]);
        // Ambiguous.
        let unknown = ["x.R", "x.G", "x.B", "y.R", "y.G", "y.B"];
        assert_eq!(named(&unknown), unknown);
        let plain = ["R", "G", "B", "beauty.R", "beauty.G", "beauty.B"];
        assert_eq!(named(&plain), plain);
    }
}
