//! Trees that follow a scene: after any edit, their answers are those of a fresh build, of the
//! oracle, and of every kernel.

use super::front_door::soup;
use crate::common::full_or;
use crate::common::rays::{Engines, toward};
use crate::common::rng::Rng;
use glam::{DAffine3, DQuat, DVec3, Vec3};
use phalanx::bvh::{BuildSettings, Child, LeafKind, Quality};
use phalanx::oracle::{OracleRay, TwoLevelBvh};
use phalanx::scene::{Bounds, Cone, GeometryError};
use phalanx::{Bvh, GeomId, Hit, HitBuffer, NO_GEOM, Ray, RayBuffer, RayFilter, Scene, cache};
use phalanx::{UpdateError, UpdateMode, UpdateReport, UpdateWork};

/// Edits of all scenes together; `PHALANX_EDITS` asks for another number.
fn edits() -> usize {
    let given = std::env::var("PHALANX_EDITS").ok();
    given.map_or(400, |given| given.parse().expect("a number"))
}

const EDITS_PER_SCENE: usize = 25;

/// A scene that is edited, and what it consists of.
#[derive(Clone)]
struct Stage {
    scene: Scene,
    meshes: Vec<(GeomId, Vec<[f32; 3]>)>,
    prototypes: Vec<(u32, Vec<[f32; 3]>)>,
    spheres: Vec<GeomId>,
    instances: Vec<GeomId>,
}

impl Stage {
    /// A scene with some of: meshes, spheres, a cone, prototypes, instances.
    fn new(random: &mut Rng) -> Stage {
        let mut stage = Stage {
            scene: Scene::new(),
            meshes: Vec::new(),
            prototypes: Vec::new(),
            spheres: Vec::new(),
            instances: Vec::new(),
        };
        for _ in 0..random.below(3) {
            stage.add_mesh(random);
        }
        if random.below(2) == 0 {
            stage.add_spheres(random);
        }
        // Added by hand, so that it needs a material that there is.
        if random.below(3) == 0 && !stage.geometries().is_empty() {
            let (base, apex) = (random.point(1.0), random.point(1.0));
            let cone = Cone {
                base,
                apex,
                base_radius: 0.2,
                apex_radius: 0.1,
                inside: false,
            };
            stage.scene.add_cone(cone, 0);
        }
        for _ in 0..random.below(3) {
            stage.add_prototype(random);
        }
        for _ in 0..random.below(30) {
            stage.add_instance(random);
        }
        stage
    }

    fn add_mesh(&mut self, random: &mut Rng) {
        let count = [3, 40, 300][random.below(3)];
        let (vertices, indices) = soup(random, count);
        let mesh = self.scene.add_mesh(&vertices, &indices).expect("a mesh");
        self.meshes.push((mesh, vertices));
    }

    fn add_spheres(&mut self, random: &mut Rng) {
        let centers = [(); 9].map(|()| random.point(1.0).to_array());
        let count = 1 + random.below(9);
        let spheres = self
            .scene
            .add_spheres(&centers[..count], &[0.1; 9][..count]);
        self.spheres.push(spheres.expect("spheres"));
    }

    fn geometries(&self) -> Vec<GeomId> {
        let meshes = self.meshes.iter().map(|(mesh, _)| mesh);
        meshes
            .chain(&self.spheres)
            .chain(&self.instances)
            .copied()
            .collect()
    }

    fn add_prototype(&mut self, random: &mut Rng) {
        let (vertices, indices) = soup(random, 30);
        let prototype = self.scene.add_prototype(&vertices, &indices);
        self.prototypes.push((prototype.expect("a mesh"), vertices));
    }

    fn add_instance(&mut self, random: &mut Rng) {
        if !self.prototypes.is_empty() {
            let which = random.below(self.prototypes.len());
            let prototype = self.prototypes[which].0;
            let instance = self.scene.add_instance(prototype, map(random));
            self.instances.push(instance.expect("a place"));
        }
    }

