//! The file that a picture is written to.

use crate::cli::output::{CliError, OutputFile};
use phalanx::files::shown_path;
use phalanx::image::ImageFormat;
use phalanx::jobs::PictureSpec;
use phalanx::scene::Scene;
use std::path::PathBuf;

/// The file that a picture is written to. Refuses options that its format does not use, so that
/// none is silently ignored.
pub fn picture_file(
    path: PathBuf,
    format: ImageFormat,
    spec: &PictureSpec,
    scene: &Scene,
) -> Result<OutputFile, CliError> {
    let name = shown_path(&path);
    let (encoding, tone) = (&spec.encoding, &spec.encoding.tone);
    let options = [
        ("--exposure", encoding.exposure.is_some()),
        ("--tone", encoding.curve.is_some()),
        ("--transfer", tone.transfer.is_some()),
        ("--quantize", tone.quantize.is_some()),
    ];
    if let (true, Some((option, _))) = (format.is_linear(), options.iter().find(|(_, on)| *on)) {
        return Err(CliError::Usage(format!(
            "{option} is for PNG and JPEG: {name} stores linear radiance"
        )));
    }
    if let Some(bits) = encoding.bits.filter(|bits| !format.bits().contains(bits)) {
        return Err(CliError::Usage(match format.bits() {
            [usual, other] => {
                format!("--bits {bits}: {name} can have {usual} or {other} bits per sample")
            }
            _ => format!("--bits is for PNG and OpenEXR: {name} is neither"),
        }));
    }
    OutputFile::for_picture(path, format, &spec.resolve(scene), scene.origin)
}
