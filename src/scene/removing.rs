//! Scenes where things come and go: geometries removed, and their places taken by later ones.
//!
//! What is removed leaves its primitives, its vertices and its number behind. A later geometry of
//! its kind that fits takes them all: the smallest place is chosen, and the lowest number among
//! equal ones. So a removal changes no number of what stays. A place that is made while smaller
//! ones are free has room for half as many again, and one that is eight times too large is not
//! taken, so that a scene in which as much comes as goes has a bounded number of rows.

use super::{GeometryError, NO_NAME, Scene};
use crate::geometries::{GeomId, Geometry, GeometryRow};
use crate::prim_places::{FreePlace, PlaceKind};
use crate::prims::PrimKind;
use std::collections::BTreeSet;

/// Most rows of a place for each one that is needed.
const MOST_ROOM: u32 = 8;

impl Scene {
    /// Removes a geometry: no ray hits it any more, and every other one keeps its number and those
    /// of its primitives. Trees follow by `Bvh::update`.
    ///
    /// The number, the primitives' numbers and the memory go to a later geometry of this kind (a
    /// mesh, spheres, an instance) that fits. So a scene in which as much comes as goes does not
    /// grow. Names stay in the table of names.
    ///
    /// # Errors
    /// [`GeometryError::NoGeometry`].
    ///
    /// ```
    /// # extern crate phalanx_scene as phalanx;
    /// use phalanx::Scene;
    ///
    /// let mut scene = Scene::new();
    /// let pair = scene.add_spheres(&[[0.0; 3], [3.0, 0.0, 0.0]], &[1.0, 1.0])?;
    /// let other = scene.add_spheres(&[[9.0, 0.0, 0.0]], &[1.0])?;
    /// scene.remove(pair)?;
    /// assert_eq!(scene.geometry_starts()[1].1, other);
    /// assert!(scene.set_mask(pair, 1).is_err());
    /// assert_eq!(scene.add_spheres(&[[6.0, 0.0, 0.0]], &[1.0])?, pair);
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn remove(&mut self, geometry: GeomId) -> Result<(), GeometryError> {
        let removed = match self.geometry(geometry)? {
            Geometry::Prims { count: 0, .. } => GeometryRow::RemovedPrims(u32::MAX),
            Geometry::Prims { first, count } => {
                let prims = first..first + count;
                let before = self.padded_bounds(prims.clone());
                self.geometries.leave_bounds(geometry, before);
                self.names.name_run(prims, NO_NAME, Some(NO_NAME));
                GeometryRow::RemovedPrims(first)
            }
            Geometry::Instance(k) => {
                self.instances.name[k as usize] = NO_NAME;
                GeometryRow::RemovedInstance(k)
            }
        };
        self.geometries.replace(geometry, removed);
        self.edits.geometries.mark_contents(geometry);
        let place = self.place_of_removed(geometry, removed);
        self.free_places().extend(place);
        Ok(())
    }

    /// Removes a prototype that no instance shows, as [`Scene::remove`] does a geometry: the next
    /// prototype that fits takes its number.
    ///
    /// # Errors
    /// [`GeometryError::NoPrototype`] and [`GeometryError::Shown`].
    pub fn remove_prototype(&mut self, prototype: u32) -> Result<(), GeometryError> {
        let place = self.meshes.first.get(prototype as usize).copied();
        let place = place.and_then(|first| self.geometries.prim_place(first));
        let place = place.filter(|_| self.meshes.count[prototype as usize] > 0);
        let place = place.ok_or(GeometryError::NoPrototype(prototype))?;
        let shows = |(id, geometry): (GeomId, Geometry)| match geometry {
            Geometry::Instance(k) => (self.instances.mesh[k as usize] == prototype).then_some(id),
            Geometry::Prims { .. } => None,
        };
        if let Some(geometry) = self.geometries.iter().find_map(shows) {
            return Err(GeometryError::Shown {
                prototype,
                geometry,
            });
        }
        (self.names).name_run(place.all_prims(), NO_NAME, Some(NO_NAME));
        self.meshes.count[prototype as usize] = 0;
        self.edits.prototypes.mark_contents(prototype);
        let free = self.place_of_removed_prototype(prototype);
        self.free_places().extend(free);
        Ok(())
    }

