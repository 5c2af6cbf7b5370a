//! Partly transparent and fully transparent surfaces, and light that passes through them: their
//! definition, and the same bits from both engines and every kernel, wherever such surfaces are.

use crate::common::frames::{difference, frame_of};
use crate::common::rng::Rng;
use crate::common::scenes::random_map;
use crate::environments::random_environment;
use crate::maps::{random_lobes, random_maps, random_tangents};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use phalanx::frame::{Accel, Engine, Integrator, Settings};
use phalanx::sampling::{Adaptive, Sampling};
use phalanx::scene::{
    Environment, EnvironmentLight, Material, Mesh, MeshMaterial, NO_INDEX, NO_TEXTURE, SHADOWLESS,
    Scene, Texture, UpAxis, View, Wrap,
};
use phalanx::trace::Kernel;
use std::time::{Duration, Instant};

/// A picture of 3 × 3 pixels of walls, seen along −z from (0, 0, 4).
fn empty() -> Scene {
    Scene {
        width: 3,
        height: 3,
        max_depth: 0,
        background: Vec3::new(0.25, 0.5, 1.0),
        view: View {
            eye: Vec3::new(0.0, 0.0, 4.0),
            center: Vec3::ZERO,
            up: Vec3::Y,
            fovy: 20.0,
            ortho: None,
        },
        ..Scene::default()
    }
}

/// Adds a square of half side `half` in the plane of this z, facing the camera.
fn add_wall(scene: &mut Scene, z: f32, half: f32, material: &Material) {
    let row = scene.materials.push(material);
    let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, z);
    let [a, b, c, d] = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    scene.add_triangle([a, b, c], None, row);
    scene.add_triangle([a, c, d], None, row);
}

/// An emissive surface of one colour, with this opacity.
fn shining(color: Vec3, opacity: f32) -> Material {
    Material {
        ka: Vec3::ZERO,
        ke: color,
        opacity,
        ..Material::DEFAULT
    }
}

/// A surface that scatters all light.
fn white(opacity: f32) -> Material {
    Material {
        ka: Vec3::ZERO,
        kd: Vec3::ONE,
        opacity,
        ..Material::DEFAULT
    }
}

/// The middle pixel, after checking that every kernel, with and without adaptive cells, agrees with
/// the oracle.
fn middle(scene: &Scene) -> Vec3 {
    assert_same_everywhere(scene, "");
    let prepared = Accel::build(scene, Engine::Simd);
    let frame = frame_of(scene, &prepared, Settings::of(scene));
    frame.film.pixel(scene.width / 2, scene.height / 2).into()
}

pub fn assert_same_everywhere(scene: &Scene, what: &str) {
    scene.validate().expect("a scene");
    let [packets, oracle] = [Engine::Simd, Engine::Scalar].map(|e| Accel::build(scene, e));
    let halved = Sampling {
        spp: 4,
        adaptive: Some(Adaptive { threshold: 0.01 }),
        ..Sampling::CENTER
    };
    let occlusion = Integrator::Occlusion { distance: 3.0 };
    for (sampling, integrator) in [
        (Sampling::CENTER, Integrator::Whitted),
        (halved, Integrator::Whitted),
        (Sampling::CENTER, occlusion),
    ] {
        let settings = Settings {
            record_hits: true,
            sampling,
            integrator,
            ..Settings::of(scene)
        };
        let want = frame_of(
            scene,
            &oracle,
            Settings {
                engine: Engine::Scalar,
                ..settings.clone()
            },
        );
        for (name, kernel) in Kernel::ALL {
            let tile = if name.ends_with("16") { 8 } else { 32 };
            let settings = Settings {
                kernel,
                tile,
                ..settings.clone()
            };
            let got = frame_of(scene, &packets, settings);
            let differs = difference(&got, &want);
            assert_eq!(differs, None, "{what} {name} {integrator:?} {sampling:?}");
        }
    }
}

