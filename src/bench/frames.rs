//! Whole frames: camera rays, traversal, shading, bounces and film, by each kernel and by the
//! oracle.

use super::entrants::{kernels, row};
use super::error::BenchError;
use super::plan::{BenchPlan, SceneInfo};
use super::rounds::{Measurement, SampleFn};
use super::timer::Timing;
use super::workload::BenchTrees;
use phalanx_render::NO_HIT;
use phalanx_render::frame::{
    AccelRef, Control, Frame, FrameError, Sampling, Settings, render_with,
};
use phalanx_report::{FRAME, ORACLE, PHALANX};
use phalanx_trace::Kernel;

/// Divisor of the ray sets' picture width and height that gives the size of a frame. Frames trace
/// many more rays per pixel.
const SHRINK: u32 = 2;

/// Further divisor for timed frames of the oracle: its rate is the same, and it takes a quarter of
/// the time.
const ORACLE_SHRINK: u32 = 2;

/// The frames of a plan.
pub(super) struct Frames<'a> {
    trees: &'a BenchTrees<'a>,
    threads: Vec<usize>,
    settings: Vec<(&'static str, &'static str, Settings)>,
}

impl<'a> Frames<'a> {
    pub(super) fn new(trees: &'a BenchTrees, plan: &BenchPlan) -> Frames<'a> {
        let settings = Settings {
            width: plan.size[0].div_ceil(SHRINK),
            height: plan.size[1].div_ceil(SHRINK),
            sampling: Sampling::CENTER,
            ..Settings::of(trees.scene)
        };
        let mut all = Vec::new();
        if plan.frames {
            all.push((ORACLE, "scalar", settings.clone()));
            all.extend(kernels(plan).into_iter().map(|kernel: Kernel| {
                let settings = Settings {
                    kernel,
                    ..settings.clone()
                };
                (PHALANX, kernel.name(), settings)
            }));
        }
        Frames {
            trees,
            threads: plan.threads.clone(),
            settings: all,
        }
    }

    fn tree(&self, engine: &str) -> AccelRef<'a> {
        match engine {
            ORACLE => AccelRef::Oracle(&self.trees.oracle_bvh),
            _ => AccelRef::Packets(&self.trees.bvh),
        }
    }

    /// Checks that all kernels render the oracle's frame, bit for bit. Returns the number of pixels
    /// that show anything.
    pub(super) fn check(&self, info: &SceneInfo) -> Result<u64, BenchError> {
        let mut oracle: Option<Frame> = None;
        for (engine, kernel, settings) in &self.settings {
            let settings = Settings {
                threads: BenchPlan::all_threads(),
                record_hits: true,
                ..settings.clone()
            };
            let (tree, control) = (self.tree(engine), Control::default());
            let frame = render_with(self.trees.scene, tree, &settings, &control);
            let frame = match frame {
                Ok(frame) => frame,
                Err(FrameError::View(source)) => {
                    let scene = info.name.clone();
                    return Err(BenchError::View { scene, source });
                }
                // Not possible: the control belongs to this function, and frames are measured with
                // the settings of the scene.
                Err(_) => continue,
            };
            let Some(expected) = &oracle else {
                oracle = Some(frame);
                continue;
            };
            if let Some([x, y]) = first_difference(expected, &frame) {
                return Err(BenchError::Frame {
                    scene: info.name.clone(),
                    kernel: (*kernel).to_owned(),
                    x,
                    y,
                });
            }
        }
        let hits = oracle.and_then(|frame| frame.film.hits);
        let shown = hits.map(|hits| hits.prim_id.iter().filter(|id| **id != NO_HIT).count());
        Ok(shown.unwrap_or(0) as u64)
    }

    pub(super) fn measurements(&self, info: &SceneInfo, hits: u64) -> Vec<Measurement<'a>> {
        let mut measurements = Vec::new();
        for &threads in &self.threads {
            for (engine, kernel, settings) in &self.settings {
                let shrink = match *engine {
                    ORACLE => ORACLE_SHRINK,
                    _ => 1,
                };
                let settings = Settings {
                    width: settings.width.div_ceil(shrink),
                    height: settings.height.div_ceil(shrink),
                    threads,
                    ..settings.clone()
                };
                let mut row = row(info, FRAME, engine, kernel, threads);
                row.hits = hits;
                let sampler = self.sampler(engine, settings);
                measurements.push(Measurement::new(row, 1, sampler));
            }
        }
        measurements
    }

    /// Renders frames. Each takes long enough for what its caches hold before not to matter.
    fn sampler(&self, engine: &str, settings: Settings) -> SampleFn<'a> {
        let (scene, tree) = (self.trees.scene, self.tree(engine));
        Box::new(move |passes, threads, pin| {
            let settings = Settings {
                pin,
                ..settings.clone()
            };
            let (mut timing, mut rays) = (Timing::default(), 0);
            for _ in 0..passes {
                // An error is impossible: the frame was rendered before, for comparison.
                if let Ok(frame) = render_with(scene, tree, &settings, &Control::default()) {
                    rays = frame.stats.rays.total();
                    timing.add_frame(frame.seconds, &frame.tile_seconds, threads);
                }
            }
            (timing, rays)
        })
    }
}

/// The first pixel whose radiance or primary hit differs in any bit.
fn first_difference(a: &Frame, b: &Frame) -> Option<[u32; 2]> {
    let (a, b) = (&a.film, &b.film);
    let width = a.width as usize;
    let differs = |i: &usize| {
        let planes = a.planes.iter().zip(&b.planes);
        let mut radiance = planes.map(|(p, q)| p[*i].to_bits() != q[*i].to_bits());
        let hit = |film: &phalanx_render::Film| {
            let hits = film.hits.as_ref()?;
            let [t, u, v] = [hits.t[*i], hits.u[*i], hits.v[*i]].map(f32::to_bits);
            Some((hits.prim_id[*i], t, u, v))
        };
        radiance.any(|d| d) || hit(a) != hit(b)
    };
    let first = (0..a.planes[0].len()).find(differs)?;
    Some([(first % width) as u32, (first / width) as u32])
}
