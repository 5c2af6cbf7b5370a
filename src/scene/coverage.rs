//! Partly transparent surfaces, and light that passes through them. Both tracers use these
//! functions, one hit at a time.
//!
//! The coverage α of a hit is its material's opacity, times the alpha of a texture, times the
//! opacity of the vertices; with a cutoff it is 1 from there on, and 0 below (glTF 2.0, 3.9.4). The
//! radiance along a ray is α times the light of the surface, plus (1 − α) times that of the next
//! hit. For camera, mirror and refracted rays a single-sided material is invisible from behind:
//! there its coverage is 0 ([`Scene::seen_coverage`]). For lamps it has both sides: their light is
//! weighted by V, the product of the transmission of all surfaces on the way: 1 − α each, and for
//! thin sheets (1 − α) + α·Kt. If every surface is opaque, this is the design document's V.
//!
//! Hits are ordered by (t, prim_id), and a primitive counts once per ray. So does a surface of
//! several triangles hit on the edge between them ([`Scene::is_same_surface`]); otherwise a half
//! transparent window would have a seam along its diagonal.

use crate::{NO_TEXTURE, PrimKind, SINGLE_SIDED, Scene, THIN};
use glam::{Vec2, Vec3};

/// Maximum number of partly covered surfaces that a ray passes before its light counts as lost.
/// Fully transparent surfaces do not count.
pub const MAX_PASSES: u32 = 64;

/// Smallest share of a camera ray that is followed through other surfaces, 2⁻²⁰. In dense foliage
/// it ends soon.
pub const MIN_SURFACE_SHARE: f32 = 1.0 / 1_048_576.0;

/// A ray's hit on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Primitive, or primitive of an instance: see [`Scene::resolve`].
    pub prim_id: u32,
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Barycentric weight of a triangle's second vertex.
    pub u: f32,
    /// Barycentric weight of a triangle's third vertex.
    pub v: f32,
}

/// Smallest share of a lamp's light that counts, 2⁻²⁰: a product V below this in every component is
/// zero, so that it ends soon in dense foliage.
const MIN_VISIBILITY: f32 = 1.0 / 1_048_576.0;

/// Largest difference of the distances at which a ray meets two triangles on the edge between
/// them, relative to the distance: four times the error of one distance
/// (`perf/notes/distances.md`).
pub(crate) const EDGE_DISTANCE: f32 = 1.0 / 65_536.0;

impl Scene {
    /// Returns true if rays may pass through some surface because it is not fully opaque.
    pub fn has_coverage(&self) -> bool {
        let m = &self.materials;
        m.opacity.iter().any(|&opacity| opacity < 1.0)
            || m.opacity_texture
                .iter()
                .any(|&texture| texture != NO_TEXTURE)
            || (self.triangles.vertex_opacity.iter()).any(|&opacity| opacity < 1.0)
    }

    /// Returns true if light from a lamp may pass through some surface, so that V may be other than
    /// 0 or 1.
    pub fn has_clear_shadows(&self) -> bool {
        self.materials.flags.iter().any(|&flags| flags & THIN != 0) || self.has_coverage()
    }

    /// Returns true if some material is invisible from behind.
    pub fn has_unseen_backs(&self) -> bool {
        let mut flags = self.materials.flags.iter();
        flags.any(|&flags| flags & SINGLE_SIDED != 0)
    }

    /// Returns true if a ray of this direction hits the invisible back of a triangle: its material
    /// is single-sided, and its vertices are clockwise as seen along the ray. A mirroring instance
    /// does not turn fronts into backs (glTF 2.0, 3.7.4 and 3.9.6).
    pub fn is_unseen_back(&self, dir: Vec3, prim_id: u32) -> bool {
        let placed = self.resolve(prim_id);
        let prim = self.prims[placed.prim as usize];
        let material = self.prim_material(placed.prim) as usize;
        if self.materials.flags[material] & SINGLE_SIDED == 0 || prim.kind() != PrimKind::Triangle {
            return false;
        }
        let dir = self.object_direction(dir, placed.instance);
        let [a, b, c] = self.triangles.corners(prim.index()).map(Vec3::as_dvec3);
        (b - a).cross(c - a).dot(dir.as_dvec3()) > 0.0
    }

