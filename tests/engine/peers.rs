//! Other tracers on our rays: their answers match ours, except where single precision leaves room.
//!
//! Embree is tested if it is found; `PHALANX_EMBREE` may name additional libraries, like `PATH`
//! names folders.

use crate::common::rays::{pack, toward};
use crate::common::rng::Rng;
use crate::common::scenes;
use bumpalo::Bump;
use glam::Vec3;
use phalanx::bvh::{BuildSettings, Bvh, Quality};
use phalanx::lanes::{LANES, LaneMask, Mask8, Vec3x8};
use phalanx::oracle::OracleRay;
use phalanx::packet::{HitPacket, NO_PRIM, RayQueue, packets_for};
use phalanx::peers::embree::{EmbreeError, EmbreeLibrary};
use phalanx::peers::{BenchEngine, PeerScene, RaySetRef, obvhs};
use phalanx::scene::{Cone, Scene};
use phalanx::trace::{Kernel, Traversal};
use std::path::Path;

/// Not a multiple of eight: the last packet is not full, and half of a packet of sixteen.
const RAYS: usize = 100_003;
/// Number of rays whose answer may differ, at edges and silhouettes.
const MOST_DIFFERENT: usize = RAYS / 10_000;

/// Every available Embree.
fn libraries() -> Vec<EmbreeLibrary> {
    let named = std::env::var_os("PHALANX_EMBREE").unwrap_or_default();
    let named = std::env::split_paths(&named).filter(|path| !path.as_os_str().is_empty());
    let mut libraries: Vec<EmbreeLibrary> = named
        .map(|path| EmbreeLibrary::open(Some(&path)).expect("a library that PHALANX_EMBREE names"))
        .collect();
    match EmbreeLibrary::open(None) {
        Ok(library) => libraries.push(library),
        Err(error) => println!("skipped: {error}"),
    }
    for library in &libraries {
        println!(
            "Embree {} ({})",
            library.version(),
            library.path().display()
        );
    }
    libraries
}

fn queue<'a>(arena: &'a Bump, rays: &[OracleRay]) -> RayQueue<'a> {
    let mut queue = RayQueue::with_capacity(arena, rays.len());
    for rays in rays.chunks(LANES) {
        let packet = pack(rays, |_| 0.0);
        let weight = Vec3x8::splat(1.0, 1.0, 1.0);
        let mask = Mask8::first(rays.len());
        queue.push(mask, packet.org, packet.dir, weight, &[0; LANES]);
    }
    queue
}

/// Triangles and spheres, mixed in the order of the file.
fn mixed(rng: &mut Rng, count: usize) -> Scene {
    let mut scene = scenes::bare();
    for _ in 0..count {
        add_one(&mut scene, rng);
    }
    scene
}

fn add_one(scene: &mut Scene, rng: &mut Rng) {
    let center = rng.point(1.0);
    if rng.once_in(3) {
        scene.add_sphere(center, rng.magnitude(-2.0, -1.0), 0);
    } else {
        let corners = [0; 3].map(|_| center + rng.point(0.1));
        scene.add_triangle(corners, None, 0);
    }
}

fn random_rays(rng: &mut Rng) -> Vec<OracleRay> {
    let mut eye = Vec3::ZERO;
    let ray = |k: usize| {
        // Some packets have a common origin, as primary rays.
        if k.is_multiple_of(LANES) || k.is_multiple_of(3) {
            eye = rng.point(2.0);
        }
        toward(eye, rng.point(1.0))
    };
    (0..RAYS).map(ray).collect()
}

/// Hits, ray by ray.
struct Answers {
    closest: Vec<(f32, u32)>,
    blocked: Vec<bool>,
}

impl Answers {
    fn of(hits: &[HitPacket], blocked: &[u8]) -> Answers {
        let lane = |ray: usize| (ray / LANES, ray % LANES);
        let hit = |ray| {
            let (packet, lane) = lane(ray);
            (hits[packet].t.lane(lane), hits[packet].prim_id.lane(lane))
        };
        let bit = |ray| {
            let (packet, lane) = lane(ray);
            blocked[packet] >> lane & 1 == 1
        };
        Answers {
            closest: (0..RAYS).map(hit).collect(),
            blocked: (0..RAYS).map(bit).collect(),
        }
    }

