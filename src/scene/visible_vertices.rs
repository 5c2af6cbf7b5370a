//! Vertices of visible triangles, each once: their bounds, and other maxima over all of them. A
//! mesh has six times as many corners as vertices, but a file may have vertices that no triangle
//! uses, and those do not count.

use super::{Bounds, PrimKind, Scene, thread_count, workers};
use glam::Vec3;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Vertices that visible triangles use, one bit each.
pub struct VisibleVertices {
    words: Vec<u64>,
    threads: usize,
}

/// Number of primitives that a thread examines at a time.
const PRIMS: u32 = 1 << 16;

/// Number of words of 64 vertices that a thread examines at a time.
const WORDS: usize = 1 << 8;

const BITS: usize = u64::BITS as usize;

impl VisibleVertices {
    /// The vertices of the scene's triangles that are not only in instances, found by this many
    /// threads; 0 is one per CPU.
    pub fn of(scene: &Scene, threads: usize) -> VisibleVertices {
        let threads = thread_count(threads);
        let count = scene.triangles.vertices.len().div_ceil(BITS);
        let words: Vec<AtomicU64> = (0..count).map(|_| AtomicU64::new(0)).collect();
        let runs = match scene.triangles.len() {
            0 => Vec::new(),
            _ => blocks_of_prims(scene),
        };
        workers::map(threads, runs, |run| mark(scene, run, &words));
        VisibleVertices {
            words: words.into_iter().map(AtomicU64::into_inner).collect(),
            threads,
        }
    }

    /// Bounds of everything visible. A scene of nothing but triangles may have millions, so several
    /// threads compute them.
    pub fn bounds(&self, scene: &Scene) -> Bounds {
        let t = &scene.triangles;
        if t.len() != scene.prim_count() || !scene.meshes.is_empty() {
            return scene.bounds();
        }
        let [x, y, z] = t.vertices.parts();
        let blocks = self.map(|block| {
            let mut bounds = [(f32::INFINITY, f32::NEG_INFINITY); 3];
            block.for_each(|vertex| {
                for (column, (lo, hi)) in [x, y, z].into_iter().zip(&mut bounds) {
                    // Comparisons, not f32::min: no coordinate is NaN here, and they take a third
                    // of the instructions.
                    let c = column[vertex];
                    *lo = if c < *lo { c } else { *lo };
                    *hi = if c > *hi { c } else { *hi };
                }
            });
            let [x, y, z] = bounds;
            Bounds::new(Vec3::new(x.0, y.0, z.0), Vec3::new(x.1, y.1, z.1))
        });
        blocks.into_iter().fold(Bounds::EMPTY, Bounds::union)
    }

    /// Calls `work` with each block of vertices, on several threads. The results are in the
    /// vertices' order.
    pub fn map<R: Send>(&self, work: impl Fn(VertexBlock) -> R + Sync) -> Vec<R> {
        let blocks = (0..).step_by(WORDS).zip(self.words.chunks(WORDS));
        let blocks = blocks.map(|(first, words)| VertexBlock { first, words });
        workers::map(self.threads, blocks.collect(), work)
    }

    /// Number of threads to use.
    pub fn threads(&self) -> usize {
        self.threads
    }
}

/// Some of the visible vertices.
pub struct VertexBlock<'v> {
    /// Index of the first word.
    first: usize,
    words: &'v [u64],
}

impl VertexBlock<'_> {
    /// Calls `work` with the index of each vertex.
    #[inline]
    pub fn for_each(&self, mut work: impl FnMut(usize)) {
        for (word, &bits) in (self.first..).zip(self.words) {
            let first = word * BITS;
            if bits == u64::MAX {
                for vertex in first..first + BITS {
                    work(vertex);
                }
                continue;
            }
            let mut left = bits;
            while left != 0 {
                work(first + left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
    }
}

/// Primitives in the world, in blocks for threads.
pub fn blocks_of_prims(scene: &Scene) -> Vec<Range<u32>> {
    let cut = |run: Range<u32>| {
        let firsts = run.clone().step_by(PRIMS as usize);
        firsts.map(move |first| first..run.end.min(first.saturating_add(PRIMS)))
    };
    scene.world_runs().into_iter().flat_map(cut).collect()
}

fn mark(scene: &Scene, run: Range<u32>, words: &[AtomicU64]) {
    let prims = &scene.prims[run.start as usize..run.end as usize];
    for prim in prims.iter().filter(|p| p.kind() == PrimKind::Triangle) {
        for vertex in scene.triangles.corners[prim.index()] {
            let (word, bit) = (
                &words[vertex as usize / BITS],
                1 << (vertex as usize % BITS),
            );
            // Most corners are of a vertex that is marked already, and reading is cheaper.
            if word.load(Relaxed) & bit == 0 {
                word.fetch_or(bit, Relaxed);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_those_of_the_triangles() {
        let mut scene = Scene::default();
        for k in 0..200_000 {
            let position = |j: u32| Vec3::new((k * j) as f32, (k % 77) as f32 - 3.0, -(j as f32));
            scene.add_triangle([position(1), position(2), position(3)], None, 0);
        }
        // A vertex that no triangle uses does not count.
        scene.triangles.vertices.push(Vec3::splat(1e9));
        for threads in [1, 3] {
            let bounds = VisibleVertices::of(&scene, threads).bounds(&scene);
            let expected = scene.bounds();
            assert_eq!((bounds.lo, bounds.hi), (expected.lo, expected.hi));
        }
    }

    #[test]
    fn vertices_of_triangles_in_the_world_are_visible_once_each() {
        let mut scene = Scene::default();
        let mut corner = 0.0;
        let mut add = |scene: &mut Scene| {
            let corners = [0.0, 1.0, 2.0].map(|k| Vec3::splat(corner + k));
            scene.add_triangle(corners, None, 0);
            corner += 3.0;
        };
        (0..50).for_each(|_| add(&mut scene));
        scene.add_sphere(Vec3::ZERO, 1.0, 0);
        let mesh = scene.begin_mesh();
        (0..50).for_each(|_| add(&mut scene));
        scene.end_mesh(mesh);
        (0..50).for_each(|_| add(&mut scene));
        scene.triangles.corners[3] = scene.triangles.corners[4];
        let visible = VisibleVertices::of(&scene, 2).map(|block| {
            let mut vertices = Vec::new();
            block.for_each(|vertex| vertices.push(vertex));
            vertices
        });
        let expected = (0..9).chain(12..150).chain(300..450);
        assert!(visible.concat().into_iter().eq(expected));
    }
}