#[test]
fn what_is_not_covered_shows_what_is_behind() {
    let (red, blue) = (Vec3::X, Vec3::Z);
    let mut scene = empty();
    let behind = scene.background;
    assert_eq!(middle(&scene), behind);
    add_wall(&mut scene, 0.0, 9.0, &shining(red, 0.25));
    assert_eq!(middle(&scene), red * 0.25 + behind * 0.75);
    add_wall(&mut scene, -1.0, 9.0, &shining(blue, 0.5));
    let rest = blue * 0.5 + behind * 0.5;
    assert_eq!(middle(&scene), red * 0.25 + rest * 0.75);
    // Fully transparent.
    add_wall(&mut scene, 1.0, 9.0, &shining(Vec3::ONE, 0.0));
    assert_eq!(middle(&scene), red * 0.25 + rest * 0.75);
}

/// Decals lie in the plane of their wall.
#[test]
fn surfaces_in_one_plane_are_met_in_the_order_of_their_numbers() {
    let (red, blue) = (Vec3::X, Vec3::Z);
    let mut scene = empty();
    add_wall(&mut scene, 0.0, 9.0, &shining(red, 0.5));
    add_wall(&mut scene, 0.0, 9.0, &shining(blue, 1.0));
    assert_eq!(middle(&scene), red * 0.5 + blue * 0.5);
    let mut scene = empty();
    for _ in 0..3 {
        add_wall(&mut scene, 0.0, 9.0, &shining(red, 0.5));
    }
    assert_eq!(middle(&scene), red * 0.875 + scene.background * 0.125);
}

#[test]
fn rays_pass_more_surfaces_than_they_may_bounce() {
    let mut scene = empty();
    for k in 0..20 {
        add_wall(
            &mut scene,
            -0.1 * k as f32,
            9.0,
            &shining(Vec3::ZERO, 0.0625),
        );
    }
    let left = (0.9375f32).powi(20);
    assert!(
        (middle(&scene) - scene.background * left)
            .abs()
            .max_element()
            < 1e-6
    );
}

/// Each ray continues through all of them, as does the light of the lamp behind them. The test
/// bounds the number of traversals, and checks that both engines agree.
#[test]
fn surfaces_in_one_place_take_few_traversals() {
    let packets = |opacity: f32, surfaces: usize| {
        let mut scene = empty();
        add_wall(&mut scene, -1.0, 9.0, &white(1.0));
        let screen = scene.materials.push(&white(opacity));
        let corners = [[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]];
        let corners = corners.map(|[x, y]| Vec3::new(x, y, 0.0));
        let mesh = scene.begin_mesh();
        scene.add_triangle(corners, None, screen);
        scene.end_mesh(mesh);
        for k in 0..surfaces {
            if k % 5 == 0 {
                (scene.add_instance(mesh, DAffine3::IDENTITY)).expect("invertible");
            } else {
                scene.add_triangle(corners, None, screen);
            }
        }
        scene.lights.add_directional(Vec3::Z, Vec3::ONE);
        if surfaces < 1000 {
            assert_same_everywhere(&scene, "in one place");
        }
        let prepared = Accel::build(&scene, Engine::Simd);
        let stats = frame_of(&scene, &prepared, Settings::of(&scene)).stats;
        stats.packets
    };
    for opacity in [0.0, 0.001, 0.5, 0.999] {
        let [few, many] = [300, 3000].map(|surfaces| packets(opacity, surfaces));
        assert!(many <= 2 * few, "{opacity}: {few}, {many}");
    }
}

#[test]
fn a_light_without_shadows_shines_through_everything() {
    let mut scene = empty();
    scene.view.ortho = Some(0.1);
    add_wall(&mut scene, 0.0, 9.0, &white(1.0));
    // Behind the camera: what it hides from, the others shine through.
    add_wall(&mut scene, 5.0, 9.0, &white(1.0));
    scene.lights.add_fill(Vec3::Z, Vec3::splat(0.5));
    scene.lights.add_directional(Vec3::Z, Vec3::ONE);
    scene.lights.add_point(Vec3::Z * 8.0, Vec3::X, Vec3::X);
    scene.lights.flags[2] = SHADOWLESS;
    assert_eq!(middle(&scene), Vec3::new(1.5, 0.5, 0.5));
    for engine in [Engine::Simd, Engine::Scalar] {
        let settings = Settings {
            engine,
            ..Settings::of(&scene)
        };
        let stats = frame_of(&scene, &Accel::build(&scene, engine), settings).stats;
        // One toward the light that casts shadows.
        assert_eq!((stats.rays.primary, stats.rays.shadow), (9, 9));
    }
}

