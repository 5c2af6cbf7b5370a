//! The one check between reading and tracing: after it nothing downstream can fail.

use super::ViewError;
use super::{
    Bounds, MAX_TEXTURE_SIDE, NO_COLORS, NO_NORMALS, NO_TEXTURE, NO_UVS, Prim, PrimKind, Scene,
    Vec3s,
};
use glam::Vec3;

/// Longest side of an image, in pixels.
pub const MAX_SIDE: u32 = 65_536;
/// Most bounces after the primary ray.
pub const MAX_DEPTH_LIMIT: u32 = 1000;

/// Most materials: shading packs a material's number, a bit for instances and the kind of its hits
/// into one word.
const MAX_MATERIALS: usize = 1 << (u32::BITS - PrimKind::BITS - 1);

/// Errors of a scene as a whole. A reader reports most of these earlier, with the line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// Image too large, or a side of zero.
    #[error("an image of {0}x{1} pixels is out of range: its sides are 1 to {MAX_SIDE} pixels")]
    ImageSize(u64, u64),
    /// Too many bounces.
    #[error("maxdepth {0} is out of range: at most {MAX_DEPTH_LIMIT}")]
    Depth(u32),
    /// No camera frame can be made.
    #[error(transparent)]
    View(#[from] ViewError),
    /// A column holds NaN or an infinity, or columns of a kind differ in length.
    #[error("{column} of {kind} {index} is {problem}")]
    Column {
        /// Kind of row: "sphere", "triangle", …
        kind: &'static str,
        /// Name of the attribute.
        column: &'static str,
        /// Index of the row.
        index: usize,
        /// Description of the error.
        problem: &'static str,
    },
    /// A camera or a light that is given for a finished scene is too far from its origin.
    #[error(
        "the camera or a light is too far away: a finished scene takes coordinates of at most {0:e}"
    )]
    TooFar(f64),
    /// More primitives than prim_id can count.
    #[error("{0} primitives are more than 2^30 - 1")]
    TooMany(usize),
    /// More primitives, those of all instances counted, than prim_id can number.
    #[error("{0} primitives, those of instances among them: at most 2^32 - 2 can be told apart")]
    TooManyShown(u64),
}

/// Checks an image size. Sides are taken as u64 so that an overflowing request can be reported.
pub fn check_image_size(width: u64, height: u64) -> Result<(), SceneError> {
    let side = 1..=MAX_SIDE as u64;
    if side.contains(&width) && side.contains(&height) {
        Ok(())
    } else {
        Err(SceneError::ImageSize(width, height))
    }
}

