//! Geometry from plain slices, checked as it is added, and its numbers in hits.

use super::{Instances, Material, Mesh, MeshMaterial, Prim, Scene, Vec3s};
use crate::geometries::{GeomId, Geometry, GeometryRow, NO_GEOM};
use crate::prim_places::PlaceKind;
use glam::Vec3;

/// Errors of geometry that cannot be added. A call that returns one adds nothing.
///
/// ```
/// # extern crate phalanx_scene as phalanx;
/// use phalanx::{GeometryError, Scene};
///
/// let error = Scene::new().add_spheres(&[[0.0; 3]], &[-1.0]).unwrap_err();
/// assert_eq!(error, GeometryError::Radius { sphere: 0, radius: -1.0 });
/// assert_eq!(
///     error.to_string(),
///     "sphere 0 has a radius of -1: radii are positive and finite"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A coordinate of a vertex, or of a sphere's centre, is NaN or infinite.
    #[error("vertex {vertex} is not finite: {position:?}")]
    NotFinite {
        /// Row of the vertex.
        vertex: usize,
        /// Its coordinates.
        position: [f32; 3],
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} names vertex {index}, and there are {vertices}")]
    IndexOutOfRange {
        /// Row of the triangle.
        triangle: usize,
        /// The index.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A radius is zero, negative, NaN or infinite.
    #[error("sphere {sphere} has a radius of {radius}: radii are positive and finite")]
    Radius {
        /// Row of the sphere.
        sphere: usize,
        /// Its radius.
        radius: f32,
    },
    /// Centres and radii differ in number.
    #[error("{centers} centres, but {radii} radii")]
    Lengths {
        /// Number of centres.
        centers: usize,
        /// Number of radii.
        radii: usize,
    },
    /// A prototype has no triangles.
    #[error("a prototype without triangles")]
    EmptyPrototype,
    /// More primitives or vertices than 32-bit numbers can name.
    #[error("{0} primitives or vertices in one scene: at most 2^30 - 1 can be told apart")]
    TooMany(usize),
    /// More numbers of primitives than 32 bits hold: each stored one has one, and each that an
    /// instance shows.
    #[error("{0} primitives, those of instances among them: at most 2^32 - 2 can be told apart")]
    TooManyShown(u64),
    /// Moved vertices of another number than the mesh has.
    #[error("{given} vertices for a mesh of {vertices}")]
    VertexCount {
        /// Number of moved vertices.
        given: usize,
        /// Number of the mesh's vertices.
        vertices: usize,
    },
    /// A number that is no geometry's, or not one of this kind.
    #[error("no {kind} has the number {id}")]
    NoGeometry {
        /// Kind of geometry that the call asks for.
        kind: &'static str,
        /// The number.
        id: GeomId,
    },
    /// A prototype that is to be removed, and an instance that shows it.
    #[error("geometry {geometry} is an instance of prototype {prototype}: remove it first")]
    Shown {
        /// The prototype.
        prototype: u32,
        /// The instance.
        geometry: GeomId,
    },
    /// An instance of a prototype that does not exist, or has not been ended.
    #[error("there is no prototype {0}")]
    NoPrototype(u32),
    /// The map of an instance has no inverse in single precision: it or its inverse stretches or
    /// shrinks beyond 2^±40, or leaves the range of f32.
    #[error("the transform cannot be inverted in single precision")]
    NotInvertible,
}

impl Scene {
    /// Creates an empty scene: no primitives, no lights, a camera at (0, 0, 1) that looks at the
    /// origin, 640×480 pixels. Camera, lights and size only matter for pictures, not for rays.
    ///
    /// ```
    /// # extern crate phalanx_scene as phalanx;
    /// use phalanx::Scene;
    ///
    /// let scene = Scene::new();
    /// assert_eq!((scene.prim_count(), scene.lights.len()), (0, 0));
    /// assert_eq!((scene.width, scene.height), (640, 480));
    /// ```
    #[inline]
    pub fn new() -> Scene {
        Scene::default()
    }