/// The light on a wall from a lamp behind the camera, with screens that only the light passes.
fn lit_through(screens: &[Material]) -> Vec3 {
    let heights = (0..).map(|k| 5.0 + k as f32);
    let screens: Vec<(Material, f32)> = screens.iter().copied().zip(heights).collect();
    lit_at(&screens)
}

/// As [`lit_through`], with the screens at given heights.
fn lit_at(screens: &[(Material, f32)]) -> Vec3 {
    let mut scene = empty();
    scene.view.ortho = Some(0.1);
    add_wall(&mut scene, 0.0, 9.0, &white(1.0));
    for (screen, height) in screens {
        // Behind the camera, and in front of the lamp.
        add_wall(&mut scene, *height, 9.0, screen);
    }
    scene.lights.add_directional(Vec3::Z, Vec3::ONE);
    middle(&scene)
}

#[test]
fn light_passes_as_much_as_is_not_covered() {
    let half = white(0.5);
    let sheet = Material {
        kt: Vec3::new(1.0, 0.5, 0.0),
        thin: true,
        ..white(1.0)
    };
    assert_eq!(lit_through(&[]), Vec3::ONE);
    assert_eq!(lit_through(&[white(1.0)]), Vec3::ZERO);
    assert_eq!(lit_through(&[white(0.0)]), Vec3::ONE);
    assert_eq!(lit_through(&[half]), Vec3::splat(0.5));
    assert_eq!(lit_through(&[half, half]), Vec3::splat(0.25));
    assert_eq!(lit_through(&[half, white(1.0), half]), Vec3::ZERO);
    // In one plane, on the edge between two triangles.
    assert_eq!(lit_at(&[(half, 5.0), (half, 5.0)]), Vec3::splat(0.25));
    assert_eq!(lit_through(&[sheet]), Vec3::new(1.0, 0.5, 0.0));
    assert_eq!(lit_through(&[sheet, half]), Vec3::new(0.5, 0.25, 0.0));
    // Refractive glass keeps its shadow.
    let glass = Material {
        thin: false,
        ior: 1.5,
        ..sheet
    };
    assert_eq!(lit_through(&[glass]), Vec3::ZERO);
    assert_eq!(lit_through(&[half, glass]), Vec3::ZERO);
}

/// Walls with the front toward +z, directly and under mirroring instances.
#[test]
fn single_sided_walls_are_seen_from_the_front_alone() {
    let shown = |turned: bool, material: &Material, map: Option<DVec3>| {
        let mut scene = empty();
        if turned {
            scene.view.eye.z = -4.0;
        }
        let mesh = map.map(|_| scene.begin_mesh());
        add_wall(&mut scene, 0.0, 9.0, material);
        if let (Some(mesh), Some(scale)) = (mesh, map) {
            scene.end_mesh(mesh);
            let placed = scene.add_instance(mesh, DAffine3::from_scale(scale));
            placed.expect("invertible");
        }
        middle(&scene)
    };
    let behind = empty().background;
    for opacity in [1.0, 0.5] {
        let red = shining(Vec3::X, opacity);
        let seen = Vec3::X * opacity + behind * (1.0 - opacity);
        let one_sided = Material {
            single_sided: true,
            ..red
        };
        assert_eq!(shown(true, &red, None), seen);
        for (map, is_turned) in [
            (None, false),
            (Some(DVec3::ONE), false),
            // Mirrored, front faces stay front faces.
            (Some(DVec3::new(-1.0, 1.0, 1.0)), false),
            (Some(DVec3::new(1.0, 1.0, -1.0)), true),
        ] {
            assert_eq!(shown(is_turned, &one_sided, map), seen, "{map:?}");
            assert_eq!(shown(!is_turned, &one_sided, map), behind, "{map:?}");
        }
    }
    // The lamp is above the front of the screens, and the lit surface below their backs.
    let screen = Material {
        single_sided: true,
        ..white(1.0)
    };
    assert_eq!(lit_through(&[screen]), Vec3::ZERO);
}

