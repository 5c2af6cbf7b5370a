//! Pictures of all directions, as environments: Radiance HDR, OpenEXR and PFM.

use crate::memory::MemoryLedger;
use crate::read_scene::LoadError;
use phalanx_image::{
    ImageFormat, PictureChannel, PictureError, PictureLayout, PictureReader, SampleKind,
};
use phalanx_scene::{Column, EnvironmentMap, EnvironmentTexels, MAX_ENVIRONMENT_SIDE};
use std::path::Path;

/// Rows per read: one block of most OpenEXR files, otherwise few enough to stay in the caches.
fn band_rows(format: ImageFormat) -> u32 {
    if format == ImageFormat::Exr { 32 } else { 4 }
}

/// Radiance at and above which a sample counts as infinite.
const INFINITE: f32 = 1e30;
/// Radiance of an infinite sample: the largest half, where most of them were cut off.
const LARGEST: f32 = 65504.0;

/// Reads an environment, texels of which are stored as in the file where that is exact, and else as
/// floats. Takes up to `max_memory` bytes; `None` sets no limit. Returns a remark with it if its
/// shape is unusual, or if samples were changed.
///
/// # Errors
/// [`LoadError::Io`], [`LoadError::Memory`], and [`LoadError::Options`] for a file that is no such
/// picture.
pub fn read_environment(
    path: &Path,
    max_memory: Option<u64>,
) -> Result<(EnvironmentMap, Option<String>), LoadError> {
    let mut reader = PictureReader::open(path).map_err(fault)?;
    let unfit = |reason: String| LoadError::Options {
        path: path.to_path_buf(),
        reason,
    };
    let layout = reader.layout();
    let channels = colors(layout).map_err(unfit)?;
    let (width, height) = (layout.width, layout.height);
    let memory = MemoryLedger::of(max_memory);
    let count = layout.pixels();
    let room = |mut texels: EnvironmentTexels| {
        let bytes = count.saturating_mul(texels.column().row_size() as u64);
        let taken = memory.take(bytes, "for the environment");
        taken.map_err(|refusal| LoadError::over_limit(path, refusal))?;
        texels.column_mut().make_room(count as usize);
        Ok(texels)
    };
    let mut texels = room(match layout.format {
        ImageFormat::Hdr => EnvironmentTexels::Rgbe(Column::new()),
        _ => EnvironmentTexels::Half(Column::new()),
    })?;
    let mut changed = 0;
    let band = band_rows(layout.format);
    for top in (0..height).step_by(band as usize) {
        let rows = top..height.min(top + band);
        let mut planes = reader.read(rows).map_err(fault)?;
        changed += planes.iter_mut().map(|plane| clamp(plane)).sum::<usize>();
        let [red, green, blue] = channels.map(|channel| &planes[channel]);
        let rows = red.iter().zip(green).zip(blue);
        let float = f32::from_bits;
        let rows = rows.map(|((&r, &g), &b)| [float(r), float(g), float(b)]);
        let known = texels.rows();
        if !texels.extend(rows.clone()) {
            let mut floats = room(EnvironmentTexels::Float(Column::new()))?;
            let before = (0..known).map(|k| texels.get(k).to_array());
            floats.extend(before.chain(rows));
            texels = floats;
        }
    }
    let map = EnvironmentMap {
        width,
        height,
        texels,
    };
    let remark = remark(&map, changed);
    Ok((map, remark))
}

/// Numbers of the channels that are red, green and blue; all the same for a grey picture.
fn colors(layout: &PictureLayout) -> Result<[usize; 3], String> {
    if !layout.format.is_linear() {
        return Err("an environment needs linear radiance: HDR, OpenEXR or PFM".into());
    }
    let side = 1..=MAX_ENVIRONMENT_SIDE;
    let (width, height) = (layout.width, layout.height);
    if !side.contains(&width) || !side.contains(&height) {
        return Err(format!(
            "an environment of {width}x{height} texels is out of range: \
             sides are 1 to {MAX_ENVIRONMENT_SIDE}"
        ));
    }
    let find = |name: &str| {
        let is_it = |c: &PictureChannel| c.kind == SampleKind::Float && c.name == name;
        layout.channels.iter().position(is_it)
    };
    match (find("R"), find("G"), find("B"), find("Y")) {
        (Some(r), Some(g), Some(b), _) => Ok([r, g, b]),
        (_, _, _, Some(grey)) => Ok([grey; 3]),
        _ => Err("it has no channels R, G and B of floats".into()),
    }
}

/// Clamps samples to radiance that tracing can multiply; returns the number of changes.
fn clamp(samples: &mut [u32]) -> usize {
    let mut changed = 0;
    for bits in samples {
        // Negative numbers and NaN have larger bits than all others.
        if *bits >= INFINITE.to_bits() {
            changed += usize::from(*bits != (-0f32).to_bits());
            let is_large = f32::from_bits(*bits) >= INFINITE;
            *bits = if is_large { LARGEST.to_bits() } else { 0 };
        }
    }
    changed
}

/// A remark on an environment, of which `changed` samples were clamped.
fn remark(map: &EnvironmentMap, changed: usize) -> Option<String> {
    let (width, height) = (map.width, map.height);
    if changed > 0 {
        return Some(format!(
            "{changed} samples of the environment are negative, infinite or NaN: \
             infinite ones count as {LARGEST}, the others as 0"
        ));
    }
    (width != 2 * height).then(|| {
        format!("the environment is {width}x{height}, not twice as wide as high: it is stretched")
    })
}

fn fault(error: PictureError) -> LoadError {
    match error {
        PictureError::Read { path, source } | PictureError::Write { path, source } => {
            LoadError::Io { path, source }
        }
        PictureError::Decode { path, kind, reason } => LoadError::Options {
            path,
            reason: format!("not {kind} that can be read: {reason}"),
        },
    }
}
