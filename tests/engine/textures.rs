//! Textures: appearance at texels, between texels and beyond the edges, and the same bits from both
//! engines for any texture coordinates.

use crate::common::rng::Rng;
use glam::{DAffine3, Vec2, Vec3};
use phalanx::frame::{Accel, Control, Engine, Settings, render};
use phalanx::render::Film;
use phalanx::sampling::linear_of_srgb;
use phalanx::scene::{
    Material, Mesh, MeshMaterial, NO_INDEX, Scene, Texture, Vec2s, Vec3s, View, Wrap,
};

/// Both engines' film, after asserting that it is the same.
pub(crate) fn film(scene: &Scene) -> Film {
    scene.validate().expect("a scene");
    let rendered_by = |engine: Engine| {
        let settings = Settings {
            engine,
            ..Settings::of(scene)
        };
        let prepared = Accel::build(scene, engine);
        let frame = render(scene, &prepared, &settings, &Control::default()).expect("a frame");
        (frame.film, frame.stats.rays)
    };
    let (simd, scalar) = (rendered_by(Engine::Simd), rendered_by(Engine::Scalar));
    let (width, height) = (scene.width, scene.height);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let bits = |film: &Film| Vec3::from(film.pixel(x, y)).to_array().map(f32::to_bits);
        assert_eq!(bits(&simd.0), bits(&scalar.0), "pixel {x} {y}");
    }
    assert_eq!(simd.1, scalar.1);
    simd.0
}

pub(crate) fn texture(
    width: u32,
    height: u32,
    wrap: [Wrap; 2],
    texel: impl Fn(u32, u32) -> [u8; 3],
) -> Texture {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Texture {
        width,
        height,
        wrap,
        nearest: false,
        texels: places.map(|(x, y)| texel(x, y)).collect(),
        alpha: Default::default(),
    }
}

/// A square of side 2 around the origin that just fills the picture, lit only by its Ka. `uvs` are
/// those of its lower left, lower right, upper right and upper left corner.
pub(crate) fn square(size: [u32; 2], texture: Texture, uvs: Option<[Vec2; 4]>) -> Scene {
    let mut scene = Scene {
        width: size[0],
        height: size[1],
        view: View {
            eye: Vec3::new(0.0, 0.0, 1.0),
            center: Vec3::ZERO,
            up: Vec3::Y,
            fovy: 90.0,
            ortho: None,
        },
        ..Scene::default()
    };
    scene.textures.push(texture);
    let material = scene.materials.push(&Material {
        ka: Vec3::ONE,
        texture: 0,
        ..Material::default()
    });
    let mut mesh = Mesh {
        corners: vec![[0, 1, 2], [0, 2, 3]].into(),
        material: MeshMaterial::One(material),
        ..Mesh::default()
    };
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        mesh.vertices.push(Vec3::new(x, y, 0.0));
    }
    if let Some(uvs) = uvs {
        uvs.into_iter().for_each(|uv| mesh.vertex_uvs.push(uv));
        mesh.uvs = mesh.corners.clone();
    }
    scene.append_mesh(mesh);
    scene
}

const WHOLE_PICTURE: [Vec2; 4] = [
    Vec2::new(0.0, 1.0),
    Vec2::new(1.0, 1.0),
    Vec2::new(1.0, 0.0),
    Vec2::new(0.0, 0.0),
];

fn linear(texel: [u8; 3]) -> Vec3 {
    Vec3::from_array(texel.map(|byte| linear_of_srgb()[usize::from(byte)]))
}

fn assert_near(got: [f32; 3], want: Vec3, within: f32, what: &str) {
    let got = Vec3::from(got);
    assert!(
        (got - want).abs().max_element() <= within,
        "{what}: {got}, not {want}"
    );
}

#[test]
fn a_plane_seen_straight_on_reproduces_its_texture() {
    let texel = |x: u32, y: u32| {
        [
            (x * 36) as u8,
            (y * 50) as u8,
            ((x * 5 + y * 3) % 8 * 30) as u8,
        ]
    };
    for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
        let scene = square([5, 5], texture(5, 5, [wrap; 2], texel), Some(WHOLE_PICTURE));
        let film = film(&scene);
        for (x, y) in (0..5).flat_map(|y| (0..5).map(move |x| (x, y))) {
            assert_near(
                film.pixel(x, y),
                linear(texel(x, y)),
                2e-6,
                &format!("{wrap:?} {x} {y}"),
            );
        }
    }
}

