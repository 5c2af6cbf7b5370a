//! phalanx: a data-oriented SIMD packet ray tracer built for throughput, and the scalar tracer that
//! proves it.
//!
//! ```text
//!  bytes ── formats ──> Scene ── bvh ──> Bvh
//!                         │               │
//!         camera: 8 rays ─┴─> trace <─────┘   a tile at a time, in one worker (render)
//!                    ^          │ hits
//!                    │        shade ──> radiance
//!                    └─ queues ─┘ shadow, mirror and refracted rays, compacted into packets again
//!
//!                       Film ── image ──> PNG, JPEG, OpenEXR, HDR, PFM
//!                         └── jobs ──> tiles kept, resumed, merged
//! ```
//!
//! # Rays against a mesh
//!
//! [`Scene::add_mesh`], [`Bvh::build`], [`Bvh::intersect`]: slices in, a hit out. Millions of rays
//! go through [`Bvh::intersect_batch`], columns in and columns out, with packets, beams and threads
//! inside; the bits are the same.
//!
//! ```
//! use phalanx::{Bvh, HitBuffer, Ray, RayBuffer, Scene};
//!
//! let mut scene = Scene::new();
//! let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
//! scene.add_mesh(&corners, &[[0, 1, 2]])?;
//! let bvh = Bvh::build(&scene);
//!
//! let hit = bvh.intersect(&Ray::new([1.0, 2.0, 5.0], [0.0, 0.0, -1.0])).expect("a hit");
//! assert_eq!((hit.t, hit.u, hit.v), (5.0, 0.25, 0.5));
//! assert!(!bvh.occluded(&Ray::segment([1.0, 2.0, 5.0], [1.0, 2.0, 0.5])));
//!
//! let down = |x| Ray::new([x, 1.0, 5.0], [0.0, 0.0, -1.0]);
//! let rays: RayBuffer = (0..1000).map(|k| down(k as f32 * 0.01)).collect();
//! let mut hits = HitBuffer::new(rays.len());
//! bvh.intersect_batch(&rays.columns(), &mut hits.columns(), 0)?;
//! assert_eq!(hits.get(200), bvh.intersect(&down(2.0)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `examples/` holds five short programs to start from.
//!
//! # Pictures
//!
//! `frame::render` makes a frame with either engine (feature `render`):
//!
//! ```
//! # #[cfg(feature = "render")] {
//! use phalanx::frame::{Accel, Control, Engine, Settings, render};
//!
//! let text = "size 64 48\ncamera 0 0 4 0 0 0 0 1 0 45\npoint 4 4 4 1 1 1\n\
//!     diffuse 1 0.5 0\nsphere 0 0 0 1\n";
//! let scene = phalanx::formats::read_test(text).expect("a scene").scene;
//! let accel = Accel::build(&scene, Engine::Simd);
//! let (settings, control) = (Settings::of(&scene), Control::default());
//! let frame = render(&scene, &accel, &settings, &control).expect("a frame");
//! assert_eq!(frame.stats.rays.primary, 64 * 48);
//! # }
//! ```
//!
//! # The promise
//!
//! Both engines give the same bits: every hit, and every pixel.
//!
//! ```
//! use phalanx::oracle::{Oracle, OracleRay, OracleSearch};
//! use phalanx::{Bvh, Ray, Scene};
//!
//! let mut scene = Scene::new();
//! scene.add_spheres(&[[0.1, 0.2, 0.3]], &[0.7])?;
//! let ray = Ray::new([0.3, 0.1, 5.0], [-0.01, 0.02, -1.0]);
//! let packets = Bvh::build(&scene).intersect(&ray).expect("a hit");
//! let oracle = Oracle::new(&scene, OracleSearch::BruteForce, 0);
//! let asked = OracleRay::new(ray.origin.into(), ray.direction.into());
//! let plain = oracle.closest(&asked).expect("a hit");
//! assert_eq!(packets.t.to_bits(), plain.t.to_bits());
//! # Ok::<(), phalanx::GeometryError>(())
//! ```
//!
//! # Features
//!
//! | feature | adds | crates |
//! |---|---|---|
//! | none | scenes, the packet tracer, the oracle | 37 |
//! | `render` | file formats, pictures, whole frames | 99 |
//! | `bench` | measurements beside other tracers | 112 |
//! | `cli` (default) | the program | 140 |
//!
//! An embedder writes `phalanx = { version = "0.1", default-features = false }`, builds for the CPU
//! it runs on (`RUSTFLAGS="-C target-cpu=native"`), and has the tracer compiled in one piece:
//! `[profile.release.package.phalanx-trace]`, `codegen-units = 1`.
//!
//! # Words
//!
//! | word | meaning |
//! |---|---|
//! | primitive | a triangle, sphere, ellipsoid or cone; its `prim_id` numbers it in the scene |
//! | geometry | primitives that were added together; `geom_id` |
//! | prototype, instance | a mesh stored once; the same mesh placed in the world by a map |
//! | hit | distance `t` in units of the direction, barycentric `u` and `v`, the two numbers |
//! | closest hit, occlusion | the first thing met; whether anything is met before `tmax` |
//! | BVH | tree of boxes over the primitives; *wide*: with as many children per node as lanes |
//! | leaf | an end of the tree: primitives of one kind, side by side |
//! | SAH | surface area heuristic: the cost a random ray has in a tree |
//! | lane | one of 8 or 16 numbers that one instruction handles |
//! | packet | eight rays in lanes, which go down the tree together |
//! | beam | up to 64 packets of rays that share a point, tested as one against boxes |
//! | coherent | of rays: going nearly the same way from nearly the same place |
//! | kernel | a way down the tree: packets, beams, single rays; all give the same bits |
//! | queue | rays that wait, packed so that packets are full |
//! | wavefront | all rays of one bounce of a tile, traced before any of the next |
//! | tile | a square of the picture that one worker renders at a time |
//! | film | the picture in linear radiance, before tone and file format |
//! | AOV | what a film tells of a pixel beside its colour: depth, normals, … |
//! | oracle | the second, scalar tracer that every answer is compared with |
//! | bit-identical | equal as bit patterns: no tolerance |
//!
//! # Where to look
//!
//! | to do | begin with |
//! |---|---|
//! | cast rays at a mesh | [`Scene`], [`Bvh`], [`Ray`], [`Hit`] |
//! | cast millions | [`RayColumns`] or [`RayBuffer`], [`HitColumns`] or [`HitBuffer`] |
//! | check answers | [`oracle`] |
//! | read, write, render | `open`, `formats`, `frame`, `image`; long pictures: `jobs` |
//! | measure | `bench`, `report` |
//!
//! Lanes, packets and kernels have pages of their own, in the documentation of the inner crates
//! `phalanx-trace` and `phalanx-render`. They are the engine room: their names may change.

