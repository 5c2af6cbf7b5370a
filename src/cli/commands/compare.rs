//! `phalanx compare`.

use crate::cli::options::{MaxDiffering, parse_max_differing, parse_tolerance};
use crate::cli::output::{self, CliError, Output, aligned, grouped, lines};
use clap::Args;
use phalanx::image::{
    CompareError, LargestDifference, LayerComparison, PictureComparison, PictureReader,
    compare_pictures, save_heat, save_side_by_side,
};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// First picture: PNG, JPEG, EXR, HDR or PFM
    pub a: PathBuf,
    /// Second picture, of the same kind (display or linear)
    pub b: PathBuf,
    /// Largest difference that counts as equal
    ///
    /// Applies to each channel: in 8-bit steps (0 to 255) for PNG and JPEG, even with 16 bits per
    /// sample, and in the file's own units for EXR, HDR and PFM. [default: exact equality]
    #[arg(long, value_name = "T", value_parser = parse_tolerance)]
    pub tolerance: Option<f64>,
    /// Pixels allowed to differ more
    ///
    /// A number of pixels, or a percentage such as 0.1%. A pixel differs if any of its layers
    /// exceeds the tolerance.
    #[arg(long, value_name = "N|P%", value_parser = parse_max_differing, default_value = "0")]
    pub max_differing: MaxDiffering,
    /// Write a heat map of the differences
    ///
    /// Shows the colours, or the first layer if there are none: black for equal, through red and
    /// yellow to white; cyan where only one of the values is finite. White is 255 steps for PNG and
    /// JPEG, 1 for linear colours, and the largest value of any other layer.
    #[arg(long, value_name = "OUT.png")]
    pub heat: Option<PathBuf>,
    /// Write both pictures and their differences
    #[arg(long, value_name = "OUT.png")]
    pub side_by_side: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

/// Compares two pictures. Different sizes count as a mismatch: exit code 4, with a message.
pub fn run(args: &CompareArgs) -> Result<(), CliError> {
    output::reads("the picture", &args.a)?;
    output::reads("the picture", &args.b)?;
    let (heat, side_by_side) = (&args.heat, &args.side_by_side);
    for (option, path) in [("--heat", heat), ("--side-by-side", side_by_side)] {
        (path.iter()).try_for_each(|path| output::check_png_place(path, option))?;
    }
    let (mut a, mut b) = (PictureReader::open(&args.a)?, PictureReader::open(&args.b)?);
    let comparison = compare_pictures(&mut a, &mut b, args.tolerance).map_err(refusal)?;
    if let Some(path) = heat {
        save_heat(path, &mut a, &mut b, &comparison).map_err(refusal)?;
    }
    if let Some(path) = side_by_side {
        save_side_by_side(path, &mut a, &mut b, &comparison).map_err(refusal)?;
    }
    let verdict = Verdict::of(&comparison, args);
    output::print_output(&CompareDocument::of(args, &comparison, verdict), args.json)?;
    match verdict {
        Verdict::Different => Err(CliError::Mismatch),
        Verdict::Identical | Verdict::WithinTolerance => Ok(()),
    }
}

