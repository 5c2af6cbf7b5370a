//! Scenes that move: new vertices of meshes, new maps of instances, geometries shown and hidden.

use super::{Bounds, GeometryError, Instances, Scene};
use crate::edits::{Edits, SceneChanges};
use crate::geometries::{GeomId, Geometry};
use crate::geometry::check_finite;
use crate::prim_places::PrimPlace;

impl Scene {
    /// The stamps of the scene as it is.
    pub fn edits(&self) -> Edits {
        self.edits.with_prims(self.prim_count())
    }

    /// Compares the scene with what it was when it had these stamps.
    pub fn changes_since(&self, before: &Edits) -> SceneChanges {
        self.edits().changes_since(before)
    }

    /// Moves the vertices of a mesh that [`Scene::add_mesh`] has added: as many as it was added
    /// with, in the same order. Triangles and numbers stay. Trees follow by `Bvh::update`.
    ///
    /// # Errors
    /// [`GeometryError::NoGeometry`], [`GeometryError::NotFinite`] and
    /// [`GeometryError::VertexCount`]; nothing is changed then.
    ///
    /// ```
    /// # extern crate phalanx_scene as phalanx;
    /// use phalanx::Scene;
    ///
    /// let mut scene = Scene::new();
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let sail = scene.add_mesh(&corners, &[[0, 1, 2]])?;
    /// scene.set_vertices(sail, &corners.map(|[x, y, _]| [x, y, 2.0]))?;
    /// assert_eq!(scene.bounds().lo.z, 2.0);
    /// assert!(scene.set_vertices(sail, &corners[..2]).is_err());
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn set_vertices(
        &mut self,
        geometry: GeomId,
        vertices: &[[f32; 3]],
    ) -> Result<(), GeometryError> {
        let first = match self.geometries.get(geometry) {
            Some(Geometry::Prims { first, count }) if count > 0 => Some(first),
            _ => None,
        };
        let before = self.move_vertices(first, vertices, ("mesh", geometry))?;
        self.geometries.leave_bounds(geometry, before);
        self.edits.geometries.mark_moved(geometry);
        Ok(())
    }

    /// Moves the vertices of a prototype, as [`Scene::set_vertices`] does: all of its instances
    /// show the new ones.
    ///
    /// # Errors
    /// As [`Scene::set_vertices`].
    pub fn set_prototype_vertices(
        &mut self,
        prototype: u32,
        vertices: &[[f32; 3]],
    ) -> Result<(), GeometryError> {
        let row = prototype as usize;
        let used = self.meshes.count.get(row).is_some_and(|&count| count > 0);
        let first = used.then(|| self.meshes.first[row]);
        self.move_vertices(first, vertices, ("prototype", prototype))?;
        self.edits.prototypes.mark_moved(prototype);
        Ok(())
    }

    /// Moves vertices; returns the box of where they were.
    fn move_vertices(
        &mut self,
        first_prim: Option<u32>,
        vertices: &[[f32; 3]],
        (kind, id): (&'static str, u32),
    ) -> Result<Bounds, GeometryError> {
        let place = first_prim.and_then(|first| self.geometries.prim_place(first));
        // Spheres have none, and a damaged cache may name others than there are.
        let rows = self.triangles.vertices.len() as u64;
        let end = |place: &PrimPlace| u64::from(place.first_vertex) + u64::from(place.vertices);
        let place = place.filter(|place| place.vertices > 0 && end(place) <= rows);
        let place = place.ok_or(GeometryError::NoGeometry { kind, id })?;
        let used = self.geometries.used_vertices(place.first_prim) as usize;
        if used != vertices.len() {
            return Err(GeometryError::VertexCount {
                given: vertices.len(),
                vertices: used,
            });
        }
        check_finite(vertices)?;
        let first = place.first_vertex as usize;
        let before = self.triangles.vertices.bounds(first..first + used);
        self.triangles.set_vertices(first, vertices);
        Ok(before)
    }

    /// Moves an instance: `to_world` as for [`Scene::add_instance`]. Trees follow by `Bvh::update`.
    ///
    /// # Errors
    /// [`GeometryError::NoGeometry`] and [`GeometryError::NotInvertible`]; nothing is changed then.
    ///
    /// ```
    /// # mod phalanx { pub use {glam, phalanx_scene::*}; }
    /// use phalanx::glam::{DAffine3, dvec3};
    /// use phalanx::Scene;
    ///
    /// let mut scene = Scene::new();
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let wing = scene.add_prototype(&corners, &[[0, 1, 2]])?;
    /// let left = scene.add_instance(wing, DAffine3::IDENTITY)?;
    /// scene.set_transform(left, DAffine3::from_translation(dvec3(0.0, 0.0, 3.0)))?;
    /// assert!(scene.bounds().lo.z > 2.9);
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn set_transform(
        &mut self,
        geometry: GeomId,
        to_world: glam::DAffine3,
    ) -> Result<(), GeometryError> {
        let Some(Geometry::Instance(k)) = self.geometries.get(geometry) else {
            return Err(GeometryError::NoGeometry {
                kind: "instance",
                id: geometry,
            });
        };
        let maps = Instances::maps(to_world).ok_or(GeometryError::NotInvertible)?;
        self.instances.set_maps(k as usize, maps);
        self.edits.geometries.mark_moved(geometry);
        Ok(())
    }

    /// Sets the mask of a geometry, which has all 32 bits at first. A ray with a mask hits only
    /// geometries that have a bit in common with it. Geometries with the mask 0 are hidden from all
    /// rays and pictures, for a while or for good; they keep their numbers. Trees follow by
    /// `Bvh::update`.
    ///
    /// # Errors
    /// [`GeometryError::NoGeometry`].
    ///
    /// ```
    /// # extern crate phalanx_scene as phalanx;
    /// use phalanx::Scene;
    ///
    /// let mut scene = Scene::new();
    /// let ball = scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// scene.set_mask(ball, 0)?;
    /// assert_eq!((scene.prim_count(), scene.visible_count()), (1, 0));
    /// assert!(scene.set_mask(1, 0).is_err());
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn set_mask(&mut self, geometry: GeomId, mask: u32) -> Result<(), GeometryError> {
        self.geometry(geometry)?;
        let before = &mut self.geometries.mask[geometry as usize];
        let shown_or_hidden = (*before == 0) != (mask == 0);
        *before = mask;
        if shown_or_hidden {
            self.edits.geometries.mark_contents(geometry);
        }
        Ok(())
    }
}