/// A floor that reflects the back of a wall, or not, and a wall seen through its back.
#[test]
fn mirrors_and_layers_pass_backs() {
    let mirrored = |single_sided: bool| {
        let mut scene = empty();
        scene.max_depth = 1;
        let mirror = Material {
            ka: Vec3::ZERO,
            ks: Vec3::ONE,
            ..Material::DEFAULT
        };
        add_wall(&mut scene, 0.0, 9.0, &mirror);
        // Behind the camera, and turned away from the mirror.
        let red = Material {
            single_sided,
            ..shining(Vec3::X, 1.0)
        };
        add_wall(&mut scene, 5.0, 9.0, &red);
        middle(&scene)
    };
    assert_eq!(mirrored(false), Vec3::X);
    assert_eq!(mirrored(true), empty().background);
    let mut scene = empty();
    scene.view.eye.z = -4.0;
    add_wall(&mut scene, 0.0, 9.0, &shining(Vec3::Z, 1.0));
    let red = Material {
        single_sided: true,
        ..shining(Vec3::X, 1.0)
    };
    add_wall(&mut scene, -1.0, 9.0, &red);
    let prepared = Accel::build(&scene, Engine::Simd);
    let settings = Settings {
        record_hits: true,
        ..Settings::of(&scene)
    };
    let frame = frame_of(&scene, &prepared, settings);
    let hits = frame.film.hits.as_ref().expect("recorded hits");
    assert!(hits.prim_id.iter().all(|&id| id < 2), "{:?}", hits.prim_id);
    // Nine pixels, three of which look at the edge between two triangles.
    assert_eq!(frame.stats.unseen_backs, 12);
}

#[test]
fn a_mirror_sees_the_sky_and_the_camera_the_background() {
    let mut scene = empty();
    scene.max_depth = 1;
    let sky = EnvironmentLight::Gradient {
        nadir: Vec3::ZERO,
        zenith: Vec3::new(2.0, 4.0, 8.0),
    };
    let mut environment = Environment::new(sky, UpAxis::Z, 0.0);
    environment.is_background = false;
    scene.environment = Some(environment);
    assert_eq!(middle(&scene), scene.background);
    let mirror = Material {
        ka: Vec3::ZERO,
        ks: Vec3::ONE,
        opacity: 0.5,
        ..Material::DEFAULT
    };
    add_wall(&mut scene, 0.0, 9.0, &mirror);
    // Straight back up, and straight on.
    let want = Vec3::new(1.0, 2.0, 4.0) + scene.background * 0.5;
    assert!((middle(&scene) - want).abs().max_element() < 1e-6);
}

#[test]
fn a_spot_lights_a_cone() {
    let lit = |angle: f32| {
        let mut scene = empty();
        scene.view.ortho = Some(0.01);
        add_wall(&mut scene, 0.0, 9.0, &white(1.0));
        let axis = Vec3::new(angle.sin(), 0.0, -angle.cos());
        let (place, cone) = (Vec3::new(0.0, 0.0, 2.0), [0.2, 0.4]);
        (scene.lights).add_spot(place, Vec3::ONE, Vec3::X, axis, cone);
        middle(&scene).x
    };
    assert_eq!(lit(0.0), 1.0);
    assert!(lit(0.19) > 0.999);
    assert_eq!(lit(0.41), 0.0);
    let share = |angle: f32| (angle.cos() - 0.4f32.cos()) / (0.2f32.cos() - 0.4f32.cos());
    assert!((lit(0.3) - share(0.3).powi(2)).abs() < 1e-4);
}