#[test]
fn a_surface_without_texture_places_keeps_its_colour() {
    let scene = square(
        [4, 4],
        texture(1, 1, [Wrap::Repeat; 2], |_, _| [9, 9, 9]),
        None,
    );
    let film = film(&scene);
    assert_eq!(film.pixel(1, 2), [1.0; 3]);
}

#[test]
fn between_texel_centres_the_colour_is_a_straight_line() {
    // 64 pixels across the half between the centres of two texels.
    let (black, white) = ([0, 10, 255], [255, 200, 0]);
    let ramp = texture(
        2,
        1,
        [Wrap::Clamp; 2],
        |x, _| if x == 0 { black } else { white },
    );
    let (a, b) = (Vec2::new(0.25, 0.5), Vec2::new(0.75, 0.5));
    // The picture is 64 high, too: its angle is the vertical one.
    let film = film(&square([64, 64], ramp, Some([a, b, b, a])));
    let (black, white) = (linear(black), linear(white));
    for x in 0..64 {
        let t = (x as f32 + 0.5) / 64.0;
        let want = black + (white - black) * t;
        assert_near(film.pixel(x, 20), want, 1e-6, &format!("pixel {x}"));
    }
}

#[test]
fn beyond_the_edges() {
    // Texels 0 to 3 in a row; where a place falls between two, both are given.
    let texel = |x: u32| [(x * 80) as u8, 0, 255 - (x * 60) as u8];
    let cases = [
        (Wrap::Repeat, -0.125, [3, 3]),
        (Wrap::Repeat, 1.0, [3, 0]),
        (Wrap::Repeat, 0.0, [3, 0]),
        (Wrap::Repeat, 7.375, [1, 1]),
        (Wrap::Repeat, -3.0e30, [3, 0]),
        (Wrap::Repeat, 3.0e38, [3, 0]),
        (Wrap::Clamp, -5.0, [0, 0]),
        (Wrap::Clamp, 0.05, [0, 0]),
        (Wrap::Clamp, 1.0, [3, 3]),
        (Wrap::Clamp, 3.0e38, [3, 3]),
        (Wrap::Mirror, -0.125, [0, 0]),
        (Wrap::Mirror, -0.375, [1, 1]),
        (Wrap::Mirror, 1.0, [3, 3]),
        (Wrap::Mirror, 1.125, [3, 3]),
        (Wrap::Mirror, 1.875, [0, 0]),
        (Wrap::Mirror, 2.375, [1, 1]),
        (Wrap::Mirror, -1.0e20, [0, 0]),
    ];
    for (wrap, place, [a, b]) in cases {
        let want = (linear(texel(a)) + linear(texel(b))) * 0.5;
        let row = texture(4, 1, [wrap, Wrap::Repeat], |x, _| texel(x));
        let film_across = film(&square([2, 2], row, Some([Vec2::new(place, 0.3); 4])));
        let what = format!("{wrap:?} {place}");
        assert_near(film_across.pixel(0, 1), want, 1e-5, &what);
        let column = texture(1, 4, [Wrap::Repeat, wrap], |_, y| texel(y));
        let film_down = film(&square([2, 2], column, Some([Vec2::new(0.7, place); 4])));
        assert_near(film_down.pixel(1, 0), want, 1e-5, &what);
    }
}

#[test]
fn ka_and_kd_take_the_texture_and_the_rest_does_not() {
    let brown = [120, 60, 30];
    let mut scene = square(
        [2, 2],
        texture(1, 1, [Wrap::Repeat; 2], |_, _| brown),
        Some(WHOLE_PICTURE),
    );
    scene.materials = Default::default();
    scene.materials.push(&Material {
        ka: Vec3::splat(0.25),
        ke: Vec3::new(0.0, 0.0, 0.5),
        kd: Vec3::splat(0.5),
        texture: 0,
        ..Material::default()
    });
    scene.lights.add_directional(Vec3::Z, Vec3::ONE);
    let want = linear(brown) * 0.75 + Vec3::new(0.0, 0.0, 0.5);
    assert_near(film(&scene).pixel(0, 0), want, 1e-6, "lit");
}

