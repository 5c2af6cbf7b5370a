//! `phalanx compare`.

use crate::cli::output::{self, CliError, SCHEMA_VERSION, grouped, lines};
use clap::Args;
use phalanx::image::{Comparison, compare, heat, load, save_png};
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
    schema_version: u32,
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
        output::check_png_name(path, "--heat")?;
        output::check_picture_place(path)?;
    }
    let (a, b) = (load(&args.a)?, load(&args.b)?);
    let found = compare(&a, &b).map_err(|sizes| {
        output::note(&format!("error: {sizes}"));
        CliError::Mismatch
    })?;
    if let Some(path) = &args.heat
        && let Ok(picture) = heat(&a, &b)
    {
        save_png(path, &picture)?;
    }
    if args.json {
        output::print_json(&document(args, &found))?;
    } else {
        output::print(&table(&found))?;
    }
    if found.exact {
        Ok(())
    } else {
        Err(CliError::Mismatch)
    }
}

fn document(args: &CompareArgs, found: &Comparison) -> CompareDocument {
    let name = |path: &std::path::Path| path.to_string_lossy().into_owned();
    CompareDocument {
        schema_version: SCHEMA_VERSION,
        a: name(&args.a),
        b: name(&args.b),
        exact: found.exact,
        largest_difference: found.largest,
        rmse: found.rmse,
        differing_pixels: found.differing,
        share: found.share,
        heat: args.heat.as_deref().map(name),
    }
}

fn table(found: &Comparison) -> String {
    if found.exact {
        return "identical\n".to_owned();
    }
    // `largest` is a whole number for 8-bit pictures, and is written as one.
    let rows = [
        (
            "largest difference",
            format!("{} of 255", (found.largest * 1000.0).round() / 1000.0),
        ),
        ("root mean square", format!("{:.6}", found.rmse)),
        (
            "differing pixels",
            format!(
                "{} ({:.4} %)",
                grouped(found.differing),
                100.0 * found.share
            ),
        ),
    ];
    format!("different\n{}", lines(&rows))
}
