//! `phalanx compare`.

use crate::cli::output::{self, CliError, Output, grouped, lines};
use clap::Args;
use phalanx::image::{compare, heat, load, save_png};
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// First picture
    pub a: PathBuf,
    /// Second picture
    pub b: PathBuf,
    /// Write a picture of the differences: black where equal, then red, yellow, white
    #[arg(long, value_name = "OUT.png")]
    pub heat: Option<PathBuf>,
    /// Print one JSON document instead of lines
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct CompareDocument {
    a: String,
    b: String,
    exact: bool,
    largest_difference: f64,
    rmse: f64,
    differing_pixels: u64,
    share: f64,
    /// The picture of the differences, if one was requested.
    heat: Option<String>,
}

/// Compares two pictures. Pictures of different sizes differ too: exit code 4, with a message.
pub fn run(args: &CompareArgs) -> Result<(), CliError> {
    if let Some(path) = &args.heat {
        output::check_png_place(path, "--heat")?;
    }
    let (a, b) = (load(&args.a)?, load(&args.b)?);
    let found = compare(&a, &b).map_err(|sizes| {
        output::error(&sizes.to_string());
        CliError::Mismatch
    })?;
    if let Some(path) = &args.heat
        && let Ok(picture) = heat(&a, &b)
    {
        save_png(path, &picture)?;
    }
    let name = |path: &PathBuf| path.to_string_lossy().into_owned();
    let document = CompareDocument {
        a: name(&args.a),
        b: name(&args.b),
        exact: found.exact,
        largest_difference: found.largest,
        rmse: found.rmse,
        differing_pixels: found.differing,
        share: found.share,
        heat: args.heat.as_ref().map(name),
    };
    output::print_output(&document, args.json)?;
    match found.exact {
        true => Ok(()),
        false => Err(CliError::Mismatch),
    }
}

impl Output for CompareDocument {
    fn table(&self) -> String {
        if self.exact {
            return "identical\n".to_owned();
        }
        // The largest difference of 8-bit pictures is a whole number, and is written as one.
        let largest = (self.largest_difference * 1000.0).round() / 1000.0;
        let share = 100.0 * self.share;
        let differing = format!("{} ({share:.4} %)", grouped(self.differing_pixels));
        let rows = [
            ("largest difference", format!("{largest} of 255")),
            ("root mean square", format!("{:.6}", self.rmse)),
            ("differing pixels", differing),
        ];
        format!("different\n{}", lines(&rows))
    }
}
