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
//! # One ray
//!
//! Slices in, a hit out. Nothing is allocated; the first ray builds the tree's wide half, unless
//! [`Bvh::build_wide`] has done so.
//!
//! ```
//! use phalanx::{Bvh, Ray, Scene};
//!
//! let mut scene = Scene::new();
//! let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
//! let wall = scene.add_mesh(&corners, &[[0, 1, 2]])?;
//! let bvh = Bvh::build(&scene);
//!
//! let hit = bvh.intersect(&Ray::new([1.0, 2.0, 5.0], [0.0, 0.0, -1.0])).expect("a hit");
//! assert_eq!((hit.t, hit.u, hit.v, hit.geom_id), (5.0, 0.25, 0.5, wall));
//! assert!(!bvh.occluded(&Ray::segment([1.0, 2.0, 5.0], [1.0, 2.0, 0.5])));
//! # Ok::<(), phalanx::GeometryError>(())
//! ```
//!
//! # Many rays, and threads
//!
//! Columns in, columns out; packets, beams and threads are inside. Neighbours in the columns should
//! go about the same way. The last argument is the number of threads, 0 for one per CPU. Any number
//! of threads may query a tree at once; queries take no locks. Builds and files use the pool of
//! rayon that they are called on, else one of the library's own. A forked process starts its own,
//! and may use the scenes and trees of its parent.
//!
//! ```
//! use phalanx::{Bvh, HitBuffer, Ray, RayBuffer, Scene};
//!
//! let mut scene = Scene::new();
//! scene.add_spheres(&[[0.0; 3]], &[2.5])?;
//! let bvh = Bvh::build(&scene);
//! let down = |x| Ray::new([x, 1.0, 5.0], [0.0, 0.0, -1.0]);
//! let rays: RayBuffer = (0..1000).map(|k| down(k as f32 * 0.01)).collect();
//! let mut hits = HitBuffer::new(rays.len());
//! bvh.intersect_batch(&rays.columns(), &mut hits.columns(), 0)?;
//! assert_eq!(hits.get(200), bvh.intersect(&down(2.0)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What changes
//!
//! Vertices, instances and masks may change, and geometries come and go ([`Scene::remove`]).
//! [`Bvh::update`] lets the tree follow in the time of what has changed, says what it did, and
//! answers are those of a fresh build; [`Bvh::update_with`] keeps to refits, or builds. Queries on
//! one thread while another prepares the next state: two trees, or clones, each of which catches up
//! with any state of the scene.
//!
//! ```
//! use phalanx::glam::{DAffine3, dvec3};
//! use phalanx::{Bvh, Ray, Scene};
//!
//! let mut scene = Scene::new();
//! let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
//! let flag = scene.add_prototype(&corners, &[[0, 1, 2]])?;
//! let flag = scene.add_instance(flag, DAffine3::IDENTITY)?;
//! let mut shown = Bvh::build(&scene);
//! let mut next = shown.clone();
//! let ahead = Ray::new([0.0, 0.0, -9.0], [0.0, 0.0, 1.0]);
//! for frame in 1..4 {
//!     std::thread::scope(|scope| {
//!         let query = scope.spawn(|| shown.intersect(&ahead).map(|hit| hit.t));
//!         let place = dvec3(0.0, 0.0, f64::from(frame));
//!         scene.set_transform(flag, DAffine3::from_translation(place))?;
//!         next.update(&scene);
//!         assert_eq!(query.join().expect("an answer"), Some(8.0 + frame as f32));
//!         Ok::<(), phalanx::GeometryError>(())
//!     })?;
//!     std::mem::swap(&mut shown, &mut next);
//! }
//! # Ok::<(), phalanx::GeometryError>(())
//! ```
//!
//! # Rays that choose
//!
//! [`RayFilter`]: hits from a distance on, geometries by mask, all but one primitive, or whatever a
//! closure accepts, for the closest hit, any hit and all hits. A ray without a filter pays nothing
//! for it.
//!
//! ```
//! use phalanx::{Bvh, Hit, Ray, RayFilter, Scene};
//!
//! let mut scene = Scene::new();
//! let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
//! let leaf = scene.add_mesh(&corners, &[[0, 1, 2]])?;
//! let bvh = Bvh::build(&scene);
//! // A hole in the middle, as a texture with alpha would have it.
//! let solid = |hit: &Hit| hit.geom_id != leaf || (hit.u - 0.3).hypot(hit.v - 0.3) > 0.1;
//! let filter = RayFilter { accept: &solid, ..RayFilter::default() };
//! let down = |x, y| Ray::new([x, y, 5.0], [0.0, 0.0, -1.0]);
//! assert!(bvh.intersect_filtered(&down(1.2, 1.2), &filter).is_none());
//! assert!(bvh.occluded_filtered(&down(0.2, 0.2), &filter));
//! # Ok::<(), phalanx::GeometryError>(())
//! ```
//!
//! # What a hit is
//!
//! The point is `origin + t · direction`, and on a triangle (1 − u − v) · a + u · b + v · c.
//!
//! | | [`Hit`], [`Ray`], [`RayFilter`] | Embree | Open3D |
//! |---|---|---|---|
//! | distance, in units of the direction | `t` | `tfar` | `t_hit` |
//! | weights of the second and third vertex | `u`, `v` | `u`, `v` | `primitive_uvs` |
//! | triangle of a mesh | `prim_id` − [`Bvh::first_prim`] | `primID` | `primitive_ids` |
//! | mesh | `geom_id` | `geomID` | `geometry_ids` |
//! | instance | `geom_id` | `instID` | – |
//! | miss | `None`; [`NO_PRIM`] in columns, −1 in Python | `RTC_INVALID_GEOMETRY_ID` | `INVALID_ID` |
//! | hits count if | `tnear` < t < `tmax`, 0 < t | `tnear` ≤ t ≤ `tfar` | `tnear` < t < `tfar` |
//! | mask | [`Scene::set_mask`], `mask` | `rtcSetGeometryMask`, `mask` | – |
//! | the triangle that a ray leaves | `ignore` | a filter function | – |
//! | filter | `accept` | `rtcSetGeometryIntersectFilterFunction` | – |
//! | normal | [`refine`] | `Ng` | `primitive_normals` |
//!
//! # Precision
//!
//! Positions, distances and weights are `f32`. No ray passes between triangles that share an edge
//! or a vertex, and among hits at equal distance the smallest `prim_id` counts. [`refine`] computes
//! distance, point and normal of a hit again in `f64`; for coordinates such as those of maps,
//! subtract a point near the geometry first.
//!
//! ```
//! use phalanx::{Bvh, Ray, Scene, refine};
//!
//! let mut scene = Scene::new();
//! scene.add_spheres(&[[0.0; 3]], &[1.0])?;
//! let hit = Bvh::build(&scene).intersect(&Ray::new([0.1, 0.0, -3.0], [0.0, 0.0, 1.0]));
//! let exact = refine(&scene, [0.1, 0.0, -3.0], [0.0, 0.0, 1.0], &hit.expect("a hit"));
//! assert!((exact.t - (3.0 - 0.99f64.sqrt())).abs() < 1e-15);
//! # Ok::<(), phalanx::GeometryError>(())
//! ```
//!
//! # Debug builds
//!
//! Without optimization, trees take twenty to thirty times as long to build, and rays up to 160
//! times as long to trace. Two lines in the `Cargo.toml` of your program, or of its workspace, keep
//! what it depends on optimized in debug builds, and your own code as it is:
//!
//! ```toml
//! [profile.dev.package."*"]
//! opt-level = 3
//! ```
//!
//! # Programs to start from
//!
//! `examples/` has short programs, among them a path tracer (`path_tracer.rs`) and, in Python, a
//! rotating LiDAR among moving cars.
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
//! # The same bits
//!
//! Both engines give the same bits, on every CPU, for any number of threads and any tree: every
//! hit, and every pixel.
//!
//! ```
//! use phalanx::oracle::{Oracle, OracleRay, OracleSearch};
//! use phalanx::{Bvh, Ray, Scene};
//!
//! let mut scene = Scene::new();
//! scene.add_spheres(&[[0.1, 0.2, 0.3]], &[0.7])?;
//! let ray = Ray::new([0.3, 0.1, 5.0], [-0.01, 0.02, -1.0]);
//! let packets = Bvh::build(&scene).intersect(&ray).expect("a hit");
//! let oracle = Oracle::new(&scene, OracleSearch::BruteForce);
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
//! | none | scenes, the packet tracer, the oracle | 34 |
//! | `render` | file formats, pictures, whole frames | 98 |
//! | `bench` | measurements beside other tracers | 111 |
//! | `cli` | the program | 139 |
//! | `view` (default) | its page in the browser | 145 |
//!
//! Counted in the versions of the repository's `Cargo.lock`; newer ones bring a few crates more.
//!
//! An embedder writes `phalanx = { version = "0.1", default-features = false }`, builds for the CPU
//! it runs on (`RUSTFLAGS="-C target-cpu=native"`), and has the tracer compiled in one piece:
//! `[profile.release.package.phalanx-trace]`, `codegen-units = 1`. A program for other people's
//! CPUs writes `phalanx = { package = "phalanx-levels", version = "0.1" }` instead, and is compiled
//! for plain x86-64: that crate has all of this one, with a [`Bvh`] that takes the instructions of
//! the machine when the program runs (on Linux with glibc).
//!
//! # From Python
//!
//! `.ci/wheel` makes a wheel of three builds, for plain x86-64, AVX2 and AVX-512; `import phalanx`
//! loads the best for the CPU. `src/python/README.md` is its page.
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
pub use phalanx_trace::bvh::{UpdateError, UpdateMode, UpdateReport, UpdateWork};
#[doc(inline)]
pub use phalanx_trace::cast::{
    AcceptHit, BatchError, BatchFilter, Hit, HitBuffer, HitColumns, HitLists, PerRay, Ray,
    RayBatch, RayBuffer, RayColumns, RayFilter, RayRows, RefinedHit, TMax, refine, world_corners,
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
        DefaultedParts, Ellipsoids, Environment, EnvironmentLight, EnvironmentMap,
        EnvironmentTexels, FileView, GeomId, Geometries, GeometryError, Instances, LightShape,
        Lights, LobeWeights, MAX_DEPTH_LIMIT, MAX_ENVIRONMENT_SIDE, MAX_SIDE, MAX_TEXTURE_SIDE,
        MapTarget, Material, MaterialTable, Materials, MatteIds, Mesh, MeshMaterial, Meshes,
        MetallicRoughness, NO_GEOM, NO_INDEX, NO_NAME, NO_PRIM, NO_TEXTURE, NameTable, OrthoHeight,
        OutputEncoding, Prim, PrimKind, Quantize, ResolvedPrim, SHADOWLESS, Scene, SceneCamera,
        SceneError, Spheres, Texture, TextureMap, TextureMaps, Transfer, Triangles, UpAxis, Vec2s,
        Vec3s, View, ViewError, Wrap, check_image_size, lighting, material_names, matte_id,
        object_names,
    };
}
#[doc(inline)]
pub use phalanx_trace::bvh;