    /// A direction in the space of an instance's mesh, or of the world.
    pub(crate) fn object_direction(&self, dir: Vec3, instance: Option<u32>) -> Vec3 {
        instance.map_or(dir, |instance| {
            let [x, y, z, _] = self.instances.object_columns(instance as usize);
            (x * dir.x + y * dir.y) + z * dir.z
        })
    }

    /// Coverage at a hit for a ray of this direction; `None` on an invisible back, where it is 0.
    pub fn seen_coverage(&self, dir: Vec3, hit: SurfaceHit) -> Option<f32> {
        (!self.is_unseen_back(dir, hit.prim_id)).then(|| self.coverage(hit))
    }

    /// Coverage at a hit, 0 to 1: the opacity of the surface.
    pub fn coverage(&self, hit: SurfaceHit) -> f32 {
        let stored = self.resolve(hit.prim_id).prim;
        self.stored_coverage(stored, self.prim_material(stored) as usize, hit)
    }

    /// Coverage at a hit on a stored primitive of this material.
    fn stored_coverage(&self, stored: u32, material: usize, hit: SurfaceHit) -> f32 {
        let prim = self.prims[stored as usize];
        let mut share = self.materials.opacity[material];
        if prim.kind() == PrimKind::Triangle {
            let weights = [(1.0 - hit.u) - hit.v, hit.u, hit.v];
            share *= self.vertex_coverage(prim.index(), weights);
            let texture = self.materials.opacity_texture[material];
            if texture != NO_TEXTURE
                && let Some([a, b, c]) = self.triangles.corner_uvs(prim.index(), 0)
            {
                let [wa, wb, wc] = weights;
                let Vec2 { x, y } = (a * wa + b * wb) + c * wc;
                share *= self.textures[texture as usize].alpha_at(x, y);
            }
        }
        match self.materials.alpha_cutoff[material] {
            0.0 => share,
            cutoff if share >= cutoff => 1.0,
            _ => 0.0,
        }
    }

    /// Opacity of a triangle's vertices at these barycentric weights; 1 without any.
    fn vertex_coverage(&self, triangle: usize, [wa, wb, wc]: [f32; 3]) -> f32 {
        let Some(rows) = self.triangles.color_rows(triangle) else {
            return 1.0;
        };
        let [a, b, c] = rows.map(|row| self.triangles.vertex_opacity[row as usize]);
        // The weights' sum is rounded; an opaque triangle stays opaque.
        if a == b && b == c { a } else { ((a * wa + b * wb) + c * wc).clamp(0.0, 1.0) }
    }

    /// Returns true if a ray's next hit is only the other side of an edge or vertex on which the
    /// previous hit lies: both are on triangles that share a vertex, at the same distance.
    pub fn is_same_surface(&self, before: SurfaceHit, next: SurfaceHit) -> bool {
        if next.t - before.t > EDGE_DISTANCE * next.t {
            return false;
        }
        let [before, next] = [before, next].map(|hit| self.resolve(hit.prim_id));
        let corners = |stored: u32| {
            let prim = self.prims[stored as usize];
            (prim.kind() == PrimKind::Triangle).then(|| self.triangles.corners(prim.index()))
        };
        match (corners(before.prim), corners(next.prim)) {
            (Some(before_corners), Some(corners)) if before.instance == next.instance => {
                let shared = before_corners.iter().filter(|&c| corners.contains(c));
                // Coincident triangles are separate surfaces.
                (1..3).contains(&shared.count())
            }
            _ => false,
        }
    }

    /// V after one more surface: `passed`, the share of a lamp's light that has passed the previous
    /// surfaces, times the share that passes this one. Zero if that is negligible.
    pub fn pass_light(&self, passed: Vec3, hit: SurfaceHit) -> Vec3 {
        let passed = passed * self.transmittance(hit);
        if passed.cmplt(Vec3::splat(MIN_VISIBILITY)).all() {
            Vec3::ZERO
        } else {
            passed
        }
    }

