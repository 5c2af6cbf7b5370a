//! Calls that should not be made: each is refused in words or answered, and nothing is written that
//! was not asked for.

use crate::full_or::full_or;
use crate::rng::Rng;
use crate::world::{self, NO_COLUMN, NO_HITS, NO_ROWS, TwinScenes, check, mesh, no_lists};
use phalanx::Ray;
use phalanx_c::batch::*;
use phalanx_c::columns::PhxColumn;
use phalanx_c::hits::PhxHits;
use phalanx_c::ray::*;
use phalanx_c::rows::PhxRows;
use phalanx_c::scene::*;
use phalanx_c::status::{PhxStatus, phx_error_message};
use phalanx_c::table::Opaque;
use phalanx_c::tree::*;
use std::ffi::CStr;
use std::ptr::{null, null_mut, without_provenance_mut};

/// Bytes before and behind the memory that calls are given.
const EDGE: usize = 256;
/// Memory of the calls.
const ROOM: usize = 4096;

/// Memory between edges that must stay as they are.
struct Arena(Vec<u64>);

impl Arena {
    fn new() -> Arena {
        Arena(vec![0x5a5a_5a5a_5a5a_5a5a; (ROOM + 2 * EDGE) / 8])
    }

    /// An address within the room, aligned or not, with `bytes` behind it.
    fn place(&mut self, rng: &mut Rng, bytes: usize) -> *mut u8 {
        let step = if rng.once_in(8) { 1 } else { 8 };
        let offset = rng.below((ROOM - bytes) / step + 1) * step;
        // SAFETY: within the vector.
        unsafe { self.0.as_mut_ptr().cast::<u8>().add(EDGE + offset) }
    }

    fn check(&self) {
        let edge = EDGE / 8;
        let edges = self.0[..edge].iter().chain(&self.0[self.0.len() - edge..]);
        assert!(edges.into_iter().all(|&word| word == 0x5a5a_5a5a_5a5a_5a5a));
    }
}

/// A pointer of a call: null, or into the arena.
fn pointer<T>(arena: &mut Arena, rng: &mut Rng) -> *mut T {
    match rng.once_in(10) {
        true => null_mut(),
        false => arena.place(rng, size_of::<T>()).cast(),
    }
}

/// Rows of up to `count` numbers, with a stride that need not fit, within the arena.
fn rows(arena: &mut Arena, rng: &mut Rng, count: usize, row: usize) -> (*mut u8, usize) {
    let stride = rng.pick(&[
        0,
        1,
        2,
        4,
        8,
        12,
        16,
        24,
        28,
        32,
        64,
        11_usize.wrapping_neg(),
    ]);
    let bytes = (count.max(1) - 1)
        .saturating_mul(stride)
        .saturating_add(row);
    if rng.once_in(12) || bytes > ROOM {
        return (null_mut(), stride);
    }
    (arena.place(rng, bytes), stride)
}

fn input(arena: &mut Arena, rng: &mut Rng, count: usize, row: usize) -> PhxRows {
    let (data, stride) = rows(arena, rng, count, row);
    PhxRows {
        data: data.cast(),
        stride,
    }
}

fn output(arena: &mut Arena, rng: &mut Rng, count: usize, row: usize) -> PhxColumn {
    let (data, stride) = rows(arena, rng, count, row);
    let data = if rng.once_in(3) { null_mut() } else { data.cast() };
    let miss = rng.pick(&[0, 1, 2, 0, 1, 2, 3, -1]);
    PhxColumn {
        data,
        stride,
        miss,
        reserved: u32::from(rng.once_in(50)),
    }
}

/// A size that a structure says.
fn size<T>(rng: &mut Rng) -> usize {
    if rng.once_in(20) { rng.below(200) } else { size_of::<T>() }
}

/// Refusals have words.
fn look(status: PhxStatus) -> bool {
    // SAFETY: the library's text.
    let words = unsafe { CStr::from_ptr(phx_error_message()) };
    let is_refused = status != PhxStatus::Ok;
    assert!(!is_refused || !words.is_empty(), "{status:?}");
    assert_ne!(status, PhxStatus::Internal, "{words:?}");
    is_refused
}

