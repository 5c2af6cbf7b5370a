//! Trees of the machine's level against those of the program's own: the same bits from every call.
//! Where the program is compiled for the machine, both are one build. `.ci/consumer` compiles this
//! for plain x86-64 and runs it at every level.

use phalanx_levels as phalanx;

use phalanx::bvh::Bvh as OwnBvh;
use phalanx::glam::{DAffine3, dvec3};
use phalanx::{
    BatchFilter, Bvh, Hit, HitBuffer, PerRay, Ray, RayBuffer, RayFilter, RayRows, Scene, TMax,
};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;

const RAYS: usize = 3000;

/// Numbers in −1..1, the same ones each time.
fn numbers() -> impl FnMut() -> f32 {
    let mut seed = 1u64;
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }
}

fn triangles(count: usize, mut number: impl FnMut() -> f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut corners = Vec::new();
    for _ in 0..count {
        let center = [number(), number(), number()];
        corners.extend([(); 3].map(|()| center.map(|x| x + 0.1 * number())));
    }
    let rows = (0..count as u32).map(|k| [0, 1, 2].map(|corner| 3 * k + corner));
    (corners, rows.collect())
}

/// A cloud of triangles and spheres, and an instance of another cloud.
fn scene() -> (Scene, u32) {
    let mut number = numbers();
    let mut scene = Scene::new();
    let (corners, rows) = triangles(2000, &mut number);
    scene.add_mesh(&corners, &rows).expect("a mesh");
    let centers: Vec<[f32; 3]> = (0..50).map(|_| [(); 3].map(|()| number())).collect();
    scene.add_spheres(&centers, &[0.05; 50]).expect("spheres");
    let (corners, rows) = triangles(300, &mut number);
    let cloud = scene.add_prototype(&corners, &rows).expect("a mesh");
    let placed = scene.add_instance(cloud, DAffine3::from_scale(dvec3(0.5, 0.4, 0.3)));
    (scene, placed.expect("an instance"))
}

fn rays() -> Vec<Ray> {
    let mut number = numbers();
    let mut point = || [number(), number(), number()].map(|x| 1.5 * x);
    let segment = |_| Ray {
        tmax: f32::INFINITY,
        ..Ray::segment(point(), point())
    };
    (0..RAYS).map(segment).collect()
}

fn bits(hit: Option<Hit>) -> [u32; 5] {
    hit.map_or([u32::MAX; 5], |hit| {
        [
            hit.t.to_bits(),
            hit.u.to_bits(),
            hit.v.to_bits(),
            hit.prim_id,
            hit.geom_id,
        ]
    })
}

/// Compares what both trees answer to rays, one by one and as batches.
macro_rules! compare {
    ($level:expr, $own:expr) => {
        let (rays, level, own) = (rays(), $level, $own);
        let odd = |hit: &Hit| hit.prim_id % 2 == 1;
        let filter = RayFilter {
            accept: &odd,
            ..RayFilter::default()
        };
        for ray in &rays {
            let hit = own.intersect(ray);
            assert_eq!(bits(level.intersect(ray)), bits(hit));
            let mut into = Hit {
                t: 0.0,
                u: 0.0,
                v: 0.0,
                prim_id: 0,
                geom_id: 0,
            };
            assert_eq!(level.intersect_into(ray, &mut into), hit.is_some());
            assert!(hit.is_none_or(|hit| hit == into));
            assert_eq!(level.occluded(ray), own.occluded(ray));
            let [a, b] = [
                level.intersect_filtered(ray, &filter),
                own.intersect_filtered(ray, &filter),
            ];
            assert_eq!(bits(a), bits(b));
            assert_eq!(
                level.occluded_filtered(ray, &filter),
                own.occluded_filtered(ray, &filter)
            );
            assert_eq!(
                level.all_hits_filtered(ray, &filter),
                own.all_hits_filtered(ray, &filter)
            );
        }
        let each = |k: usize, _: &Hit| k % 3 != 0;
        let filter = BatchFilter {
            ignore: PerRay::All(7),
            accept: Some(&each),
            ..BatchFilter::default()
        };
        let buffer: RayBuffer = rays.iter().copied().collect();
        let columns = buffer.columns();
        let rows = |hits: &HitBuffer| hits.iter().map(bits).collect::<Vec<_>>();
        let [mut a, mut b] = [(); 2].map(|()| HitBuffer::new(RAYS));
        level
            .intersect_batch(&columns, &mut a.columns(), 2)
            .expect("columns");
        own.intersect_batch(&columns, &mut b.columns(), 1)
            .expect("columns");
        assert_eq!(rows(&a), rows(&b));
        level
            .intersect_batch_filtered(&columns, &filter, &mut a.columns(), 2)
            .expect("columns");
        own.intersect_batch_filtered(&columns, &filter, &mut b.columns(), 1)
            .expect("columns");
        assert_eq!(rows(&a), rows(&b));
        let [mut a, mut b] = [[false; RAYS]; 2];
        level.occluded_batch(&columns, &mut a, 2).expect("columns");
        own.occluded_batch(&columns, &mut b, 1).expect("columns");
        assert_eq!(a, b);
        level
            .occluded_batch_filtered(&columns, &filter, &mut a, 2)
            .expect("columns");
        own.occluded_batch_filtered(&columns, &filter, &mut b, 1)
            .expect("columns");
        assert_eq!(a, b);
        let [mut a, mut b] = [[0; RAYS]; 2];
        level.count_batch(&columns, &mut a, 2).expect("columns");
        own.count_batch(&columns, &mut b, 1).expect("columns");
        assert_eq!(a, b);
        assert_eq!(
            level.all_hits_batch(&columns, 2),
            own.all_hits_batch(&columns, 1)
        );
        let [a, b] = [
            level.all_hits_batch_filtered(&columns, &filter, 2),
            own.all_hits_batch_filtered(&columns, &filter, 1),
        ];
        assert_eq!(a, b);
        let [a, b] = [(); 2].map(|()| Mutex::new(vec![None; RAYS]));
        level
            .intersect_batch_each(&columns, 2, |k, hit| a.lock().unwrap()[k] = hit)
            .expect("columns");
        level
            .intersect_batch_filtered_each(&columns, &filter, 2, |k, hit| {
                b.lock().unwrap()[k] = hit
            })
            .expect("columns");
        for (k, (a, b)) in a
            .into_inner()
            .unwrap()
            .into_iter()
            .zip(b.into_inner().unwrap())
            .enumerate()
        {
            assert_eq!(bits(a), bits(own.intersect(&rays[k])));
            assert!(k % 3 != 0 || b.is_none());
        }
    };
}

