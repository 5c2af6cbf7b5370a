//! Bands of a picture, filled by workers at the same time, and taken from the top as soon as they
//! are complete, while workers continue below.

use super::stored_tiles::StoredTiles;
use phalanx_render::frame::{Aovs, Settings, Tile};
use phalanx_scene::film::{Film, TileBuffer, TileSink};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Approximate number of pixels of all bands that are filled at the same time. However slow a tile
/// is, all threads have work below it for a fifth of a second.
const OPEN_PIXELS: u64 = 1 << 22;

/// Maximum number of bands that are filled at the same time; at least two.
pub fn open_bands(bands: &[Tile]) -> usize {
    let pixels = bands.first().map_or(1, Tile::pixels);
    (OPEN_PIXELS / pixels.max(1)).max(2) as usize
}

/// Bands of a window from the top, some of which are open: in memory, and being filled.
pub(super) struct OpenBands<'a> {
    bands: &'a [Tile],
    /// Tiles of each band that are still to be rendered when it is opened.
    missing: Vec<usize>,
    /// Tiles that were finished before, in the order of the bands.
    finished: &'a [Vec<Tile>],
    record_hits: bool,
    /// Finished tiles, and the reason why one could not be stored or read.
    pub(super) stored: StoredTiles<'a>,
    state: Mutex<OpenState>,
    changed: Condvar,
}

/// State shared by workers and the consumer of bands.
#[derive(Default)]
struct OpenState {
    /// Bands that have been taken.
    taken: usize,
    /// The bands after those.
    open: VecDeque<Arc<OpenBand>>,
    /// True if there are no further tiles.
    ended: bool,
    /// True if no further band will be taken.
    closed: bool,
    /// Time that workers waited for bands to be taken.
    waited: Duration,
}

struct OpenBand {
    place: Tile,
    film: Mutex<Film>,
    /// Tiles that are still to come.
    missing: AtomicUsize,
}

/// Interval at which waiting threads check whether the render has been stopped.
const POLL: Duration = Duration::from_millis(20);

impl<'a> OpenBands<'a> {
    pub(super) fn new(
        bands: &'a [Tile],
        (finished, missing): (&'a [Vec<Tile>], Vec<usize>),
        settings: &Settings,
        stored: StoredTiles<'a>,
    ) -> OpenBands<'a> {
        OpenBands {
            bands,
            missing,
            finished,
            record_hits: settings.record_hits,
            stored,
            state: Mutex::default(),
            changed: Condvar::new(),
        }
    }

    /// Passes all bands to `take`, until it does not want the next, or there is none. Returns
    /// whether it wanted all of them.
    pub(super) fn give_all(&self, take: &mut impl FnMut(Film) -> bool) -> bool {
        for _ in self.bands {
            let Some(film) = self.take_next() else {
                break;
            };
            if !take(film) {
                return false;
            }
        }
        true
    }

    /// The next band from the top, once it is complete; `None` if it will not be.
    fn take_next(&self) -> Option<Film> {
        let mut state = self.lock();
        let next = state.taken;
        // A band that was finished before is not opened by any worker.
        if self.missing[next] == 0 && state.open.is_empty() {
            self.open_next(&mut state);
        }
        loop {
            let first = state.open.front();
            if let Some(band) = first.filter(|band| band.missing.load(SeqCst) == 0).cloned() {
                state.open.pop_front();
                state.taken += 1;
                self.changed.notify_all();
                let mut film = band.film.lock().unwrap_or_else(PoisonError::into_inner);
                return Some(std::mem::replace(&mut film, Film::new(0, 0, false)));
            }
            if state.ended {
                return None;
            }
            state = self.wait(state);
        }
    }

    /// Marks the end of the tiles.
    pub(super) fn end(&self) {
        self.lock().ended = true;
        self.changed.notify_all();
    }