impl Scene {
    /// Checks every range that tracing relies on: sizes, finite columns, indices, signs.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.validate_tables()?;
        self.validate_prims()?;
        self.validate_shapes()?;
        self.validate_boxes()
    }

    /// Checks the same as [`Scene::validate`], but for the rows of primitives, spheres, ellipsoids
    /// and triangles, which must be known to be valid. That is quick even for scenes of millions.
    /// Only the primitives that instances show are checked row by row.
    pub fn validate_settings(&self) -> Result<(), SceneError> {
        self.validate_tables()?;
        self.validate_boxes()
    }

    fn validate_tables(&self) -> Result<(), SceneError> {
        check_image_size(self.width as u64, self.height as u64)?;
        if self.max_depth > MAX_DEPTH_LIMIT {
            return Err(SceneError::Depth(self.max_depth));
        }
        if self.prims.len() > Prim::MAX_INDEX as usize {
            return Err(SceneError::TooMany(self.prims.len()));
        }
        self.view.basis()?;
        self.validate_lengths()?;
        self.validate_cones()?;
        self.validate_instances()?;
        self.validate_geometries()?;
        self.validate_textures()?;
        self.validate_materials()?;
        self.validate_lights()
    }

    /// Checks that the columns of spheres, ellipsoids and triangles have the required lengths.
    fn validate_lengths(&self) -> Result<(), SceneError> {
        let (s, e, t) = (&self.spheres, &self.ellipsoids, &self.triangles);
        let rows = self.counts().iter().sum();
        same_length("primitive", "row", self.prims.len(), rows)?;
        let vectors = |kind, name, v: &Vec3s, len| {
            let mut parts = v.parts().into_iter();
            parts.try_for_each(|part| same_length(kind, name, part.len(), len))
        };
        vectors("sphere", "center", &s.center, s.len())?;
        same_length("sphere", "material", s.material.len(), s.len())?;
        for columns in e.to_world.iter().chain(&e.to_object) {
            vectors("ellipsoid", "transform", columns, e.len())?;
        }
        vectors("vertex", "place", &t.vertices, t.vertices.len())?;
        let normals = &t.vertex_normals;
        vectors("vertex normal", "direction", normals, normals.len())?;
        let places = &t.vertex_uvs;
        same_length("vertex", "texture place", places.y.len(), places.len())?;
        same_length("triangle", "corners", t.corners.len(), t.len())?;
        let colors = t.vertex_colors.len();
        vectors("vertex", "color", &t.vertex_colors, colors)?;
        same_length("vertex", "opacity", t.vertex_opacity.len(), colors)?;
        for (name, rows) in [
            ("normals", &t.normals),
            ("texture places", &t.uvs),
            ("colors", &t.colors),
        ] {
            if !rows.is_empty() {
                same_length("triangle", name, rows.len(), t.len())?;
            }
        }
        Ok(())
    }

    /// Checks that every primitive's row exists.
    fn validate_prims(&self) -> Result<(), SceneError> {
        let counts = self.counts();
        let known = |p: &Prim| p.index() < counts[p.kind() as usize];
        all("primitive", "row", &self.prims, known, "out of range")
    }

    fn validate_shapes(&self) -> Result<(), SceneError> {
        let s = &self.spheres;
        finite("sphere", "center", &s.center, s.len())?;
        positive("sphere", "radius", &s.radius, s.len())?;
        materials("sphere", &s.material, self.materials.len())?;
        let e = &self.ellipsoids;
        for columns in e.to_world.iter().chain(&e.to_object) {
            finite("ellipsoid", "transform", columns, e.len())?;
        }
        materials("ellipsoid", &e.material, self.materials.len())?;
        self.validate_triangles()
    }

    fn validate_triangles(&self) -> Result<(), SceneError> {
        let t = &self.triangles;
        finite("vertex", "place", &t.vertices, t.vertices.len())?;
        let normals = t.vertex_normals.len();
        finite("vertex normal", "direction", &t.vertex_normals, normals)?;
        let places = t.vertex_uvs.len();
        for part in [&t.vertex_uvs.x, &t.vertex_uvs.y] {
            same_length("vertex", "texture place", part.len(), places)?;
            let finite = |c: &f32| c.is_finite();
            all("vertex", "texture place", part, finite, "not finite")?;
        }
        let colors = t.vertex_colors.len();
        for part in t.vertex_colors.parts() {
            same_length("vertex", "color", part.len(), colors)?;
            all("vertex", "color", part, is_color, "negative or not finite")?;
        }
        same_length("vertex", "opacity", t.vertex_opacity.len(), colors)?;
        all("vertex", "opacity", &t.vertex_opacity, is_share, NO_SHARE)?;
        same_length("triangle", "corners", t.corners.len(), t.len())?;
        rows_in("corners", &t.corners, t.vertices.len(), None)?;
        for (name, rows, count, none) in [
            ("normals", &t.normals, normals, NO_NORMALS),
            ("texture places", &t.uvs, places, NO_UVS),
            ("colors", &t.colors, colors, NO_COLORS),
        ] {
            if !rows.is_empty() {
                same_length("triangle", name, rows.len(), t.len())?;
                rows_in(name, rows, count, Some(none))?;
            }
        }
        materials("triangle", &t.material, self.materials.len())
    }

    fn validate_cones(&self) -> Result<(), SceneError> {
        let c = &self.cones;
        finite("cone", "base", &c.base, c.len())?;
        finite("cone", "apex", &c.apex, c.len())?;
        for radii in [&c.base_radius, &c.apex_radius] {
            same_length("cone", "radius", radii.len(), c.len())?;
            let fine = |r: &f32| r.is_finite() && *r >= 0.0;
            all("cone", "radius", radii, fine, "negative or not finite")?;
        }
        same_length("cone", "side", c.inside.len(), c.len())?;
        for i in 0..c.len() {
            let cone = c.get(i);
            if cone.base == cone.apex || (cone.base_radius == 0.0 && cone.apex_radius == 0.0) {
                return Err(column("cone", "extent", i, "zero"));
            }
        }
        materials("cone", &c.material, self.materials.len())
    }

    /// Checks that geometries are runs of primitives, one after another, and instances that exist.
    fn validate_geometries(&self) -> Result<(), SceneError> {
        let geometries = &self.geometries;
        let rows = geometries.len();
        same_length("geometry", "size", geometries.count.len(), rows)?;
        match geometries.first_wrong(self.prim_count(), self.instances.len()) {
            Some(id) => Err(column("geometry", "run", id as usize, "out of range")),
            None => Ok(()),
        }
    }

    fn validate_instances(&self) -> Result<(), SceneError> {
        let (meshes, instances) = (&self.meshes, &self.instances);
        same_length("mesh", "size", meshes.count.len(), meshes.len())?;
        let mut end = 0u64;
        for mesh in 0..meshes.len() {
            let (first, count) = (meshes.first[mesh], meshes.count[mesh]);
            if u64::from(first) < end || count == 0 {
                return Err(column(
                    "mesh",
                    "run",
                    mesh,
                    "empty, or begins within another",
                ));
            }
            end = u64::from(first) + u64::from(count);
        }
        if end > self.prim_count() as u64 {
            return Err(column("mesh", "run", meshes.len() - 1, "out of range"));
        }
        let known = |&mesh: &u32| (mesh as usize) < meshes.len();
        all("instance", "mesh", &instances.mesh, known, "out of range")?;
        for columns in instances.to_world.iter().chain(&instances.to_object) {
            finite("instance", "transform", columns, instances.len())?;
        }
        let wild = (0..instances.len()).find(|&k| !instances.has_moderate_transforms(k));
        if let Some(k) = wild {
            return Err(column("instance", "transform", k, "beyond 2^40 either way"));
        }
        // The last number stands for a miss.
        let ids = self.id_count();
        if ids >= u64::from(u32::MAX) {
            return Err(SceneError::TooManyShown(ids));
        }
        let mut first = 0;
        same_length("instance", "number", instances.first.len(), instances.len())?;
        for (k, (&mesh, &given)) in instances.mesh.iter().zip(&instances.first).enumerate() {
            if given != first {
                return Err(column(
                    "instance",
                    "number",
                    k,
                    "not the sum of those before",
                ));
            }
            first += meshes.count[mesh as usize];
        }
        Ok(())
    }

    /// Checks that every instance's box is finite in single precision, as trees need it.
    fn validate_boxes(&self) -> Result<(), SceneError> {
        let meshes = (0..self.meshes.len()).map(|mesh| self.mesh_bounds(mesh));
        let meshes: Vec<Bounds> = meshes.collect();
        for (k, &mesh) in self.instances.mesh.iter().enumerate() {
            let own = self.instances.bounds(k, meshes[mesh as usize]).padded();
            if !own.lo.is_finite() || !own.hi.is_finite() {
                return Err(column("instance", "box", k, "not finite"));
            }
        }
        Ok(())
    }

    fn validate_textures(&self) -> Result<(), SceneError> {
        for (i, t) in self.textures.iter().enumerate() {
            let side = 1..=MAX_TEXTURE_SIDE;
            if !side.contains(&t.width) || !side.contains(&t.height) {
                return Err(column("texture", "size", i, "not 1 to 16384 a side"));
            }
            let texels = u64::from(t.width) * u64::from(t.height);
            if texels != t.texels.len() as u64 {
                return Err(column("texture", "texels", i, "missing or surplus"));
            }
            if !t.alpha.is_empty() && texels != t.alpha.len() as u64 {
                return Err(column("texture", "alpha", i, "missing or surplus"));
            }
        }
        Ok(())
    }

    fn validate_materials(&self) -> Result<(), SceneError> {
        let m = &self.materials;
        for (name, column) in [
            ("ka", &m.ka),
            ("ke", &m.ke),
            ("kd", &m.kd),
            ("ks", &m.ks),
            ("kt", &m.kt),
        ] {
            finite("material", name, column, m.len())?;
        }
        same_length("material", "shininess", m.shininess.len(), m.len())?;
        let exponent = |s: &f32| s.is_finite() && *s >= 0.0;
        all(
            "material",
            "shininess",
            &m.shininess,
            exponent,
            "negative or not finite",
        )?;
        same_length("material", "gloss", m.gloss.len(), m.len())?;
        all(
            "material",
            "gloss",
            &m.gloss,
            exponent,
            "negative or not finite",
        )?;
        if m.len() > MAX_MATERIALS {
            return Err(column("material", "row", MAX_MATERIALS, "one too many"));
        }
        let known = |&t: &u32| t == NO_TEXTURE || (t as usize) < self.textures.len();
        for (name, textures) in [
            ("texture", &m.texture),
            ("opacity texture", &m.opacity_texture),
        ] {
            same_length("material", name, textures.len(), m.len())?;
            all("material", name, textures, known, "out of range")?;
        }
        for (name, shares) in [("opacity", &m.opacity), ("cutoff", &m.alpha_cutoff)] {
            same_length("material", name, shares.len(), m.len())?;
            all("material", name, shares, is_share, NO_SHARE)?;
        }
        same_length("material", "flag", m.flags.len(), m.len())?;
        positive("material", "ior", &m.ior, m.len())
    }

    fn validate_lights(&self) -> Result<(), SceneError> {
        let l = &self.lights;
        finite("light", "place", &l.position, l.len())?;
        finite("light", "color", &l.color, l.len())?;
        finite("light", "attenuation", &l.attenuation, l.len())?;
        same_length("light", "radius", l.radius.len(), l.len())?;
        let radius = |r: &f32| r.is_finite() && *r >= 0.0;
        all(
            "light",
            "radius",
            &l.radius,
            radius,
            "negative or not finite",
        )?;
        for edges in &l.edges {
            finite("light", "edge", edges, l.len())?;
        }
        finite("light", "axis", &l.axis, l.len())?;
        for part in [&l.cone.x, &l.cone.y] {
            same_length("light", "cone", part.len(), l.len())?;
            all("light", "cone", part, |c| c.is_finite(), "not finite")?;
        }
        for i in 0..l.len() {
            let flat = l.edges.iter().any(|edge| edge.get(i) != Vec3::ZERO);
            let shapes = [l.directional[i], l.radius[i] > 0.0, flat];
            if shapes.into_iter().filter(|&is| is).count() > 1 {
                return Err(column("light", "shape", i, "not one of those there are"));
            }
            let a = l.attenuation.get(i);
            if a.min_element() < 0.0 || a.max_element() == 0.0 {
                return Err(column("light", "attenuation", i, "negative or all zero"));
            }
        }
        Ok(())
    }
}