/// One call by chance; returns true if it was refused.
fn call(arena: &mut Arena, rng: &mut Rng, handles: &[*mut Opaque]) -> bool {
    let handle = rng.pick(handles);
    let count = rng.below(12);
    let (batch, rays) = (
        PhxBatch {
            size: size::<PhxBatch>(rng),
            tnear: input(arena, rng, count, 4),
            mask: input(arena, rng, count, 4),
            ignore: input(arena, rng, count, 4),
            accept: None,
            user: null_mut(),
            threads: rng.below(3) as u32,
            reserved: 0,
        },
        PhxRays {
            size: size::<PhxRays>(rng),
            count,
            origin: input(arena, rng, count, 12),
            direction: input(arena, rng, count, 12),
            tmax: input(arena, rng, count, 4),
        },
    );
    let rays = if rng.once_in(20) { null() } else { &raw const rays };
    let batch = if rng.once_in(2) { null() } else { &raw const batch };
    // SAFETY: every pointer is null, or has as many bytes behind it as the call may touch.
    look(unsafe {
        match rng.below(14) {
            0 => phx_intersect(handle, pointer(arena, rng), null(), pointer(arena, rng)),
            1 => phx_occluded(handle, pointer(arena, rng), null(), pointer(arena, rng)),
            2 => {
                let hits = arena.place(rng, 3 * size_of::<PhxHit>()).cast();
                phx_all_hits(
                    handle,
                    pointer(arena, rng),
                    null(),
                    hits,
                    3,
                    pointer(arena, rng),
                )
            }
            3 => phx_refine(
                handle,
                pointer(arena, rng),
                pointer(arena, rng),
                pointer(arena, rng),
                pointer(arena, rng),
            ),
            4 | 5 => {
                let hits = PhxHits {
                    size: size::<PhxHits>(rng),
                    t: output(arena, rng, count, 4),
                    u: output(arena, rng, count, 4),
                    v: output(arena, rng, count, 4),
                    prim_id: output(arena, rng, count, 4),
                    geom_id: output(arena, rng, count, 4),
                    local_prim_id: output(arena, rng, count, 4),
                    inst_id: output(arena, rng, count, 4),
                    normal: output(arena, rng, count, 12),
                    scene: rng.pick(handles).cast_const(),
                };
                phx_intersect_batch(handle, rays, batch, &hits)
            }
            6 => phx_occluded_batch(handle, rays, batch, output(arena, rng, count, 1)),
            7 => phx_count_batch(handle, rays, batch, output(arena, rng, count, 4)),
            8 => {
                let mut lists = no_lists();
                lists.size = size::<PhxHitLists>(rng);
                lists.memory = if rng.once_in(9) { handle } else { null_mut() };
                look(phx_all_hits_batch(handle, rays, batch, &mut lists));
                phx_hit_lists_free(&mut lists)
            }
            9 => {
                let given = PhxMesh {
                    size: size::<PhxMesh>(rng),
                    vertices: input(arena, rng, count, 12),
                    vertex_count: count,
                    triangles: input(arena, rng, count, 12),
                    triangle_count: count,
                };
                phx_scene_set_vertices(handle, rng.below(60) as u32, given.vertices, count);
                phx_scene_add_mesh(handle, &given, pointer(arena, rng))
            }
            10 => phx_scene_get_name(
                handle,
                rng.bits() as u32,
                arena.place(rng, 16).cast(),
                16,
                pointer(arena, rng),
            ),
            11 => phx_scene_set_transform(handle, rng.below(60) as u32, pointer(arena, rng)),
            12 => phx_scene_get_bounds(handle, pointer(arena, rng)),
            _ => phx_tree_get_first_prim(handle, rng.below(60) as u32, pointer(arena, rng)),
        }
    })
}