    /// Removes a geometry, or a prototype that nothing shows; the others keep their numbers.
    fn remove(&mut self, random: &mut Rng) {
        let geometries = self.geometries();
        if let Some(&(prototype, _)) = self.prototypes.first()
            && random.below(8) == 0
        {
            if self.scene.remove_prototype(prototype).is_ok() {
                self.prototypes.remove(0);
            }
        } else if !geometries.is_empty() {
            let gone = geometries[random.below(geometries.len())];
            let firsts = |stage: &Stage| {
                let starts = stage.scene.geometry_starts().into_iter();
                let all = starts.filter(|&(_, id)| id != gone && id != NO_GEOM);
                all.collect::<Vec<_>>()
            };
            let before = firsts(self);
            self.scene.remove(gone).expect("a geometry");
            self.meshes.retain(|&(id, _)| id != gone);
            self.spheres.retain(|&id| id != gone);
            self.instances.retain(|&id| id != gone);
            assert_eq!(firsts(self), before);
        }
    }

    /// Makes one random edit.
    fn edit(&mut self, random: &mut Rng) {
        match random.below(25) {
            0 => self.add_mesh(random),
            1 => self.add_prototype(random),
            2 | 3 => self.add_instance(random),
            20 | 21 => self.add_spheres(random),
            22..25 => self.remove(random),
            4 | 5 if !self.geometries().is_empty() => {
                let geometries = self.geometries();
                let geometry = geometries[random.below(geometries.len())];
                let mask = [0, u32::MAX, 5][random.below(3)];
                self.scene.set_mask(geometry, mask).expect("a geometry");
            }
            6..=9 if !self.meshes.is_empty() => {
                let which = random.below(self.meshes.len());
                let (mesh, vertices) = &mut self.meshes[which];
                deform(random, vertices);
                self.scene.set_vertices(*mesh, vertices).expect("a mesh");
            }
            10..=12 if !self.prototypes.is_empty() => {
                let which = random.below(self.prototypes.len());
                let (prototype, vertices) = &mut self.prototypes[which];
                deform(random, vertices);
                let moved = self.scene.set_prototype_vertices(*prototype, vertices);
                moved.expect("a prototype");
            }
            _ if !self.instances.is_empty() => {
                let which = random.below(self.instances.len());
                let moved = self.scene.set_transform(self.instances[which], map(random));
                moved.expect("an instance");
            }
            _ => {}
        }
    }
}

fn map(random: &mut Rng) -> DAffine3 {
    let turn = DQuat::from_rotation_y(f64::from(random.range(0.0, 6.0)));
    let scale = DVec3::splat(f64::from(random.range(0.1, 0.6)));
    DAffine3::from_scale_rotation_translation(scale, turn, random.point(1.0).as_dvec3())
}

/// Moves vertices a little, or anywhere.
fn deform(random: &mut Rng, vertices: &mut [[f32; 3]]) {
    let amount = [0.01, 0.3, 5.0][random.below(3)];
    for vertex in vertices {
        *vertex = (Vec3::from(*vertex) + random.point(amount)).to_array();
    }
}

/// Checks that every visible object is in the tree once, within the boxes of all nodes above it.
fn assert_whole(scene: &Scene, bvh: &Bvh) {
    let mut seen = Vec::new();
    let everything = Bounds::new(Vec3::NEG_INFINITY, Vec3::INFINITY);
    let mut waiting = vec![(Child::Node(0), everything)];
    while let Some((child, within)) = waiting.pop() {
        match child {
            Child::Node(index) => {
                let node = &bvh.nodes()[index as usize];
                for k in 0..2 {
                    let [lo, hi] = node.boxes[k].map(Vec3::from_array);
                    let bounds = Bounds::new(lo, hi);
                    if !matches!(node.child(k), Child::Leaf { count: 0, .. }) {
                        assert_eq!(within.union(bounds), within, "node {index}");
                        waiting.push((node.child(k), bounds));
                    }
                }
            }
            Child::Leaf {
                kind: LeafKind::Instance,
                first,
                count,
            } => {
                for row in &bvh.leaf_prims().instances[first as usize..][..count as usize] {
                    let [lo, hi] = row.prim_aabb.map(Vec3::from_array);
                    assert_eq!(within.union(Bounds::new(lo, hi)), within);
                }
                seen.extend((0..count).map(|_| u32::MAX));
            }
            Child::Leaf { kind, first, count } => {
                let rows = first as usize..(first + count) as usize;
                for prim in bvh.leaf_prims().stored_prims(kind, rows) {
                    let bounds = scene.prim_bounds(prim);
                    assert_eq!(within.union(bounds), within, "primitive {prim}");
                    seen.push(prim);
                }
            }
        }
    }
    seen.sort_unstable();
    let prims = scene.world_runs().into_iter().flatten();
    let shown = scene.visible_instances().map(|_| u32::MAX);
    assert!(seen.into_iter().eq(prims.chain(shown)));
}

