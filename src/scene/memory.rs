//! Memory of the columns, in bytes.

use super::Scene;

/// Parts of a scene, and the sections of scene caches that belong to each.
const PARTS: [(&str, &[&str]); 10] = [
    ("vertices", &["vertices"]),
    (
        "vertex colours",
        &["triangle colours", "vertex colours", "vertex opacity"],
    ),
    ("triangles", &["triangle corners", "triangle materials"]),
    (
        "vertex normals",
        &[
            "triangle normals",
            "vertex normals",
            "triangle tangents",
            "vertex tangents",
        ],
    ),
    (
        "texture places",
        &["triangle texture places", "texture places"],
    ),
    ("textures", &[]),
    ("environment", &[]),
    ("curved primitives", &[]),
    ("instances", &["instances", "instance maps"]),
    ("primitive list, materials and lights", &["primitive list"]),
];
const TEXTURES: usize = 5;
const ENVIRONMENT: usize = 6;
const CURVED: usize = 7;
const OTHERS: usize = 9;

impl Scene {
    /// Bytes of the columns by part, both in owned memory and in a mapped file.
    pub fn memory_parts(&self) -> [(&'static str, usize); 10] {
        let mut parts = PARTS.map(|(part, _)| (part, 0));
        let part_of = |section: &str| PARTS.iter().position(|(_, all)| all.contains(&section));
        for info in self.prim_columns() {
            parts[part_of(info.section).unwrap_or(CURVED)].1 += info.column.bytes().len();
        }
        // Few rows of meshes and geometries, whatever the scene.
        let few = |section: &str| ["meshes", "geometries"].contains(&section);
        let others = self.other_columns().into_iter();
        for info in others.filter(|info| !few(info.section)) {
            parts[part_of(info.section).unwrap_or(OTHERS)].1 += info.column.bytes().len();
        }
        parts[OTHERS].1 += self.lights.directional.row_bytes();
        let texels = |t: &super::Texture| t.texels.row_bytes() + t.alpha.row_bytes();
        parts[TEXTURES].1 = self.textures.iter().map(texels).sum();
        let environment = self.environment.as_ref();
        parts[ENVIRONMENT].1 =
            environment.map_or(0, |environment| environment.light.texel_bytes().len());
        parts
    }

    /// Bytes of all columns.
    pub fn memory_bytes(&self) -> usize {
        self.memory_parts().iter().map(|(_, bytes)| bytes).sum()
    }
}
