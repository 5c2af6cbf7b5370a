//! Changes of many rates together: a kernel's, a kernel's on one kind of rays, or in one scene.

use super::log_rate::{LogRate, RateChange};
use super::noise::{KernelChanges, RunNoise, median_with_variance, robust_variance};
use serde::Serialize;
use std::collections::BTreeMap;
use std::slice::from_ref;

/// Minimum number of rates of a group: with fewer it is hardly more than one of them.
const MIN_RATES: usize = 4;

/// Part of the threshold that a kernel's whole interval must be beyond, where its change itself is
/// beyond the threshold.
const KERNEL_INTERVAL: f64 = 1.0 / 3.0;

/// Rates of one of our kernels that have changed together since the first record: by more than the
/// threshold, beyond the machine's change and other load.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroupChange {
    /// Index of the record.
    pub record: usize,
    /// Kernel.
    pub kernel: String,
    /// Threads.
    pub threads: u32,
    /// The scene; `None` for a change over all scenes.
    pub scene: Option<String>,
    /// The kind of rays; `None` for a change over all kinds.
    pub rays: Option<String>,
    /// Number of rates.
    pub rates: usize,
    /// Median of their changes, with its interval: 95 % for a kernel as a whole, 99.95 % for its
    /// part in one scene or on one kind of rays, of which there are many.
    pub change: RateChange,
}

/// Rates of a kernel: all of them, those in one scene, or on one kind of rays.
struct RateGroup<'a> {
    scene: Option<&'a str>,
    rays: Option<&'a str>,
    number: usize,
    change: LogRate,
}

/// A kernel on a number of threads, as a whole and in parts.
struct KernelGroups<'a> {
    name: &'a str,
    threads: u32,
    total: RateGroup<'a>,
    parts: Vec<RateGroup<'a>>,
}

/// The changed groups of all further records; `noise` is that of each.
///
/// - A **kernel** has changed as a whole if the median of its rates has by more than the threshold,
///   and the whole 95 % interval is beyond a third of it: a kernel that is a little slower
///   everywhere is found so, and in no single rate.
/// - A **part** of it, in one scene or on one kind of rays, has changed if its whole 99.95 %
///   interval is beyond the threshold, and beyond the change of the kernel as a whole.
pub(super) fn changed_groups(noise: &[Option<RunNoise>], threshold: f64) -> Vec<GroupChange> {
    let mut changed = Vec::new();
    let known = noise.iter().enumerate();
    let known = known.filter_map(|(i, noise)| Some((i + 1, noise.as_ref()?)));
    for (record, noise) in known {
        let kernels: Vec<KernelGroups> = noise.beyond_load().filter_map(kernel).collect();
        for kernel in &kernels {
            let group = |part: &RateGroup, change| GroupChange {
                record,
                kernel: kernel.name.to_owned(),
                threads: kernel.threads,
                scene: part.scene.map(str::to_owned),
                rays: part.rays.map(str::to_owned),
                rates: part.number,
                change,
            };
            let total = kernel.total.change.change();
            let differs = total.by.abs() > threshold && total.exceeds(KERNEL_INTERVAL * threshold);
            changed.extend(differs.then(|| group(&kernel.total, total)));
            let explained = if differs { kernel.total.change.value() } else { 0.0 };
            changed.extend(kernel.parts.iter().filter_map(|part| {
                let change = part
                    .change
                    .beyond(0.0, part_variance(&kernels, kernel, part));
                let differs = change.beyond(explained, 0.0).mostly().exceeds(threshold);
                differs.then(|| group(part, change.mostly()))
            }));
        }
    }
    changed
}

/// Variance of a part's change from run to run: a scene's rates have an error in common (its memory
/// lies elsewhere), as have those of a kind of rays. It is the scatter of such parts about their
/// kernels, of this kernel or of all, whichever is larger.
fn part_variance(kernels: &[KernelGroups], kernel: &KernelGroups, part: &RateGroup) -> f64 {
    let scatter = |kernels: &[KernelGroups]| {
        let offsets = kernels.iter().flat_map(|kernel| {
            let parts = kernel.parts.iter();
            let like = parts.filter(|other| other.scene.is_some() == part.scene.is_some());
            like.map(|part| part.change.value() - kernel.total.change.value())
        });
        robust_variance(offsets)
    };
    scatter(kernels).max(scatter(from_ref(kernel)))
}

/// A kernel and its parts; `None` if it has too few rates.
fn kernel<'a>(
    ((name, threads), changes): ((&'a str, u32), KernelChanges<'a>),
) -> Option<KernelGroups<'a>> {
    let mut members: BTreeMap<(Option<&str>, Option<&str>), Vec<f64>> = BTreeMap::new();
    for (&(scene, rays), &change) in &changes {
        for part in [(None, None), (Some(scene), None), (None, Some(rays))] {
            members.entry(part).or_default().push(change);
        }
    }
    members.retain(|(scene, rays), rates| {
        let is_total = scene.is_none() && rays.is_none();
        rates.len() >= MIN_RATES && (is_total || rates.len() < changes.len())
    });
    let mut parts = members.into_iter().map(|((scene, rays), rates)| RateGroup {
        scene,
        rays,
        number: rates.len(),
        change: median_with_variance(&rates),
    });
    // The total is first: `None` before any name.
    Some(KernelGroups {
        name,
        threads,
        total: parts.next()?,
        parts: parts.collect(),
    })
}