#[test]
fn calls_by_chance_are_refused_in_words_or_answered() {
    let (world, gone) = (TwinScenes::new(7), TwinScenes::new(8));
    let stale = [gone.scene, gone.tree];
    drop(gone);
    let mut handles = vec![null_mut(), stale[0], stale[1]];
    handles.extend(
        [0, 1, 0x53, 0x0100_0053, 0x7fff_dead_beef, usize::MAX].map(without_provenance_mut),
    );
    handles.extend([world.scene, world.tree].repeat(9));
    let (mut arena, mut rng) = (Arena::new(), Rng::new(9));
    let calls = full_or(1_000_000, 100_000);
    let mut refused = 0;
    for _ in 0..calls {
        if rng.once_in(4) {
            // Numbers of all kinds, many of them finite.
            let (word, number) = (
                rng.below(arena.0.len() - 2 * EDGE / 8) + EDGE / 8,
                rng.bits(),
            );
            let pair = u64::from(rng.range(-9.0, 9.0).to_bits()) << 32
                | u64::from(rng.range(-9.0, 9.0).to_bits());
            arena.0[word] = if rng.once_in(3) { number } else { pair };
        }
        let before = arena.0.clone();
        let is_refused = call(&mut arena, &mut rng, &handles);
        assert!(!is_refused || arena.0 == before, "a refusal writes nothing");
        refused += usize::from(is_refused);
        arena.check();
    }
    assert!(
        refused > calls / 4 && refused < calls * 9 / 10,
        "{refused} of {calls}"
    );
}

#[test]
fn handles_of_what_is_gone_are_refused() {
    let world = TwinScenes::new(10);
    let (scene, tree) = (world.scene, world.tree);
    assert_eq!(phx_tree_destroy(scene), PhxStatus::Handle);
    assert_eq!(phx_scene_destroy(tree), PhxStatus::Handle);
    drop(world);
    assert_eq!(phx_tree_destroy(tree), PhxStatus::Handle);
    assert_eq!(phx_scene_destroy(scene), PhxStatus::Handle);
    assert_eq!(phx_tree_destroy(null_mut()), PhxStatus::Ok);
    let mut again = null_mut();
    // SAFETY: a place of this function's.
    check(unsafe { phx_scene_create_for(phx_version(), &mut again) });
    assert_ne!(again, scene);
    check(phx_scene_destroy(again));
}

#[test]
fn what_does_not_fit_is_refused_in_words() {
    let world = TwinScenes::new(11);
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, f32::NAN, 0.0]];
    let words = |status, kind: PhxStatus, expected: &str| {
        // SAFETY: the library's text.
        let words = unsafe { CStr::from_ptr(phx_error_message()) }
            .to_str()
            .unwrap();
        assert!(
            status == kind && words.contains(expected),
            "{status:?}: {words}"
        );
    };
    let mut id = 5;
    // SAFETY: all is this test's.
    unsafe {
        let nan = phx_scene_add_mesh(world.scene, &mesh(&corners, &[[0, 1, 2]]), &mut id);
        words(nan, PhxStatus::Geometry, "vertex 2 is not finite");
        let wrong = phx_scene_add_mesh(world.scene, &mesh(&corners[..2], &[[0, 1, 2]]), &mut id);
        words(
            wrong,
            PhxStatus::Geometry,
            "names vertex 2, and there are 2",
        );
        let huge = PhxMesh {
            vertex_count: 1 << 60,
            ..mesh(&corners, &[[0, 1, 2]])
        };
        let huge = phx_scene_add_mesh(world.scene, &huge, &mut id);
        words(huge, PhxStatus::Argument, "more than memory");
        let short = PhxMesh {
            size: 3,
            ..mesh(&corners, &[[0, 1, 2]])
        };
        let short = phx_scene_add_mesh(world.scene, &short, &mut id);
        words(short, PhxStatus::Argument, "phx_mesh.size is 3");
        // A flat array, whose elements were taken for rows.
        let flat = PhxMesh {
            vertices: PhxRows {
                data: corners.as_ptr().cast(),
                stride: 4,
            },
            ..mesh(&corners, &[[0, 1, 2]])
        };
        let flat = phx_scene_add_mesh(world.scene, &flat, &mut id);
        words(
            flat,
            PhxStatus::Argument,
            "vertices has a stride of 4, and rows of 12 bytes",
        );
        let ray = Ray::new([0.0; 3], [1.0; 3]);
        let (mut hit, mut zeros) = (MISS, std::mem::zeroed::<PhxFilter>());
        zeros.size = size_of::<PhxFilter>();
        let zeros = phx_intersect(world.tree, &ray, &zeros, &mut hit);
        words(zeros, PhxStatus::Argument, "phx_filter.mask is 0");
        let mut scene = null_mut();
        words(
            phx_scene_create_for(9_900, &mut scene),
            PhxStatus::Version,
            "of version 9900",
        );
        assert!(scene.is_null());
    }
    assert_eq!(id, 5, "nothing is written");
}

