//! Draws a scene in sections, on several threads, and passes it to its builder in order.
//!
//! Every thread runs the whole generator, but draws only the sections that it takes, in ascending
//! order, and counts the triangles of the others. Finished sections are cut into chunks in the
//! scene's order; chunks are prepared on all threads. The calling thread draws like the others, and
//! delivers the chunks. None of this depends on the number of threads.

use super::chunks::{MaterialChunk, OpenChunks};
use super::mesh_builder::{MeshBuilder, NONE, count, draw_sections};
use super::section::SceneSection;
use crate::builder::{DocumentMaterial, MaterialDesc, SceneBuilder};
use crate::mesh_slice::{Prepare, PreparedMesh};
use phalanx_scene::thread_count;
use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Number of triangles in a section, at least and at most. Large ones repeat fewer rows of corners.
const SECTION: (u64, u64) = (1 << 13, 1 << 17);
/// Number of sections of a scene, between these limits.
const SECTIONS: u64 = 512;

/// Draws the whole scene, on each thread. Not generic, so that threads are compiled once for all
/// scenes.
type SceneDrawing<'a> = dyn Fn(&mut MeshBuilder) + Sync + 'a;

/// Draws a scene of triangles into a builder with the materials of `palette`. If the builder only
/// needs counts, no points are computed.
pub(super) fn draw(
    builder: &mut dyn SceneBuilder,
    palette: impl IntoIterator<Item = DocumentMaterial>,
    scene: &SceneDrawing,
) {
    let triangles = count(scene);
    if builder.takes_count(triangles) {
        return;
    }
    let palette: Vec<_> = palette.into_iter().map(MaterialDesc::Document).collect();
    let prepare = builder.preparation();
    let threads = thread_count(builder.threads());
    let assembly = Assembly::new(triangles, threads, &*prepare);
    std::thread::scope(|scope| {
        for _ in 1..threads.min(assembly.sections) {
            let work = || assembly.work(scene, None);
            let thread = std::thread::Builder::new();
            // If the system has no more threads, the existing ones do the rest.
            if thread.spawn_scoped(scope, work).is_err() {
                break;
            }
        }
        let mut deliver = |ready: Ready| {
            builder.material(&palette[ready.material]);
            builder.prepared(ready.mesh);
        };
        assembly.work(scene, Some(&mut deliver));
    });
}

struct Assembly<'a> {
    prepare: &'a Prepare,
    threads: usize,
    /// Number of sections, and of the triangles in each.
    sections: usize,
    size: u64,
    state: Mutex<AssemblyState>,
    changed: Condvar,
}

#[derive(Default)]
struct AssemblyState {
    /// Number of sections that threads have taken, and of those that are cut into chunks.
    taken: usize,
    cut: usize,
    /// Sections that were finished before an earlier one.
    early: BTreeMap<usize, SceneSection>,
    open: OpenChunks,
    /// Chunks to be prepared; the first has the number `started`.
    waiting: VecDeque<MaterialChunk>,
    started: usize,
    /// Chunks to be delivered, by number; the next is `delivered`.
    ready: BTreeMap<usize, Ready>,
    delivered: usize,
    /// True after a panic: nothing more will come.
    stopped: bool,
}

/// A prepared chunk, to be delivered.
struct Ready {
    material: usize,
    mesh: PreparedMesh,
}

/// Passes a chunk to the builder, on the calling thread.
type Deliver<'a> = &'a mut dyn FnMut(Ready);

impl Assembly<'_> {
    fn new(triangles: u64, threads: usize, prepare: &Prepare) -> Assembly<'_> {
        let size = (triangles / SECTIONS).clamp(SECTION.0, SECTION.1);
        Assembly {
            prepare,
            threads,
            sections: triangles.div_ceil(size) as usize,
            size,
            state: Mutex::default(),
            changed: Condvar::new(),
        }
    }

    /// Draws and prepares until nothing is left; the thread that delivers also waits for others.
    fn work(&self, scene: &SceneDrawing, mut deliver: Option<Deliver>) {
        let _alarm = Alarm(self);
        let mut section = self.next(&mut deliver);
        let first = self.triangles(section);
        let mut next = |drawn| {
            if let Some(number) = section {
                self.finish(number, drawn);
            }
            section = self.next(&mut deliver);
            self.triangles(section)
        };
        draw_sections(first, &mut next, scene);
    }

    /// The triangles of a section.
    fn triangles(&self, section: Option<usize>) -> Range<u64> {
        let from = |number: usize| number as u64 * self.size;
        section.map_or(NONE, |number| from(number)..from(number + 1))
    }

    /// Takes the next section to be drawn, after delivering and preparing chunks; `None` if nothing
    /// is left to be done.
    fn next(&self, deliver: &mut Option<Deliver>) -> Option<usize> {
        let mut state = self.lock();
        while !state.stopped {
            let ready = deliver.is_some().then(|| state.take_ready()).flatten();
            if let (Some(ready), Some(deliver)) = (ready, deliver.as_mut()) {
                drop(state);
                deliver(ready);
                state = self.lock();
            } else if let Some(chunk) = state.waiting.pop_front() {
                let number = state.started;
                state.started += 1;
                drop(state);
                let ready = Ready {
                    material: chunk.material,
                    mesh: (self.prepare)(&chunk.parts(), chunk.first_vertex),
                };
                // Its sections are freed without the lock.
                drop(chunk);
                state = self.lock();
                state.ready.insert(number, ready);
                self.changed.notify_all();
            } else if state.taken < self.sections && state.has_room(self.threads) {
                state.taken += 1;
                return Some(state.taken - 1);
            } else if state.cut == self.sections
                && (deliver.is_none() || state.delivered == state.started)
            {
                return None;
            } else {
                let waited = self.changed.wait(state);
                state = waited.unwrap_or_else(PoisonError::into_inner);
            }
        }
        None
    }

    /// Takes in a drawn section. As soon as all before it are there, it is cut into chunks.
    fn finish(&self, number: usize, section: SceneSection) {
        let mut state = self.lock();
        let AssemblyState {
            cut,
            early,
            open,
            waiting,
            ..
        } = &mut *state;
        early.insert(number, section);
        while let Some(section) = early.remove(cut) {
            open.add(section, waiting);
            *cut += 1;
        }
        if *cut == self.sections {
            open.finish(waiting);
        }
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, AssemblyState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl AssemblyState {
    fn take_ready(&mut self) -> Option<Ready> {
        let ready = self.ready.remove(&self.delivered);
        self.delivered += usize::from(ready.is_some());
        ready
    }

    /// Returns true if the sections and chunks in memory leave room for another section.
    fn has_room(&self, threads: usize) -> bool {
        let chunks = self.started + self.waiting.len() - self.delivered;
        self.taken - self.cut < 2 * threads && chunks < 8 * threads
    }
}

/// Stops all threads if this one panics, for what it had taken will never come.
struct Alarm<'a>(&'a Assembly<'a>);

impl Drop for Alarm<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.lock().stopped = true;
            self.0.changed.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MemoryBuilder;
    use crate::modern::mesh_builder::Grid;
    use glam::DVec3;

    /// Otherwise the other threads would wait for the section that is lost.
    #[test]
    #[should_panic]
    fn a_panic_on_one_thread_ends_all() {
        let mut builder = MemoryBuilder::default();
        builder.threads = 3;
        draw(&mut builder, [DocumentMaterial::default()], &|mesh| {
            mesh.grid(Grid::open(500, 500), |_, j| {
                assert!(j != 100);
                DVec3::ZERO
            });
        });
    }
}