    /// Share of a lamp's light that passes the surface at a hit: its factor in V.
    pub fn transmittance(&self, hit: SurfaceHit) -> Vec3 {
        let stored = self.resolve(hit.prim_id).prim;
        let material = self.prim_material(stored) as usize;
        let coverage = self.stored_coverage(stored, material, hit);
        let open = Vec3::splat(1.0 - coverage);
        match self.materials.flags[material] & THIN {
            0 => open,
            _ => open + self.materials.kt.get(material) * coverage,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, Mesh, MeshMaterial, Texture, Wrap};

    /// A triangle whose vertices have these opacities, and one texture of two columns of alpha.
    fn scene(material: Material, vertex_opacity: Option<[f32; 3]>) -> Scene {
        let mut scene = Scene::default();
        scene.textures.push(Texture {
            width: 2,
            height: 1,
            wrap: [Wrap::Clamp; 2],
            nearest: false,
            texels: vec![[0; 3]; 2].into(),
            alpha: vec![0, 255].into(),
        });
        scene.materials.push(&material);
        let mut mesh = Mesh {
            corners: vec![[0, 1, 2]].into(),
            uvs: vec![[0, 1, 2]].into(),
            material: MeshMaterial::One(0),
            ..Mesh::default()
        };
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] {
            mesh.vertices.push(Vec3::new(x, y, 0.0));
            mesh.vertex_uvs.push(Vec2::new(x, y));
        }
        if let Some(opacity) = vertex_opacity {
            mesh.colors = vec![[0, 1, 2]].into();
            (0..3).for_each(|_| mesh.vertex_colors.push(Vec3::ONE));
            mesh.vertex_opacity = opacity.to_vec().into();
        }
        scene.append_mesh(mesh);
        scene.validate().expect("a scene");
        scene
    }

    fn at(u: f32, v: f32) -> SurfaceHit {
        SurfaceHit {
            prim_id: 0,
            t: 1.0,
            u,
            v,
        }
    }

    #[test]
    fn opacity_texture_and_vertices_are_multiplied() {
        let half = Material {
            opacity: 0.5,
            opacity_texture: 0,
            ..Material::DEFAULT
        };
        let textured = scene(half, None);
        assert!(textured.has_coverage() && textured.has_clear_shadows());
        assert_eq!(textured.coverage(at(0.0, 0.5)), 0.0);
        assert_eq!(textured.coverage(at(1.0, 0.0)), 0.5);
        assert_eq!(textured.coverage(at(0.5, 0.25)), 0.25);
        let all = scene(half, Some([0.0, 0.5, 1.0]));
        assert_eq!(all.coverage(at(1.0, 0.0)), 0.25);
        assert_eq!(all.transmittance(at(1.0, 0.0)), Vec3::splat(0.75));
    }

    #[test]
    fn a_cutoff_leaves_all_or_nothing() {
        let mask = Material {
            opacity_texture: 0,
            alpha_cutoff: 0.5,
            ..Material::DEFAULT
        };
        let scene = scene(mask, None);
        for (u, want) in [(0.3, 0.0), (0.5, 1.0), (0.9, 1.0)] {
            assert_eq!(scene.coverage(at(u, 0.0)), want, "{u}");
        }
    }

    #[test]
    fn whole_vertices_stay_whole_whatever_the_weights() {
        let scene = scene(Material::DEFAULT, Some([1.0; 3]));
        assert!(!scene.has_coverage());
        for k in 0..1000 {
            let (u, v) = (k as f32 / 3001.0, k as f32 / 1999.0);
            assert_eq!(scene.coverage(at(u, v)), 1.0);
        }
    }

    #[test]
    fn thin_sheets_pass_light_in_their_colour() {
        let sheet = Material {
            kt: Vec3::new(0.5, 1.0, 0.0),
            thin: true,
            ..Material::DEFAULT
        };
        let opaque = scene(sheet, None);
        assert!(!opaque.has_coverage() && opaque.has_clear_shadows());
        assert_eq!(opaque.transmittance(at(0.2, 0.2)), sheet.kt);
        let half = scene(
            Material {
                opacity: 0.5,
                ..sheet
            },
            None,
        );
        assert_eq!(half.transmittance(at(0.2, 0.2)), Vec3::new(0.75, 1.0, 0.5));
        // Glass that bends light keeps its shadow.
        let glass = scene(
            Material {
                thin: false,
                ..sheet
            },
            None,
        );
        assert_eq!(glass.transmittance(at(0.2, 0.2)), Vec3::ZERO);
        assert!(!glass.has_clear_shadows());
    }
}