    fn ours(bvh: &Bvh, rays: &RayQueue, tmax: f32) -> Answers {
        let mut traversal = Traversal::new(bvh, Kernel::Auto);
        let mut hits = vec![HitPacket::miss(); rays.packets()];
        traversal.closest(rays, 0..rays.packets(), &mut hits);
        let mut blocked = vec![0; rays.packets()];
        traversal.occluded(rays, 0..rays.packets(), tmax, &mut blocked);
        Answers::of(&hits, &blocked)
    }

    /// Hits, in chunks, as in the benchmark.
    fn theirs(closest: &dyn BenchEngine, occluded: &dyn BenchEngine) -> Answers {
        let packets = packets_for(RAYS);
        let mut hits = vec![HitPacket::miss(); packets];
        let mut blocked = vec![0; packets];
        let (mut closest, mut occluded) = (closest.thread(), occluded.thread());
        for first in (0..packets).step_by(128) {
            let end = packets.min(first + 128);
            // Some packets twice, so that ranges of odd length are among them.
            for part in [first..end.min(first + 51), end.min(first + 50)..end] {
                closest.closest(part.clone(), &mut hits[part.clone()]);
                occluded.occluded(part.clone(), &mut blocked[part]);
            }
        }
        Answers::of(&hits, &blocked)
    }
}

/// Rays with a different closest hit, and rays occluded for only one tracer. In random scenes two
/// primitives are rarely hit at the same distance, so a different primitive counts, too.
fn differences(ours: &Answers, theirs: &Answers) -> [usize; 2] {
    let near = |a: f32, b: f32| (a - b).abs() <= 1e-4 * a.abs();
    let both = ours.closest.iter().zip(&theirs.closest);
    let closest = both
        .filter(|((t, id), (other_t, other))| id != other || *id != NO_PRIM && !near(*t, *other_t));
    let both = ours.blocked.iter().zip(&theirs.blocked);
    [closest.count(), both.filter(|(a, b)| a != b).count()]
}

/// Traces with every engine; prints and checks the differences.
fn compare(scene: &Scene, rng: &mut Rng, peer: &str, engines: PeerScene) {
    scene.validate().expect("a valid scene");
    let (arena, bvh, tmax) = (Bump::new(), Bvh::build(scene), 0.9);
    let rays = random_rays(rng);
    let queue = queue(&arena, &rays);
    let ours = Answers::ours(&bvh, &queue, tmax);
    let hits = ours.closest.iter().filter(|(_, id)| *id != NO_PRIM).count();
    let blocked = ours.blocked.iter().filter(|&&blocked| blocked).count();
    assert!(hits > RAYS / 10 && hits < RAYS, "{hits} hits");
    assert!(blocked > RAYS / 10 && blocked < hits, "{blocked} blocked");
    let engines_for = |tmax| {
        engines(RaySetRef {
            queue: &queue,
            tmax,
        })
    };
    let all = engines_for(f32::INFINITY);
    assert!(all.len() >= 2);
    for ((name, closest), (_, occluded)) in all.iter().zip(&engines_for(tmax)) {
        let theirs = Answers::theirs(&**closest, &**occluded);
        let different = differences(&ours, &theirs);
        println!("{peer}, {name}: {different:?} of {RAYS} rays differ");
        let few = different.iter().all(|&d| d <= MOST_DIFFERENT);
        assert!(few, "{peer}, {name}: {different:?}");
        flushing_is_over();
    }
}

/// Denormals are no longer treated as zero.
fn flushing_is_over() {
    let least = std::hint::black_box(f32::MIN_POSITIVE);
    assert!(least / 2.0 > 0.0, "denormals are flushed");
}

/// The best trees, on some threads.
fn settings(threads: usize) -> BuildSettings {
    BuildSettings {
        quality: Quality::Best,
        threads,
    }
}

fn compare_embree(scene: &Scene, rng: &mut Rng) {
    for library in libraries() {
        for robust in [false, true] {
            let built = library.build(scene, &settings(2), robust);
            flushing_is_over();
            let peer = format!("Embree {}, robust {robust}", library.version());
            compare(scene, rng, &peer, built.expect("a scene it has all of"));
        }
    }
}

#[test]
fn embree_agrees_on_triangles_and_spheres() {
    let mut rng = Rng::new(81);
    compare_embree(&mixed(&mut rng, 5000), &mut rng);
}