    /// Adds a mesh: x, y and z of each vertex, and three rows of `vertices` for each triangle.
    ///
    /// Coordinates are in the scene's units, which are the caller's own. If the largest lies
    /// between 2⁻²⁸ and 2²⁸, nothing overflows or vanishes on the way to a hit. Corners are
    /// counter-clockwise, seen from outside; rays hit both sides. Triangle i has the `prim_id` of
    /// the mesh's first triangle plus i. The material is number 0, a light grey if the scene has
    /// none yet. Both slices may be empty, and triangles may lack area.
    ///
    /// Costs one pass over both slices and a copy of them. A scene holds up to 2³⁰ − 1 primitives
    /// and as many vertices.
    ///
    /// # Errors
    /// [`GeometryError::NotFinite`], [`GeometryError::IndexOutOfRange`], [`GeometryError::TooMany`]
    /// and [`GeometryError::TooManyShown`].
    ///
    /// ```
    /// # extern crate phalanx_scene as phalanx;
    /// use phalanx::{GeometryError, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// assert_eq!(scene.add_mesh(&corners, &[[0, 1, 2]]), Ok(0));
    /// let wrong = scene.add_mesh(&corners, &[[0, 1, 3]]);
    /// assert!(matches!(wrong, Err(GeometryError::IndexOutOfRange { triangle: 0, .. })));
    /// ```
    pub fn add_mesh(
        &mut self,
        vertices: &[[f32; 3]],
        indices: &[[u32; 3]],
    ) -> Result<GeomId, GeometryError> {
        let (taken, first) = self.add_triangles(PlaceKind::Mesh, vertices, indices)?;
        Ok(self.add_geometry(taken, first, indices.len()))
    }

    /// Adds spheres by centre and radius, in the scene's units. Sphere i has the `prim_id` of the
    /// first plus i. Rays that start inside hit the far side. Material and cost as in
    /// [`Scene::add_mesh`].
    ///
    /// # Errors
    /// [`GeometryError::Lengths`], [`GeometryError::NotFinite`], [`GeometryError::Radius`],
    /// [`GeometryError::TooMany`] and [`GeometryError::TooManyShown`].
    ///
    /// ```
    /// # extern crate phalanx_scene as phalanx;
    /// use phalanx::{GeometryError, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let pair = scene.add_spheres(&[[0.0; 3], [3.0, 0.0, 0.0]], &[1.0, 0.5])?;
    /// assert_eq!((pair, scene.prim_count()), (0, 2));
    /// let uneven = scene.add_spheres(&[[0.0; 3]], &[]);
    /// assert_eq!(uneven, Err(GeometryError::Lengths { centers: 1, radii: 0 }));
    /// # Ok::<(), GeometryError>(())
    /// ```
    pub fn add_spheres(
        &mut self,
        centers: &[[f32; 3]],
        radii: &[f32],
    ) -> Result<GeomId, GeometryError> {
        if centers.len() != radii.len() {
            return Err(GeometryError::Lengths {
                centers: centers.len(),
                radii: radii.len(),
            });
        }
        check_finite(centers)?;
        let fine = |radius: &f32| *radius > 0.0 && radius.is_finite();
        if let Some(sphere) = radii.iter().position(|radius| !fine(radius)) {
            return Err(GeometryError::Radius {
                sphere,
                radius: radii[sphere],
            });
        }
        let (taken, first) = self.find_place(PlaceKind::Spheres, centers.len(), 0)?;
        if taken.is_some() && !centers.is_empty() {
            let row = self.prims[first as usize].index();
            self.spheres.replace(row, centers, radii);
        } else {
            let place = self.geometries.prim_place(first);
            let room = place.map_or(0, |place| place.prims as usize);
            let spare = std::iter::repeat_n((&[0.0; 3], &1.0), room - centers.len());
            for (&center, &radius) in centers.iter().zip(radii).chain(spare) {
                self.add_sphere(Vec3::from(center), radius, 0);
            }
        }
        Ok(self.add_geometry(taken, first, centers.len()))
    }

