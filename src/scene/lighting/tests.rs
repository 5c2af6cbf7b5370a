use super::*;
use crate::{
    Environment, EnvironmentLight, EnvironmentMap, EnvironmentTexels, MapTarget, Material, Texture,
    TextureMap, UpAxis, Wrap,
};
use glam::{DAffine3, DMat3};
use std::f64::consts::PI;

const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];
const GLOW: Material = Material {
    ke: Vec3::ONE,
    ..Material::DEFAULT
};

/// A scene where emission is light, from (-2, -2, -2) to (2, 2, 2) and without other light.
fn room(materials: &[Material]) -> Scene {
    let mut scene = Scene {
        emission_lights: true,
        ..Scene::default()
    };
    let dark = scene.materials.push(&Material::DEFAULT);
    for corner in [Vec3::splat(-2.0), Vec3::splat(2.0)] {
        scene.add_triangle([corner; 3], None, dark);
    }
    for material in materials {
        scene.materials.push(material);
    }
    scene
}

fn texture(texels: &[[u8; 3]]) -> Texture {
    Texture {
        width: texels.len() as u32,
        height: 1,
        wrap: [Wrap::Repeat; 2],
        nearest: false,
        texels: texels.to_vec().into(),
        alpha: Vec::new().into(),
    }
}

/// The lights and their shares, relative to the first one's.
fn ratios(scene: &Scene) -> Vec<(LightSource, f64)> {
    let table = LightTable::of(scene);
    let sum: f64 = (0..table.lights.len())
        .map(|light| table.alias.pdf[light])
        .sum();
    assert!(
        table.lights.is_empty() || (sum - 1.0).abs() < 1e-12,
        "{sum}"
    );
    let ratio = |light| {
        (
            table.lights[light],
            table.alias.pdf[light] / table.alias.pdf[0],
        )
    };
    (0..table.lights.len()).map(ratio).collect()
}

#[track_caller]
fn near(is: f64, wanted: f64) {
    assert!(
        (is - wanted).abs() <= 1e-6 * wanted.abs(),
        "{is}, wanted {wanted}"
    );
}

/// Surroundings of this mean luminance.
fn glow(mean: f32) -> Environment {
    let (nadir, zenith) = (Vec3::ZERO, Vec3::splat(2.0 * mean));
    Environment::new(EnvironmentLight::Gradient { nadir, zenith }, UpAxis::Z, 0.0)
}

/// The mean over all directions, not over all texels.
#[test]
fn the_poles_of_an_environment_count_by_their_share_of_the_sphere() {
    let mut texels = EnvironmentTexels::Float(Default::default());
    // The upper quarter of the rows, 45 degrees about the zenith.
    let rows = (0..4).flat_map(|row| [[f32::from(u8::from(row == 0)); 3]; 8]);
    assert!(texels.extend(rows));
    let map = EnvironmentMap {
        width: 8,
        height: 4,
        texels,
    };
    let mut environment = Environment::new(EnvironmentLight::Map(map.into()), UpAxis::Y, 10.0);
    environment.scale = 4.0;
    let mut scene = Scene {
        environment: Some(environment),
        ..Scene::default()
    };
    let light = Vec3::splat(2.0 - 2f32.sqrt());
    scene.lights.add_directional(Vec3::Y, light);
    let table = LightTable::of(&scene);
    assert!((table.alias.pdf[1] / table.alias.pdf[0] - 1.0).abs() < 1e-6);
}

#[test]
fn nothing_is_picked_where_nothing_shines() {
    let mut scene = room(&[GLOW]);
    for _ in 0..2 {
        scene.environment = Some(glow(0.0));
        let table = LightTable::of(&scene);
        assert!(table.lights.is_empty() && table.shares(&scene).is_empty());
        assert_eq!(
            (table.alias.pick(7), &table.densities[..]),
            (None, &[0.0; 2][..])
        );
        scene.lights.add_point(Vec3::Y, Vec3::ZERO, Vec3::Z);
        scene.lights.add_point(Vec3::Y, Vec3::splat(-1.0), Vec3::Z);
    }
    let table = LightTable::of(&Scene {
        environment: Some(glow(0.5)),
        ..Scene::default()
    });
    assert_eq!(
        (table.lights[0], table.alias.pdf[0]),
        (LightSource::Environment, 1.0)
    );
}

