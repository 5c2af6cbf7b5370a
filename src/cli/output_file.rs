//! The file that a picture is written to: its format by its name, and what may be asked of that.

use super::error::CliError;
use super::output::{is_dash, is_replaced};
use super::picture_args::PictureArgs;
use clap::Args;
use phalanx::frame::{Aovs, Control, Settings, Tile};
use phalanx::image::{
    Depth, Exposure, ImageFormat, MAX_EXPOSURE, PictureFile, save_bands, write_bands,
};
use phalanx::jobs::BandsError;
use phalanx::render::Film;
use phalanx::scene::Scene;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

/// How samples for a screen are made of radiance.
#[derive(Debug, Args)]
pub struct GradeArgs {
    /// Stops by which PNG and JPEG pictures are lighter (or darker, as in --exposure=-1.5)
    #[arg(long, value_name = "STOPS", value_parser = parse_exposure)]
    pub exposure: Option<f32>,
    /// Bits of a PNG's samples: 8 or 16 [default: 8]
    #[arg(long, value_name = "N", value_parser = parse_depth)]
    pub bits: Option<Depth>,
}

fn parse_exposure(text: &str) -> Result<f32, String> {
    let stops: Option<f32> = text.parse().ok();
    stops
        .filter(|stops| stops.abs() <= MAX_EXPOSURE)
        .ok_or_else(|| format!("expected stops from -{MAX_EXPOSURE} to {MAX_EXPOSURE}, as in 0.5"))
}

fn parse_depth(text: &str) -> Result<Depth, String> {
    match text {
        "8" => Ok(Depth::Eight),
        "16" => Ok(Depth::Sixteen),
        _ => Err("expected 8 or 16".to_owned()),
    }
}

/// Longest side of a JPEG.
const JPEG_SIDE: u32 = 65_535;

/// The format that was asked for, or what a picture's name says of it; refuses one whose ending no
/// format has, for the given reason of asking. Stdout and pipes and devices without an ending get a
/// PNG.
pub fn format_of(
    path: &Path,
    asked: Option<ImageFormat>,
    origin: &str,
) -> Result<ImageFormat, CliError> {
    let plain = || path.extension().is_none() && !is_replaced(path);
    let format = asked.or_else(|| ImageFormat::of(path));
    format.or_else(|| plain().then_some(ImageFormat::Png)).ok_or_else(|| {
        let endings = ImageFormat::ENDINGS.map(|(ending, _)| format!(".{ending}"));
        CliError::Usage(format!(
            "{origin} {}: the name must end in one of {}, which says what is written, or --format must",
            path.display(),
            endings.join(", ")
        ))
    })
}

/// A picture file to be.
#[derive(Clone, Debug)]
pub struct OutputFile {
    pub path: PathBuf,
    pub file: PictureFile,
}

impl OutputFile {
    /// Refuses what the format has no use for: nobody should wonder why it did nothing.
    pub fn new(
        path: PathBuf,
        format: ImageFormat,
        args: &GradeArgs,
        picture: &PictureArgs,
        scene: &Scene,
        settings: &Settings,
    ) -> Result<OutputFile, CliError> {
        let name = path.display();
        let asked = [
            ("--exposure", args.exposure.is_some()),
            ("--transfer", picture.transfer.is_some()),
            ("--quantize", picture.quantize.is_some()),
        ];
        if let (true, Some((option, _))) = (format.is_linear(), asked.iter().find(|(_, on)| *on)) {
            return Err(CliError::Usage(format!(
                "{option} is for PNG and JPEG: {name} holds radiance as it is"
            )));
        }
        if args.bits.is_some() && format != ImageFormat::Png {
            return Err(CliError::Usage(format!(
                "--bits is for PNG, and {name} is none: leave it out"
            )));
        }
        let exposure = Exposure {
            stops: args.exposure.unwrap_or(0.0),
            encoding: picture.tone(scene),
        };
        OutputFile::for_picture(
            path,
            format,
            exposure,
            args.bits.unwrap_or_default(),
            settings.window(),
            (settings.aovs, scene.origin),
        )
    }

    /// A file of a window with layers of a scene that has this origin, which the format must be
    /// able to hold.
    pub fn for_picture(
        path: PathBuf,
        format: ImageFormat,
        exposure: Exposure,
        depth: Depth,
        window: Tile,
        (aovs, origin): (Aovs, [f64; 3]),
    ) -> Result<OutputFile, CliError> {
        if !aovs.is_empty() && format != ImageFormat::Exr {
            return Err(CliError::Usage(format!(
                "--aov is for OpenEXR, and {} is none: name it .exr",
                path.display()
            )));
        }
        let Tile { width, height, .. } = window;
        let longest = width.max(height);
        if format == ImageFormat::Jpeg && longest > JPEG_SIDE {
            return Err(CliError::Usage(format!(
                "{}: the sides of a JPEG are {JPEG_SIDE} pixels at most, not {longest}: write a PNG",
                path.display()
            )));
        }
        let file = PictureFile {
            width,
            height,
            format,
            aovs,
            origin,
            exposure,
            depth,
        };
        Ok(OutputFile { path, file })
    }

    /// Tells whether the whole file is in memory before it is written: where it is not replaced,
    /// nothing can be sought in it.
    pub fn is_in_memory(&self) -> bool {
        self.file.format.seeks() && !is_replaced(&self.path)
    }

    /// Writes bands as they are made, on a thread of its own; `make` is given what takes them. A
    /// pipe whose reader does not come, or reads no more, is given up when the control says stop.
    pub fn write_while<T>(
        &self,
        control: &Control,
        make: impl FnOnce(&mut dyn FnMut(Film) -> bool) -> Result<T, BandsError>,
    ) -> Result<T, CliError> {
        // No band waits: one is being made, one is being written.
        let (send, receive) = sync_channel::<io::Result<Film>>(0);
        let output = self.clone();
        let writer = std::thread::Builder::new()
            .spawn(move || output.save(receive))
            .map_err(|e| CliError::Runtime(format!("cannot start a thread: {e}")))?;
        let stopped = || control.stop.load(Ordering::SeqCst);
        let made = make(&mut |film| send_band(&send, film, stopped));
        drop(send);
        // A thread that waits for a pipe's reader ends with the process, and has no file to finish.
        while !writer.is_finished() && !is_replaced(&self.path) {
            match made {
                Ok(_) | Err(BandsError::Abandoned) if !stopped() => std::thread::sleep(POLL),
                Ok(_) | Err(BandsError::Abandoned) => return Err(CliError::Interrupted),
                Err(error) => return Err(error.into()),
            }
        }
        let written = writer
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        match (made, written) {
            (Err(BandsError::Abandoned), _) if stopped() => Err(CliError::Interrupted),
            // Nobody took the bands, and that is why.
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
        // Standard output looks for ends of lines, which samples do not have.
        let mut out = BufWriter::new(io::stdout().lock());
        write_bands(&mut out, &self.file, bands)
            .map_err(|e| CliError::Runtime(format!("cannot write the picture to stdout: {e}")))
    }
}

/// How often a thread that waits looks for a signal.
const POLL: Duration = Duration::from_millis(1);

/// Hands a band to the thread that writes; `false` where that has ended, or where nobody is to wait
/// for it any more.
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