/// Scenes of one kind only, so that numbers need not be looked up.
#[test]
fn embree_agrees_on_one_kind() {
    let mut rng = Rng::new(82);
    let mut triangles = scenes::bare();
    for _ in 0..5000 {
        let center = rng.point(1.0);
        triangles.add_triangle([0; 3].map(|_| center + rng.point(0.1)), None, 0);
    }
    compare_embree(&triangles, &mut rng);
    let mut spheres = scenes::bare();
    for _ in 0..2000 {
        spheres.add_sphere(rng.point(1.0), rng.magnitude(-2.0, -1.0), 0);
    }
    compare_embree(&spheres, &mut rng);
}

#[test]
fn embree_agrees_on_instances() {
    let mut rng = Rng::new(83);
    let mut scene = mixed(&mut rng, 100);
    for _ in 0..3 {
        let mesh = scene.begin_mesh();
        for _ in 0..200 {
            add_one(&mut scene, &mut rng);
        }
        scene.end_mesh(mesh);
        for _ in 0..10 {
            let mut map = scenes::random_map(&mut rng, 1.0);
            map.matrix3 *= 0.3;
            scene.add_instance(mesh, map).expect("an invertible map");
        }
        add_one(&mut scene, &mut rng);
    }
    compare_embree(&scene, &mut rng);
}

#[test]
fn obvhs_agrees() {
    let mut rng = Rng::new(84);
    let mixed = mixed(&mut rng, 5000);
    let mut triangles = scenes::bare();
    for _ in 0..5000 {
        let center = rng.point(1.0);
        triangles.add_triangle([0; 3].map(|_| center + rng.point(0.1)), None, 0);
    }
    for scene in [mixed, triangles] {
        let built = obvhs::build(&scene, Quality::Best).expect("a scene it has all of");
        compare(&scene, &mut rng, "obvhs", built);
    }
}

/// An empty scene is valid.
#[test]
fn nothing_is_hit_where_there_is_nothing() {
    let (scene, arena) = (scenes::bare(), Bump::new());
    let rays = random_rays(&mut Rng::new(85));
    let queue = queue(&arena, &rays);
    let rays = RaySetRef {
        queue: &queue,
        tmax: 1.0,
    };
    let mut all = obvhs::build(&scene, Quality::Best).expect("an empty scene")(rays);
    for library in libraries() {
        let built = library
            .build(&scene, &settings(1), true)
            .expect("an empty scene");
        all.extend(built(rays));
    }
    for (name, engine) in &all {
        let theirs = Answers::theirs(&**engine, &**engine);
        let missed = theirs
            .closest
            .iter()
            .all(|&(t, id)| t >= 1.0 && id == NO_PRIM);
        assert!(missed && !theirs.blocked.contains(&true), "{name}");
    }
}

#[test]
fn what_a_peer_has_not_is_said() {
    let mut scene = scenes::bare();
    let cone = Cone {
        base: Vec3::ZERO,
        base_radius: 1.0,
        apex: Vec3::Z,
        apex_radius: 0.0,
        inside: false,
    };
    scene.add_cone(cone, 0);
    let error = obvhs::build(&scene, Quality::Best)
        .err()
        .expect("no cones there");
    assert!(error.to_string().contains("cones"), "{error}");
    for library in libraries() {
        let error = library.build(&scene, &settings(1), false).err();
        let error = error.expect("no such cones there").to_string();
        assert!(error.contains("cones"), "{error}");
    }
}

#[test]
fn what_is_no_embree_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let nothing = EmbreeLibrary::open(Some(folder.path())).err();
    let error = nothing.expect("an empty folder");
    assert!(matches!(error, EmbreeError::NotThere(_)));
    let text = error.to_string();
    for way in ["pip install embreex", "libembree3-3", "--embree PATH"] {
        assert!(text.contains(way), "{text}");
    }
    let file = folder.path().join("libembree4.so.4");
    std::fs::write(&file, "no library").expect("a file");
    for path in [folder.path(), file.as_path()] {
        let error = EmbreeLibrary::open(Some(path)).err().expect("no library");
        assert!(matches!(error, EmbreeError::NotLoaded { .. }), "{error}");
    }
    // The C library is a library, but not this one.
    let other = Path::new("/lib/x86_64-linux-gnu/libc.so.6");
    if other.exists() {
        let error = EmbreeLibrary::open(Some(other))
            .err()
            .expect("another library");
        assert!(error.to_string().contains("rtcNewDevice"), "{error}");
    }
}