    /// Adds a mesh that is visible only through its instances, and returns its number for
    /// [`Scene::add_instance`]. That number is not a [`GeomId`]. The mesh is stored once, however
    /// often it is placed. Slices as in [`Scene::add_mesh`], with at least one triangle.
    ///
    /// # Errors
    /// As [`Scene::add_mesh`], and [`GeometryError::EmptyPrototype`].
    ///
    /// ```
    /// # mod phalanx { pub use {glam, phalanx_scene::*}; }
    /// use phalanx::Scene;
    /// use phalanx::glam::{DAffine3, dvec3};
    ///
    /// let mut scene = Scene::new();
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let leaf = scene.add_prototype(&corners, &[[0, 1, 2]])?;
    /// assert_eq!((scene.prim_count(), scene.visible_count()), (1, 0));
    /// for x in 0..10 {
    ///     let to_world = DAffine3::from_translation(dvec3(f64::from(x), 0.0, 0.0));
    ///     scene.add_instance(leaf, to_world)?;
    /// }
    /// assert_eq!((scene.prim_count(), scene.visible_count()), (1, 10));
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn add_prototype(
        &mut self,
        vertices: &[[f32; 3]],
        indices: &[[u32; 3]],
    ) -> Result<u32, GeometryError> {
        if indices.is_empty() {
            return Err(GeometryError::EmptyPrototype);
        }
        let (taken, first) = self.add_triangles(PlaceKind::Prototype, vertices, indices)?;
        let prototype = taken.unwrap_or_else(|| {
            self.meshes.first.push(first);
            self.meshes.count.push(0);
            self.meshes.len() as u32 - 1
        });
        self.meshes.count[prototype as usize] = indices.len() as u32;
        self.edits.prototypes.mark_added(prototype);
        Ok(prototype)
    }

    /// Places a mesh from [`Scene::add_prototype`] or [`Scene::begin_mesh`]. The instance is a
    /// separate geometry. Its triangles have numbers beyond those of all stored primitives.
    /// `to_world` maps the mesh's coordinates to the scene's: any invertible affine map.
    ///
    /// # Errors
    /// [`GeometryError::NoPrototype`], [`GeometryError::NotInvertible`] and
    /// [`GeometryError::TooManyShown`].
    ///
    /// ```
    /// # mod phalanx { pub use {glam, phalanx_scene::*}; }
    /// use phalanx::glam::{DAffine3, DVec3, dvec3};
    /// use phalanx::{GeometryError, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = scene.add_prototype(&corners, &[[0, 1, 2]])?;
    /// let large = DAffine3::from_scale(DVec3::splat(3.0));
    /// assert_eq!(scene.add_instance(mesh, large)?, 0);
    /// assert_eq!((scene.prim_count(), scene.visible_count()), (1, 1));
    /// let flat = DAffine3::from_scale(dvec3(1.0, 0.0, 1.0));
    /// assert_eq!(scene.add_instance(mesh, flat), Err(GeometryError::NotInvertible));
    /// assert_eq!(scene.add_instance(7, large), Err(GeometryError::NoPrototype(7)));
    /// # Ok::<(), GeometryError>(())
    /// ```
    pub fn add_instance(
        &mut self,
        mesh: u32,
        to_world: glam::DAffine3,
    ) -> Result<GeomId, GeometryError> {
        let count = self.meshes.count.get(mesh as usize).copied();
        let count = count.filter(|&count| count > 0);
        let count = count.ok_or(GeometryError::NoPrototype(mesh))?;
        let maps = Instances::maps(to_world).ok_or(GeometryError::NotInvertible)?;
        let taken = self.take_place(PlaceKind::Instance, count, 0);
        let id = if let Some(id) = taken {
            let k = self.geometries.first[id as usize];
            self.instances.set_maps(k as usize, maps);
            self.instances.mesh[k as usize] = mesh;
            self.geometries
                .replace(id, GeometryRow::There(Geometry::Instance(k)));
            id
        } else {
            self.number(count.into())?;
            let first = self.instanced_count() as u32;
            self.instances.push(mesh, first, maps);
            let number = self.instances.len() as u32 - 1;
            self.geometries.push(Geometry::Instance(number))
        };
        self.edits.geometries.mark_added(id);
        Ok(id)
    }

