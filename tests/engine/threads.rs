//! Whose threads the library uses: those of the pool it is called on, else of one that this process
//! has started. A forked process has the memory of its parent and none of its threads.

use crate::front_door::mixed_scene;
use phalanx::bvh::{BuildSettings, Bvh, Quality};
use phalanx::film::Aovs;
use phalanx::frame::{AccelRef, Control, Settings, render_with};
use phalanx::glam::{DAffine3, dvec3};
use phalanx::image::{
    Depth, Exposure, ImageFormat, PictureFile, PictureHeader, PictureReader, compare_pictures,
    save_bands,
};
use phalanx::{HitBuffer, Ray, RayBuffer, Scene, cache, standard};

/// Large enough for several threads in each stage of a build, and for blocks of a validation.
fn room() -> Scene {
    standard::scene(standard::parse_spec("standard:room:50k").unwrap(), 0).unwrap()
}

/// Bits of what a batch hits.
fn traced(bvh: &Bvh, threads: usize) -> Vec<u32> {
    let turn = |k: u32| [k * 7919 % 1000, k * 104_729 % 1000, k * 1_299_709 % 1000];
    let rays = (0..20_000).map(|k| {
        let direction = turn(k).map(|c| c as f32 / 500.0 - 1.0);
        Ray::new([0.1, 1.0, 0.2], direction)
    });
    let rays: RayBuffer = rays.collect();
    let mut hits = HitBuffer::new(rays.len());
    bvh.intersect_batch(&rays.columns(), &mut hits.columns(), threads)
        .unwrap();
    let hits = (0..rays.len()).map(|k| hits.get(k));
    hits.flat_map(|hit| hit.map_or([0; 2], |hit| [hit.t.to_bits(), hit.prim_id]))
        .collect()
}

/// A tree of every quality, one that follows an edit, one from a cache, and a picture.
fn everything(scene: &Scene) -> Vec<Vec<u32>> {
    scene.validate().unwrap();
    let mut answers = Vec::new();
    for (_, quality) in Quality::ALL {
        for threads in [0, 2] {
            let bvh = Bvh::build_with(scene, &BuildSettings { quality, threads });
            answers.push(traced(&bvh, threads));
        }
    }
    let mut moving = mixed_scene(7);
    let mut bvh = Bvh::build(&moving);
    bvh.build_wide(0);
    let place = DAffine3::from_translation(dvec3(0.1, 0.2, 0.3));
    moving.set_transform(2, place).unwrap();
    bvh.update(&moving);
    answers.push(traced(&bvh, 0));
    let bvh = Bvh::build(scene);
    let mut bytes = Vec::new();
    cache::write(&mut bytes, scene, &bvh).unwrap();
    let opened = cache::open_bytes("a".as_ref(), &bytes).unwrap();
    answers.push(traced(&opened.bvh, 0));
    // Several tiles and several blocks of rows for each thread.
    let settings = Settings {
        width: 320,
        height: 240,
        ..Settings::of(scene)
    };
    let packets = AccelRef::Packets(&bvh);
    let frame = render_with(scene, packets, &settings, &Control::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for format in [ImageFormat::Png, ImageFormat::Exr] {
        let path = folder.path().join("a");
        let file = PictureFile {
            width: frame.film.width,
            height: frame.film.height,
            crop: None,
            format,
            aovs: Aovs::NONE,
            origin: [0.0; 3],
            exposure: Exposure::from(scene.encoding),
            depth: Depth::Standard,
            header: PictureHeader::NONE,
        };
        save_bands(&path, &file, [Ok(frame.film.clone())]).unwrap();
        let mut readers = [0, 1].map(|_| PictureReader::open(&path).unwrap());
        let [a, b] = &mut readers;
        assert!(compare_pictures(a, b, None).unwrap().identical());
    }
    answers.push(frame.film.planes[0].iter().map(|c| c.to_bits()).collect());
    answers
}

/// Rayon starts its global pool once, whether asked to or because something ran outside of every
/// other pool.
#[test]
fn nothing_starts_rayons_global_pool() {
    everything(&room());
    let global = rayon::ThreadPoolBuilder::new().num_threads(1);
    assert!(global.build_global().is_ok(), "there was one already");
}

#[test]
fn a_pool_of_the_caller_may_do_everything() {
    let scene = room();
    let alone = everything(&scene);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3);
    let pool = pool.build().unwrap();
    assert!(pool.install(|| everything(&scene)) == alone);
    // Several of its workers at once, and threads outside of it.
    let (a, b) = pool.join(|| everything(&scene), || everything(&scene));
    assert!(a == alone && b == alone);
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(|| assert!(everything(&scene) == alone));
        }
    });
}

