//! Surface, lights and bounces for one hit; the formulas are explained in the files of `shade`.

use super::instance::to_object;
use super::intersect::{OracleHit, OracleRay, max, max_abs, min};
use super::primitives::{OraclePoint, surface_point, unit, unit_or};
use super::texture::{map_value, mapped_normal, tint};
use glam::Vec3;
use phalanx_scene::sampling::{
    BounceKind, Dimension, child_seed, cosine_hemisphere, phong_lobe, points, pow, seeds, to_frame,
    uniform_sphere as sphere_point,
};
use phalanx_scene::{INWARD, LightShape, LobeWeights, MapTarget, PAD, PrimKind, Scene};

/// One row of the material columns.
pub(super) struct OracleMaterial {
    /// Ka + Ke, with Ka times the texture's colour.
    pub(super) own: Vec3,
    pub(super) kd: Vec3,
    ks: Vec3,
    /// Weight of the highlight without a mirror.
    highlight: Vec3,
    kt: Vec3,
    shininess: f32,
    ior: f32,
    gloss: f32,
}

impl OracleMaterial {
    /// The material of a stored primitive at a hit.
    pub(super) fn of(scene: &Scene, prim: u32, hit: &OracleHit) -> OracleMaterial {
        let (m, i) = (&scene.materials, scene.prim_material(prim) as usize);
        let tint = tint(scene, m.texture[i], prim, hit);
        let (mut ambient, mut kd) = (m.ka.get(i) * tint, m.kd.get(i) * tint);
        let (mut ke, mut ks, mut highlight) = (m.ke.get(i), m.ks.get(i), m.highlight.get(i));
        let mut shininess = m.shininess[i];
        let (mut metallic, mut roughness) = (m.metallic[i], m.roughness[i]);
        for map in scene.maps.range(m.maps[i]) {
            let Some(value) = map_value(scene, &map, prim, hit) else {
                continue;
            };
            let channel = value[map.channel as usize];
            match map.target {
                MapTarget::Emission => ke *= value,
                MapTarget::Specular => (ks, highlight) = (ks * value, highlight * value),
                MapTarget::Shininess => shininess *= channel,
                MapTarget::Metallic => metallic *= channel,
                MapTarget::Roughness => roughness *= channel,
                MapTarget::Normal => {}
            }
        }
        if m.metallic_roughness(i).is_some() {
            let lobes = LobeWeights::of([metallic], [roughness]);
            let [metal] = lobes.metal;
            highlight = ks * lobes.highlight[0];
            ks = ks * lobes.dielectric[0] + kd * metal;
            ambient *= 1.0 - metal;
            kd *= 1.0 - metal;
            shininess = lobes.shininess[0];
        }
        OracleMaterial {
            own: ambient + ke,
            kd,
            ks,
            highlight: highlight * ((shininess + 2.0) * 0.125),
            kt: m.kt.get(i),
            shininess,
            ior: m.ior[i],
            gloss: m.gloss[i],
        }
    }

    /// Divisor of Ks and Kt for the share of its camera ray that a bounce carries.
    pub(super) fn secondary_weight(&self) -> Vec3 {
        let both = self.ks.abs() + self.kt.abs();
        Vec3::new(max(both.x, 1.0), max(both.y, 1.0), max(both.z, 1.0))
    }
}

/// A hit point with its normals turned toward the viewer.
#[derive(Clone, Copy, Debug)]
pub struct OracleSurface {
    /// The hit point.
    pub point: Vec3,
    /// Geometric normal, of unit length.
    pub ng: Vec3,
    /// Shading normal, of unit length.
    pub ns: Vec3,
    dir: Vec3,
    pub(super) offset: f32,
    /// True if the ray comes from outside.
    pub entering: bool,
    bumped: bool,
}

impl OracleSurface {
    /// The surface at a ray's hit in a validated scene.
    pub fn new(scene: &Scene, ray: &OracleRay, hit: &OracleHit) -> OracleSurface {
        let placed = scene.resolve(hit.prim_id);
        let surface_point = |ray: &OracleRay, back| {
            let mut surface = surface_point(scene, placed.prim, ray, back, hit);
            surface.ns = mapped_normal(scene, placed.prim, hit, surface.ns);
            surface
        };
        let surface = match placed.instance {
            None => surface_point(ray, -ray.dir),
            Some(k) => {
                let inner = to_object(scene, k as usize, ray);
                let inside = surface_point(&inner, -unit(inner.dir));
                to_world(scene, k as usize, inside, ray)
            }
        };
        let OraclePoint { point, ng, ns, .. } = surface;
        let ng = if ng.dot(surface.outward) < INWARD { -ng } else { ng };
        let away = ray.dir.dot(ng) > 0.0;
        let ng = if away { -ng } else { ng };
        let mut ns = if away { -ns } else { ns };
        let bumped = scene.prims[placed.prim as usize].kind() == PrimKind::Triangle
            && scene.normal_map(scene.prim_material(placed.prim)).is_some();
        if bumped {
            ns = in_front(ns, ng);
        }
        OracleSurface {
            point,
            ng,
            ns,
            dir: ray.dir,
            offset: surface.offset,
            entering: !away,
            bumped,
        }
    }