/// The unit of importance is the luminance of a white surface that faces the light.
#[test]
fn kinds_of_light_are_weighed_by_their_irradiance() {
    let mut scene = room(&[GLOW]);
    scene.lights.add_directional(Vec3::Y, Vec3::ONE);
    scene
        .lights
        .add_point(Vec3::X * 10.0, Vec3::ONE * 50.0, Vec3::Z);
    let cone = [0.1, 0.2];
    let attenuation = Vec3::new(1.0, 2.0, 0.5);
    scene
        .lights
        .add_spot(Vec3::Y * 4.0, Vec3::ONE, attenuation, Vec3::NEG_Y, cone);
    // Within the scene, whose corners are the root of 12 away.
    scene
        .lights
        .add_point(Vec3::X, Vec3::new(0.0, 3.0, 0.0), Vec3::Z);
    scene.add_triangle(CORNERS, None, 1);
    scene.environment = Some(glow(0.25));
    let table = LightTable::of(&scene);
    let wanted = [
        (LightSource::Punctual(0), 1.0),
        (LightSource::Punctual(1), 50.0 / 100.0),
        (
            LightSource::Punctual(2),
            1.0 / (1.0 + 2.0 * 4.0 + 0.5 * 16.0),
        ),
        (LightSource::Punctual(3), 0.7152 * 3.0 / 12.0),
        (LightSource::Environment, 0.25),
        (LightSource::Triangle(2), 0.5 / (PI * 12.0) / 2.0),
    ];
    assert_eq!(table.lights.len(), wanted.len());
    for (number, (light, weight)) in wanted.into_iter().enumerate() {
        assert_eq!(table.lights[number], light);
        near(table.alias.pdf[number] / table.alias.pdf[0], weight);
    }
    let shares = table.shares(&scene);
    assert!(shares.is_sorted_by(|a, b| a.share >= b.share));
    near(shares.iter().map(|row| row.share).sum(), 1.0);
}

#[test]
fn triangles_of_instances_count_by_their_area_in_the_world() {
    let one_sided = Material {
        single_sided: true,
        ke: Vec3::ONE * 3.0,
        ..GLOW
    };
    let mut scene = room(&[GLOW, one_sided]);
    scene.add_triangle(CORNERS, None, 1);
    let mesh = scene.begin_mesh();
    scene.add_triangle(CORNERS, None, 0);
    scene.add_triangle(CORNERS, None, 1);
    scene.add_triangle([Vec3::ZERO, Vec3::X, Vec3::X], None, 1);
    scene.add_triangle(CORNERS, None, 2);
    scene.end_mesh(mesh);
    for sizes in [
        DVec3::new(2.0, 2.0, 2.0),
        DVec3::new(-3.0, 1.0, 1.0),
        DVec3::splat(0.5),
    ] {
        let matrix3 = DMat3::from_rotation_y(1.0) * DMat3::from_diagonal(sizes);
        let map = DAffine3::from_mat3_translation(matrix3, DVec3::splat(0.1));
        scene.add_instance(mesh, map).unwrap();
    }
    scene.validate().unwrap();
    let first = scene.instance_first_id(0);
    let wanted = [
        (2, 1.0),
        (first + 1, 4.0),
        (first + 3, 4.0 * 1.5),
        (first + 5, 3.0),
        (first + 7, 3.0 * 1.5),
        (first + 9, 0.25),
        (first + 11, 0.25 * 1.5),
    ];
    let given = ratios(&scene);
    assert_eq!(given.len(), wanted.len(), "{given:?}");
    let table = LightTable::of(&scene);
    for ((number, &(light, ratio)), (id, times)) in given.iter().enumerate().zip(wanted) {
        assert_eq!(light, LightSource::Triangle(id));
        near(ratio, times);
        let material = scene.prim_material(scene.resolve(id).prim);
        let area = times / if material == 1 { 2.0 } else { 3.0 };
        near(
            table.alias.pdf[number],
            table.densities[material as usize] * area,
        );
    }
    assert_eq!(table.densities[0], 0.0);
    let shares = table.shares(&scene);
    let rows: Vec<u64> = shares.iter().map(|row| row.count).collect();
    assert_eq!(rows, [3, 4], "{shares:?}");
}