/// The error for pictures that cannot be compared.
fn refusal(error: CompareError) -> CliError {
    match error {
        CompareError::Picture(error) => error.into(),
        CompareError::Sizes(_) | CompareError::Windows(..) => {
            output::error(&error.to_string());
            CliError::Mismatch
        }
        CompareError::Meaning { .. } => CliError::Usage(error.to_string())
            .with_hint("compare only PNG and JPEG, or only EXR, HDR and PFM"),
        other => CliError::Runtime(other.to_string()),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Verdict {
    Identical,
    WithinTolerance,
    Different,
}

impl Verdict {
    fn of(comparison: &PictureComparison, args: &CompareArgs) -> Verdict {
        let allowed = args.max_differing.pixels(comparison.pixels());
        let same_layers = comparison.only_in.iter().all(Vec::is_empty);
        if comparison.identical() {
            Verdict::Identical
        } else if same_layers && comparison.differing <= allowed {
            Verdict::WithinTolerance
        } else {
            Verdict::Different
        }
    }
}

#[derive(Debug, Serialize)]
struct CompareDocument {
    a: String,
    b: String,
    verdict: Verdict,
    exact: bool,
    width: u32,
    height: u32,
    /// Unit of differences: steps of an 8-bit sample, or the file's own numbers.
    unit: &'static str,
    tolerance: Option<f64>,
    max_differing: u64,
    /// Largest difference of all layers.
    largest_difference: f64,
    /// Root mean square difference of the first layer: colours, if both pictures have them.
    rmse: f64,
    differing_pixels: u64,
    share: f64,
    layers: Vec<LayerRow>,
    only_in_a: Vec<String>,
    only_in_b: Vec<String>,
    not_compared: Vec<String>,
    /// The picture of the differences, if one was requested.
    heat: Option<String>,
    side_by_side: Option<String>,
}

/// Figures of a layer.
#[derive(Debug, Serialize)]
struct LayerRow {
    name: String,
    channels: Vec<String>,
    exact: bool,
    largest_difference: f64,
    /// The first sample with the largest difference.
    at: Option<LargestDifference>,
    rmse: f64,
    psnr: Option<f64>,
    ssim: Option<f64>,
    flip: Option<f64>,
    differing_pixels: u64,
    share: f64,
    nan: [u64; 2],
    infinite: [u64; 2],
    differing_not_finite: u64,
}

impl CompareDocument {
    fn of(args: &CompareArgs, comparison: &PictureComparison, verdict: Verdict) -> CompareDocument {
        let name = |path: &Path| path.to_string_lossy().into_owned();
        let share = |pixels: u64| pixels as f64 / comparison.pixels().max(1) as f64;
        let row = |layer: &LayerComparison| LayerRow::of(layer, share(layer.differing));
        let layers: Vec<LayerRow> = comparison.layers.iter().map(row).collect();
        let [only_in_a, only_in_b] = comparison.only_in.clone();
        CompareDocument {
            a: name(&args.a),
            b: name(&args.b),
            verdict,
            exact: verdict == Verdict::Identical,
            width: comparison.width,
            height: comparison.height,
            unit: if comparison.display { "8-bit steps" } else { "linear" },
            tolerance: args.tolerance,
            max_differing: args.max_differing.pixels(comparison.pixels()),
            largest_difference: layers.iter().fold(0.0, |m, l| l.largest_difference.max(m)),
            rmse: layers.first().map_or(0.0, |layer| layer.rmse),
            differing_pixels: comparison.differing,
            share: share(comparison.differing),
            layers,
            only_in_a,
            only_in_b,
            not_compared: comparison.left_out.clone(),
            heat: args.heat.as_deref().map(name),
            side_by_side: args.side_by_side.as_deref().map(name),
        }
    }

    /// Rows on layers that only one picture has, and on samples that are not finite.
    fn remarks(&self) -> Vec<(&'static str, String)> {
        let mut rows = Vec::new();
        for (label, names) in [
            ("only in first", &self.only_in_a),
            ("only in second", &self.only_in_b),
            ("not compared", &self.not_compared),
        ] {
            rows.extend(wrapped(names).into_iter().map(|line| (label, line)));
        }
        for layer in &self.layers {
            rows.extend(layer.not_finite().map(|text| ("not finite", text)));
        }
        rows
    }
}

impl LayerRow {
    fn of(layer: &LayerComparison, share: f64) -> LayerRow {
        let largest = layer.largest.clone();
        LayerRow {
            name: layer.name.clone(),
            channels: layer.channels.clone(),
            exact: layer.identical,
            largest_difference: largest.as_ref().map_or(0.0, |largest| largest.value),
            at: largest,
            rmse: layer.rmse,
            psnr: layer.psnr,
            ssim: layer.ssim,
            flip: layer.flip,
            differing_pixels: layer.differing,
            share,
            nan: layer.not_finite.nan,
            infinite: layer.not_finite.infinite,
            differing_not_finite: layer.not_finite.different,
        }
    }

    fn not_finite(&self) -> Option<String> {
        let ([nan_a, nan_b], [infinite_a, infinite_b]) = (self.nan, self.infinite);
        let all = nan_a + nan_b + infinite_a + infinite_b;
        (all > 0).then(|| {
            format!(
                "{}: NaN {} and {}, infinite {} and {}, {} of them different",
                self.name,
                grouped(nan_a),
                grouped(nan_b),
                grouped(infinite_a),
                grouped(infinite_b),
                grouped(self.differing_not_finite)
            )
        })
    }

    /// Pixel and channel of the largest difference.
    fn place(&self) -> String {
        self.at.as_ref().map_or("-".to_owned(), |sample| {
            format!("{},{} {}", sample.x, sample.y, sample.channel)
        })
    }

    fn differing(&self) -> String {
        let share = 100.0 * self.share;
        format!("{} ({share:.4} %)", grouped(self.differing_pixels))
    }

    /// The row of a table of several layers.
    fn cells(&self) -> Vec<String> {
        let mut cells = vec![self.name.clone()];
        if self.exact {
            cells.push("identical".to_owned());
            return cells;
        }
        let optional = |value: Option<f64>, decimals: usize| {
            value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"))
        };
        cells.extend([
            float(self.largest_difference),
            self.place(),
            float(self.rmse),
            optional(self.psnr, 2),
            optional(self.ssim, 4),
            optional(self.flip, 4),
            grouped(self.differing_pixels),
        ]);
        cells
    }
}

/// Names in lines short enough to fit a terminal next to their label.
fn wrapped(names: &[String]) -> Vec<String> {
    const WIDTH: usize = 64;
    let mut lines: Vec<String> = Vec::new();
    for name in names {
        match lines.last_mut() {
            Some(line) if line.len() + 2 + name.len() <= WIDTH => line.extend([", ", &name[..]]),
            _ => lines.push(name.clone()),
        }
    }
    lines
}

/// A number of linear samples, which may be of any size.
fn float(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e5).contains(&size) => format!("{value:.6}"),
        _ => format!("{value:.3e}"),
    }
}