fn column(
    kind: &'static str,
    column: &'static str,
    index: usize,
    problem: &'static str,
) -> SceneError {
    SceneError::Column {
        kind,
        column,
        index,
        problem,
    }
}

fn all<T>(
    kind: &'static str,
    name: &'static str,
    values: &[T],
    good: impl Fn(&T) -> bool,
    problem: &'static str,
) -> Result<(), SceneError> {
    // Without an exit from the loop it is vectorised, eight rows at a time. The position of the
    // first invalid row is seldom needed.
    let each = |block: &[T]| block.iter().fold(true, |fine, v| fine & good(v));
    if values.chunks(1 << 12).all(each) {
        return Ok(());
    }
    match values.iter().position(|v| !good(v)) {
        Some(index) => Err(column(kind, name, index, problem)),
        None => Ok(()),
    }
}

/// True for a component of a colour.
fn is_color(c: &f32) -> bool {
    c.is_finite() && *c >= 0.0
}

/// True for a share of a whole.
fn is_share(s: &f32) -> bool {
    (0.0..=1.0).contains(s)
}

const NO_SHARE: &str = "not from 0 to 1";

fn same_length(
    kind: &'static str,
    name: &'static str,
    have: usize,
    want: usize,
) -> Result<(), SceneError> {
    if have == want {
        Ok(())
    } else {
        Err(column(kind, name, have.min(want), "missing or surplus"))
    }
}