    /// Lists the geometries by their first `prim_id`, in ascending order. Primitives between two
    /// geometries belong to none ([`NO_GEOM`]), and the last row marks the end. Numbers change
    /// while primitives are added: those of instances follow all stored ones.
    ///
    /// ```
    /// # extern crate phalanx_scene as phalanx;
    /// use phalanx::{NO_GEOM, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let pair = scene.add_spheres(&[[0.0; 3], [3.0, 0.0, 0.0]], &[1.0, 0.5])?;
    /// let one = scene.add_spheres(&[[6.0, 0.0, 0.0]], &[1.0])?;
    /// assert_eq!(scene.geometry_starts(), [(0, pair), (2, one), (3, NO_GEOM)]);
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn geometry_starts(&self) -> Vec<(u32, GeomId)> {
        let mut starts: Vec<(u32, GeomId)> = Vec::new();
        let mut end = 0;
        let mut push = |first: u32, count: u32, id: GeomId| {
            if count > 0 {
                if first > end {
                    starts.push((end, NO_GEOM));
                }
                starts.push((first, id));
                end = first + count;
            }
        };
        for (id, geometry) in self.geometries.iter() {
            if let Geometry::Prims { first, count } = geometry {
                push(first, count, id);
            }
        }
        for (id, geometry) in self.geometries.iter() {
            if let Geometry::Instance(k) = geometry {
                let mesh = self.instances.mesh[k as usize] as usize;
                push(
                    self.instance_first_id(k as usize),
                    self.meshes.count[mesh],
                    id,
                );
            }
        }
        starts.push((end, NO_GEOM));
        starts
    }

    /// Adds triangles of material 0. Returns the number whose place they took, if one was free, and
    /// the first primitive.
    fn add_triangles(
        &mut self,
        kind: PlaceKind,
        vertices: &[[f32; 3]],
        indices: &[[u32; 3]],
    ) -> Result<(Option<u32>, u32), GeometryError> {
        check_finite(vertices)?;
        check_indices(indices, vertices.len())?;
        // Vertices without triangles are nobody's.
        let vertices = if indices.is_empty() { &[] } else { vertices };
        let (taken, first) = self.find_place(kind, indices.len(), vertices.len())?;
        if indices.is_empty() {
            return Ok((taken, first));
        }
        if taken.is_some() {
            let row = self.prims[first as usize].index();
            let place = self.geometries.prim_place(first);
            let first_vertex = place.map_or(0, |place| place.first_vertex);
            self.triangles.replace(row, first_vertex, vertices, indices);
            self.geometries.use_vertices(first, vertices.len() as u32);
            return Ok((taken, first));
        }
        let place = self.geometries.prim_place(first);
        let room = place.map_or([0; 2], |place| [place.prims, place.vertices]);
        let [prims, rows] = room.map(|room| room as usize);
        let mut positions = Vec3s::default();
        for (axis, column) in positions.parts_mut().into_iter().enumerate() {
            let spare = std::iter::repeat_n(vertices[0][axis], rows - vertices.len());
            column.extend(vertices.iter().map(|vertex| vertex[axis]).chain(spare));
        }
        let mut corners = indices.to_vec();
        corners.resize(prims, [0; 3]);
        self.append_mesh(Mesh {
            vertices: positions,
            corners: corners.into(),
            material: MeshMaterial::One(0),
            ..Mesh::default()
        });
        Ok((taken, first))
    }