// Scenes and pictures as files.
#[cfg(feature = "render")]
#[doc(inline)]
pub use {
    phalanx_files as files, phalanx_image as image,
    phalanx_io::{cache, open},
    phalanx_standard as standard,
};

/// Scene files: read, given the parts that they lack, and changed by the user's options.
#[cfg(feature = "render")]
pub mod formats {
    #[doc(inline)]
    pub use phalanx_formats::{
        Diagnostic, LoadError, MAX_DIAGNOSTICS, Origin, ReadOptions, endings, foreign, is_bare_name,
    };
    #[doc(inline)]
    pub use phalanx_io::EnvironmentSource;
    #[doc(inline)]
    pub use phalanx_io::open::{Opened as Loaded, Options, load, read_bytes, read_nff, read_test};
    #[doc(inline)]
    pub use phalanx_look::{
        AddedLight, DefaultLights, Overrides, environment_scale, override_scene,
    };
    #[doc(no_inline)]
    pub use phalanx_scene::{OrthoHeight, UpAxis};
}

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
pub use phalanx_scene::{ForkSafeOnce, PAD, sampling, set_pool_threads, thread_count};
#[doc(hidden)]
pub use phalanx_trace as trace;
#[doc(hidden)]
pub use phalanx_trace::{isa, packet, simd as lanes};

// The README's programs, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
