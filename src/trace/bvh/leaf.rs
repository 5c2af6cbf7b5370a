//! Primitives in leaf order, with only the data that their tests need.

use super::build_input::{BuildInput, triangle_bounds};
use super::clustering::LeafObjects;
use super::leaf_column::{LeafColumn, LeafRow};
use super::leaving::RowKey;
use super::node::LeafKind;
use super::prim_ref::PrimIndex;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use phalanx_scene::{AnyColumn, Bounds, Column, PrimKind};
use std::ops::Range;

/// A triangle in leaf order. Its own padded box is not stored: it is computed from the vertices if
/// a ray hits them.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct LeafTriangle {
    /// The three vertices.
    pub vertices: [[f32; 3]; 3],
    /// `prim_id` of the stored primitive.
    pub prim_id: u32,
}

impl LeafTriangle {
    /// The triangle's padded box.
    #[inline(always)]
    pub(super) fn bounds(&self) -> Bounds {
        // One by one: `map` would copy the row through memory.
        let [a, b, c] = &self.vertices;
        triangle_bounds([
            Vec3::from_array(*a),
            Vec3::from_array(*b),
            Vec3::from_array(*c),
        ])
    }
}

impl LeafRow for LeafTriangle {
    const KIND: LeafKind = LeafKind::TRIANGLE;
    const NAME: &'static str = "triangles of the tree";

    #[inline(always)]
    fn of(input: &BuildInput, object: PrimIndex) -> LeafTriangle {
        let [a, b, c] = input.vertices(input.row(object));
        LeafTriangle {
            vertices: [a.to_array(), b.to_array(), c.to_array()],
            prim_id: object,
        }
    }

    fn key(&self) -> RowKey {
        RowKey::Prim(self.prim_id)
    }

    fn padded_box(&self) -> Bounds {
        self.bounds()
    }
}

/// A sphere in leaf order.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct LeafSphere {
    /// Centre.
    pub center: [f32; 3],
    /// Radius.
    pub radius: f32,
    /// The sphere's own padded box.
    pub prim_aabb: [[f32; 3]; 2],
    /// `prim_id` of the stored primitive.
    pub prim_id: u32,
}

impl LeafRow for LeafSphere {
    const KIND: LeafKind = LeafKind::SPHERE;
    const NAME: &'static str = "spheres of the tree";

    fn of(input: &BuildInput, object: PrimIndex) -> LeafSphere {
        let (spheres, row) = (&input.scene.spheres, input.row(object));
        LeafSphere {
            center: spheres.center.get(row).to_array(),
            radius: spheres.radius[row],
            prim_aabb: input.prim_aabb(object),
            prim_id: object,
        }
    }

    fn key(&self) -> RowKey {
        RowKey::Prim(self.prim_id)
    }

    fn padded_box(&self) -> Bounds {
        box_of(&self.prim_aabb)
    }
}

/// An ellipsoid in leaf order.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct LeafEllipsoid {
    /// World-to-object map: three columns of the matrix and the translation.
    pub to_object: [[f32; 3]; 4],
    /// The ellipsoid's own padded box.
    pub prim_aabb: [[f32; 3]; 2],
    /// `prim_id` of the stored primitive.
    pub prim_id: u32,
}

impl LeafRow for LeafEllipsoid {
    const KIND: LeafKind = LeafKind::Prim(PrimKind::Ellipsoid);
    const NAME: &'static str = "ellipsoids of the tree";

    fn of(input: &BuildInput, object: PrimIndex) -> LeafEllipsoid {
        let columns = input.scene.ellipsoids.object_columns(input.row(object));
        LeafEllipsoid {
            to_object: columns.map(|column| column.to_array()),
            prim_aabb: input.prim_aabb(object),
            prim_id: object,
        }
    }

    fn key(&self) -> RowKey {
        RowKey::Prim(self.prim_id)
    }

    fn padded_box(&self) -> Bounds {
        box_of(&self.prim_aabb)
    }
}

/// A truncated cone in leaf order: see [`ConeFrame`](phalanx_scene::ConeFrame).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct LeafCone {
    /// Centre of the first end.
    pub base: [f32; 3],
    /// The cone's own unit axes; the last is its axis.
    pub axes: [[f32; 3]; 3],
    /// Distance between the two ends.
    pub length: f32,
    /// The first end's radius times the slope's cosine.
    pub radius: f32,
    /// The slope's sine.
    pub sin: f32,
    /// The slope's cosine, squared.
    pub cos_squared: f32,
    /// The cone's own padded box.
    pub prim_aabb: [[f32; 3]; 2],
    /// 1 if only the inside is visible, else 0.
    pub inside: u32,
    /// `prim_id` of the stored primitive.
    pub prim_id: u32,
}

impl LeafRow for LeafCone {
    const KIND: LeafKind = LeafKind::Prim(PrimKind::Cone);
    const NAME: &'static str = "cones of the tree";

    fn of(input: &BuildInput, object: PrimIndex) -> LeafCone {
        let (cones, row) = (&input.scene.cones, input.row(object));
        let frame = cones.frame(row);
        LeafCone {
            base: frame.base.to_array(),
            axes: frame.axes.map(|axis| axis.to_array()),
            length: frame.length,
            radius: frame.radius,
            sin: frame.sin,
            cos_squared: frame.cos_squared,
            prim_aabb: input.prim_aabb(object),
            inside: u32::from(cones.inside[row]),
            prim_id: object,
        }
    }

    fn key(&self) -> RowKey {
        RowKey::Prim(self.prim_id)
    }