#[cfg(target_os = "linux")]
#[allow(unsafe_code, reason = "a fork has no safe interface")]
mod forks {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::Barrier;
    use std::time::{Duration, Instant};

    /// Time after which a child is taken to wait for a thread that it does not have.
    const LIMIT: Duration = Duration::from_secs(120);

    /// A forked process, ended if it is dropped.
    struct ForkedProcess(libc::pid_t);

    impl ForkedProcess {
        /// Forks a process that does some work, and succeeds unless that panics.
        fn start(work: impl FnOnce()) -> ForkedProcess {
            // SAFETY: the child is a copy of this thread alone. It does the work and ends, so that
            // nothing of the caller's is dropped twice.
            let pid = unsafe { libc::fork() };
            if pid == 0 {
                let done = catch_unwind(AssertUnwindSafe(work));
                // SAFETY: this ends the process at once.
                unsafe { libc::_exit(i32::from(done.is_err())) };
            }
            assert!(pid > 0, "no fork");
            ForkedProcess(pid)
        }

        /// The process's status once it has ended; `None` if it hangs.
        fn status(&self) -> Option<i32> {
            let start = Instant::now();
            while start.elapsed() < LIMIT {
                let mut status = 0;
                // SAFETY: the status is written to an integer that is lent for the call.
                let ended = unsafe { libc::waitpid(self.0, &mut status, libc::WNOHANG) };
                if ended == self.0 {
                    return Some(status);
                }
                std::thread::sleep(Duration::from_millis(5));
            }
            // SAFETY: it is a child that nobody has waited for, so that the number is still its.
            unsafe { libc::kill(self.0, libc::SIGKILL) };
            None
        }
    }

    #[test]
    fn a_child_and_its_child_answer_as_their_parent() {
        let scene = room();
        let expected = everything(&scene);
        let child = ForkedProcess::start(|| {
            assert!(everything(&scene) == expected);
            let grandchild = ForkedProcess::start(|| assert!(everything(&scene) == expected));
            assert_eq!(grandchild.status(), Some(0));
            assert!(everything(&scene) == expected);
        });
        assert_eq!(child.status(), Some(0));
        assert!(everything(&scene) == expected);
    }

    /// Forks while another thread does some work, at several moments of it.
    fn while_another_thread(work: impl FnOnce() + Send, child: impl Fn()) {
        let begun = Barrier::new(2);
        let children: Vec<ForkedProcess> = std::thread::scope(|scope| {
            let other = scope.spawn(|| {
                begun.wait();
                work();
            });
            begun.wait();
            let children = (0..8).map_while(|k| {
                std::thread::sleep(Duration::from_millis(k));
                (k < 2 || !other.is_finished()).then(|| ForkedProcess::start(&child))
            });
            children.collect()
        });
        for child in children {
            assert_eq!(child.status(), Some(0));
        }
    }

    #[test]
    fn a_fork_while_another_thread_builds() {
        let scene = room();
        let expected = traced(&Bvh::build(&scene), 0);
        let built = || traced(&Bvh::build(&scene), 0);
        while_another_thread(|| drop(built()), || assert!(built() == expected));
    }

    #[test]
    fn a_fork_while_another_thread_builds_the_wide_tree() {
        let scene = room();
        let expected = traced(&Bvh::build(&scene), 0);
        for _ in 0..4 {
            let bvh = Bvh::build(&scene);
            while_another_thread(
                || bvh.build_wide(1),
                || assert!(traced(&bvh, 0) == expected),
            );
        }
    }

    #[test]
    fn a_fork_while_another_thread_traces() {
        let scene = room();
        let bvh = Bvh::build(&scene);
        let expected = traced(&bvh, 0);
        while_another_thread(
            || (0..10).for_each(|_| drop(traced(&bvh, 2))),
            || assert!(traced(&bvh, 2) == expected && traced(&Bvh::build(&scene), 0) == expected),
        );
    }
}
