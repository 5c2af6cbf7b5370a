//! PNG: the header, and plain messages for faults.

use super::{CheckSides, io_reason};
use ::png::{ColorType, Decoder, DecodingError, Reader, Transformations};
use std::io::{BufRead, Seek};

/// A decoder that has read all before the first row, which checks neither the text around the
/// picture nor its colour profile.
pub fn open<R: BufRead + Seek>(bytes: R, check: CheckSides) -> Result<Reader<R>, String> {
    let mut decoder = Decoder::new(bytes);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(plain)?;
    check(header.width.into(), header.height.into())?;
    let reader = decoder.read_info().map_err(plain)?;
    let info = reader.info();
    // Checked here, because the crate relies on a palette's length.
    let palette = info.palette.as_deref().unwrap_or_default();
    let is_palette = (3..=3 * 256).contains(&palette.len()) && palette.len().is_multiple_of(3);
    if info.color_type != ColorType::Indexed || is_palette {
        Ok(reader)
    } else {
        Err("its palette (PLTE) does not hold whole colours, 1 to 256".into())
    }
}

/// Checks the checksums of the data after the last row. A missing end is accepted.
pub fn finish<R: BufRead + Seek>(reader: &mut Reader<R>) -> Result<(), String> {
    match reader.next_interlaced_row() {
        Err(DecodingError::IoError(_)) | Ok(_) => Ok(()),
        Err(error) => Err(plain(error)),
    }
}

/// The crate's message in plain words: only the name remains of its debug text for a chunk.
pub fn plain(error: DecodingError) -> String {
    const DEFLATE: &str = "Corrupt deflate stream";
    let mut message = match error {
        DecodingError::IoError(e) => return io_reason(&e),
        other => other.to_string(),
    };
    if message.starts_with(DEFLATE) {
        return BROKEN_DATA.into();
    }
    const START: &str = "ChunkType { type: ";
    while let Some(start) = message.find(START) {
        let name = start + START.len();
        let end = message[name..]
            .find(" }")
            .map_or(message.len(), |end| name + end + 2);
        let chunk = message[name..end].split(',').next().unwrap_or_default();
        let chunk = chunk.to_owned();
        message.replace_range(start..end, &chunk);
    }
    format!("it is broken: {message}")
}

const BROKEN_DATA: &str = "it is broken: the compressed data are not a valid zlib stream";
