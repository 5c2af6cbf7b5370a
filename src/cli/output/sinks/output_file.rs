//! The file that a picture is written to, its format, and the options that the format allows.

use super::destination::is_replaced;
use super::stdout::is_dash;
use crate::cli::output::error::CliError;
use phalanx::files::shown_path;
use phalanx::frame::{Aov, Control};
use phalanx::image::{ImageFormat, PictureFile, PictureHeader, save_bands, write_bands};
use phalanx::jobs::{BandsError, PictureSpec, spec::set_header};
use phalanx::render::Film;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

/// Longest side of a JPEG.
const JPEG_SIDE: u32 = 65_535;

/// The requested format, or that of a picture's name. Refuses an unknown extension; `origin` names
/// the option in the message. The default is PNG for stdout, and for pipes and devices without an
/// extension.
pub fn format_of(
    path: &Path,
    requested: Option<ImageFormat>,
    origin: &str,
) -> Result<ImageFormat, CliError> {
    let plain = || path.extension().is_none() && !is_replaced(path);
    let format = requested.or_else(|| ImageFormat::of(path));
    format
        .or_else(|| plain().then_some(ImageFormat::Png))
        .ok_or_else(|| {
            let endings = ImageFormat::ENDINGS.map(|(ending, _)| format!(".{ending}"));
            CliError::Usage(format!(
                "{origin} {}: unknown picture format: use one of {} or --format",
                shown_path(path),
                endings.join(", ")
            ))
        })
}

/// A picture file to be written.
#[derive(Clone, Debug)]
pub struct OutputFile {
    pub path: PathBuf,
    pub file: PictureFile,
}

impl OutputFile {
    /// The file of a fully resolved picture, for a scene with this origin, with an empty header.
    /// The format must be able to store the AOVs.
    pub fn for_picture(
        path: PathBuf,
        format: ImageFormat,
        spec: &PictureSpec,
        origin: [f64; 3],
    ) -> Result<OutputFile, CliError> {
        let file = spec.file(format, origin);
        let aovs = file.aovs;
        let mut layers = Aov::ALL.iter();
        if let Some((name, aov)) = layers.find(|(_, aov)| aovs.has(*aov) && !format.holds(*aov)) {
            let needed = if ImageFormat::Png.holds(*aov) {
                "a PNG or OpenEXR file (.png, .exr)"
            } else {
                "an OpenEXR file (.exr)"
            };
            return Err(CliError::Usage(format!(
                "--aov {name} needs {needed}, not {}",
                shown_path(path)
            )));
        }
        let longest = file.width.max(file.height);
        if format == ImageFormat::Jpeg && longest > JPEG_SIDE {
            return Err(CliError::Usage(format!(
                "{}: a JPEG has at most {JPEG_SIDE} pixels per side, not {longest}: write a PNG",
                shown_path(path)
            )));
        }
        Ok(OutputFile { path, file })
    }

    /// The same file in another place.
    pub fn with_path(&self, path: PathBuf) -> OutputFile {
        let file = self.file.clone();
        OutputFile { path, file }
    }

    /// The file with this header, completed with the file's own options.
    pub fn with_header(&self, header: PictureHeader) -> OutputFile {
        let mut output = self.clone();
        set_header(&mut output.file, header);
        output
    }

    /// Returns true if the whole file is built in memory first, because its format seeks and its
    /// destination cannot.
    pub fn is_in_memory(&self) -> bool {
        self.file.format.seeks() && !is_replaced(&self.path)
    }

    /// Writes bands on a separate thread while `make` produces them and passes them to its
    /// argument. A pipe whose reader is missing or stalled is abandoned once the control's `stop`
    /// is set.
    pub fn write_while<T>(
        &self,
        control: &Control,
        make: impl FnOnce(&mut dyn FnMut(Film) -> bool) -> Result<T, BandsError>,
    ) -> Result<T, CliError> {
        // No queue: one band is rendered while the previous one is written.
        let (send, receive) = sync_channel::<io::Result<Film>>(0);
        let output = self.clone();
        let writer = std::thread::Builder::new()
            .spawn(move || output.save(receive))
            .map_err(|e| CliError::Runtime(format!("cannot start a thread: {e}")))?;
        let stopped = || control.stop.load(Ordering::SeqCst);
        let made = make(&mut |film| send_band(&send, film, stopped));
        drop(send);
        // A thread that waits for a pipe's reader ends with the process, and leaves no partial
        // file.
        while !writer.is_finished() && !is_replaced(&self.path) {
            match made {
                Ok(_) | Err(BandsError::Abandoned) if !stopped() => std::thread::sleep(POLL),
                Ok(_) | Err(BandsError::Abandoned) => return Err(CliError::Interrupted),
                Err(error) => return Err(error.into()),
            }
        }
        let written = writer.join();
        let written = written.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        match (made, written) {
            (Err(BandsError::Abandoned), _) if stopped() => Err(CliError::Interrupted),
            // The writer failed, and took no more bands.
            (Err(BandsError::Abandoned), Err(failure)) => Err(failure),
            (Err(error), _) => Err(error.into()),
            (Ok(_), Err(failure)) => Err(failure),
            (Ok(done), Ok(())) => Ok(done),
        }
    }

    fn save(&self, bands: Receiver<io::Result<Film>>) -> Result<(), CliError> {
        if !is_dash(&self.path) {
            return Ok(save_bands(&self.path, &self.file, bands)?);
        }
        // Buffered, because standard output otherwise scans for line ends.
        let mut out = BufWriter::new(io::stdout().lock());
        write_bands(&mut out, &self.file, bands)
            .map_err(|e| CliError::Runtime(format!("cannot write the picture to stdout: {e}")))
    }
}

/// Interval at which a waiting thread checks for a signal.
const POLL: Duration = Duration::from_millis(1);

/// Passes a band to the writing thread. Returns false if the thread has ended, or once `stopped`
/// returns true.
fn send_band(send: &SyncSender<io::Result<Film>>, film: Film, stopped: impl Fn() -> bool) -> bool {
    let mut waiting = Ok(film);
    loop {
        waiting = match send.try_send(waiting) {
            Ok(()) => return true,
            Err(TrySendError::Disconnected(_)) => return false,
            Err(TrySendError::Full(_)) if stopped() => return false,
            Err(TrySendError::Full(back)) => back,
        };
        std::thread::sleep(POLL);
    }
}
