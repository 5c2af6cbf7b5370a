//! The library for C against the one for Rust, Embree and tinybvh, in one process: the same bits,
//! and the rate of one ray a call and of batches.
//!
//!     cargo run --release --manifest-path perf/calls/Cargo.toml --bin c_library -- \
//!         MESH --c LIBRARY [--embree LIBRARY] [--tinybvh LIBRARY] [--side PIXELS] [--rounds N]
//!
//! MESH is a file of triangles, or a standard scene. `perf/calls/tinybvh.cpp` says how its library
//! is made. One thread; trees of the best quality; all take turns, and medians of the rounds are
//! printed. Beside the sets of `rays`, `shadow` has rays from where the camera's hit to points above
//! the scene.

#[path = "../rays.rs"]
mod rays;
#[path = "../shadow.rs"]
mod shadow;
#[path = "../turns.rs"]
mod turns;

use bumpalo::Bump;
use libloading::Library;
use phalanx::bench::peers::{self, Peer, RaySetRef, embree::EmbreeLibrary};
use phalanx::bvh::{BuildSettings, Quality};
use phalanx::lanes::LANES;
use phalanx::packet::{HitPacket, RayQueue};
use phalanx::{Bvh, HitBuffer, Ray, RayBuffer, RayColumns, Scene, TMax};
use phalanx_c::batch::{PhxBatch, PhxRays};
use phalanx_c::columns::PhxColumn;
use phalanx_c::hits::PhxHits;
use phalanx_c::ray::{MISS, PhxFilter, PhxHit};
use phalanx_c::rows::PhxRows;
use phalanx_c::scene::PhxMesh;
use phalanx_c::status::PhxStatus;
use phalanx_c::table::Opaque;
use phalanx_c::tree::PhxBuildSettings;
use shadow::shadow_rays;
use std::error::Error;
use std::ffi::{c_int, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::Arc;
use turns::{NamedCast, median, take_turns};

type Tree = *mut Opaque;

/// Functions of the library for C, from its file.
struct CLibrary {
    tree: Tree,
    intersect:
        unsafe extern "C" fn(*const Opaque, *const Ray, *const PhxFilter, *mut PhxHit) -> PhxStatus,
    occluded:
        unsafe extern "C" fn(*const Opaque, *const Ray, *const PhxFilter, *mut c_int) -> PhxStatus,
    intersect_batch: unsafe extern "C" fn(
        *const Opaque,
        *const PhxRays,
        *const PhxBatch,
        *const PhxHits,
    ) -> PhxStatus,
    occluded_batch: unsafe extern "C" fn(
        *const Opaque,
        *const PhxRays,
        *const PhxBatch,
        PhxColumn,
    ) -> PhxStatus,
}

fn ok(status: PhxStatus) {
    assert_eq!(status, PhxStatus::Ok);
}

fn rows<T>(array: &[T]) -> PhxRows {
    let stride = size_of::<T>();
    PhxRows {
        data: array.as_ptr().cast(),
        stride,
    }
}

fn column<T>(array: &mut [T]) -> PhxColumn {
    let stride = size_of::<T>();
    PhxColumn {
        data: array.as_mut_ptr().cast(),
        stride,
        miss: 0,
        reserved: 0,
    }
}

impl CLibrary {
    fn open(
        name: &str,
        vertices: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<CLibrary, Box<dyn Error>> {
        let mesh = PhxMesh {
            size: size_of::<PhxMesh>(),
            vertices: rows(vertices),
            vertex_count: vertices.len(),
            triangles: rows(triangles),
            triangle_count: triangles.len(),
        };
        let settings = PhxBuildSettings {
            size: size_of::<PhxBuildSettings>(),
            quality: 2,
            threads: 0,
        };
        let (mut scene, mut tree): (Tree, Tree) = (null_mut(), null_mut());
        // SAFETY: the types are those of the header, to which the crate is held.
        unsafe {
            let library = Box::leak(Box::new(Library::new(name)?));
            type Create = unsafe extern "C" fn(u32, *mut Tree) -> PhxStatus;
            type Add = unsafe extern "C" fn(Tree, *const PhxMesh, *mut u32) -> PhxStatus;
            type Build =
                unsafe extern "C" fn(Tree, *const PhxBuildSettings, *mut Tree) -> PhxStatus;
            ok(library.get::<Create>("phx_scene_create_for")?(
                phalanx_c::scene::phx_version(),
                &mut scene,
            ));
            ok(library.get::<Add>("phx_scene_add_mesh")?(
                scene,
                &mesh,
                null_mut(),
            ));
            ok(library.get::<Build>("phx_tree_build")?(
                scene, &settings, &mut tree,
            ));
            Ok(CLibrary {
                tree,
                intersect: *library.get("phx_intersect")?,
                occluded: *library.get("phx_occluded")?,
                intersect_batch: *library.get("phx_intersect_batch")?,
                occluded_batch: *library.get("phx_occluded_batch")?,
            })
        }
    }

    fn intersect(&self, ray: &Ray) -> PhxHit {
        let mut hit = MISS;
        // SAFETY: all is this function's.
        ok(unsafe { (self.intersect)(self.tree, ray, null(), &mut hit) });
        hit
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let mut blocked = 0;
        // SAFETY: all is this function's.
        ok(unsafe { (self.occluded)(self.tree, ray, null(), &mut blocked) });
        blocked != 0
    }
}

/// tinybvh, behind `tinybvh.cpp`.
struct TinyBvh {
    bvh: *mut c_void,
    intersect: unsafe extern "C" fn(
        *const c_void,
        *const f32,
        *const f32,
        f32,
        *mut f32,
        *mut u32,
    ) -> c_int,
    occluded: unsafe extern "C" fn(*const c_void, *const f32, *const f32, f32) -> c_int,
}

impl TinyBvh {
    fn open(
        name: &str,
        vertices: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<TinyBvh, Box<dyn Error>> {
        let corner = |&k: &u32| {
            let [x, y, z] = vertices[k as usize];
            [x, y, z, 0.0]
        };
        let corners: &mut Vec<[f32; 4]> = Box::leak(Box::new(
            triangles.as_flattened().iter().map(corner).collect(),
        ));
        // SAFETY: the types are those of `tinybvh.cpp`.
        unsafe {
            let library = Box::leak(Box::new(Library::new(name)?));
            type Build = unsafe extern "C" fn(*const [f32; 4], u32) -> *mut c_void;
            let bvh = library.get::<Build>("tiny_build")?(corners.as_ptr(), triangles.len() as u32);
            Ok(TinyBvh {
                bvh,
                intersect: *library.get("tiny_intersect")?,
                occluded: *library.get("tiny_occluded")?,
            })
        }
    }

    fn hits(&self, ray: &Ray) -> bool {
        let (mut t, mut prim) = (0.0, 0);
        let (origin, direction) = (ray.origin.as_ptr(), ray.direction.as_ptr());
        let tmax = ray.tmax.min(1e30);
        // SAFETY: all is this function's.
        unsafe { (self.intersect)(self.bvh, origin, direction, tmax, &mut t, &mut prim) != 0 }
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let (origin, direction) = (ray.origin.as_ptr(), ray.direction.as_ptr());
        // SAFETY: all is this function's.
        unsafe { (self.occluded)(self.bvh, origin, direction, ray.tmax.min(1e30)) != 0 }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let option = |name: &str| words.iter().skip_while(|word| *word != name).nth(1);
    let mesh = words.first().ok_or("give a mesh, or a standard scene")?;
    let side = option("--side").map_or(Ok(512), |side| side.parse())?;
    let rounds = option("--rounds").map_or(Ok(9), |rounds| rounds.parse())?;
    let read = phalanx::open::open(Path::new(mesh), &Default::default())?.scene;
    let vertices: Vec<[f32; 3]> = (0..read.triangles.vertices.len())
        .map(|k| read.triangles.vertices.get(k).into())
        .collect();
    let triangles = read.triangles.corners.to_vec();
    let mut scene = Scene::new();
    scene.add_mesh(&vertices, &triangles)?;
    let settings = BuildSettings {
        quality: Quality::Best,
        threads: 0,
    };
    let bvh = Bvh::build_with(&scene, &settings);
    bvh.build_wide(0);
    let c = CLibrary::open(
        option("--c").ok_or("--c LIBRARY is wanted")?,
        &vertices,
        &triangles,
    )?;
    let tiny = option("--tinybvh")
        .map(|name| TinyBvh::open(name, &vertices, &triangles))
        .transpose()?;
    let library = Arc::new(EmbreeLibrary::open(option("--embree").map(Path::new))?);
    let embrees = [true, false].map(|robust| {
        let peer = Peer::Embree {
            library: Arc::clone(&library),
            robust,
        };
        (
            if robust { "Embree robust" } else { "Embree fastest" },
            peer.build(&scene, &settings),
        )
    });
    let mut sets: Vec<_> = rays::sets(&scene, &bvh, side)
        .into_iter()
        .map(|(name, rays)| (name, rays, false))
        .collect();
    sets.push(("shadow", shadow_rays(&scene, &bvh, &sets[0].1), true));
    for (name, rays, any) in sets {
        check_bits(&bvh, &c, &rays, any);
        let arena = Bump::new();
        let mut queue = RayQueue::with_capacity(&arena, rays.len());
        rays.iter()
            .for_each(|ray| queue.push_ray(ray.origin, ray.direction));
        let set = RaySetRef {
            queue: &queue,
            tmax: rays[0].tmax,
        };
        let buffer: RayBuffer = rays.iter().copied().collect();
        let mut casts = ours(&bvh, &c, (&rays, &buffer), any);
        for (peer, built) in &embrees {
            let built = built.as_ref().map_err(|error| error.to_string())?;
            for (mode, engine) in built(set) {
                if mode == peers::ONE {
                    casts.push((
                        format!("{peer}, one ray a call"),
                        Box::new(move || {
                            let packets = set.queue.len().div_ceil(LANES);
                            if any {
                                let mut blocked = vec![0; packets];
                                engine.thread().occluded(0..packets, &mut blocked);
                            } else {
                                let mut hits = vec![HitPacket::miss(); packets];
                                engine.thread().closest(0..packets, &mut hits);
                            }
                            packets
                        }),
                    ));
                }
            }
        }
        if let Some(tiny) = &tiny {
            let rays = &rays;
            casts.push((
                "tinybvh BVH8_CPU".into(),
                Box::new(move || {
                    rays.iter()
                        .filter(|ray| if any { tiny.occluded(ray) } else { tiny.hits(ray) })
                        .count()
                }),
            ));
        }
        println!("\n{mesh}, {name}, {} rays", rays.len());
        measure((rays.len(), rounds), casts);
    }
    Ok(())
}

/// Asserts that no bit of C's answers differs, of single rays and of batches.
fn check_bits(bvh: &Bvh, c: &CLibrary, rays: &[Ray], any: bool) {
    let buffer: RayBuffer = rays.iter().copied().collect();
    let (mut batch, mut from_c) = (HitBuffer::new(rays.len()), HitBuffer::new(rays.len()));
    let (mut dark, mut dark_of_c) = (vec![false; rays.len()], vec![false; rays.len()]);
    bvh.intersect_batch(&buffer.columns(), &mut batch.columns(), 0)
        .expect("columns of one length");
    bvh.occluded_batch(&buffer.columns(), &mut dark, 0)
        .expect("columns of one length");
    c_batch(c, rays, &mut from_c, 0);
    c_dark(c, rays, &mut dark_of_c, 0);
    let parts = |hit: &PhxHit| {
        [
            hit.t.to_bits(),
            hit.u.to_bits(),
            hit.v.to_bits(),
            hit.prim_id,
            hit.geom_id,
        ]
    };
    for (k, ray) in rays.iter().enumerate() {
        let (one, expected) = (c.intersect(ray), bvh.intersect(ray));
        assert_eq!(parts(&one), parts(&expected.unwrap_or(MISS)), "ray {k}");
        assert_eq!(
            batch.get(k).map(|hit| parts(&hit)),
            expected.map(|hit| parts(&hit)),
            "ray {k} of a batch"
        );
        assert_eq!(
            from_c.get(k).map(|hit| parts(&hit)),
            expected.map(|hit| parts(&hit)),
            "ray {k} of a batch in C"
        );
        assert_eq!(
            [dark[k], dark_of_c[k], c.occluded(ray)],
            [expected.is_some(); 3],
            "ray {k}"
        );
    }
    println!(
        "{} rays: no bit differs{}",
        rays.len(),
        if any { ", shadows" } else { "" }
    );
}

fn c_rays(rays: &[Ray]) -> PhxRays {
    let stride = size_of::<Ray>();
    PhxRays {
        size: size_of::<PhxRays>(),
        count: rays.len(),
        origin: PhxRows {
            data: (&raw const rays[0].origin).cast(),
            stride,
        },
        direction: PhxRows {
            data: (&raw const rays[0].direction).cast(),
            stride,
        },
        tmax: PhxRows {
            data: (&raw const rays[0].tmax).cast(),
            stride: if rays.iter().all(|ray| ray.tmax == rays[0].tmax) { 0 } else { stride },
        },
    }
}

fn threads_of(threads: u32) -> PhxBatch {
    let none = PhxRows {
        data: null(),
        stride: 0,
    };
    PhxBatch {
        size: size_of::<PhxBatch>(),
        tnear: none,
        mask: none,
        ignore: none,
        accept: None,
        user: null_mut(),
        threads,
        reserved: 0,
    }
}

fn c_batch(c: &CLibrary, rays: &[Ray], hits: &mut HitBuffer, threads: u32) {
    let none = PhxColumn {
        data: null_mut(),
        stride: 0,
        miss: 0,
        reserved: 0,
    };
    let columns = hits.columns();
    let hits = PhxHits {
        size: size_of::<PhxHits>(),
        t: column(columns.t),
        u: column(columns.u),
        v: column(columns.v),
        prim_id: column(columns.prim_id),
        geom_id: column(columns.geom_id),
        local_prim_id: none,
        inst_id: none,
        normal: none,
        scene: null(),
    };
    // SAFETY: all is the caller's.
    ok(unsafe { (c.intersect_batch)(c.tree, &c_rays(rays), &threads_of(threads), &hits) });
}

/// A hit in a structure of the caller's.
#[derive(Clone, Copy)]
#[repr(C)]
struct RayHit {
    ray: Ray,
    hit: PhxHit,
}

/// From and to the caller's structures, in place.
fn c_in_place(c: &CLibrary, records: &mut [RayHit]) {
    let none = PhxColumn {
        data: null_mut(),
        stride: 0,
        miss: 0,
        reserved: 0,
    };
    let (first, stride) = (records.as_mut_ptr(), size_of::<RayHit>());
    // SAFETY: fields of the first structure.
    unsafe {
        let rays = PhxRays {
            size: size_of::<PhxRays>(),
            count: records.len(),
            origin: PhxRows {
                data: (&raw const (*first).ray.origin).cast(),
                stride,
            },
            direction: PhxRows {
                data: (&raw const (*first).ray.direction).cast(),
                stride,
            },
            tmax: PhxRows {
                data: (&raw const (*first).ray.tmax).cast(),
                stride: 0,
            },
        };
        let number = |data: *mut f32| PhxColumn {
            data: data.cast(),
            stride,
            ..none
        };
        let id = |data: *mut u32| PhxColumn {
            data: data.cast(),
            stride,
            ..none
        };
        let hits = PhxHits {
            size: size_of::<PhxHits>(),
            t: number(&raw mut (*first).hit.t),
            u: number(&raw mut (*first).hit.u),
            v: number(&raw mut (*first).hit.v),
            prim_id: id(&raw mut (*first).hit.prim_id),
            geom_id: id(&raw mut (*first).hit.geom_id),
            local_prim_id: none,
            inst_id: none,
            normal: none,
            scene: null(),
        };
        ok((c.intersect_batch)(c.tree, &rays, &threads_of(1), &hits));
    }
}

fn c_dark(c: &CLibrary, rays: &[Ray], dark: &mut [bool], threads: u32) {
    // SAFETY: all is the caller's.
    ok(unsafe { (c.occluded_batch)(c.tree, &c_rays(rays), &threads_of(threads), column(dark)) });
}

/// Our casts, from Rust and from C.
fn ours<'a>(
    bvh: &'a Bvh,
    c: &'a CLibrary,
    (rays, buffer): (&'a [Ray], &'a RayBuffer),
    any: bool,
) -> Vec<NamedCast<'a>> {
    let columns = RayColumns {
        tmax: TMax::All(rays[0].tmax),
        ..buffer.columns()
    };
    if any {
        let (mut dark, mut dark_of_c) = (vec![false; rays.len()], vec![false; rays.len()]);
        return vec![
            (
                "Rust, one ray a call".into(),
                Box::new(|| rays.iter().filter(|ray| bvh.occluded(ray)).count()),
            ),
            (
                "C, one ray a call".into(),
                Box::new(|| rays.iter().filter(|ray| c.occluded(ray)).count()),
            ),
            (
                "Rust, a batch of rows".into(),
                Box::new(move || {
                    bvh.occluded_batch(&phalanx_rows(rays), &mut dark, 1)
                        .expect("columns of one length");
                    dark.len()
                }),
            ),
            (
                "C, the same batch".into(),
                Box::new(move || {
                    c_dark(c, rays, &mut dark_of_c, 1);
                    dark_of_c.len()
                }),
            ),
        ];
    }
    let (mut hits, mut rows, mut from_c) = (
        HitBuffer::new(rays.len()),
        HitBuffer::new(rays.len()),
        HitBuffer::new(rays.len()),
    );
    let (mut kept, mut kept_of_c) = (vec![MISS; rays.len()], vec![MISS; rays.len()]);
    let mut records: Vec<RayHit> = rays.iter().map(|&ray| RayHit { ray, hit: MISS }).collect();
    vec![
        (
            "Rust, one ray a call".into(),
            Box::new(move || {
                let hits = rays.iter().zip(&mut kept);
                hits.for_each(|(ray, hit)| *hit = bvh.intersect(ray).unwrap_or(MISS));
                kept.len()
            }),
        ),
        (
            "C, one ray a call".into(),
            Box::new(move || {
                let hits = rays.iter().zip(&mut kept_of_c);
                // SAFETY: all is this function's.
                hits.for_each(|(ray, hit)| ok(unsafe { (c.intersect)(c.tree, ray, null(), hit) }));
                kept_of_c.len()
            }),
        ),
        (
            "Rust, a batch of columns".into(),
            Box::new(move || {
                bvh.intersect_batch(&columns, &mut hits.columns(), 1)
                    .expect("columns of one length");
                hits.len()
            }),
        ),
        (
            "Rust, a batch of rows".into(),
            Box::new(move || {
                bvh.intersect_batch(&phalanx_rows(rays), &mut rows.columns(), 1)
                    .expect("columns of one length");
                rows.len()
            }),
        ),
        (
            "C, the same batch".into(),
            Box::new(move || {
                c_batch(c, rays, &mut from_c, 1);
                from_c.len()
            }),
        ),
        (
            "C, in place".into(),
            Box::new(move || {
                c_in_place(c, &mut records);
                records.len()
            }),
        ),
    ]
}

/// Rays as rows, which is how C has them.
fn phalanx_rows(rays: &[Ray]) -> phalanx::RayRows<'_> {
    let words = size_of_val(rays) / size_of::<f32>();
    // SAFETY: rays are floats alone.
    let all = unsafe { std::slice::from_raw_parts(rays.as_ptr().cast::<f32>(), words) };
    phalanx::RayRows {
        origin: &all[..words - 4],
        direction: &all[3..words - 1],
        stride: 7,
        tmax: TMax::All(rays[0].tmax),
    }
}

/// Prints the median rate of each cast, and its ratio to the first one's.
fn measure((rays, rounds): (usize, usize), mut casts: Vec<NamedCast>) {
    let seconds = take_turns(rounds, &mut casts);
    for ((name, _), own) in casts.into_iter().zip(&seconds) {
        // Ratios within a round: a load on the machine slows both of its casts.
        let ratios = seconds[0].iter().zip(own).map(|(first, own)| first / own);
        let ratio = median(ratios.collect());
        let nanoseconds = median(own.clone()) / rays as f64 * 1e9;
        println!(
            "{name:32} {:8.2} M/s {nanoseconds:8.1} ns {ratio:6.3}",
            1e3 / nanoseconds
        );
    }
}