    fn padded_box(&self) -> Bounds {
        box_of(&self.prim_aabb)
    }
}

/// An instance in leaf order.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct LeafInstance {
    /// World-to-mesh map: three columns of the matrix and the translation.
    pub to_object: [[f32; 3]; 4],
    /// The instance's own padded box.
    pub prim_aabb: [[f32; 3]; 2],
    /// Root node of the mesh's tree.
    pub root: u32,
    /// Offset that is added, wrapping, to a stored primitive's number to give the number of the
    /// instance's primitive.
    pub id_offset: u32,
}

impl LeafRow for LeafInstance {
    const KIND: LeafKind = LeafKind::Instance;
    const NAME: &'static str = "instances of the tree";

    fn of(input: &BuildInput, object: PrimIndex) -> LeafInstance {
        let (scene, row) = (input.scene, input.row(object));
        let mesh = scene.instances.mesh[row] as usize;
        let first_id = scene.instance_first_id(row);
        LeafInstance {
            to_object: scene.instances.object_columns(row).map(|c| c.to_array()),
            prim_aabb: input.prim_aabb(object),
            // The root of the mesh's tree is known once all trees exist.
            root: mesh as u32,
            id_offset: first_id.wrapping_sub(scene.meshes.first[mesh]),
        }
    }

    fn key(&self) -> RowKey {
        RowKey::Instance(self.root, self.id_offset)
    }

    fn padded_box(&self) -> Bounds {
        box_of(&self.prim_aabb)
    }
}

/// A padded box from its corners.
fn box_of([lo, hi]: &[[f32; 3]; 2]) -> Bounds {
    Bounds::new(Vec3::from_array(*lo), Vec3::from_array(*hi))
}

/// All primitives in leaf order, a column for each kind.
#[derive(Clone, Debug, Default)]
pub struct LeafPrims {
    /// Triangles.
    pub triangles: Column<LeafTriangle>,
    /// Spheres.
    pub spheres: Column<LeafSphere>,
    /// Ellipsoids.
    pub ellipsoids: Column<LeafEllipsoid>,
    /// Cones.
    pub cones: Column<LeafCone>,
    /// Instances.
    pub instances: Column<LeafInstance>,
}

impl LeafPrims {
    /// Order of the columns in a file, each kind once.
    pub const FILE_ORDER: [LeafKind; LeafKind::COUNT] = {
        let mut order = [LeafKind::Instance; LeafKind::COUNT];
        let mut k = 0;
        while k < PrimKind::COUNT {
            order[k] = LeafKind::Prim(PrimKind::FILE_ORDER[k]);
            k += 1;
        }
        order
    };

    /// The rows of all objects of chunks, chunk by chunk.
    pub(super) fn of_chunks(input: &BuildInput, chunks: &[LeafObjects]) -> LeafPrims {
        let mut all = LeafPrims::default();
        for kind in LeafKind::all() {
            all.leaf_column_mut(kind).fill(input, chunks);
        }
        all
    }

    /// The column of a kind.
    pub(super) fn column(&self, kind: LeafKind) -> &dyn LeafColumn {
        match kind {
            LeafKind::Prim(PrimKind::Triangle) => &self.triangles,
            LeafKind::Prim(PrimKind::Sphere) => &self.spheres,
            LeafKind::Prim(PrimKind::Ellipsoid) => &self.ellipsoids,
            LeafKind::Prim(PrimKind::Cone) => &self.cones,
            LeafKind::Instance => &self.instances,
        }
    }

    pub(super) fn leaf_column_mut(&mut self, kind: LeafKind) -> &mut dyn LeafColumn {
        match kind {
            LeafKind::Prim(PrimKind::Triangle) => &mut self.triangles,
            LeafKind::Prim(PrimKind::Sphere) => &mut self.spheres,
            LeafKind::Prim(PrimKind::Ellipsoid) => &mut self.ellipsoids,
            LeafKind::Prim(PrimKind::Cone) => &mut self.cones,
            LeafKind::Instance => &mut self.instances,
        }
    }

    /// The column of a kind, to be mapped.
    pub fn column_mut(&mut self, kind: LeafKind) -> &mut dyn AnyColumn {
        self.leaf_column_mut(kind)
    }

    /// Number of primitives of a kind.
    pub fn count(&self, kind: LeafKind) -> usize {
        self.column(kind).rows()
    }

    /// [`LeafPrims::count`] of every kind, in the order of their numbers.
    pub(super) fn counts(&self) -> [usize; LeafKind::COUNT] {
        let mut counts = [0; LeafKind::COUNT];
        LeafKind::all().for_each(|kind| counts[kind.number()] = self.count(kind));
        counts
    }

    /// The numbers of the primitives of a kind in these rows; none of instances.
    pub fn stored_prims(&self, kind: LeafKind, rows: Range<usize>) -> Vec<u32> {
        self.column(kind).stored_prims(rows)
    }

    /// Bytes of a row of a kind.
    pub(crate) fn row_size(kind: LeafKind) -> usize {
        LeafPrims::default().column(kind).row_size()
    }

    /// Bytes of all columns.
    pub fn bytes(&self) -> usize {
        let columns = LeafKind::all().map(|kind| self.column(kind));
        columns.map(|column| column.bytes().len()).sum()
    }

    /// Writes the rows of a kind of another set from row `first` on.
    pub(super) fn write(&mut self, kind: LeafKind, first: usize, other: &LeafPrims) {
        let rows = other.column(kind).bytes();
        self.leaf_column_mut(kind).write_bytes(first, rows);
    }
}