fn random_wrap(rng: &mut Rng) -> Wrap {
    rng.pick(&[Wrap::Repeat, Wrap::Clamp, Wrap::Mirror])
}

fn random_place(rng: &mut Rng) -> Vec2 {
    let mut one = || match rng.below(8) {
        0 => rng.range(-1e3, 1e3),
        1 => rng.pick(&[0.0, 1.0, -1.0, 0.5, -0.0, f32::MIN_POSITIVE, -1e-20]),
        2 => rng.pick(&[1e30, -1e30, f32::MAX, f32::MIN, 4_194_303.7, -8_388_609.0]),
        _ => rng.range(-2.0, 3.0),
    };
    Vec2::new(one(), one())
}

/// Triangles, some without texture coordinates or with untextured materials, and spheres, lights
/// and mirrors.
fn random_scene(seed: u64) -> Scene {
    let rng = &mut Rng::new(seed);
    let mut scene = Scene {
        width: 40,
        height: 30,
        max_depth: 2,
        ..Scene::default()
    };
    for _ in 0..1 + rng.below(4) {
        let (width, height) = (1 + rng.below(9) as u32, 1 + rng.below(9) as u32);
        let wrap = [random_wrap(rng), random_wrap(rng)];
        let texels: Vec<[u8; 3]> = (0..width * height)
            .map(|_| rng.bits().to_le_bytes()[..3].try_into().expect("three"))
            .collect();
        scene.textures.push(texture(width, height, wrap, |x, y| {
            texels[(y * width + x) as usize]
        }));
        let last = scene.textures.last_mut().expect("it was added");
        last.nearest = rng.once_in(3);
    }
    for k in 0..6 {
        let texture = rng.below(scene.textures.len()) as u32;
        scene.materials.push(&Material {
            ka: rng.color(),
            kd: rng.color(),
            ks: if k == 1 { Vec3::splat(0.5) } else { Vec3::ZERO },
            highlight: rng.pick(&[Vec3::ZERO, Vec3::splat(0.04), Vec3::new(0.5, 0.0, 2.0)]),
            shininess: 20.0,
            texture: if k == 2 { phalanx::scene::NO_TEXTURE } else { texture },
            ..Material::default()
        });
    }
    let (mut vertices, mut vertex_uvs) = (Vec3s::default(), Vec2s::default());
    let (mut corners, mut uvs, mut materials) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..60u32 {
        let center = rng.point(1.0);
        (0..3).for_each(|_| vertices.push(center + rng.point(0.5)));
        (0..3).for_each(|_| vertex_uvs.push(random_place(rng)));
        let row = [3 * k, 3 * k + 1, 3 * k + 2];
        corners.push(row);
        uvs.push(if rng.once_in(6) { [NO_INDEX; 3] } else { row });
        materials.push(rng.below(6) as u32);
    }
    // Half of the scenes show all of it twice, as instances.
    let placed = seed.is_multiple_of(2).then(|| scene.begin_mesh());
    scene.append_mesh(Mesh {
        vertices,
        corners: corners.into(),
        uvs: uvs.into(),
        vertex_uvs,
        material: MeshMaterial::Each(materials.into()),
        ..Mesh::default()
    });
    if let Some(mesh) = placed {
        scene.end_mesh(mesh);
        for _ in 0..2 {
            let map = DAffine3::from_translation(rng.point(1.0).as_dvec3());
            scene.add_instance(mesh, map).expect("invertible");
        }
    }
    scene.add_sphere(rng.point(1.0), 0.3, 1);
    scene.lights.add_point(rng.point(4.0), Vec3::ONE, Vec3::X);
    scene
        .lights
        .add_directional(rng.direction(), Vec3::splat(0.5));
    scene.view.eye = rng.direction() * 3.0;
    scene
}

#[test]
fn both_engines_agree_wherever_the_places_are() {
    let mut colors = std::collections::BTreeSet::new();
    for seed in 0..40 {
        let film = film(&random_scene(seed));
        colors.insert(film.pixel(20, 15).map(f32::to_bits));
    }
    assert!(colors.len() > 10, "the pictures show something");
}
