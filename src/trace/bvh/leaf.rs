//! Primitives in leaf order, with only the data that their tests need.

use super::LeafKind;
use bytemuck::{Pod, Zeroable};
use phalanx_scene::{Column, PrimKind};

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
    pub const FILE_ORDER: [LeafKind; LeafKind::COUNT] = [
        LeafKind::TRIANGLE,
        LeafKind::SPHERE,
        LeafKind::Prim(PrimKind::Ellipsoid),
        LeafKind::Prim(PrimKind::Cone),
        LeafKind::Instance,
    ];

    /// Number of primitives of a kind.
    #[inline]
    pub fn count(&self, kind: LeafKind) -> usize {
        match kind {
            LeafKind::Prim(PrimKind::Triangle) => self.triangles.len(),
            LeafKind::Prim(PrimKind::Sphere) => self.spheres.len(),
            LeafKind::Prim(PrimKind::Ellipsoid) => self.ellipsoids.len(),
            LeafKind::Prim(PrimKind::Cone) => self.cones.len(),
            LeafKind::Instance => self.instances.len(),
        }
    }

    /// Bytes of all columns.
    pub fn bytes(&self) -> usize {
        // Columns are named one and all, so that a new one does not compile before it counts.
        let LeafPrims {
            triangles,
            spheres,
            ellipsoids,
            cones,
            instances,
        } = self;
        triangles.row_bytes()
            + spheres.row_bytes()
            + ellipsoids.row_bytes()
            + cones.row_bytes()
            + instances.row_bytes()
    }

    /// Appends the primitives of another set.
    pub(super) fn append(&mut self, other: LeafPrims) {
        // Leaves refer to these rows without a check of bounds, so none may be left out.
        let LeafPrims {
            triangles,
            spheres,
            ellipsoids,
            cones,
            instances,
        } = other;
        self.triangles.extend_from(&triangles);
        self.spheres.extend_from(&spheres);
        self.ellipsoids.extend_from(&ellipsoids);
        self.cones.extend_from(&cones);
        self.instances.extend_from(&instances);
    }
}