/// Reversed vertex order with correct normals, as exporters of mirrored parts write them.
#[test]
fn normals_of_the_file_say_which_side_is_lit() {
    let seen = |reversed: bool, normal: f32| {
        let mut scene = empty();
        let row = scene.materials.push(&white(1.0));
        let mut corners =
            [[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        if reversed {
            corners.swap(0, 1);
        }
        scene.add_triangle(corners, Some([Vec3::Z * normal; 3]), row);
        scene.lights.add_directional(Vec3::Z, Vec3::ONE);
        middle(&scene)
    };
    for normal in [1.0, -1.0] {
        assert_eq!(seen(false, normal), Vec3::ONE);
        assert_eq!(seen(true, normal), Vec3::ONE);
    }
}

/// Normals in the plane of their triangle do not determine its sides.
#[test]
fn normals_in_the_plane_leave_no_speckles() {
    let mut scene = empty();
    (scene.width, scene.height) = (40, 40);
    scene.view.eye = Vec3::new(-2.0, 1.0, 3.0);
    let row = scene.materials.push(&white(1.0));
    let corners = [[-1.0, -1.0], [1.0, -1.0], [0.3, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.1 * x));
    let along = (corners[1] - corners[0]).normalize();
    scene.add_triangle(corners, Some([along; 3]), row);
    scene
        .lights
        .add_directional(Vec3::new(0.9, 0.3, 0.5).normalize(), Vec3::ONE);
    assert_same_everywhere(&scene, "in the plane");
    let prepared = Accel::build(&scene, Engine::Simd);
    let film = frame_of(&scene, &prepared, Settings::of(&scene)).film;
    let pixels = || (0..40).flat_map(|y| (0..40).map(move |x| (x, y)));
    let seen = pixels().map(|(x, y)| Vec3::from(film.pixel(x, y)));
    let seen: Vec<Vec3> = seen.filter(|&c| c != scene.background).collect();
    assert!(seen.len() > 100, "a picture of something");
    let alike = |c: &Vec3| (*c - seen[0]).abs().max_element() < 1e-5;
    assert!(seen.iter().all(alike), "one colour");
}

fn random_texture(rng: &mut Rng) -> Texture {
    let nearest = rng.once_in(3);
    let (width, height) = (1 + rng.below(5) as u32, 1 + rng.below(5) as u32);
    let texels = (0..width * height).map(|_| [0; 3].map(|_| rng.bits() as u8));
    let texels: Vec<[u8; 3]> = texels.collect();
    let alpha = (0..width * height).map(|_| rng.pick(&[0, 0, 255, 255, 90, 200]));
    Texture {
        width,
        height,
        wrap: [Wrap::Repeat, Wrap::Clamp],
        nearest,
        alpha: alpha.collect(),
        texels: texels.into(),
    }
}

fn random_material(rng: &mut Rng, textures: usize) -> Material {
    let texture = |rng: &mut Rng| match rng.below(2) {
        0 => NO_TEXTURE,
        _ => rng.below(textures) as u32,
    };
    Material {
        ka: rng.color() * 0.3,
        kd: rng.color(),
        ks: rng.pick(&[Vec3::ZERO, Vec3::ZERO, Vec3::splat(0.4)]),
        kt: rng.pick(&[Vec3::ZERO, Vec3::ZERO, Vec3::new(0.5, 0.2, 0.0)]),
        ior: rng.pick(&[1.0, 1.0, 1.5]),
        gloss: rng.pick(&[0.0, 0.0, 0.0, 50.0]),
        highlight: rng.pick(&[Vec3::ZERO, Vec3::ZERO, Vec3::new(0.5, 0.04, 0.0)]),
        shininess: 20.0,
        texture: texture(rng),
        opacity: rng.pick(&[1.0, 1.0, 0.0, 0.5, 0.3]),
        opacity_texture: texture(rng),
        alpha_cutoff: rng.pick(&[0.0, 0.0, 0.5]),
        thin: rng.once_in(3),
        single_sided: rng.once_in(3),
        metallic_roughness: random_lobes(rng),
        ..Material::DEFAULT
    }
}

/// Triangles of all such surfaces, many of them in one plane, spheres, lights of all kinds, and in
/// half of the scenes instances of everything, and in half of them smooth shadows.
fn random_scene(seed: u64) -> Scene {
    let rng = &mut Rng::new(seed);
    let mut scene = Scene {
        width: 36,
        height: 28,
        max_depth: rng.below(4) as u32,
        ..empty()
    };
    scene.view.fovy = 45.0;
    scene.textures = (0..3).map(|_| random_texture(rng)).collect();
    for _ in 0..8 {
        let maps = scene.maps.push_all(&random_maps(rng, 3));
        let material = random_material(rng, 3);
        scene.materials.push(&Material { maps, ..material });
    }
    let mut mesh = Mesh::default();
    let (mut corners, mut uvs, mut colors, mut rows) = (vec![], vec![], vec![], vec![]);
    let (mut normals, mut tangents) = (vec![], vec![]);
    for k in 0..70u32 {
        let flat = if rng.once_in(3) { 0.0 } else { 1.0 };
        let point = rng.point(0.8) * Vec3::new(1.0, 1.0, flat);
        (0..3).for_each(|_| {
            mesh.vertices
                .push(point + rng.point(0.7) * Vec3::new(1.0, 1.0, flat))
        });
        // Two layers.
        (0..6).for_each(|_| {
            mesh.vertex_uvs
                .push(Vec2::new(rng.range(-1.0, 2.0), rng.unit()))
        });
        (0..3).for_each(|_| mesh.vertex_normals.push(rng.direction()));
        (0..3).for_each(|_| mesh.vertex_colors.push(rng.color()));
        let row = [3 * k, 3 * k + 1, 3 * k + 2];
        corners.push(row);
        let pairs = row.map(|vertex| 2 * vertex);
        uvs.push(if rng.once_in(5) { [NO_INDEX; 3] } else { pairs });
        normals.push(if rng.once_in(2) { [NO_INDEX; 3] } else { row });
        tangents.push(if rng.once_in(3) { [NO_INDEX; 3] } else { row });
        colors.push(if rng.once_in(3) { [NO_INDEX; 3] } else { row });
        rows.push(rng.below(8) as u32);
    }
    mesh.vertex_opacity = (0..210).map(|_| rng.pick(&[1.0, 1.0, 0.5, 0.0])).collect();
    (mesh.corners, mesh.uvs, mesh.colors) = (corners.into(), uvs.into(), colors.into());
    let (directions, signs) = random_tangents(rng, 210);
    directions
        .into_iter()
        .for_each(|t| mesh.vertex_tangents.push(t));
    (mesh.normals, mesh.tangents, mesh.bitangent_signs) =
        (normals.into(), tangents.into(), signs.into());
    mesh.material = MeshMaterial::Each(rows.into());
    let placed = seed.is_multiple_of(2).then(|| scene.begin_mesh());
    scene.smooth_shadows = (seed / 2).is_multiple_of(2);
    scene.append_mesh(mesh);
    scene.add_sphere(rng.point(0.8), 0.3, 1);
    scene.add_sphere(rng.point(0.8), 0.3, 2);
    if let Some(mesh) = placed {
        scene.end_mesh(mesh);
        for _ in 0..3 {
            let map = random_map(rng, 1.0);
            scene.add_instance(mesh, map).expect("invertible");
        }
    }
    if rng.once_in(2) {
        scene.add_missing_tangents();
    }
    scene
        .lights
        .add_directional(rng.direction(), Vec3::splat(0.5));
    let place = rng.direction() * 3.0;
    let cone = [0.1, rng.range(0.2, 1.5)];
    (scene.lights).add_spot(place, Vec3::splat(2.0), Vec3::X, -place.normalize(), cone);
    if rng.once_in(3) {
        let (center, dim) = (rng.point(3.0), Vec3::splat(0.3));
        scene.lights.add_sphere(center, 0.4, dim, Vec3::X);
    }
    scene.view.eye = rng.direction() * 3.0;
    scene.view.ortho = rng.once_in(3).then_some(2.5);
    scene.environment = rng.once_in(2).then(|| random_environment(rng));
    scene
}

#[test]
fn both_engines_and_all_kernels_agree_on_surfaces_that_are_partly_there() {
    // As long as `random_scenes` runs, and from the same seed.
    let variable = |name: &str| std::env::var(name).ok()?.parse::<u64>().ok();
    let end = variable("PHALANX_HUNT_SECONDS").map(Duration::from_secs);
    let (first, start) = (variable("PHALANX_HUNT_SEED").unwrap_or(0), Instant::now());
    let goes_on = |seed: &u64| match end {
        Some(end) => start.elapsed() < end,
        None => *seed < first + 24,
    };
    let mut scenes = 0;
    for seed in (first..).take_while(goes_on) {
        assert_same_everywhere(&random_scene(seed), &format!("seed {seed}"));
        scenes += 1;
    }
    println!("{scenes} scenes from seed {first} on");
}