fn finite(kind: &'static str, name: &'static str, v: &Vec3s, len: usize) -> Result<(), SceneError> {
    for part in [&v.x, &v.y, &v.z] {
        same_length(kind, name, part.len(), len)?;
        all(kind, name, part, |c| c.is_finite(), "not finite")?;
    }
    Ok(())
}

fn positive(
    kind: &'static str,
    name: &'static str,
    v: &[f32],
    len: usize,
) -> Result<(), SceneError> {
    same_length(kind, name, v.len(), len)?;
    all(
        kind,
        name,
        v,
        |r| r.is_finite() && *r > 0.0,
        "not a positive number",
    )
}

/// Checks that every row is three indices below `count`, or three times `none`.
fn rows_in(
    name: &'static str,
    rows: &[[u32; 3]],
    count: usize,
    none: Option<u32>,
) -> Result<(), SceneError> {
    let good = |row: &[u32; 3]| {
        let within = row
            .iter()
            .fold(true, |fine, &index| fine & ((index as usize) < count));
        within || none.is_some_and(|none| *row == [none; 3])
    };
    all("triangle", name, rows, good, "out of range")
}

fn materials(kind: &'static str, v: &[u32], count: usize) -> Result<(), SceneError> {
    all(
        kind,
        "material",
        v,
        |&m| (m as usize) < count,
        "out of range",
    )
}
