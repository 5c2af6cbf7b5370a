//! The scene cache: a scene survives the round trip unchanged, and nothing else is accepted.

mod hostile;
mod pictures;
mod refused;

use crate::common::rng::Rng;
use crate::common::scenes;
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use phalanx::bvh::Bvh;
use phalanx::cache::{self, Cached};
use phalanx::frame::{Accel, Control, Engine, Frame, Kernel, Settings, render};
use phalanx::scene::{
    Material, Mesh, MeshMaterial, NO_INDEX, NO_NAME, OutputEncoding, Scene, SceneCamera, Texture,
    View, Wrap,
};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A scene with something in every column, and its tree.
fn scene(seed: u64, prims: usize) -> (Scene, Bvh) {
    let mut rng = Rng::new(seed);
    let mut scene = scenes::random(&mut rng, prims, 4.0);
    scene.textures.push(Texture {
        width: 3,
        height: 2,
        wrap: [Wrap::Mirror, Wrap::Clamp],
        nearest: true,
        texels: vec![[1, 2, 3], [4, 5, 6], [7, 8, 9], [0; 3], [255; 3], [9; 3]].into(),
        alpha: Default::default(),
    });
    let glass = scene.materials.push(&Material {
        kd: Vec3::splat(0.4),
        ks: Vec3::splat(0.2),
        highlight: Vec3::splat(0.04),
        kt: Vec3::splat(0.3),
        ior: 1.4,
        texture: 0,
        gloss: 50.0,
        ..Material::default()
    });
    let mut mesh = Mesh {
        corners: vec![[0, 1, 2], [1, 3, 2]].into(),
        uvs: vec![[0, 1, 2], [NO_INDEX; 3]].into(),
        material: MeshMaterial::One(glass),
        ..Mesh::default()
    };
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        mesh.vertices.push(Vec3::new(x, y, 0.25));
        mesh.vertex_uvs.push(Vec2::new(x * 2.0, y));
    }
    let run = scene.begin_mesh();
    scene.append_mesh(mesh);
    scene.add_sphere(Vec3::new(0.5, 0.5, 0.5), 0.2, glass);
    scene.end_mesh(run);
    let other = scene.begin_mesh();
    for _ in 0..prims / 4 + 1 {
        scene.add_sphere(rng.point(0.5), 0.1, glass);
    }
    scene.end_mesh(other);
    scene
        .add_spheres(&[[0.0, 3.0, 0.0], [0.5, 3.0, 0.0]], &[0.2, 0.1])
        .expect("a geometry");
    for k in 0..7 {
        let turn = DQuat::from_rotation_y(f64::from(k));
        let position = rng.point(3.0).as_dvec3();
        let map = DAffine3::from_scale_rotation_translation(DVec3::splat(0.7), turn, position);
        let mesh = if k % 3 == 0 { other } else { run };
        scene.add_instance(mesh, map).expect("an invertible map");
    }
    let names = ["ä\0", "b", "c"].map(|name| scene.names.intern(name.as_bytes()));
    (scene.names).name_run(0..scene.prim_count() as u32, names[0], Some(names[1]));
    scene.set_name(1, "c").expect("a geometry");
    scene.lights.add_point(Vec3::splat(6.0), Vec3::ONE, Vec3::X);
    scene.lights.add_directional(Vec3::Y, Vec3::splat(0.3));
    let (dim, fading) = (Vec3::splat(0.2), Vec3::new(0.5, 0.1, 0.0));
    scene.lights.add_sphere(Vec3::splat(-5.0), 0.5, dim, fading);
    scene.lights.add_fill(Vec3::X, dim);
    let edges = [Vec3::new(1.0, 2.0, 0.0), Vec3::new(0.0, -1.0, 3.0)];
    scene
        .lights
        .add_rectangle(Vec3::Z * 7.0, edges, dim, fading);
    scene.view = View {
        eye: Vec3::new(1.0, 2.0, 11.0),
        center: Vec3::ZERO,
        up: Vec3::Y,
        fovy: 40.0,
        ortho: None,
    };
    let camera = SceneCamera {
        name: names[2],
        view: scene.view,
        ortho_size: None,
        width: 7,
    };
    let parallel = View {
        ortho: Some(3.0),
        ..scene.view
    };
    scene.cameras = vec![
        camera,
        SceneCamera {
            name: NO_NAME,
            view: parallel,
            ortho_size: Some([4.0, 3.0]),
            ..camera
        },
    ];
    (scene.width, scene.height, scene.max_depth) = (24, 16, 3);
    scene.output = Some("shown.png".to_owned());
    scene.encoding = OutputEncoding::SRGB;
    scene.background = Vec3::new(0.1, 0.2, 0.3);
    scene.validate().expect("a valid scene");
    let bvh = Bvh::build(&scene);
    (scene, bvh)
}