    /// The geometry of this number.
    pub(crate) fn geometry(&self, id: GeomId) -> Result<Geometry, GeometryError> {
        let kind = "geometry";
        (self.geometries.get(id)).ok_or(GeometryError::NoGeometry { kind, id })
    }

    /// Takes the smallest free place that fits, and returns the number of what was there. One that
    /// is far too large waits for another.
    pub(crate) fn take_place(&mut self, kind: PlaceKind, prims: u32, vertices: u32) -> Option<u32> {
        let from = FreePlace {
            kind,
            prims,
            vertices,
            number: 0,
        };
        let free = self.free_places();
        let all_larger = free.range(from..).take_while(|place| place.kind == kind);
        let fits = |place: &&FreePlace| {
            let most = |count: u32| count.saturating_mul(MOST_ROOM).max(MOST_ROOM);
            let is_instance = kind == PlaceKind::Instance;
            let is_near = place.prims <= most(prims) && place.vertices <= most(vertices);
            place.vertices >= vertices && (is_instance || is_near)
        };
        let chosen = *all_larger.into_iter().find(fits)?;
        free.remove(&chosen);
        Some(chosen.number)
    }

    /// Returns true if there is a free place of this kind, but too small.
    pub(crate) fn has_smaller_place(&mut self, kind: PlaceKind, prims: u32) -> bool {
        let [first, end] = [0, prims].map(|prims| FreePlace {
            kind,
            prims,
            vertices: 0,
            number: 0,
        });
        self.free_places().range(first..end).next().is_some()
    }

    /// The free places; those of a scene from a cache are looked up once.
    fn free_places(&mut self) -> &mut BTreeSet<FreePlace> {
        if self.geometries.past.free.is_none() {
            let rows = self.geometries.rows();
            let free = rows.filter_map(|(id, row)| self.place_of_removed(id, row));
            let prototypes = (0..self.meshes.len() as u32)
                .filter_map(|prototype| self.place_of_removed_prototype(prototype));
            self.geometries.past.free = Some(free.chain(prototypes).collect());
        }
        self.geometries.past.free.get_or_insert_default()
    }

    /// The place of a removed geometry.
    fn place_of_removed(&self, id: u32, row: GeometryRow) -> Option<FreePlace> {
        let (kind, prims, vertices) = match row {
            GeometryRow::RemovedPrims(first) => match self.geometries.prim_place(first) {
                Some(place) => {
                    let kind = self.prims.get(first as usize)?.kind();
                    let spheres = kind == PrimKind::Sphere;
                    let kind = if spheres { PlaceKind::Spheres } else { PlaceKind::Mesh };
                    (kind, place.prims, place.vertices)
                }
                None => (PlaceKind::Nothing, 0, 0),
            },
            GeometryRow::RemovedInstance(k) => {
                let k = k as usize;
                let first = self.instances.first.get(k)?;
                // Nothing follows the last one's numbers.
                let end = self.instances.first.get(k + 1).unwrap_or(&u32::MAX);
                (PlaceKind::Instance, end.saturating_sub(*first), 0)
            }
            GeometryRow::There(_) => return None,
        };
        Some(FreePlace {
            kind,
            prims,
            vertices,
            number: id,
        })
    }

    /// The place of a removed prototype.
    fn place_of_removed_prototype(&self, prototype: u32) -> Option<FreePlace> {
        let first = self.meshes.first[prototype as usize];
        let place = self.geometries.prim_place(first)?;
        (self.meshes.count[prototype as usize] == 0).then_some(FreePlace {
            kind: PlaceKind::Prototype,
            prims: place.prims,
            vertices: place.vertices,
            number: prototype,
        })
    }
}
