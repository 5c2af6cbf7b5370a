//! Readers for every kind of picture that can be written, by rows.

use super::super::error::PictureError;
use super::super::format::ImageFormat;
use super::bytes::open_bytes;
use super::exr::open_exr;
use super::hdr::open_hdr;
use super::jpeg::open_jpeg;
use super::layout::{PictureLayout, RowReader, SamplePlanes};
use super::pfm::open_pfm;
use super::png::open_png;
use crate::decoders::TOO_SHORT;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A picture file of which the header has been read.
pub struct PictureReader {
    path: PathBuf,
    layout: PictureLayout,
    rows: Box<dyn RowReader>,
}

/// The kind of a file, by its first bytes.
fn format_of_bytes(head: &[u8]) -> Option<ImageFormat> {
    match head {
        [b'P', b'F' | b'f', space, ..] if space.is_ascii_whitespace() => Some(ImageFormat::Pfm),
        _ if head.starts_with(b"\x89PNG\r\n\x1a\n") => Some(ImageFormat::Png),
        _ if head.starts_with(b"\xff\xd8\xff") => Some(ImageFormat::Jpeg),
        _ if head.starts_with(b"\x76\x2f\x31\x01") => Some(ImageFormat::Exr),
        _ if head.starts_with(b"#?RADIANCE") || head.starts_with(b"#?RGBE") => {
            Some(ImageFormat::Hdr)
        }
        _ => None,
    }
}

/// The kind of a file, for a message.
fn name_of(format: Option<ImageFormat>) -> &'static str {
    match format {
        Some(ImageFormat::Png) => "a PNG picture",
        Some(ImageFormat::Jpeg) => "a JPEG picture",
        Some(ImageFormat::Exr) => "an OpenEXR picture",
        Some(ImageFormat::Hdr) => "a Radiance HDR picture",
        Some(ImageFormat::Pfm) => "a portable float map",
        None => "a picture",
    }
}

impl PictureReader {
    /// Opens a PNG, JPEG, OpenEXR, Radiance HDR or PFM file; it is identified by its first bytes,
    /// not by its name. PNG, OpenEXR, HDR and PFM are read row by row, so that they may be larger
    /// than memory; JPEG and interlaced PNG are held as a whole, up to 2^28 pixels.
    ///
    /// # Errors
    /// [`PictureError::Read`] and [`PictureError::Decode`].
    pub fn open(path: &Path) -> Result<PictureReader, PictureError> {
        let known = |head: &[u8]| format_of_bytes(head).is_some();
        let (bytes, head) = open_bytes(path, known).map_err(|source| PictureError::Read {
            path: path.to_path_buf(),
            source,
        })?;
        let format = format_of_bytes(&head);
        let opened = match format {
            Some(ImageFormat::Png) => open_png(bytes),
            Some(ImageFormat::Jpeg) => open_jpeg(bytes),
            Some(ImageFormat::Exr) => open_exr(bytes),
            Some(ImageFormat::Hdr) => open_hdr(bytes),
            Some(ImageFormat::Pfm) => open_pfm(bytes),
            None if head.is_empty() => Err("it is empty".into()),
            None => Err("it is none of PNG, JPEG, OpenEXR, HDR and PFM by its first bytes".into()),
        };
        let path = path.to_path_buf();
        match opened {
            Ok((layout, rows)) => Ok(PictureReader { path, layout, rows }),
            Err(reason) => Err(PictureError::Decode {
                path,
                kind: name_of(format),
                reason,
            }),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Size and channels.
    pub fn layout(&self) -> &PictureLayout {
        &self.layout
    }

    /// Reads rows, which are within the picture. Continuing where the last call ended costs least;
    /// for earlier rows, decoding may restart at the first.
    ///
    /// # Errors
    /// [`PictureError::Decode`].
    pub fn read(&mut self, rows: Range<u32>) -> Result<SamplePlanes, PictureError> {
        let samples = rows.len() * self.layout.width as usize;
        let plane = || Vec::with_capacity(samples);
        let mut planes: SamplePlanes = self.layout.channels.iter().map(|_| plane()).collect();
        let read = if rows.end <= self.layout.height {
            self.rows.read(rows, &mut planes)
        } else {
            Err(TOO_SHORT.into())
        };
        let complete = planes.iter().all(|plane| plane.len() == samples);
        let read = read.and_then(|()| complete.then_some(()).ok_or(TOO_SHORT.into()));
        read.map_err(|reason| self.error(reason))?;
        Ok(planes)
    }

    /// The error of a file that does not match its header.
    pub(crate) fn error(&self, reason: String) -> PictureError {
        PictureError::Decode {
            path: self.path.clone(),
            kind: name_of(Some(self.layout.format)),
            reason,
        }
    }
}