    /// A ray that leaves the surface on the side to which its direction points.
    pub fn offset_origin(&self, dir: Vec3) -> OracleRay {
        let offset = if dir.dot(self.ng) >= 0.0 { self.offset } else { -self.offset };
        OracleRay::new(self.point + self.ng * offset, dir)
    }
}

/// The world point of a surface point in the space of an instance's mesh.
fn to_world(scene: &Scene, instance: usize, inside: OraclePoint, ray: &OracleRay) -> OraclePoint {
    let [wx, wy, wz, wshift] = scene.instances.world_columns(instance);
    let [mx, my, mz, shift] = scene.instances.object_columns(instance);
    let p = inside.point;
    let point = ((wx * p.x + wy * p.y) + wz * p.z) + wshift;
    let back = |n: Vec3| Vec3::new(mx.dot(n), my.dot(n), mz.dot(n));
    let gradient = back(inside.ng);
    let length = gradient.dot(gradient).sqrt();
    let ng = unit_or(gradient, -ray.dir);
    let p = point.abs();
    let terms = ((mx.abs() * p.x + my.abs() * p.y) + mz.abs() * p.z) + shift.abs();
    let reach = (max_abs(terms) * PAD + inside.offset) / length;
    OraclePoint {
        point,
        ng,
        ns: unit_or(back(inside.ns), ng),
        outward: unit_or(back(inside.outward), ng),
        offset: reach + max_abs(point) * PAD,
    }
}

/// Seed of the random choices at a hit: the ray's seed and its pixel's sample number.
#[derive(Clone, Copy)]
pub(super) struct SampleSeed {
    seed: u32,
    sample: u32,
}

impl SampleSeed {
    /// The seed of a pixel's camera ray.
    pub(super) fn of(x: u32, y: u32, sample: u32) -> SampleSeed {
        let [seed] = seeds([x], [y]);
        SampleSeed { seed, sample }
    }

    /// The seed of a secondary ray.
    pub(super) fn child(self, way: BounceKind) -> SampleSeed {
        let [seed] = child_seed([self.seed], way);
        SampleSeed { seed, ..self }
    }

    /// A point of the unit square.
    pub(super) fn point(self, purpose: Dimension) -> [[f32; 1]; 2] {
        points([self.seed], self.sample, purpose)
    }
}

/// A position of a light: one of many if it is an area light.
fn sample_light_position(scene: &Scene, light: usize, seed: SampleSeed) -> Vec3 {
    let position = scene.lights.position.get(light);
    let square = || seed.point(Dimension::Light(light as u32));
    match scene.lights.shape(light) {
        LightShape::Point | LightShape::Directional => position,
        LightShape::Sphere(radius) => {
            let [[x], [y], [z]] = sphere_point(square());
            position + Vec3::new(x, y, z) * radius
        }
        LightShape::Rectangle([e, f]) => {
            let [[u], [v]] = square();
            (position + e * u) + f * v
        }
    }
}

/// Unoccluded contribution of a light, and the shadow ray that tests it.
pub(super) struct OracleLightSample {
    pub(super) ray: OracleRay,
    /// On a smooth surface, the ray that starts there, and true if `ray` starts beneath its facet.
    pub(super) above: Option<(OracleRay, bool)>,
    pub(super) tmax: f32,
    pub(super) radiance: Vec3,
}

/// The hit that a light falls on, beside its surface: its seed, its material, and its coverage.
pub(super) struct Lit<'m> {
    pub(super) seed: SampleSeed,
    pub(super) material: &'m OracleMaterial,
    pub(super) coverage: f32,
    pub(super) above: Option<OracleTerminatorShift>,
}

/// The smooth surface above a hit.
#[derive(Clone, Copy)]
pub(super) struct OracleTerminatorShift {
    /// Vector from the hit point to the smooth surface.
    pub(super) shift: Vec3,
    /// Unit normal of the smooth surface, turned toward the viewer.
    pub(super) normal: Vec3,
}

/// Share of a spot light's light in a direction; explained in `shade`.
fn spot(scene: &Scene, light: usize, to_light: Vec3) -> f32 {
    let cos = -to_light.dot(scene.lights.axis.get(light));
    let cone = scene.lights.cone.get(light);
    let part = min(max(cos * cone.x + cone.y, 0.0), 1.0);
    part * part
}

