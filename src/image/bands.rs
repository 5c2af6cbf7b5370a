//! Writes a picture file of any format from films that are bands of the picture. Only one of them,
//! and its part of the file, must be in memory at a time.

use super::description::{BAND_ROWS, Films, PictureFile};
use super::encoder::Encoder;
use super::error::PictureError;
use super::exr::write_exr;
use super::format::ImageFormat;
use super::hdr_pfm::{write_hdr, write_pfm};
use super::jpeg::write_jpeg;
use super::png::write_png;
use phalanx_files::{WriteSeek, in_memory, replace_file, replace_file_seeking};
use phalanx_scene::film::Film;
use std::io::{self, Write};
use std::path::Path;

/// Saves a picture from its bands, top to bottom: whole, or not at all (see [`replace_file`]). The
/// bytes depend only on the description and the radiance, not on the heights of the bands. PNG and
/// OpenEXR are encoded on the threads of a pool.
///
/// # Errors
/// [`PictureError::Write`]: the error of a band in place of the band, bands that make no picture of
/// this size, or the system's reason.
pub fn save_bands(
    path: &Path,
    file: &PictureFile,
    bands: impl IntoIterator<Item = io::Result<Film>>,
) -> Result<(), PictureError> {
    let mut bands = bands.into_iter();
    save(path, CheckedBands::new(file, &mut bands))
}

fn save(path: &Path, mut bands: CheckedBands) -> Result<(), PictureError> {
    let written = if bands.file.format.seeks() {
        replace_file_seeking(path, |out| bands.write_seeking(out))
    } else {
        replace_file(path, |out| bands.write(out))
    };
    written.map_err(PictureError::write(path))
}

/// Writes a picture to any writer, as [`save_bands`] does to a file. A format that requires seeking
/// is written once its bytes are complete.
///
/// # Errors
/// The errors of [`save_bands`].
pub fn write_bands(
    out: &mut dyn Write,
    file: &PictureFile,
    bands: impl IntoIterator<Item = io::Result<Film>>,
) -> io::Result<()> {
    let mut bands = bands.into_iter();
    CheckedBands::new(file, &mut bands).write_to(out)
}

/// Bands that have been checked: each is as wide as the picture, and none reaches below it. If they
/// end before the picture does, the last item is an error.
struct CheckedBands<'a> {
    bands: Films<'a>,
    file: &'a PictureFile,
    /// Rows that are still to come.
    rows: u32,
}

impl<'a> CheckedBands<'a> {
    fn new(file: &'a PictureFile, bands: Films<'a>) -> CheckedBands<'a> {
        CheckedBands {
            bands,
            file,
            rows: file.height,
        }
    }

    fn write_to(&mut self, out: &mut dyn Write) -> io::Result<()> {
        if self.file.format.seeks() {
            out.write_all(&in_memory(|out| self.write_seeking(out))?)?
        } else {
            self.write(out)?
        }
        out.flush()
    }

    /// Writes a format that needs no seeking.
    fn write(&mut self, out: &mut dyn Write) -> io::Result<()> {
        let file = self.file;
        let encoder = Encoder::new(file.exposure);
        let size = (file.width, file.height);
        let bands = self.by_ref();
        match file.format {
            ImageFormat::Jpeg => {
                let rows = bands.map(|film| Ok(encoder.encode(&film?)));
                write_jpeg(out, size, &file.header, rows)?;
            }
            ImageFormat::Hdr => write_hdr(out, size, &file.header, bands)?,
            _ => {
                let encoder = &encoder;
                let mut bands = bands.map(|film| {
                    let film = film?;
                    let height = film.height as usize;
                    let samples = move |rows| encoder.png_samples(&film, rows, file.depth);
                    Ok((height, Box::new(samples) as Box<_>))
                });
                write_png(out, size, Some(file), &mut bands)?;
            }
        }
        self.end()
    }

    /// Writes a format that needs seeking.
    fn write_seeking(&mut self, out: &mut dyn WriteSeek) -> io::Result<()> {
        let file = self.file;
        match file.format {
            ImageFormat::Exr => write_exr(out, file, self)?,
            _ => write_pfm(out, file.width, file.height, self)?,
        }
        self.end()
    }

    fn check(&mut self, film: Film) -> io::Result<Film> {
        let last = film.height == self.rows;
        if film.width != self.file.width || film.height > self.rows {
            return Err(io::Error::other("a band is not of the picture's size"));
        }
        if film.aovs != self.file.aovs {
            return Err(io::Error::other("a band has other layers than the picture"));
        }
        if film.height == 0 || !last && !film.height.is_multiple_of(BAND_ROWS) {
            return Err(io::Error::other("a band ends between two tiles"));
        }
        self.rows -= film.height;
        Ok(film)
    }

    /// Checks that nothing comes after the picture's last row.
    fn end(&mut self) -> io::Result<()> {
        match self.next() {
            None => Ok(()),
            Some(Err(error)) => Err(error),
            Some(Ok(_)) => Err(io::Error::other("there are more bands than rows")),
        }
    }
}

