//! Identifiers of objects and materials in the form of Cryptomatte (Friedman and Jones, "Fully
//! Automatic ID Mattes with Support for Motion Blur and Transparency", 2015; specification 1.2.0).
//!
//! Everything has a name, and its identifier is a hash of the name. What has no name in the file
//! gets one from a number: of the material, instance or geometry, or otherwise of the primitive.

use crate::geometries::Geometry;
use crate::{NO_NAME, Scene};
use std::collections::BTreeSet;

/// Identifiers of a scene's objects and materials: the bits of floats.
#[derive(Clone, Debug, Default)]
pub struct MatteIds {
    /// First primitive of each object, in ascending order.
    starts: Vec<u32>,
    objects: Vec<u32>,
    /// Identifiers of names, by their numbers.
    names: Vec<u32>,
    /// Identifiers of materials without a name.
    materials: Vec<u32>,
}

impl MatteIds {
    /// The identifiers of all objects and materials.
    pub fn of(scene: &Scene) -> MatteIds {
        let (starts, names): (_, Vec<String>) = objects(scene).unzip();
        let known = (0..scene.names.len() as u32).map(|name| scene.names.get(name));
        let rows = 0..scene.materials.len() as u32;
        MatteIds {
            starts,
            objects: names.iter().map(|name| matte_id(name)).collect(),
            names: known
                .map(|name| matte_id(name.unwrap_or_default()))
                .collect(),
            materials: rows.map(|row| matte_id(&unnamed_material(row))).collect(),
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
        let prim = scene.resolve(prim_id).prim;
        let [_, name] = scene.names.of_prim(prim);
        let material = match self.names.get(name as usize) {
            Some(&id) => id,
            None => self.materials[scene.prim_material(prim) as usize],
        };
        [self.objects[object], material]
    }
}

/// Names of a scene's objects. An instance is an object, and so are primitives of one name that
/// follow each other. Of those without a name, primitives that were added together are an object
/// (see [`Scene::add_mesh`]), each other sphere and ellipsoid is one, and so are triangles or cones
/// that follow each other with one material. The number in a name is that of the instance, of the
/// geometry, or of the first primitive.
pub fn object_names(scene: &Scene) -> impl Iterator<Item = String> {
    objects(scene).map(|(_, name)| name)
}

/// Names of a scene's materials. Those without a name have their numbers.
pub fn material_names(scene: &Scene) -> impl Iterator<Item = String> {
    let named = scene.names.runs.iter().map(|&[.., name]| name);
    let named: BTreeSet<u32> = named.collect();
    let mut is_bare = vec![false; scene.materials.len()];
    let prims = 0..scene.prim_count() as u32;
    for prim in prims.filter(|&prim| scene.names.of_prim(prim)[1] == NO_NAME) {
        is_bare[scene.prim_material(prim) as usize] = true;
    }
    let named = named.into_iter();
    let named = named.filter_map(|name| scene.names.get(name).map(str::to_owned));
    let bare = (0..).zip(is_bare).filter(|(_, is_bare)| *is_bare);
    named.chain(bare.map(|(row, _)| unnamed_material(row)))
}

fn unnamed_material(row: u32) -> String {
    format!("material{row}")
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
        let [name, _] = scene.names.of_prim(prim);
        let kind = scene.prims[prim as usize].kind();
        let bare = name == NO_NAME && geometry.is_none();
        let alone = bare && kind.is_whole_object();
        let run = if bare {
            (name, None, Some((kind, scene.prim_material(prim))))
        } else {
            (name, geometry.filter(|_| name == NO_NAME), None)
        };
        let last = before.replace((run, prim));
        let goes_on = last.is_some_and(|(last_run, last)| last_run == run && last + 1 == prim);
        if goes_on && !alone {
            return None;
        }
        let plural = if alone { "" } else { "s" };
        Some(match (scene.names.get(name), geometry) {
            (Some(name), _) => (prim, name.to_owned()),
            (None, Some(geometry)) => (prim, format!("geometry{geometry}")),
            (None, None) => (prim, format!("{}{plural}{prim}", kind.name())),
        })
    });
    let instances = scene.visible_instances().map(|instance| {
        let name = scene.names.get(scene.instances.name[instance]);
        (
            scene.instance_first_id(instance),
            name.map_or_else(|| format!("instance{instance}"), str::to_owned),
        )
    });
    stored.chain(instances)
}

/// The identifier of a name: the bits of a float that is not infinite, NaN, zero or denormal, so
/// that no program changes it.
///
/// ```
/// # mod phalanx { pub mod scene { pub use phalanx_scene::*; } pub use phalanx_scene::*; }
/// assert_eq!(phalanx::scene::matte_id("hello"), 0x248b_fa47);
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

    /// Materials of one row keep their names, and objects of one name are one.
    #[test]
    fn names_of_the_file_take_the_place_of_numbers() {
        let mut scene = Scene::new();
        scene.materials.push(&Material::default());
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        for _ in 0..5 {
            scene.add_triangle(corners, None, 0);
        }
        scene.add_sphere(Vec3::ZERO, 1.0, 0);
        scene.add_sphere(Vec3::ONE, 1.0, 0);
        let mesh = scene.begin_mesh();
        scene.add_triangle(corners, None, 0);
        scene.end_mesh(mesh);
        for _ in 0..2 {
            scene.add_instance(mesh, DAffine3::IDENTITY).unwrap();
        }
        let names = ["cup", "red", "blue", "rim"];
        let [cup, red, blue, rim] = names.map(|name| scene.names.intern(name.as_bytes()));
        scene.names.name_run(0..1, cup, Some(red));
        scene.names.name_run(1..2, cup, Some(blue));
        scene.names.name_run(3..4, cup, None);
        scene.names.name_run(5..7, rim, None);
        scene.names.name_run(7..8, NO_NAME, Some(red));
        scene.instances.name[1] = rim;
        let objects: Vec<String> = object_names(&scene).collect();
        assert_eq!(
            objects,
            [
                "cup",
                "triangles2",
                "cup",
                "triangles4",
                "rim",
                "instance0",
                "rim"
            ]
        );
        let materials: Vec<String> = material_names(&scene).collect();
        assert_eq!(materials, ["red", "blue", "material0"]);
        let ids = MatteIds::of(&scene);
        for (prim, object, material) in [
            (0, "cup", "red"),
            (1, "cup", "blue"),
            (2, "triangles2", "material0"),
            (3, "cup", "material0"),
            (4, "triangles4", "material0"),
            (6, "rim", "material0"),
            (8, "instance0", "red"),
            (9, "rim", "red"),
        ] {
            let want = [object, material].map(matte_id);
            assert_eq!(ids.find(&scene, prim), want, "{prim}");
        }
    }
}