/// Samples a light; `None` if it contributes nothing or does not face the surface.
pub(super) fn sample_light(
    scene: &Scene,
    light: usize,
    lit: &Lit,
    surface: &OracleSurface,
) -> Option<OracleLightSample> {
    let lights = &scene.lights;
    let &Lit {
        seed,
        material,
        coverage,
        above,
    } = lit;
    let position = sample_light_position(scene, light, seed);
    let color = lights.color.get(light);
    let (dir, to_light, seen, tmax) = if lights.directional[light] {
        (position, position, color, f32::INFINITY)
    } else {
        let to = position - surface.point;
        let squared = to.dot(to);
        let distance = squared.sqrt();
        let a = lights.attenuation.get(light);
        let loss = (a.x + a.y * distance) + a.z * squared;
        if loss.is_nan() || loss <= 0.0 {
            return None;
        }
        let mut seen = Vec3::new(color.x / loss, color.y / loss, color.z / loss);
        let to_light = to * (1.0 / distance);
        if lights.is_spot(light) {
            seen *= spot(scene, light, to_light);
        }
        (to, to_light, seen, 1.0)
    };
    let diffuse = max(to_light.dot(surface.ns), 0.0);
    let specular = if material.ks == Vec3::ZERO && material.highlight == Vec3::ZERO {
        0.0
    } else {
        let half = unit(to_light - surface.dir);
        pow(max(half.dot(surface.ns), 0.0), material.shininess)
    };
    let mut lobe = material.kd * diffuse + material.ks * specular;
    if material.highlight != Vec3::ZERO {
        lobe += material.highlight * (specular * diffuse);
    }
    let radiance = (seen * lobe) * coverage;
    let facing = to_light.dot(above.map_or(surface.ng, |above| above.normal)) > 0.0;
    let faces_facet = to_light.dot(surface.ng) > 0.0;
    let is_beneath = above.is_some() && !faces_facet;
    let (over, under) = (
        surface.point + surface.ng * surface.offset,
        surface.point - surface.ng * surface.offset,
    );
    let above = above.map(|OracleTerminatorShift { shift, .. }| {
        let is_directional = lights.directional[light];
        let dir = if is_directional { dir } else { dir - shift };
        (OracleRay::new(over + shift, dir), is_beneath)
    });
    let org = if is_beneath { under } else { over };
    let adds = !radiance.is_nan() && radiance != Vec3::ZERO;
    (facing && adds).then(|| OracleLightSample {
        ray: OracleRay::new(org, dir),
        above,
        tmax,
        radiance,
    })
}

/// A random direction of the lobe about a mirror direction.
fn sample_glossy(gloss: f32, seed: SampleSeed, surface: &OracleSurface, mirror: Vec3) -> Vec3 {
    let local = phong_lobe(seed.point(Dimension::Gloss), gloss);
    unit(mirror_into_hemisphere(
        surface,
        to_world_direction(local, mirror),
        mirror,
    ))
}

/// An ambient occlusion ray.
pub(super) fn sample_ao_ray(seed: SampleSeed, surface: &OracleSurface) -> OracleRay {
    let local = cosine_hemisphere(seed.point(Dimension::Sky));
    surface.offset_origin(unit(in_front(
        to_world_direction(local, surface.ns),
        surface.ng,
    )))
}

/// Rotates a vector about z to one about a unit vector.
fn to_world_direction(local: [[f32; 1]; 3], axis: Vec3) -> Vec3 {
    let [[x], [y], [z]] = to_frame(local, axis.to_array().map(|c| [c]));
    Vec3::new(x, y, z)
}

/// A vector on the side of the unit normal `ng`; one on the other side is mirrored.
fn in_front(v: Vec3, ng: Vec3) -> Vec3 {
    let along = v.dot(ng);
    if along >= 0.0 { v } else { v - ng * (2.0 * along) }
}

/// Mirrors a direction at the geometric surface, unless it is on the same side as `inner`.
fn mirror_into_hemisphere(surface: &OracleSurface, dir: Vec3, inner: Vec3) -> Vec3 {
    let along = dir.dot(surface.ng);
    if (along >= 0.0) == (inner.dot(surface.ng) >= 0.0) {
        dir
    } else {
        dir - surface.ng * (2.0 * along)
    }
}

/// A secondary ray and the weight of its light.
pub(super) struct OracleBounce {
    pub(super) ray: OracleRay,
    pub(super) weight: Vec3,
}

/// The mirror ray and the refracted ray, if their weights are not zero.
pub(super) fn bounces(
    material: &OracleMaterial,
    seed: SampleSeed,
    surface: &OracleSurface,
) -> [Option<OracleBounce>; 2] {
    let (d, n) = (surface.dir, surface.ns);
    let along = d.dot(n);
    let cos = -along;
    let eta = if surface.entering { 1.0 / material.ior } else { material.ior };
    let k = 1.0 - (eta * eta) * (1.0 - cos * cos);
    let transmits = material.kt != Vec3::ZERO;
    let total = transmits && k < 0.0;
    let weight = if total { material.ks + material.kt } else { material.ks };
    let mirror = (weight != Vec3::ZERO).then(|| {
        let mut straight = unit(d - n * (2.0 * along));
        if surface.bumped {
            straight = in_front(straight, surface.ng);
        }
        let dir = if material.gloss > 0.0 {
            sample_glossy(material.gloss, seed, surface, straight)
        } else {
            straight
        };
        OracleBounce {
            ray: surface.offset_origin(dir),
            weight,
        }
    });
    let refracted = (transmits && !total).then(|| OracleBounce {
        ray: surface.offset_origin(unit(d * eta + n * (eta * cos - k.sqrt()))),
        weight: material.kt,
    });
    [mirror, refracted]
}