#[test]
fn what_is_not_seen_is_no_light() {
    let mut scene = room(&[GLOW]);
    let points = CORNERS.map(|c| c.to_array());
    let glowing = |scene: &mut Scene| {
        scene
            .triangles
            .material
            .make_mut()
            .iter_mut()
            .for_each(|m| *m = 1)
    };
    let mesh = scene.add_mesh(&points, &[[0, 1, 2]]).unwrap();
    let other = scene.add_mesh(&points, &[[0, 1, 2]]).unwrap();
    let prototype = scene.add_prototype(&points, &[[0, 1, 2]]).unwrap();
    let placed = scene.add_instance(prototype, DAffine3::IDENTITY).unwrap();
    scene.add_instance(prototype, DAffine3::IDENTITY).unwrap();
    glowing(&mut scene);
    assert_eq!(ratios(&scene).len(), 4);
    scene.set_mask(mesh, 0).unwrap();
    scene.set_mask(placed, 0).unwrap();
    scene.remove(other).unwrap();
    let hidden = ratios(&scene);
    assert_eq!(
        hidden,
        [(LightSource::Triangle(scene.instance_first_id(1)), 1.0)]
    );
    scene.emission_lights = false;
    assert!(ratios(&scene).is_empty(), "Ke that is only seen");
}

/// A texture of one colour is that factor, and others their mean in linear light.
#[test]
fn textures_weigh_by_their_mean() {
    let mapped = |first: u32| Material {
        maps: [first, 1],
        ..GLOW
    };
    let factor = Material {
        ke: Vec3::splat(crate::sampling::linear_of_srgb()[188]),
        ..GLOW
    };
    let faded = |opacity: f32| Material { opacity, ..GLOW };
    let materials = [
        (GLOW, 1.0),
        (mapped(0), f64::from(factor.ke.x)),
        (factor, f64::from(factor.ke.x)),
        (mapped(1), 0.2126 / 2.0),
        (faded(0.5), 0.5),
        (faded(0.0), 0.0),
    ];
    let mut scene = room(&materials.map(|(material, _)| material));
    scene.textures = vec![texture(&[[188; 3]; 5]), texture(&[[255, 0, 0], [0; 3]])];
    for picture in [0, 1] {
        scene.maps.push_all(&[TextureMap {
            target: MapTarget::Emission,
            texture: picture,
            channel: 0,
            uv_layer: 0,
            scale: 1.0,
        }]);
    }
    for row in 1..=materials.len() as u32 {
        scene.add_triangle(CORNERS, None, row);
    }
    scene.validate().unwrap();
    let table = LightTable::of(&scene);
    for (row, (_, times)) in (1..).zip(materials) {
        near(table.densities[row as usize] / table.densities[1], times);
    }
    assert_eq!(
        table.lights.len(),
        materials.len() - 1,
        "one is never there"
    );
}

#[test]
fn extremes_leave_numbers() {
    let bright = Material {
        ke: Vec3::splat(1e30),
        ..GLOW
    };
    let dim = Material {
        ke: Vec3::splat(1e-30),
        ..GLOW
    };
    let mut scene = room(&[bright, dim]);
    scene.add_triangle(CORNERS.map(|c| c * 1e8), None, 1);
    scene.add_triangle(CORNERS.map(|c| c * 1e-8), None, 2);
    scene
        .lights
        .add_point(Vec3::ZERO, Vec3::splat(1e30), Vec3::Z);
    let lights = ratios(&scene);
    assert_eq!(lights.len(), 3);
    assert!(lights.iter().all(|(_, ratio)| ratio.is_finite()));
}

#[test]
fn emission_follows_the_scale_and_comes_back() {
    let mut scene = room(&[GLOW]);
    scene.lights.add_directional(Vec3::Y, Vec3::ONE);
    for (scale, ke) in [(1e-3, 1e-3), (1e3, 1e3), (1.0, 1.0)] {
        scene.set_light_scale(scale);
        assert_eq!(scene.light_scale, scale);
        near(scene.materials.ke.get(1).x.into(), ke);
        assert_eq!(scene.lights.color.get(0), Vec3::ONE);
        assert_eq!(scene.materials.ka.get(1), GLOW.ka);
    }
}