// The front door: what is added, built, cast and answered.
#[doc(inline)]
pub use phalanx_scene::{GeomId, GeometryError, NO_GEOM, NO_PRIM, Scene};
#[doc(inline)]
pub use phalanx_trace::bvh::{BuildSettings, Bvh, Quality};
#[doc(inline)]
pub use phalanx_trace::cast::{
    BatchError, BatchFilter, Hit, HitBuffer, HitColumns, HitLists, PerRay, Ray, RayBatch,
    RayBuffer, RayColumns, RayFilter, RayRows, RefinedHit, TMax, refine,
};

// Vectors and maps, in the version that the interfaces take.
#[doc(no_inline)]
pub use glam;

// Scenes, the trees over them, and the scalar tracer.
#[doc(inline)]
pub use phalanx_oracle as oracle;
#[doc(inline)]
pub use phalanx_scene::{camera, film};

/// Scenes: one column per attribute of primitives, instances, materials, textures and lights, and
/// the camera. Units are the scene's own, angles degrees, colours linear RGB.
pub mod scene {
    #[doc(inline)]
    pub use phalanx_scene::{
        AnyColumn, Basis, Bounds, CameraKey, CameraMatrices, CameraPath, Column, Cone, Cones,
        DefaultedParts, Ellipsoids, FileView, GeomId, Geometries, GeometryError, Instances,
        LightShape, Lights, MAX_DEPTH_LIMIT, MAX_SIDE, MAX_TEXTURE_SIDE, Material, MaterialTable,
        Materials, MatteIds, Mesh, MeshMaterial, Meshes, NO_COLORS, NO_GEOM, NO_NORMALS, NO_PRIM,
        NO_TEXTURE, NO_UVS, OrthoHeight, OutputEncoding, Prim, PrimKind, Quantize, ResolvedPrim,
        Scene, SceneError, Sky, Spheres, Texture, Transfer, Triangles, UpAxis, Vec2s, Vec3s, View,
        ViewError, Wrap, check_image_size, material_names, matte_id, object_names,
    };
}
#[doc(inline)]
pub use phalanx_trace::bvh;

// Scenes and pictures as files.
#[cfg(feature = "render")]
#[doc(inline)]
pub use {
    phalanx_files as files, phalanx_formats as formats, phalanx_image as image,
    phalanx_io::{cache, open},
    phalanx_standard as standard,
};

// One frame by either tracer, and large ones band by band.
#[cfg(feature = "render")]
#[doc(inline)]
pub use {phalanx_jobs as jobs, phalanx_render::frame};

// Benchmarks: speed, peers, and the record of both.
#[cfg(feature = "bench")]
#[doc(inline)]
pub use {phalanx_bench as bench, phalanx_report as report};

// The engine room: for the program, the benchmarks and the tests.
#[cfg(feature = "bench")]
#[doc(hidden)]
pub use phalanx_bench::peers;
#[cfg(feature = "render")]
#[doc(hidden)]
pub use phalanx_render as render;
#[cfg(feature = "render")]
#[doc(hidden)]
pub use phalanx_render::shade;
#[doc(hidden)]
pub use phalanx_scene::{PAD, sampling};
#[doc(hidden)]
pub use phalanx_trace as trace;
#[doc(hidden)]
pub use phalanx_trace::{isa, packet, simd as lanes};

// The README's programs, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
