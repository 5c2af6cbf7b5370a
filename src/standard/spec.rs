//! Standard scenes by name and size: `standard:NAME[:SIZE]`.

use super::builder::SceneBuilder;
use super::catalogue::{CATALOGUE, Family, StandardScene};
use super::count::{ShapeCounter, ShapeCounts};
use super::memory_builder::MemoryBuilder;
use phalanx_scene::{OutputEncoding, Scene, SceneError};

/// Prefix of the name of a standard scene: `standard:NAME` or `standard:NAME:SIZE`.
pub const PREFIX: &str = "standard:";

/// A scene of the catalogue at a size.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// The entry of the catalogue.
    pub scene: &'static StandardScene,
    /// Its size, within [`StandardScene::sizes`].
    pub size: u32,
}

/// The reason why a name is not that of a standard scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StandardError {
    /// No entry of that name.
    #[error("no standard scene is called `{name}`; did you mean `{closest}`?")]
    Unknown {
        /// The name that was requested.
        name: String,
        /// The known name closest to it.
        closest: &'static str,
    },
    /// The specification does not start with [`PREFIX`].
    #[error("`{0}` is not of the form standard:NAME[:SIZE]")]
    NotASpec(String),
    /// The size is not an integer.
    #[error(
        "the size `{size}` of {name} is not a whole number (k or M may follow it, for thousands or millions)"
    )]
    SizeNotANumber {
        /// The scene.
        name: &'static str,
        /// The text that should be the size.
        size: String,
    },
    /// The size is a number, but the scene does not have it.
    #[error("{name} comes in sizes {least} to {most}, not {size}")]
    SizeOutOfRange {
        /// The scene.
        name: &'static str,
        /// The size that was requested.
        size: u64,
        /// The smallest size.
        least: u32,
        /// The largest size.
        most: u32,
    },
    /// The generated scene breaks a limit of scenes.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// The entry of that name.
///
/// # Errors
/// [`StandardError::Unknown`] with the closest known name.
pub fn find(name: &str) -> Result<&'static StandardScene, StandardError> {
    let known = CATALOGUE.iter().find(|entry| entry.name == name);
    known.ok_or_else(|| StandardError::Unknown {
        name: name.chars().take(40).collect(),
        closest: closest(name),
    })
}

fn closest(name: &str) -> &'static str {
    let name = name.to_lowercase();
    let distance = |entry: &&StandardScene| strsim::osa_distance(entry.name, &name);
    let best = CATALOGUE.iter().min_by_key(distance);
    best.map_or("", |entry| entry.name)
}

/// Parses `standard:NAME[:SIZE]`.
///
/// # Errors
/// [`StandardError`]: no such form, no such scene, no such size.
pub fn parse_spec(text: &str) -> Result<Spec, StandardError> {
    let rest = text.strip_prefix(PREFIX);
    let rest = rest.ok_or_else(|| StandardError::NotASpec(text.to_owned()))?;
    let (name, size) = match rest.split_once(':') {
        Some((name, size)) => (name, Some(size)),
        None => (rest, None),
    };
    let entry = find(name)?;
    let Some(size) = size else {
        return Ok(Spec::of(entry));
    };
    Spec::sized(entry, parse_size(entry, size)?)
}

/// Parses a size: an integer, in thousands with the suffix `k`, or in millions with `M`.
///
/// # Errors
/// [`StandardError::SizeNotANumber`], which names `entry`.
pub fn parse_size(entry: &StandardScene, text: &str) -> Result<u64, StandardError> {
    let (digits, unit) = match text.strip_suffix(['k', 'K', 'm', 'M']) {
        None => (text, 1),
        Some(digits) if text.ends_with(['k', 'K']) => (digits, 1_000),
        Some(digits) => (digits, 1_000_000),
    };
    let is_integer = digits.bytes().all(|b| b.is_ascii_digit());
    let number = digits.parse::<u64>().ok().filter(|_| is_integer);
    let size = number.and_then(|n| n.checked_mul(unit));
    size.ok_or_else(|| StandardError::SizeNotANumber {
        name: entry.name,
        size: text.to_owned(),
    })
}

impl Spec {
    /// The entry at its default size.
    pub fn of(entry: &'static StandardScene) -> Spec {
        Spec {
            scene: entry,
            size: entry.default_size,
        }
    }

    /// The entry at a size.
    ///
    /// # Errors
    /// [`StandardError::SizeOutOfRange`].
    pub fn sized(entry: &'static StandardScene, size: u64) -> Result<Spec, StandardError> {
        let fitting = u32::try_from(size).ok().filter(|s| entry.sizes.contains(s));
        let size = fitting.ok_or(StandardError::SizeOutOfRange {
            name: entry.name,
            size,
            least: *entry.sizes.start(),
            most: *entry.sizes.end(),
        })?;
        Ok(Spec { scene: entry, size })
    }
}

/// Passes a standard scene to a builder.
pub fn generate(spec: Spec, builder: &mut dyn SceneBuilder) {
    (spec.scene.generate)(spec.size, builder);
}

/// A standard scene as a [`Scene`], validated. Scenes of triangles are drawn on `threads` threads,
/// 0 for one per CPU; the scene does not depend on their number. Some count their parts before, on
/// the threads of a pool.
///
/// # Errors
/// [`StandardError::Scene`] if it breaks a limit of scenes.
pub fn scene(spec: Spec, threads: usize) -> Result<Scene, StandardError> {
    let mut builder = MemoryBuilder::default();
    builder.threads = threads;
    generate(spec, &mut builder);
    let mut scene = builder.finish();
    scene.max_depth = spec.scene.max_depth;
    if spec.scene.family == Family::Modern {
        scene.encoding = OutputEncoding::SRGB;
    }
    scene.validate()?;
    Ok(scene)
}

/// Counts of a standard scene, without building it.
pub fn counts(spec: Spec) -> ShapeCounts {
    let mut builder = ShapeCounter::default();
    generate(spec, &mut builder);
    builder.counts()
}
