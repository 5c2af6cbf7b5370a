//! Identifiers of objects and materials in the form of Cryptomatte (Friedman and Jones, "Fully
//! Automatic ID Mattes with Support for Motion Blur and Transparency", 2015; specification 1.2.0).
//!
//! Everything has a name, and its identifier is a hash of the name. Scenes do not keep the names in
//! their files, so names are made from numbers: of materials, instances, geometries, or otherwise
//! primitives.

use crate::Scene;
use crate::geometries::Geometry;

/// Identifiers of a scene's objects and materials: the bits of floats.
#[derive(Clone, Debug, Default)]
pub struct MatteIds {
    /// First primitive of each object, in ascending order.
    starts: Vec<u32>,
    objects: Vec<u32>,
    materials: Vec<u32>,
}

impl MatteIds {
    /// The identifiers of all objects and materials.
    pub fn of(scene: &Scene) -> MatteIds {
        let (starts, names): (_, Vec<String>) = objects(scene).unzip();
        MatteIds {
            starts,
            objects: names.iter().map(|name| matte_id(name)).collect(),
            materials: material_names(scene).map(|name| matte_id(&name)).collect(),
        }
    }

    /// The identifiers of the object and the material that a `prim_id` belongs to; 0 for a table
    /// that is empty.
    #[inline]
    pub fn find(&self, scene: &Scene, prim_id: u32) -> [u32; 2] {
        let Some(object) = self
            .starts
            .partition_point(|&s| s <= prim_id)
            .checked_sub(1)
        else {
            return [0; 2];
        };
        let material = scene.prim_material(scene.resolve(prim_id).prim);
        [self.objects[object], self.materials[material as usize]]
    }
}

/// Names of a scene's objects. An instance is an object, and so are the primitives that were added
/// together (see [`Scene::add_mesh`]). Of the others, each sphere and each ellipsoid is one, and so
/// are triangles or cones that follow each other with one material. The number in a name is that of
/// the instance, of the geometry, or of the first primitive.
pub fn object_names(scene: &Scene) -> impl Iterator<Item = String> {
    objects(scene).map(|(_, name)| name)
}

/// Names of a scene's materials, which are their numbers.
pub fn material_names(scene: &Scene) -> impl Iterator<Item = String> {
    (0..scene.materials.len()).map(|material| format!("material{material}"))
}

/// The objects of a scene: the first primitive of each, and its name.
fn objects(scene: &Scene) -> impl Iterator<Item = (u32, String)> {
    let geometries = scene.geometries.iter();
    let mut geometries = geometries
        .filter_map(|(geometry, part)| match part {
            Geometry::Prims { first, count } => Some((geometry, first..first + count)),
            Geometry::Instance(_) => None,
        })
        .peekable();
    let mut before = None;
    let prims = scene.world_runs().into_iter().flatten();
    let stored = prims.filter_map(move |prim| {
        while geometries.next_if(|(_, prims)| prims.end <= prim).is_some() {}
        let geometry = geometries.peek().filter(|(_, prims)| prims.start <= prim);
        let geometry = geometry.map(|(geometry, _)| *geometry);
        let kind = scene.prims[prim as usize].kind();
        let alone = kind.is_whole_object();
        let plural = if alone { "" } else { "s" };
        let run = match geometry {
            Some(_) => (geometry, None),
            None => (None, Some((kind, scene.prim_material(prim)))),
        };
        let last = before.replace((run, prim));
        let goes_on = last.is_some_and(|(last_run, last)| last_run == run && last + 1 == prim);
        if goes_on && !(alone && geometry.is_none()) {
            return None;
        }
        Some(match geometry {
            Some(geometry) => (prim, format!("geometry{geometry}")),
            None => (prim, format!("{}{plural}{prim}", kind.name())),
        })
    });
    let instances = (0..scene.instances.len()).map(|instance| {
        (
            scene.instance_first_id(instance),
            format!("instance{instance}"),
        )
    });
    stored.chain(instances)
}