impl Output for CompareDocument {
    fn table(&self) -> String {
        let mut text = match self.verdict {
            Verdict::Identical => "identical\n",
            Verdict::WithinTolerance => "within the tolerance\n",
            Verdict::Different => "different\n",
        }
        .to_owned();
        match &self.layers[..] {
            _ if self.exact => {}
            [layer] => text.push_str(&self.figures(layer)),
            layers => {
                let head = "layer largest at RMS PSNR SSIM FLIP pixels".split(' ');
                let mut rows = vec![head.map(str::to_owned).collect()];
                rows.extend(layers.iter().map(LayerRow::cells));
                let rows = aligned(&rows, 1);
                rows.iter().for_each(|row| text.extend([row, "\n"]));
            }
        }
        text + &lines(&self.remarks())
    }
}

impl CompareDocument {
    /// Lines of the figures of a single layer.
    fn figures(&self, layer: &LayerRow) -> String {
        let screen = self.unit == "8-bit steps";
        // The largest difference of 8-bit pictures is a whole number, and is written as one.
        let steps = (layer.largest_difference * 1000.0).round() / 1000.0;
        let [largest, rms] = if screen {
            [format!("{steps} of 255"), format!("{:.6}", layer.rmse)]
        } else {
            [layer.largest_difference, layer.rmse].map(float)
        };
        let mut rows = vec![("largest difference", largest), ("at pixel", layer.place())];
        rows.push(("root mean square", rms));
        rows.extend(layer.psnr.map(|psnr| ("PSNR", format!("{psnr:.2} dB"))));
        rows.extend(layer.ssim.map(|ssim| ("SSIM", format!("{ssim:.4}"))));
        rows.extend(layer.flip.map(|flip| ("FLIP", format!("{flip:.4}"))));
        rows.push(("differing pixels", layer.differing()));
        lines(&rows)
    }
}
