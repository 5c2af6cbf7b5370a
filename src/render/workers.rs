//! Workers that take tiles until none are left. This is the only file that names core_affinity.

use super::stats::RenderStats;
use phalanx_scene::film::Tile;
use phalanx_scene::film::{TileBuffer, TileSink};
use phalanx_trace::stopwatch::Stopwatch;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

/// Binding of workers to cores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoreAffinity {
    /// No binding: the system places the workers.
    None,
    /// Binding of worker k to the k-th core of the process's affinity mask.
    Cores,
}

/// The cores to which workers are bound, if any.
pub struct Cores(Vec<core_affinity::CoreId>);

impl Cores {
    /// The cores of the process's affinity mask. Call this before any thread is bound: the children
    /// of a bound thread would see only one core.
    pub fn here(pin: CoreAffinity) -> Cores {
        Cores(match pin {
            CoreAffinity::None => Vec::new(),
            CoreAffinity::Cores => core_affinity::get_core_ids().unwrap_or_default(),
        })
    }

    /// Binds the calling thread, which is worker `worker`. This is best effort: if the system
    /// refuses, the thread stays unbound.
    pub fn bind(&self, worker: usize) {
        if let Some(&core) = self.0.get(worker % self.0.len().max(1)) {
            core_affinity::set_for_current(core);
        }
    }
}

/// Progress and stop flag, shared with a running render.
#[derive(Debug, Default)]
pub struct Control {
    /// Set to stop: workers leave, those of the packet engine within a second, without their tile.
    pub stop: AtomicBool,
    /// Pixels finished.
    pub pixels: AtomicU64,
    /// Pixels that were finished before the render began; `pixels` includes them.
    pub pixels_resumed: AtomicU64,
    /// Rays traced so far, all kinds.
    pub rays: AtomicU64,
}

/// The stop flag of renderers that nobody stops.
pub(super) static NEVER_SET: AtomicBool = AtomicBool::new(false);

/// The render was stopped through [`Control::stop`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the render was interrupted")]
pub struct Interrupted;

/// One worker's renderer of tiles, which counts its work.
pub trait TileRenderer {
    /// Renders every pixel of a tile; `pixels` are of its size, black and without hits. Once the
    /// render is to stop, they may be incomplete.
    fn render_tile(&mut self, tile: Tile, pixels: &mut TileBuffer);
    /// The work since the renderer was made.
    fn stats(&self) -> RenderStats;
    /// The time that tracing rays took since the renderer was made, if it is measured.
    fn tracing(&self) -> Duration {
        Duration::ZERO
    }
}

/// Totals of rendering all tiles.
#[derive(Clone, Debug, Default)]
pub struct RenderedTiles {
    /// Work counters.
    pub stats: RenderStats,
    /// Seconds that each tile took the worker that rendered it.
    pub tile_seconds: Vec<f64>,
    /// Time that tracing rays took, without shading: the sum over all workers.
    pub tracing: Duration,
}

/// Renders all tiles on `threads` workers, each with its own renderer from `renderer`, and puts
/// them into the sink.
///
/// # Errors
/// [`Interrupted`] if `control.stop` was set before the last tile was finished.
pub fn render_on_workers<P: TileRenderer>(
    tiles: &[Tile],
    sink: &dyn TileSink,
    threads: usize,
    pin: CoreAffinity,
    control: &Control,
    renderer: impl Fn() -> P + Sync,
) -> Result<RenderedTiles, Interrupted> {
    let cores = Cores::here(pin);
    let next = AtomicUsize::new(0);
    let work = |worker: Option<usize>| {
        if let Some(worker) = worker {
            cores.bind(worker);
        }
        let (mut renderer, mut pixels) = (
            renderer(),
            TileBuffer::new(sink.records_hits()).with_aovs(sink.aovs()),
        );
        let mut counted = 0;
        let mut took = Vec::new();
        while !control.stop.load(Relaxed) && !sink.is_closed() {
            let k = next.fetch_add(1, Relaxed);
            let Some(&tile) = tiles.get(k) else {
                break;
            };
            let start = Stopwatch::start();
            pixels.fit(tile);
            renderer.render_tile(tile, &mut pixels);
            if control.stop.load(Relaxed) {
                break;
            }
            pixels.unify_nans();
            sink.put(tile, &pixels);
            took.push((k, start.elapsed().as_secs_f64()));
            let rays = renderer.stats().rays.total();
            control.rays.fetch_add(rays - counted, Relaxed);
            control.pixels.fetch_add(tile.pixels(), Relaxed);
            counted = rays;
        }
        (renderer.stats(), renderer.tracing(), took)
    };
    let work = &work;
    let mut rendered = RenderedTiles {
        tile_seconds: vec![0.0; tiles.len()],
        ..RenderedTiles::default()
    };
    let mut finished = 0;
    let mut add = |(stats, tracing, took): (RenderStats, Duration, Vec<(usize, f64)>)| {
        finished += took.len();
        rendered.stats.add(&stats);
        rendered.tracing += tracing;
        for (k, seconds) in took {
            rendered.tile_seconds[k] = seconds;
        }
    };
    std::thread::scope(|scope| {
        let spawn = |k| std::thread::Builder::new().spawn_scoped(scope, move || work(Some(k)));
        // If the system has no more threads, the existing ones do the rest; at worst only this one.
        let handles: Vec<_> = (0..threads.max(1)).map_while(|k| spawn(k).ok()).collect();
        if handles.is_empty() {
            add(work(None));
        }
        for handle in handles {
            match handle.join() {
                Ok(done) => add(done),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
    });
    if control.stop.load(Relaxed) && finished < tiles.len() {
        return Err(Interrupted);
    }
    Ok(rendered)
}