/// The identifier of a name: the bits of a float that is not infinite, NaN, zero or denormal, so
/// that no program changes it.
///
/// ```
/// assert_eq!(phalanx_scene::matte_id("hello"), 0x248b_fa47);
/// ```
pub fn matte_id(name: &str) -> u32 {
    let hash = murmur3_32(name.as_bytes());
    match hash >> 23 & 0xff {
        0 | 0xff => hash ^ 1 << 23,
        _ => hash,
    }
}

/// MurmurHash3 of 32 bits with seed 0 (Austin Appleby).
fn murmur3_32(bytes: &[u8]) -> u32 {
    let mix = |block: u32| {
        let block = block.wrapping_mul(0xcc9e_2d51).rotate_left(15);
        block.wrapping_mul(0x1b87_3593)
    };
    let (blocks, tail) = bytes.as_chunks::<4>();
    let mut hash = blocks.iter().fold(0u32, |hash, block| {
        let hash = (hash ^ mix(u32::from_le_bytes(*block))).rotate_left(13);
        hash.wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let rest = tail
        .iter()
        .rev()
        .fold(0, |rest, &b| rest << 8 | u32::from(b));
    hash ^= mix(rest) ^ bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Material;
    use glam::{DAffine3, Vec3};

    #[test]
    fn hashes_are_those_of_the_published_function() {
        for (text, hash) in [
            ("", 0),
            ("a", 0x3c25_69b2),
            ("test", 0xba6b_d213),
            ("Hello, world!", 0xc036_3e43),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
        ] {
            assert_eq!(murmur3_32(text.as_bytes()), hash, "{text}");
        }
        for number in 0..20_000 {
            let id = f32::from_bits(matte_id(&format!("sphere{number}")));
            assert!(id.is_normal(), "{number}");
        }
        // The hash of no bytes is 0, a denormal float.
        assert_eq!(matte_id(""), 1 << 23);
    }

    #[test]
    fn every_primitive_belongs_to_its_object() {
        let mut scene = Scene::new();
        let [first, second] = [0.1, 0.2].map(|grey| {
            scene.materials.push(&Material {
                kd: Vec3::splat(grey),
                ..Material::DEFAULT
            })
        });
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let points = corners.map(|c| c.to_array());
        for material in [first, first, second, first] {
            scene.add_triangle(corners, None, material);
        }
        scene.add_sphere(Vec3::ZERO, 1.0, first);
        scene.add_sphere(Vec3::ONE, 1.0, first);
        scene.add_spheres(&points, &[1.0; 3]).unwrap();
        let mesh = scene
            .add_prototype(&points, &[[0, 1, 2], [2, 1, 0]])
            .unwrap();
        scene.add_triangle(corners, None, first);
        for _ in 0..2 {
            scene.add_instance(mesh, DAffine3::IDENTITY).unwrap();
        }
        let names: Vec<String> = object_names(&scene).collect();
        let want = [
            "triangles0",
            "triangles2",
            "triangles3",
            "sphere4",
            "sphere5",
            "geometry0",
            "triangles11",
            "instance0",
            "instance1",
        ];
        assert_eq!(names, want);
        let ids = MatteIds::of(&scene);
        let of_prims = [0, 0, 1, 2, 3, 4, 5, 5, 5];
        let of_rest = [(11, 6), (12, 7), (13, 7), (14, 8), (15, 8)];
        for (prim, object) in (0..).zip(of_prims).chain(of_rest) {
            let [id, material] = ids.find(&scene, prim);
            assert_eq!(id, matte_id(want[object]), "{prim}");
            let stored = scene.prim_material(scene.resolve(prim).prim);
            assert_eq!(material, matte_id(&format!("material{stored}")), "{prim}");
        }
        assert_eq!(MatteIds::default().find(&scene, 3), [0; 2]);
    }
}