    /// Marks that no further band will be taken.
    pub(super) fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
    }

    /// Returns true if every band has been taken.
    pub(super) fn all_taken(&self) -> bool {
        self.lock().taken == self.bands.len()
    }

    /// Seconds that workers waited for bands to be taken, of all workers together.
    pub(super) fn waited(&self) -> f64 {
        self.lock().waited.as_secs_f64()
    }

    /// The band of a tile, opened as soon as there is room for it; `None` if that will not be.
    fn band_of(&self, tile: Tile) -> Option<Arc<OpenBand>> {
        let index = self.bands.partition_point(|band| band.y <= tile.y) - 1;
        let mut state = self.lock();
        let most = open_bands(self.bands);
        while index >= state.taken + most {
            if state.closed || self.stored.is_stopped() {
                return None;
            }
            let start = Instant::now();
            state = self.wait(state);
            state.waited += start.elapsed();
        }
        while state.taken + state.open.len() <= index {
            self.open_next(&mut state);
        }
        let first = state.taken;
        state.open.get(index - first).cloned()
    }

    /// Opens the first band that is not open yet, with the tiles that were finished before.
    fn open_next(&self, state: &mut OpenState) {
        let index = state.taken + state.open.len();
        let place = self.bands[index];
        let film = Film::new(place.width, place.height, self.record_hits);
        let mut film = film.with_aovs(self.stored.aovs());
        let outputs = self.stored.outputs;
        let mut missing = self.missing[index];
        if let Some(Err(error)) = outputs.file.map(|file| file.restore(place, &mut film)) {
            self.stored.fail(error);
            // It will never be complete.
            missing = usize::MAX;
        }
        if let Some(thumbnail) = outputs.thumbnail {
            let finished = self.finished[index].iter();
            finished.for_each(|tile| thumbnail.add_from(&film, place, *tile));
        }
        state.open.push_back(Arc::new(OpenBand {
            place,
            film: Mutex::new(film),
            missing: AtomicUsize::new(missing),
        }));
    }

    fn lock(&self) -> MutexGuard<'_, OpenState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'s>(&self, state: MutexGuard<'s, OpenState>) -> MutexGuard<'s, OpenState> {
        let waited = self.changed.wait_timeout(state, POLL);
        waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

impl TileSink for OpenBands<'_> {
    fn records_hits(&self) -> bool {
        self.record_hits
    }

    fn aovs(&self) -> Aovs {
        self.stored.aovs()
    }

    fn put(&self, tile: Tile, pixels: &TileBuffer) {
        self.stored.put(tile, pixels);
        let Some(band) = self.band_of(tile) else {
            return;
        };
        let mut film = band.film.lock().unwrap_or_else(PoisonError::into_inner);
        film.put(band.place, tile, pixels);
        drop(film);
        if band.missing.fetch_sub(1, SeqCst) == 1 {
            // Under the lock, so that no thread begins to wait after it has just checked.
            let _state = self.lock();
            self.changed.notify_all();
        }
    }

    fn is_closed(&self) -> bool {
        self.lock().closed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TileOutputs;
    use phalanx_render::frame::Control;

    /// Checks that stopping while workers wait for a band to be taken only loses the picture: no
    /// thread waits forever, and the bands are incomplete.
    #[test]
    fn a_stop_ends_those_who_wait() {
        let bands = [0, 1, 2].map(|k| Tile {
            y: 1024 * k,
            ..Tile::whole(1 << 16, 1024)
        });
        let (control, settings) = (Control::default(), Settings::of(&Default::default()));
        let stored = StoredTiles::new(TileOutputs::default(), Aovs::default(), &control);
        let there = [const { Vec::new() }; 3];
        let open = OpenBands::new(&bands, (&there, vec![1; 3]), &settings, stored);
        let tile = |y: u32| Tile {
            y,
            ..Tile::whole(8, 8)
        };
        let mut pixels = TileBuffer::new(false);
        pixels.fit(tile(0));
        std::thread::scope(|scope| {
            // Two bands are open, and the first is not complete.
            scope.spawn(|| open.put(tile(2048), &pixels));
            std::thread::sleep(2 * POLL);
            control
                .stop
                .store(true, std::sync::atomic::Ordering::Relaxed);
        });
        open.end();
        assert!(open.give_all(&mut |_| true) && !open.all_taken());
    }

    #[test]
    fn few_bands_are_open_and_never_fewer_than_two() {
        for (width, height, expected) in [(1 << 10, 1 << 8, 16), (1 << 16, 1 << 10, 2)] {
            let bands = [Tile::whole(width, height); 40];
            assert_eq!(open_bands(&bands), expected);
        }
        assert!(open_bands(&[]) >= 2);
    }
}
