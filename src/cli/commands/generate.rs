//! `phalanx generate`: a standard scene to a file, whole or not at all.

use crate::cli::options::parse_thread_count;
use crate::cli::output::{self, CliError, Output, bytes, grouped, interrupt, lines, progress};
use clap::{Args, value_parser};
use phalanx::files::{replace_file, shown_path};
use phalanx::frame::Control;
use phalanx::standard::{self, DroppedFeatures, FileFormat, PREFIX, SceneWriteError, Spec};
use serde::Serialize;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

#[derive(Debug, Args)]
pub struct GenerateArgs {
    /// Name of a standard scene, as listed by `phalanx scenes`
    pub name: String,
    /// Size, as in 50k or 2M [default: the scene's]
    ///
    /// A whole number, optionally followed by k (thousands) or M (millions).
    #[arg(long, value_name = "N")]
    pub size: Option<String>,
    /// File to write: .nff, .ply (binary) or .test
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Convert spheres and cones to triangles
    ///
    /// 12 N² triangles per sphere, 8 N per cone.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=1000))]
    pub tessellate: Option<u32>,
    /// Number of threads [default: one per available CPU]
    ///
    /// The file does not depend on this option.
    #[arg(long, value_name = "N", value_parser = parse_thread_count)]
    pub threads: Option<usize>,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct GenerateDocument {
    scene: &'static str,
    size: u32,
    file: String,
    bytes: u64,
    /// Features other than shapes that the format cannot store.
    losses: DroppedFeatures,
}

/// Writes a standard scene to a file.
pub fn run(args: &GenerateArgs) -> Result<(), CliError> {
    let spec = spec_of(args)?;
    let format = FileFormat::of(&args.output).ok_or_else(|| {
        CliError::Usage(format!(
            "--output {}: unknown scene format: use .nff, .ply or .test",
            shown_path(&args.output)
        ))
    })?;
    output::check_place(&args.output, Some("--output"))?;
    interrupt::listen()?;
    let (losses, written) = if output::is_replaced(&args.output) {
        interrupt::interruptible(|control| write(args, spec, format, control))?
    } else {
        // A write to a pipe without a reader can only be stopped by ending the process, which

        // leaves nothing behind.
        write(args, spec, format, &Control::default())?
    };
    for loss in &losses {
        output::note(&format!("{}: {loss}", shown_path(&args.output)));
    }
    let document = GenerateDocument {
        scene: spec.scene.name,
        size: spec.size,
        file: args.output.to_string_lossy().into_owned(),
        bytes: written,
        losses,
    };
    output::print_output(&document, args.json)
}

impl Output for GenerateDocument {
    fn table(&self) -> String {
        let scene = format!("{}, size {}", self.scene, grouped(self.size.into()));
        let file = format!("{}, {}", self.file, bytes(self.bytes));
        lines(&[("scene", scene), ("file", file)])
    }
}

/// The requested scene, by any name that other commands accept.
fn spec_of(args: &GenerateArgs) -> Result<Spec, CliError> {
    let plain = args.name.strip_prefix(PREFIX).unwrap_or(&args.name);
    let name = match (&args.size, plain.contains(':')) {
        (Some(_), true) => {
            let message = format!("{} already has a size: omit --size", args.name);
            return Err(CliError::Usage(message));
        }
        (Some(size), false) => format!("{PREFIX}{plain}:{size}"),
        (None, _) => format!("{PREFIX}{plain}"),
    };
    Ok(standard::parse_spec(&name)?)
}

fn write(
    args: &GenerateArgs,
    spec: Spec,
    format: FileFormat,
    control: &Control,
) -> Result<(DroppedFeatures, u64), CliError> {
    let path = &args.output;
    let mut losses = DroppedFeatures::new();
    let mut refused = None;
    let bar = progress::bar(None, "{spinner} {binary_bytes} written in {elapsed}");
    let done = replace_file(path, |out| {
        let out = bar.wrap_write(out);
        let mut out = InterruptibleWriter { out, control };
        let threads = args.threads.unwrap_or(0);
        match standard::write(spec, format, args.tessellate, threads, &mut out) {
            Ok(what) => losses = what,
            Err(SceneWriteError::Io(error)) => return Err(error),
            Err(other) => {
                refused = Some(other);
                return Err(io::Error::other("refused"));
            }
        }
        out.check()
    });
    let written = bar.position();
    bar.finish_and_clear();
    match done {
        Ok(()) => Ok((losses, written)),
        Err(_) if control.stop.load(Ordering::SeqCst) => Err(CliError::Interrupted),
        Err(error) => Err(match refused {
            Some(refused) => refusal(path, &refused),
            None => CliError::cannot_write(path, error),
        }),
    }
}

/// The error for a scene that the format cannot store, with advice.
fn refusal(path: &Path, error: &SceneWriteError) -> CliError {
    let failure = CliError::Usage(format!("{}: {error}", shown_path(path)));
    match error {
        SceneWriteError::CannotHold { .. } => failure.with_hint("try --tessellate 8"),
        _ => failure,
    }
}

/// Stops after a signal.
struct InterruptibleWriter<'a, W> {
    out: W,
    control: &'a Control,
}

impl<W> InterruptibleWriter<'_, W> {
    fn check(&self) -> io::Result<()> {
        // Not the kind `Interrupted`, which means "try again".
        if self.control.stop.load(Ordering::SeqCst) {
            Err(io::Error::other("interrupted"))
        } else {
            Ok(())
        }
    }
}

impl<W: Write> Write for InterruptibleWriter<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.check()?;
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
