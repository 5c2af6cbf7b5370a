//! Memory of the columns, in bytes.

use super::{Scene, Vec3s};

impl Scene {
    /// Bytes of the columns by part, both in owned memory and in a mapped file.
    pub fn memory_parts(&self) -> [(&'static str, usize); 9] {
        let vectors = |all: &[&Vec3s]| all.iter().map(|v| v.row_bytes()).sum::<usize>();
        let maps = |a: &[Vec3s; 4], b: &[Vec3s; 4]| {
            let all = a.iter().chain(b);
            all.map(Vec3s::row_bytes).sum::<usize>()
        };
        // Columns are named one and all, so that a new one does not compile before it counts.
        let Scene {
            spheres: s,
            ellipsoids: e,
            triangles: t,
            cones: c,
            materials: m,
            lights: l,
            instances: i,
            prims,
            textures,
            // Few rows, whatever the scene.
            meshes: _,
            geometries: _,
            output: _,
            // No columns.
            width: _,
            height: _,
            max_depth: _,
            background: _,
            sky: _,
            encoding: _,
            view: _,
            defaulted: _,
            scale: _,
            origin: _,
        } = self;
        let curved = vectors(&[&s.center, &c.base, &c.apex])
            + maps(&e.to_world, &e.to_object)
            + [&s.radius, &c.base_radius, &c.apex_radius]
                .map(|r| r.row_bytes())
                .iter()
                .sum::<usize>()
            + c.inside.row_bytes()
            + [&s.material, &e.material, &c.material]
                .map(|r| r.row_bytes())
                .iter()
                .sum::<usize>();
        [
            ("vertices", t.vertices.row_bytes()),
            (
                "vertex colours",
                t.colors.row_bytes() + t.vertex_colors.row_bytes() + t.vertex_opacity.row_bytes(),
            ),
            ("triangles", t.corners.row_bytes() + t.material.row_bytes()),
            (
                "vertex normals",
                t.normals.row_bytes() + t.vertex_normals.row_bytes(),
            ),
            (
                "texture places",
                t.uvs.row_bytes() + t.vertex_uvs.row_bytes(),
            ),
            (
                "textures",
                textures
                    .iter()
                    .map(|t| t.texels.row_bytes() + t.alpha.row_bytes())
                    .sum(),
            ),
            ("curved primitives", curved),
            (
                "instances",
                maps(&i.to_world, &i.to_object) + i.mesh.row_bytes() + i.first.row_bytes(),
            ),
            (
                "primitive list, materials and lights",
                prims.row_bytes()
                    + vectors(&[&m.ka, &m.ke, &m.kd, &m.ks, &m.kt])
                    + m.shininess.row_bytes()
                    + m.ior.row_bytes()
                    + m.texture.row_bytes()
                    + m.gloss.row_bytes()
                    + m.opacity.row_bytes()
                    + m.opacity_texture.row_bytes()
                    + m.alpha_cutoff.row_bytes()
                    + m.flags.row_bytes()
                    + vectors(&[&l.position, &l.color, &l.attenuation])
                    + vectors(&l.edges.each_ref())
                    + l.radius.row_bytes()
                    + l.axis.row_bytes()
                    + l.cone.row_bytes()
                    + l.directional.row_bytes(),
            ),
        ]
    }

    /// Bytes of all columns.
    pub fn memory_bytes(&self) -> usize {
        self.memory_parts().iter().map(|(_, bytes)| bytes).sum()
    }
}