    /// A free place that fits, and its first primitive; or none, and the number of the next
    /// primitive. Adds material 0 if there is none.
    fn find_place(
        &mut self,
        kind: PlaceKind,
        prims: usize,
        vertices: usize,
    ) -> Result<(Option<u32>, u32), GeometryError> {
        let kind = if prims == 0 { PlaceKind::Nothing } else { kind };
        let limit = Prim::MAX_INDEX as usize;
        let largest = prims.max(vertices);
        if largest > limit {
            return Err(GeometryError::TooMany(largest));
        }
        if let Some(number) = self.take_place(kind, prims as u32, vertices as u32) {
            self.add_first_material();
            let first = match kind {
                PlaceKind::Prototype => self.meshes.first[number as usize],
                PlaceKind::Nothing => 0,
                _ => self.geometries.first[number as usize],
            };
            return Ok((Some(number), first));
        }
        let first_vertex = self.triangles.vertices.len();
        // A mesh that grows, and is removed and added each time, would leave a place of each size.
        let grows = self.has_smaller_place(kind, prims as u32);
        let used = vertices as u32;
        let [prims, vertices] = [prims, vertices].map(|n| if grows { n + n / 2 } else { n });
        let all = (self.prim_count() + prims).max(first_vertex + vertices);
        if all > limit {
            return Err(GeometryError::TooMany(all));
        }
        self.number(prims as u64)?;
        self.add_first_material();
        let first = self.prim_count() as u32;
        if prims > 0 {
            let (prims, vertices) = (prims as u32, vertices as u32);
            let row = [first, prims, first_vertex as u32, vertices, used];
            self.geometries.places.push(row);
            self.edits.add_to_places(first as usize, prims as usize);
        }
        Ok((None, first))
    }

    /// Adds material 0 if there is none.
    fn add_first_material(&mut self) {
        if self.materials.is_empty() {
            self.materials.push(&Material {
                kd: Vec3::splat(0.8),
                ..Material::default()
            });
        }
    }

    /// Adds a geometry of primitives that have a place.
    fn add_geometry(&mut self, taken: Option<GeomId>, first: u32, count: usize) -> GeomId {
        let count = count as u32;
        let geometry = Geometry::Prims { first, count };
        let id = match taken {
            Some(id) => {
                self.geometries.replace(id, GeometryRow::There(geometry));
                id
            }
            None => self.geometries.push(geometry),
        };
        self.edits.geometries.mark_added(id);
        id
    }

    /// Checks that `more` primitives can be numbered, beside all that are stored or shown by
    /// instances; the last number stands for a miss.
    fn number(&self, more: u64) -> Result<(), GeometryError> {
        let all = self.prim_count() as u64 + self.instanced_count() + more;
        if all < u64::from(u32::MAX) {
            Ok(())
        } else {
            Err(GeometryError::TooManyShown(all))
        }
    }
}

pub(crate) fn check_finite(vertices: &[[f32; 3]]) -> Result<(), GeometryError> {
    let bad = |vertex: &[f32; 3]| !vertex.iter().all(|c| c.is_finite());
    match vertices.iter().position(bad) {
        Some(vertex) => Err(GeometryError::NotFinite {
            vertex,
            position: vertices[vertex],
        }),
        None => Ok(()),
    }
}

fn check_indices(indices: &[[u32; 3]], vertices: usize) -> Result<(), GeometryError> {
    let beyond = |index: &&u32| **index as usize >= vertices;
    let bad = |(triangle, corners): (usize, &[u32; 3])| {
        let index = *corners.iter().find(beyond)?;
        Some(GeometryError::IndexOutOfRange {
            triangle,
            index,
            vertices,
        })
    };
    indices.iter().enumerate().find_map(bad).map_or(Ok(()), Err)
}