impl Iterator for CheckedBands<'_> {
    type Item = io::Result<Film>;

    fn next(&mut self) -> Option<io::Result<Film>> {
        match self.bands.next() {
            Some(film) => Some(film.and_then(|film| self.check(film))),
            None if self.rows > 0 => Some(Err(io::Error::other("the picture has no more bands"))),
            None => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::Depth;
    use crate::encoder::{Exposure, ToneCurve};
    use crate::header::PictureHeader;
    use phalanx_scene::film::{Aov, Aovs};
    use phalanx_scene::{OutputEncoding, Quantize, Transfer};
    use std::fs;

    const WIDTH: u32 = 70;
    const HEIGHT: u32 = 200;

    fn alpha() -> Aovs {
        Aovs::NONE.with(Aov::Alpha)
    }

    /// Rows of the picture, as a film with alpha.
    fn rows(from: u32, to: u32) -> Film {
        let mut film = Film::new(WIDTH, to - from, false).with_aovs(alpha());
        for y in from..to {
            for x in 0..WIDTH {
                let index = ((y - from) * WIDTH + x) as usize;
                let value = (x * 7 + y * 3) as f32 / 700.0;
                for (k, plane) in film.planes.iter_mut().enumerate() {
                    plane[index] = value * (k + 1) as f32;
                }
                film.aov_planes[0][index] = x as f32 / WIDTH as f32;
            }
        }
        film
    }

    fn cut(ends: &[u32]) -> Vec<io::Result<Film>> {
        let starts = [0].into_iter().chain(ends.iter().copied());
        starts.zip(ends).map(|(a, &b)| Ok(rows(a, b))).collect()
    }

    fn file(format: ImageFormat, depth: Depth) -> PictureFile {
        PictureFile {
            width: WIDTH,
            height: HEIGHT,
            crop: None,
            format,
            aovs: alpha(),
            origin: [0.0; 3],
            exposure: Exposure {
                stops: 0.5,
                curve: ToneCurve::Linear,
                encoding: OutputEncoding {
                    transfer: Transfer::Srgb,
                    quantize: Quantize::Round,
                },
            },
            depth,
            header: PictureHeader {
                scene: "a.test".to_owned(),
                command: "phalanx render a.test".to_owned(),
                ..PictureHeader::NONE
            },
        }
    }

    #[test]
    fn the_bytes_depend_on_neither_bands_nor_threads() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        for (ending, format) in ImageFormat::ENDINGS {
            for depth in [Depth::Standard, Depth::Sixteen] {
                let encode = |ends: &[u32]| {
                    save_bands(&path, &file(format, depth), cut(ends)).unwrap();
                    fs::read(&path).unwrap()
                };
                let at_once = encode(&[HEIGHT]);
                assert!(at_once == encode(&[64, 128, 192, 200]), "{ending}");
                assert!(at_once == encode(&[128, 200]), "{ending}");
                for threads in [1, 2, 3, 7, 16] {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                    let on_pool = pool.build().unwrap().install(|| encode(&[HEIGHT]));
                    assert!(at_once == on_pool, "{ending} on {threads} threads");
                }
            }
        }
    }

    #[test]
    fn bands_that_make_no_picture_make_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let failed = |bands: Vec<io::Result<Film>>| {
            let mut message = String::new();
            for (_, format) in ImageFormat::ENDINGS {
                let again = bands.iter().map(|band| match band {
                    Ok(film) => Ok(film.clone()),
                    Err(error) => Err(io::Error::other(error.to_string())),
                });
                let saved = save_bands(&path, &file(format, Depth::Standard), again);
                let error = saved.unwrap_err().to_string();
                assert!(message.is_empty() || message == error, "{message} {error}");
                message = error;
            }
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
            message
        };
        assert!(failed(cut(&[64, 128])).contains("no more bands"));
        assert!(failed(cut(&[64, 100, 200])).contains("between two tiles"));
        assert!(failed(cut(&[64, 264])).contains("picture's size"));
        assert!(failed(cut(&[128, 200, 201])).contains("picture's size"));
        assert!(failed(vec![Ok(rows(0, 64)), Err(io::Error::other("hit"))]).contains("hit"));
        let narrow = Film::new(WIDTH - 1, HEIGHT, false);
        assert!(failed(vec![Ok(narrow)]).contains("picture's size"));
        let opaque = Film::new(WIDTH, HEIGHT, false);
        assert!(failed(vec![Ok(opaque)]).contains("other layers"));
    }

    #[test]
    fn what_goes_to_any_writer_is_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        for (_, format) in ImageFormat::ENDINGS {
            let file = file(format, Depth::Sixteen);
            save_bands(&path, &file, cut(&[64, HEIGHT])).unwrap();
            let mut bytes = Vec::new();
            write_bands(&mut bytes, &file, cut(&[128, HEIGHT])).unwrap();
            assert!(bytes == fs::read(&path).unwrap(), "{format:?}");
            let short = write_bands(&mut bytes, &file, cut(&[64]));
            assert!(short.is_err(), "{format:?}: a part of the picture");
        }
    }
}