/// Threads that edit a scene, update its tree and cast batches, with no word between them: each
/// call is answered or refused, and the tree can follow the scene in the end.
#[test]
fn threads_that_share_a_scene_are_answered_or_refused() {
    let world = TwinScenes::new(14);
    let handles = [world.scene, world.tree].map(|handle| handle as usize);
    let rounds = full_or(30_000, 3_000);
    let share = |thread: u64| {
        let [scene, tree] = handles.map(|handle| handle as *mut Opaque);
        let mut rng = Rng::new(thread);
        let mut call = || match thread {
            0 => (edit_by_chance(scene, &mut rng), &[][..]),
            1 => {
                // SAFETY: nobody casts single rays.
                let update = unsafe { phx_tree_update(tree, scene, null(), null_mut()) };
                (update, &[PhxStatus::Busy][..])
            }
            _ => {
                let refusals = &[PhxStatus::Busy, PhxStatus::Argument][..];
                (cast_by_chance(scene, tree, &mut rng), refusals)
            }
        };
        let (mut calls, mut answered) = (0, 0);
        // Those that cast are answered once the others have ended, at the latest.
        while calls < rounds || answered == 0 {
            calls += 1;
            let (status, refusals) = call();
            answered += usize::from(!look(status));
            assert!(
                status == PhxStatus::Ok || refusals.contains(&status),
                "{status:?}"
            );
        }
        answered
    };
    std::thread::scope(|scope| {
        let threads = [0, 1, 2, 3].map(|thread| scope.spawn(move || share(thread)));
        let answered = threads.map(|thread| thread.join().expect("no panic"));
        assert_eq!(answered[0], rounds, "edits wait, and are not refused");
    });
    // SAFETY: the threads have ended.
    check(unsafe { phx_tree_update(world.tree, world.scene, null(), null_mut()) });
    check(cast_by_chance(world.scene, world.tree, &mut Rng::new(15)));
}

/// Moves an instance of the world.
fn edit_by_chance(scene: *mut Opaque, rng: &mut Rng) -> PhxStatus {
    let [x, y, z] = [(); 3].map(|()| f64::from(rng.range(-6.0, 6.0)));
    let map = [[0.2, 0.0, 0.0, x], [0.0, 0.2, 0.0, y], [0.0, 0.0, 0.2, z]];
    // SAFETY: a map of this function's.
    unsafe { phx_scene_set_transform(scene, 2 + rng.below(50) as u32, &map) }
}

/// A batch, some of which need the scene for normals.
fn cast_by_chance(scene: *mut Opaque, tree: *mut Opaque, rng: &mut Rng) -> PhxStatus {
    let origins: Vec<[f32; 3]> = (0..300).map(|_| rng.point(9.0).into()).collect();
    let (mut normals, mut distances) = (vec![[0.0f32; 3]; 300], vec![0.0f32; 300]);
    let rays = PhxRays {
        size: size_of::<PhxRays>(),
        count: 300,
        origin: world::rows(&origins),
        direction: world::rows(&origins),
        tmax: NO_ROWS,
    };
    let normal = PhxColumn {
        data: normals.as_mut_ptr().cast(),
        stride: 12,
        ..NO_COLUMN
    };
    let t = PhxColumn {
        data: distances.as_mut_ptr().cast(),
        stride: 4,
        ..NO_COLUMN
    };
    let hits = match rng.once_in(2) {
        true => PhxHits {
            normal,
            scene,
            ..NO_HITS
        },
        false => PhxHits { t, ..NO_HITS },
    };
    // SAFETY: all is this function's.
    unsafe { phx_intersect_batch(tree, &rays, null(), &hits) }
}