/// Checks that a tree answers as a fresh one, and as the oracle does in every kernel.
fn assert_follows(scene: &Scene, bvh: &Bvh, random: &mut Rng) {
    assert_whole(scene, bvh);
    let fresh = Bvh::build(scene);
    let oracle = TwoLevelBvh::build(scene);
    let mut engines = Engines::new(scene, &oracle, bvh);
    let rays: Vec<OracleRay> = (0..8)
        .map(|_| toward(random.point(2.0), random.point(0.7)))
        .collect();
    engines.closest_of(&rays);
    engines.occluded_of(&rays, random.range(0.1, 2.0));
    for ray in &rays {
        let ray = Ray {
            tmax: random.range(0.5, 3.0),
            ..Ray::new(ray.org, ray.dir)
        };
        assert_eq!(bvh.intersect(&ray), fresh.intersect(&ray), "{ray:?}");
        assert_eq!(bvh.occluded(&ray), fresh.occluded(&ray), "{ray:?}");
        let filter = RayFilter {
            mask: 4,
            ..RayFilter::default()
        };
        let hits = [bvh, &fresh].map(|bvh| bvh.all_hits_filtered(&ray, &filter));
        assert_eq!(hits[0], hits[1], "{ray:?}");
    }
}

/// Lets a tree follow in one of the modes. One that refuses leaves the answers as they were.
fn follow(
    scene: &Scene,
    bvh: &mut Bvh,
    (rays, answers): (&[Ray; 20], &[Option<Hit>; 20]),
    edit: usize,
) {
    let mode = [UpdateMode::Auto, UpdateMode::RefitOnly, UpdateMode::Auto][edit % 3];
    if bvh.update_with(scene, mode).is_err() {
        assert_eq!(rays.each_ref().map(|ray| bvh.intersect(ray)), *answers);
        assert!(!bvh.is_current(scene));
        bvh.update(scene);
    }
    assert!(bvh.is_current(scene) && bvh.cost_growth() > 0.0);
    assert_eq!(bvh.update(scene), UpdateReport::default());
}

#[test]
fn updated_trees_answer_as_fresh_ones() {
    for seed in 0..(edits() / EDITS_PER_SCENE) as u64 {
        let mut random = Rng::new(seed);
        let mut stage = Stage::new(&mut random);
        let settings = BuildSettings {
            quality: Quality::ALL[(seed % 4) as usize].1,
            threads: (seed % 3) as usize,
        };
        let mut bvh = Bvh::build_with(&stage.scene, &settings);
        // A tree that follows now and then, from a state long gone.
        let mut late = bvh.clone();
        if seed % 2 == 0 {
            bvh.build_wide(1);
        }
        for edit in 0..EDITS_PER_SCENE {
            let shown = bvh.clone();
            let rays = [(); 20].map(|()| Ray::new(random.point(2.0), random.point(1.0)));
            let answers = rays.each_ref().map(|ray| shown.intersect(ray));
            stage.edit(&mut random);
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    for _ in 0..3 {
                        assert_eq!(rays.each_ref().map(|ray| shown.intersect(ray)), answers);
                    }
                });
                follow(&stage.scene, &mut bvh, (&rays, &answers), edit);
            });
            assert_follows(&stage.scene, &bvh, &mut random);
            if edit % 7 == 6 {
                late.update(&stage.scene);
                assert_follows(&stage.scene, &late, &mut random);
            }
        }
    }
}

