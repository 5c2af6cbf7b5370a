//! The one check between reading and tracing: after it nothing downstream can fail.

use super::ViewError;
use super::{MAX_TEXTURE_SIDE, Prim, PrimKind, Scene};
use crate::environment::Environment;
use crate::geometries::GeometryRow;
use crate::prim_places::PrimPlace;
use crate::prims::ColumnInfo;
use glam::Vec3;
use std::collections::HashSet;

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
    /// Names that are not text, or out of order, or fewer than their numbers.
    #[error("the names of objects, materials or cameras are damaged")]
    DamagedNames,
    /// No camera of the file has this name or number.
    #[error("no camera is called {asked}: {known}")]
    NoCamera {
        /// Name or number that was asked for, in quotes.
        asked: String,
        /// The cameras that there are.
        known: String,
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
        validate_rows(self.prim_columns())?;
        let environment = self.environment.as_ref();
        if let Some(k) = environment.and_then(Environment::first_invalid_texel) {
            return Err(column("texel", "radiance", k, "negative or not finite"));
        }
        self.validate_boxes()
    }

    /// Checks the same as [`Scene::validate`], except the conditions on the columns of primitives
    /// and on the texels of the environment, which must be known to hold. That is quick even for
    /// scenes of millions. Only the primitives that instances show are checked row by row.
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
        validate_rows(self.other_columns())?;
        self.validate_extents()?;
        self.validate_instances()?;
        self.validate_geometries()?;
        self.validate_names()?;
        self.validate_textures()?;
        if !self.environment.as_ref().is_none_or(Environment::is_valid) {
            return Err(column("environment", "size or radiance", 0, "out of range"));
        }
        self.validate_materials()?;
        self.validate_lights()
    }

    /// Checks that all columns have the required lengths.
    fn validate_lengths(&self) -> Result<(), SceneError> {
        let mut all = self.prim_columns().chain(self.other_columns());
        all.try_for_each(|info| {
            same_length(info.row_kind, info.attribute, info.column.rows(), info.len)
        })
    }

    /// Checks that no primitive is degenerate.
    fn validate_extents(&self) -> Result<(), SceneError> {
        for kind in PrimKind::ALL {
            let fault = self.columns_of(kind).first_degenerate();
            if let Some((row, [attribute, problem])) = fault {
                return Err(column(kind.name(), attribute, row, problem));
            }
        }
        Ok(())
    }

    /// Checks that geometries are runs of primitives, one after another, and instances that exist.
    fn validate_geometries(&self) -> Result<(), SceneError> {
        let (geometries, prims) = (&self.geometries, self.prim_count());
        let vertices = self.triangles.vertices.len();
        if let Some(row) = geometries.first_wrong_place(prims, vertices) {
            return Err(column("mesh", "vertices", row, "out of range"));
        }
        if let Some(id) = geometries.first_wrong(prims, self.instances.len()) {
            return Err(column("geometry", "run", id as usize, "out of range"));
        }
        let rows_are_mixed = |row: &[u32; 5]| {
            let place = PrimPlace::of_row(*row);
            let prims = place.all_prims();
            let own = &self.prims[prims.start as usize..prims.end as usize];
            let kind = match place.vertices {
                0 => PrimKind::Sphere,
                _ => PrimKind::Triangle,
            };
            let first = own.first().map_or(0, |prim| prim.index());
            let expected = |k: usize| Prim::new(kind, (first + k) as u32);
            !own.iter().enumerate().all(|(k, prim)| *prim == expected(k))
        };
        match geometries.places.iter().position(rows_are_mixed) {
            Some(row) => Err(column("mesh", "vertices", row, "of mixed rows")),
            None => Ok(()),
        }
    }

    fn validate_instances(&self) -> Result<(), SceneError> {
        let (meshes, instances) = (&self.meshes, &self.instances);
        let mut end = 0u64;
        for mesh in 0..meshes.len() {
            let (first, count) = (meshes.first[mesh], meshes.count[mesh]);
            // Those that were removed have a place, and no primitives.
            let removed = self.geometries.prim_place(first).is_some() && count == 0;
            if u64::from(first) < end || count == 0 && !removed {
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
        let wild = (0..instances.len()).find(|&k| !instances.has_moderate_transforms(k));
        if let Some(k) = wild {
            return Err(column("instance", "transform", k, "beyond 2^40 either way"));
        }
        // The last number stands for a miss.
        let ids = self.id_count();
        if ids >= u64::from(u32::MAX) {
            return Err(SceneError::TooManyShown(ids));
        }
        let mut end = 0;
        let mut present = self.present_instances().peekable();
        for (k, &first) in instances.first.iter().enumerate() {
            if u64::from(first) < end {
                return Err(column("instance", "number", k, "among those before"));
            }
            // Those that were removed may name a mesh that is another by now.
            let is_present = present.next_if_eq(&k).is_some();
            let count = meshes.count[instances.mesh[k] as usize];
            if is_present && count == 0 {
                return Err(column("instance", "mesh", k, "without primitives"));
            }
            end = u64::from(first) + if is_present { u64::from(count) } else { 0 };
        }
        Ok(())
    }

    /// The instances that were not removed.
    fn present_instances(&self) -> impl Iterator<Item = usize> {
        let removed = self.geometries.rows().filter_map(|(_, row)| match row {
            GeometryRow::RemovedInstance(k) => Some(k as usize),
            _ => None,
        });
        let removed: HashSet<usize> = removed.collect();
        (0..self.instances.len()).filter(move |k| !removed.contains(k))
    }

    /// Checks that every instance's box is finite in single precision, as trees need it.
    fn validate_boxes(&self) -> Result<(), SceneError> {
        let meshes = self.bounds_of_meshes();
        for k in self.present_instances() {
            let mesh = self.instances.mesh[k] as usize;
            let own = self.instances.bounds(k, meshes[mesh]).padded();
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
        if self.materials.len() > MAX_MATERIALS {
            return Err(column("material", "row", MAX_MATERIALS, "one too many"));
        }
        let maps = self.maps.len() as u64;
        let ends = |&[first, count]: &[u32; 2]| u64::from(first) + u64::from(count);
        match self.materials.maps.iter().position(|set| ends(set) > maps) {
            Some(row) => Err(column("material", "maps", row, "out of range")),
            None => Ok(()),
        }
    }

    fn validate_lights(&self) -> Result<(), SceneError> {
        let l = &self.lights;
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

/// Checks the condition on each row of columns.
fn validate_rows<'a>(columns: impl IntoIterator<Item = ColumnInfo<'a>>) -> Result<(), SceneError> {
    columns.into_iter().try_for_each(|info| {
        let rows = info.column;
        match info.check.first_fault(rows.bytes(), rows.row_size()) {
            Some(row) => Err(column(
                info.row_kind,
                info.attribute,
                row,
                info.check.problem(),
            )),
            None => Ok(()),
        }
    })
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