#[test]
fn every_call_gives_the_same_bits() {
    let (mut scene, placed) = scene();
    let (mut level, mut own) = (Bvh::build(&scene), OwnBvh::build(&scene));
    compare!(&level, &own);
    let before = level.clone();
    scene
        .set_transform(placed, DAffine3::from_translation(dvec3(0.3, 0.2, 0.1)))
        .expect("an instance");
    assert!(!level.is_current(&scene));
    level.update(&scene);
    own.update(&scene);
    assert!(level.is_current(&scene) && !before.is_current(&scene));
    compare!(&level, &own);
    assert_eq!(
        (level.depth(), level.first_prim(1)),
        (own.depth(), own.first_prim(1))
    );
    assert_eq!(
        (level.has_wide(), level.sah().to_bits()),
        (true, own.sah().to_bits())
    );
    assert_eq!(
        (level.node_bytes(), level.prim_bytes()),
        (own.node_bytes(), own.prim_bytes())
    );
    assert!(level.wide_bytes() > 0 && format!("{level:?}").contains(phalanx::isa()));
}

#[test]
fn the_level_is_one_that_was_asked_for() {
    let wish = std::env::var("PHALANX_LEVEL").unwrap_or_default();
    // On a line of its own, for `.ci/consumer`.
    println!("\nrays run on {}", phalanx::isa());
    assert!(wish.is_empty() || phalanx::isa() == wish, "{wish}");
}

#[test]
fn errors_and_empty_scenes_are_those_of_the_library() {
    let bvh = Bvh::default();
    assert_eq!(bvh.intersect(&Ray::new([0.0; 3], [0.0, 0.0, 1.0])), None);
    let corners = [[0.0; 3]; 2];
    let rows = RayRows::new(&corners, &corners, TMax::All(1.0));
    let error = bvh.occluded_batch(&rows, &mut [false], 0).unwrap_err();
    assert_eq!((error.column, error.len, error.rays), ("blocked", 1, 2));
}

/// A closure runs on threads of the level's library, which cannot pass on what it throws.
#[test]
fn panics_of_closures_come_back() {
    let (scene, _) = scene();
    let bvh = Bvh::build(&scene);
    let all = rays();
    let rays: RayBuffer = all.iter().copied().collect();
    let put = |k: usize, _: Option<Hit>| assert!(k != 2500, "row {k}");
    let batch = || bvh.intersect_batch_each(&rays.columns(), 2, put);
    let panic = catch_unwind(AssertUnwindSafe(batch)).unwrap_err();
    assert_eq!(
        panic.downcast_ref::<String>().map(String::as_str),
        Some("row 2500")
    );
    let refuse = RayFilter {
        accept: &|_| panic!("a hit"),
        ..RayFilter::default()
    };
    let one = || all.iter().any(|ray| bvh.occluded_filtered(ray, &refuse));
    let panic = catch_unwind(AssertUnwindSafe(one)).unwrap_err();
    assert_eq!(panic.downcast_ref::<&str>(), Some(&"a hit"));
}