fn bytes_of(scene: &Scene, bvh: &Bvh) -> Vec<u8> {
    let mut bytes = Vec::new();
    let written = cache::write(&mut bytes, scene, bvh).expect("writing to memory");
    assert_eq!(written, bytes.len() as u64);
    bytes
}

/// A folder with a file that is rewritten repeatedly.
struct CacheFolder {
    _folder: TempDir,
    path: PathBuf,
}

impl CacheFolder {
    fn new() -> CacheFolder {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.phx");
        CacheFolder {
            _folder: folder,
            path,
        }
    }

    fn open(&self, bytes: &[u8]) -> Result<Cached, cache::CacheError> {
        // Another file each time: a mapped one must not change.
        let _ = std::fs::remove_file(&self.path);
        std::fs::write(&self.path, bytes).expect("a file");
        cache::open(&self.path)
    }
}

fn frame(scene: &Scene, prepared: &Accel, engine: Engine, kernel: Kernel) -> Frame {
    let settings = Settings {
        engine,
        kernel,
        record_hits: true,
        ..Settings::of(scene)
    };
    render(scene, prepared, &settings, &Control::default()).expect("nobody interrupts")
}

#[test]
fn a_cache_gives_back_every_bit() {
    let room = CacheFolder::new();
    for (seed, prims) in [(1, 300), (2, 3), (3, 0)] {
        let (scene, bvh) = scene(seed, prims);
        let bytes = bytes_of(&scene, &bvh);
        let cached = room.open(&bytes).expect("a cache");
        // All columns, all arrays and all settings are in the bytes: equal ones are equal scenes.
        assert_eq!(bytes_of(&cached.scene, &cached.bvh), bytes);
        assert_eq!(cached.bvh.depth(), bvh.depth());
        assert_eq!(cached.scene.output, scene.output);
        assert_eq!(format!("{:?}", cached.scene), format!("{scene:?}"));
        cached.scene.validate().expect("a valid scene");
        let prepared = Accel::with_tree(cached.bvh);
        let built = Accel::build(&scene, Engine::Simd);
        let simd = |scene, prepared| frame(scene, prepared, Engine::Simd, Kernel::Auto);
        let (ours, theirs) = (simd(&cached.scene, &prepared), simd(&scene, &built));
        assert_eq!(ours.film, theirs.film);
        assert!(
            prims < 100
                || ours
                    .film
                    .hits
                    .is_some_and(|h| h.prim_id.iter().any(|&p| p > 400))
        );
    }
}

#[test]
fn an_empty_scene_can_be_stored() {
    let (scene, bvh) = (Scene::default(), Bvh::default());
    let bytes = bytes_of(&scene, &bvh);
    let cached = CacheFolder::new().open(&bytes).expect("a cache");
    assert_eq!(bytes_of(&cached.scene, &cached.bvh), bytes);
}

/// A column keeps the mapping alive, even if the file is removed and the other columns are dropped.
#[test]
fn columns_outlive_the_file_and_each_other() {
    let (scene, bvh) = scene(5, 40);
    let room = CacheFolder::new();
    let mut cached = room.open(&bytes_of(&scene, &bvh)).expect("a cache");
    drop(room);
    let vertices = cached.scene.triangles.vertices.clone();
    cached.scene.triangles.vertices.x[0] = 77.0;
    assert_eq!(cached.scene.triangles.vertices.x[0], 77.0);
    drop(cached);
    assert_eq!(vertices, scene.triangles.vertices);
}

#[test]
fn many_open_one_file_at_once() {
    let (scene, bvh) = scene(6, 200);
    let room = CacheFolder::new();
    let bytes = bytes_of(&scene, &bvh);
    std::fs::write(&room.path, &bytes).unwrap();
    let open = |path: &Path| {
        let cached = cache::open(path).expect("a cache");
        assert_eq!(bytes_of(&cached.scene, &cached.bvh), bytes);
    };
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| (0..5).for_each(|_| open(&room.path)));
        }
    });
}