/// Checks that a tree which has followed can be stored, and that an opened scene can move.
#[test]
fn moved_scenes_are_cached() {
    let mut random = Rng::new(11);
    for _ in 0..20 {
        let mut stage = Stage::new(&mut random);
        let mut bvh = Bvh::build(&stage.scene);
        for _ in 0..8 {
            stage.edit(&mut random);
            bvh.update(&stage.scene);
        }
        let mut bytes = Vec::new();
        cache::write(&mut bytes, &stage.scene, &bvh).expect("memory");
        let opened = cache::open_bytes("moved".as_ref(), &bytes).expect("a cache");
        (stage.scene, bvh) = (opened.scene, opened.bvh);
        assert_follows(&stage.scene, &bvh, &mut random);
        for _ in 0..5 {
            stage.edit(&mut random);
            bvh.update(&stage.scene);
            assert_follows(&stage.scene, &bvh, &mut random);
        }
    }
}

/// Checks that a tree does not take one scene for another, and follows primitives that were added
/// by hand.
#[test]
fn trees_follow_other_scenes() {
    let mut random = Rng::new(7);
    let scenes = [(); 6].map(|()| Stage::new(&mut random).scene);
    let mut bvh = Bvh::default();
    for round in 0..20 {
        let mut scene = scenes[random.below(6)].clone();
        if round % 3 == 0 {
            scene.add_sphere(random.point(1.0), 0.3, 0);
        }
        bvh.update(&scene);
        assert_follows(&scene, &bvh, &mut random);
    }
    let mut large = Scene::new();
    large
        .add_spheres(&[[1e20, 0.0, 0.0]], &[1e19])
        .expect("a sphere");
    bvh.update(&large);
    large.rescale_to_f32_range();
    bvh.update(&large);
    let ray = Ray::new([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    assert!(bvh.intersect(&ray).is_some_and(|hit| hit.t < 10.0));
}

/// Checks that one tree follows copies of a scene that are edited apart, in turns, and that edits
/// may come several at a time.
#[test]
fn trees_follow_copies_that_part() {
    for seed in 0..(edits() / EDITS_PER_SCENE) as u64 {
        let mut random = Rng::new(1000 + seed);
        let first = Stage::new(&mut random);
        let mut bvh = Bvh::build(&first.scene);
        let mut stages = [first.clone(), first];
        for _ in 0..EDITS_PER_SCENE {
            let which = random.below(2);
            for _ in 0..1 + random.below(4) {
                stages[which].edit(&mut random);
            }
            if random.below(12) == 0 {
                stages[1 - which] = stages[which].clone();
            }
            let scene = &stages[random.below(2)].scene;
            bvh.update(scene);
            assert_follows(scene, &bvh, &mut random);
        }
    }
}

/// Checks that a mesh that grows, and is removed and added each time, leaves no place of each size.
#[test]
fn a_mesh_that_grows_takes_no_more_room_than_it_needs() {
    let mut scene = Scene::new();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for count in 1..500 {
        let mesh = scene
            .add_mesh(&corners, &vec![[0, 1, 2]; count])
            .expect("a mesh");
        assert_eq!(scene.visible_count(), count as u64);
        assert!(scene.validate().is_ok());
        scene.remove(mesh).expect("a mesh");
        let ball = scene.add_spheres(&vec![[0.0; 3]; count], &vec![1.0; count]);
        scene.remove(ball.expect("spheres")).expect("spheres");
    }
    assert!(scene.prim_count() < 10 * 500, "{}", scene.prim_count());
    assert!(scene.geometries.len() < 60, "{}", scene.geometries.len());
}

/// Checks that many parts in one place are joined in time, at depths that a stack holds.
#[test]
fn parts_of_equal_boxes_are_joined_in_halves() {
    let mut scene = Scene::new();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let all = vec![[0, 1, 2]; 5000];
    scene.add_mesh(&corners, &all).expect("a mesh");
    let mut bvh = Bvh::build(&scene);
    bvh.build_wide(1);
    let depth = bvh.depth();
    for k in 0..4000 {
        // Half of them in one place, half in boxes that grow.
        let size = 1.0 + (k % 2 * k) as f32;
        let corners = corners.map(|corner| corner.map(|c| c * size));
        scene.add_mesh(&corners, &[[0, 1, 2]]).expect("a mesh");
    }
    let report = bvh.update_with(&scene, UpdateMode::Auto).expect("a tree");
    assert!(report.work == UpdateWork::Rebuilt || bvh.depth() < depth + 64);
    assert_follows(&scene, &bvh, &mut Rng::new(4));
}

/// Checks that numbers of free instances are no one's, and that a damaged scene's are refused.
#[test]
fn numbers_of_removed_instances_are_checked() {
    let mut scene = Scene::new();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let many = scene
        .add_prototype(&corners, &[[0, 1, 2]; 5])
        .expect("a mesh");
    let one = scene.add_prototype(&corners, &[[0, 1, 2]]).expect("a mesh");
    let placed = [(); 3].map(|()| {
        let placed = scene.add_instance(many, DAffine3::IDENTITY);
        placed.expect("a place")
    });
    scene.remove(placed[0]).expect("an instance");
    assert_eq!(scene.add_instance(one, DAffine3::IDENTITY), Ok(placed[0]));
    scene.set_name(placed[0], "leaf").expect("an instance");
    let first = scene.instance_first_id(0);
    assert_eq!(scene.prim_names(first)[0], Some("leaf"));
    assert_eq!(scene.prim_names(first + 1), [None; 2]);
    scene.remove(placed[0]).expect("an instance");
    assert!(scene.validate().is_ok());
    scene.instances.first[0] = 1000;
    assert!(scene.validate().is_err());
}

/// Checks that an instance which was hidden and shown while its prototype moved is where that is.
#[test]
fn instances_that_were_hidden_follow_their_prototype() {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut scene = Scene::new();
    let prototype = scene.add_prototype(&corners, &[[0, 1, 2]]);
    let prototype = prototype.expect("a mesh");
    let placed = scene.add_instance(prototype, DAffine3::IDENTITY);
    let placed = placed.expect("a place");
    let mut bvh = Bvh::build(&scene);
    scene.set_mask(placed, 0).expect("an instance");
    let moved = corners.map(|[x, y, z]| [x + 5.0, y, z]);
    scene
        .set_prototype_vertices(prototype, &moved)
        .expect("a mesh");
    scene.set_mask(placed, 1).expect("an instance");
    bvh.update(&scene);
    let hit = bvh.intersect(&Ray::new([5.0, 0.0, -1.0], [0.0, 0.0, 1.0]));
    assert_eq!(hit.map(|hit| hit.t), Some(1.0));
}

/// Checks that large parts stay as they are: refits keep the tree, and moved instances build only
/// the tree over them.
#[test]
fn what_stays_is_not_built() {
    let mut random = Rng::new(3);
    let (mut vertices, indices) = soup(&mut random, 3000);
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(&vertices, &indices).expect("a mesh");
    let prototype = scene.add_prototype(&vertices, &indices).expect("a mesh");
    let instances = [(); 20].map(|()| {
        let instance = scene.add_instance(prototype, map(&mut random));
        instance.expect("a place")
    });
    let mut bvh = Bvh::build(&scene);
    bvh.build_wide(1);
    let shape = |bvh: &Bvh| (bvh.nodes().len(), bvh.wide().nodes().len(), bvh.depth());
    let before = shape(&bvh);
    vertices
        .iter_mut()
        .for_each(|vertex| vertex[1] += 0.01 * vertex[0]);
    scene.set_vertices(mesh, &vertices).expect("a mesh");
    bvh.update(&scene);
    assert_eq!(shape(&bvh), before, "refitted");
    scene
        .set_transform(instances[3], map(&mut random))
        .expect("an instance");
    bvh.update(&scene);
    // The rows of the large meshes lie where they lay, from now on.
    let rows = bvh.leaf_prims().triangles.as_ptr();
    for instance in instances {
        scene
            .set_transform(instance, map(&mut random))
            .expect("an instance");
        bvh.update(&scene);
        assert_eq!(bvh.leaf_prims().triangles.as_ptr(), rows);
        assert!(bvh.has_wide());
    }
    assert_follows(&scene, &bvh, &mut random);
}

/// Checks that geometries come, go, hide and move beside a large mesh whose rows stay where they
/// are, that reports name them, and that refits are refused where something has to be built.
#[test]
fn updates_say_what_they_did_and_obey() {
    let mut random = Rng::new(13);
    let (vertices, indices) = soup(&mut random, 3000);
    let (small, few) = soup(&mut random, 40);
    let mut scene = Scene::new();
    let body = scene.add_mesh(&vertices, &indices).expect("a mesh");
    let prototype = scene.add_prototype(&small, &few).expect("a mesh");
    let placed = scene.add_instance(prototype, map(&mut random));
    let placed = placed.expect("a place");
    let mut bvh = Bvh::build(&scene);
    bvh.build_wide(1);
    assert_eq!(bvh.cost_growth(), 1.0);
    let rows = |bvh: &Bvh| {
        let rows = &bvh.leaf_prims().triangles[..indices.len()];
        rows.iter().map(|row| row.prim_id).collect::<Vec<_>>()
    };
    let before = rows(&bvh);
    let ball = scene.add_spheres(&[[0.0; 3]], &[0.5]).expect("a sphere");
    let refused = UpdateError::NotRefittable {
        geometries: vec![ball],
        prototypes: vec![],
    };
    assert_eq!(bvh.update_with(&scene, UpdateMode::RefitOnly), Err(refused));
    assert_eq!(bvh.update(&scene).built, [ball]);
    let sail = scene.add_mesh(&small, &few).expect("a mesh");
    let other = scene.add_prototype(&small, &few).expect("a mesh");
    let report = bvh.update(&scene);
    assert_eq!(report.built, [sail]);
    assert_eq!(report.built_prototypes, [other]);
    let moved: Vec<[f32; 3]> = small.iter().map(|v| [v[0], v[1] + 0.01, v[2]]).collect();
    scene.set_vertices(sail, &moved).expect("a mesh");
    let elsewhere = map(&mut random);
    scene.set_transform(placed, elsewhere).expect("a place");
    let refit = |bvh: &mut Bvh, scene: &Scene| {
        let report = bvh.update_with(scene, UpdateMode::RefitOnly);
        report.expect("nothing is built")
    };
    assert_eq!(refit(&mut bvh, &scene).refitted, [placed, sail]);
    scene.remove(ball).expect("a sphere");
    scene.set_mask(sail, 0).expect("a mesh");
    let report = refit(&mut bvh, &scene);
    assert_eq!(report.work, UpdateWork::Refitted);
    assert_eq!(report.removed, [ball, sail]);
    assert_follows(&scene, &bvh, &mut random);
    assert_eq!(rows(&bvh), before, "the large mesh stays");
    scene.set_mask(body, 3).expect("a mesh");
    assert_eq!(bvh.update(&scene).work, UpdateWork::Nothing);
    scene.add_sphere(Vec3::ZERO, 0.1, 0);
    let foreign = bvh.update_with(&scene, UpdateMode::RefitOnly);
    assert_eq!(foreign, Err(UpdateError::OtherScene));
    let rebuilt = bvh.update_with(&scene, UpdateMode::Rebuild);
    assert_eq!(rebuilt.expect("a build").work, UpdateWork::Rebuilt);
    assert_eq!(bvh.cost_growth(), 1.0);
}

/// Checks that a scene in which things come and go neither grows nor runs out of numbers, and that
/// its tree does not grow.
#[test]
fn what_comes_and_goes_takes_no_room() {
    let mut random = Rng::new(21);
    let mut scene = Scene::new();
    let (vertices, indices) = soup(&mut random, 300);
    scene.add_mesh(&vertices, &indices).expect("a mesh");
    let mut bvh = Bvh::build(&scene);
    let (mut present, mut half) = (Vec::new(), [0; 4]);
    let edits = full_or(1_000_000, 20_000);
    for edit in 0..edits {
        if present.len() == 8 || edit % 3 == 2 && !present.is_empty() {
            let gone = present.swap_remove(random.below(present.len()));
            scene.remove(gone).expect("a geometry");
        } else if edit % 2 == 0 {
            let count = 1 + random.below(40);
            let (vertices, indices) = soup(&mut random, count);
            present.push(scene.add_mesh(&vertices, &indices).expect("a mesh"));
        } else {
            let count = 1 + random.below(5);
            let centers = [(); 5].map(|()| random.point(1.0).to_array());
            let balls = scene.add_spheres(&centers[..count], &[0.1; 5][..count]);
            present.push(balls.expect("spheres"));
        }
        if edit % 97 == 0 {
            bvh.update(&scene);
        }
        let sizes = [
            scene.prim_count(),
            scene.triangles.vertices.len(),
            scene.geometries.len(),
            bvh.node_bytes() + bvh.prim_bytes(),
        ];
        if edit == edits / 2 {
            half = sizes;
        }
        let is_larger = |(now, then): (&usize, usize)| *now > then + then / 2;
        let grows = sizes.iter().zip(half).any(is_larger);
        assert!(edit <= edits / 2 || !grows, "{half:?} grew to {sizes:?}");
    }
    assert!(scene.geometries.len() < 100, "eight at a time");
    bvh.update(&scene);
    assert_follows(&scene, &bvh, &mut random);
}

/// Checks that a hidden mesh without triangles does not show a prototype that begins where it does.
#[test]
fn empty_hidden_meshes_show_nothing() {
    let corners = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let mut scene = Scene::new();
    let empty = scene.add_mesh(&corners, &[]).expect("a mesh");
    scene.add_prototype(&corners, &[[0, 1, 2]]).expect("a mesh");
    scene.set_mask(empty, 0).expect("a mesh");
    assert_eq!((scene.world_runs(), scene.visible_count()), (vec![], 0));
}

/// Checks that a tree which is queried again and again gets its wide half, and another does not.
#[test]
fn many_batches_build_the_wide_tree() {
    let mut random = Rng::new(5);
    let (vertices, indices) = soup(&mut random, 3000);
    let mut scene = Scene::new();
    scene.add_mesh(&vertices, &indices).expect("a mesh");
    let bvh = Bvh::build(&scene);
    let rays = (0..600).map(|_| Ray::new(random.point(2.0), random.point(1.0)));
    let (rays, mut hits): (RayBuffer, _) = (rays.collect(), HitBuffer::new(600));
    let has_wide = [(); 4].map(|()| {
        let batch = bvh.intersect_batch(&rays.columns(), &mut hits.columns(), 1);
        batch.expect("columns of one length");
        bvh.has_wide()
    });
    assert_eq!((has_wide[0], has_wide[3]), (false, true));
}

#[test]
fn wrong_edits_are_refused_and_change_nothing() {
    let mut scene = Scene::new();
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = scene.add_mesh(&corners, &[[0, 1, 2]]).expect("a mesh");
    let ball = scene.add_spheres(&[[0.0; 3]], &[1.0]).expect("a sphere");
    let prototype = scene.add_prototype(&corners, &[[0, 1, 2]]).expect("a mesh");
    let placed = scene
        .add_instance(prototype, DAffine3::IDENTITY)
        .expect("a place");
    let before = scene.edits();
    let none = |kind: &'static str, id| GeometryError::NoGeometry { kind, id };
    assert_eq!(scene.set_vertices(ball, &corners), Err(none("mesh", ball)));
    assert_eq!(
        scene.set_vertices(placed, &corners),
        Err(none("mesh", placed))
    );
    assert_eq!(scene.set_vertices(9, &corners), Err(none("mesh", 9)));
    assert_eq!(
        scene.set_prototype_vertices(1, &corners),
        Err(none("prototype", 1))
    );
    assert_eq!(
        scene.set_transform(mesh, DAffine3::IDENTITY),
        Err(none("instance", mesh))
    );
    assert_eq!(scene.set_mask(3, 1), Err(none("geometry", 3)));
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    assert_eq!(
        scene.set_transform(placed, flat),
        Err(GeometryError::NotInvertible)
    );
    let count = GeometryError::VertexCount {
        given: 2,
        vertices: 3,
    };
    assert_eq!(scene.set_vertices(mesh, &corners[..2]), Err(count));
    let bad = scene.set_vertices(mesh, &[[f32::NAN; 3]; 3]);
    assert!(matches!(
        bad,
        Err(GeometryError::NotFinite { vertex: 0, .. })
    ));
    assert_eq!(scene.edits(), before);
    scene.set_vertices(mesh, &corners).expect("a mesh");
    assert_ne!(scene.edits(), before);
}
