//! Trees that follow a scene.

use super::Bvh;
use super::build::run_on_threads;
use super::geometry_starts::GeometryStarts;
use super::plan::UpdatePlan;
use super::report::{UpdateError, UpdateMode, UpdateReport, UpdateWork};
use phalanx_scene::{Bounds, Scene, on_pool};
use std::borrow::Cow;
use std::ops::Range;

impl Bvh {
    /// Follows a scene that has been edited since the tree was built or last updated. Answers are
    /// those of a fresh build, bit for bit. The report says what was done.
    ///
    /// | edit | work |
    /// |---|---|
    /// | vertices of a mesh or of a prototype | its boxes are refitted |
    /// | instances added, moved, shown | the tree over all such instances is built |
    /// | meshes and spheres added, shown | each gets a tree of its own |
    /// | prototypes added | each gets its tree |
    /// | geometries removed, hidden | their primitives leave the tree |
    /// | masks but 0 | none |
    ///
    /// So the time is that of what has changed, and of joining the trees below one root. Of a mesh
    /// among many, the first move builds a tree of its own, too, if it is less than a quarter of
    /// all. A part is built anew if refits have made it cost 1.5 times as much as when it was
    /// built, by the surface area heuristic, and everything if that holds of the whole
    /// ([`Bvh::cost_growth`]), or if more comes than was there: that takes as long as the build.
    /// [`Bvh::update_with`] has other rules.
    ///
    /// The settings are those of the build. [`Bvh::wide`] follows, too, if it has been built.
    /// Columns that were changed by hand are not noticed, but for added primitives: build the tree
    /// anew. Any tree can follow any scene; the cost is that of what differs, or a build. A mesh
    /// that was hidden, moved and shown between two updates counts as added.
    ///
    /// Queries on other threads need a tree that stands still: keep two, and update one while the
    /// other is queried. A tree of many parts is worth a fresh build on another thread meanwhile:
    ///
    /// ```
    /// # mod phalanx { pub use {glam, phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::glam::{DAffine3, dvec3};
    /// use phalanx::{Bvh, Ray, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let corners = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    /// let door = scene.add_prototype(&corners, &[[0, 1, 2]])?;
    /// let door = scene.add_instance(door, DAffine3::IDENTITY)?;
    /// let mut bvh = Bvh::build(&scene);
    /// let ray = Ray::new([1.0, 1.0, -5.0], [0.0, 0.0, 1.0]);
    /// assert_eq!(bvh.intersect(&ray).map(|hit| hit.t), Some(5.0));
    ///
    /// // A build of the scene as it is now, while frames go on.
    /// let snapshot = scene.clone();
    /// let fresh = std::thread::spawn(move || Bvh::build(&snapshot));
    /// scene.set_transform(door, DAffine3::from_translation(dvec3(0.0, 0.0, 2.0)))?;
    /// assert_eq!(bvh.update(&scene).refitted, [door]);
    /// assert_eq!(bvh.intersect(&ray).map(|hit| hit.t), Some(7.0));
    ///
    /// // Once it is there, it catches up with what has been edited meanwhile.
    /// bvh = fresh.join().expect("a tree");
    /// bvh.update(&scene);
    /// assert_eq!(bvh.intersect(&ray).map(|hit| hit.t), Some(7.0));
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn update(&mut self, scene: &Scene) -> UpdateReport {
        // Only refits are ever refused.
        self.update_with(scene, UpdateMode::Auto)
            .unwrap_or_default()
    }

    /// Follows a scene as [`Bvh::update`] does, by other rules.
    ///
    /// # Errors
    /// [`UpdateError`], of [`UpdateMode::RefitOnly`] alone: an edit that cannot be refitted.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Scene, UpdateError, UpdateMode, UpdateWork};
    ///
    /// let mut scene = Scene::new();
    /// let corners = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    /// let sail = scene.add_mesh(&corners, &[[0, 1, 2]])?;
    /// let mut bvh = Bvh::build(&scene);
    /// scene.set_vertices(sail, &corners.map(|[x, y, _]| [x, y, 1.0]))?;
    /// let report = bvh.update_with(&scene, UpdateMode::RefitOnly)?;
    /// assert_eq!((report.work, report.refitted), (UpdateWork::Refitted, vec![sail]));
    ///
    /// let other = scene.add_mesh(&corners, &[[0, 1, 2]])?;
    /// let refused = bvh.update_with(&scene, UpdateMode::RefitOnly).unwrap_err();
    /// let (geometries, prototypes) = (vec![other], vec![]);
    /// assert_eq!(refused, UpdateError::NotRefittable { geometries, prototypes });
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn update_with(
        &mut self,
        scene: &Scene,
        mode: UpdateMode,
    ) -> Result<UpdateReport, UpdateError> {
        if mode != UpdateMode::Rebuild && self.is_current(scene) {
            self.geometries = GeometryStarts::of(scene);
            return Ok(UpdateReport::default());
        }
        let plan = UpdatePlan::of(self.parts.as_deref(), scene, mode)?;
        let settings = self.parts.as_ref().map(|parts| parts.settings);
        let settings = settings.unwrap_or_default();
        let (had_wide, rows) = (self.has_wide(), scene.prims.len());
        let report = plan.and_then(|plan| {
            let follow = || on_pool(|| self.follow(scene, plan, mode));
            run_on_threads(settings.threads, rows, follow)
        });
        Ok(report.unwrap_or_else(|| {
            *self = Bvh::build_with(scene, &settings);
            if had_wide {
                self.build_wide(settings.threads);
            }
            UpdateReport {
                work: UpdateWork::Rebuilt,
                ..UpdateReport::default()
            }
        }))
    }

    /// Why [`UpdateMode::RefitOnly`] would be refused, without doing anything.
    pub fn refusal(&self, scene: &Scene) -> Option<UpdateError> {
        let plan = UpdatePlan::of(self.parts.as_deref(), scene, UpdateMode::RefitOnly);
        plan.err().filter(|_| !self.is_current(scene))
    }

    /// Returns true if the tree was built or updated for the scene as it is now. Trees from a cache
    /// do not know.
    ///
    /// ```
    /// # mod phalanx { pub use {phalanx_scene::*, phalanx_trace::*, phalanx_trace::bvh::*}; }
    /// use phalanx::{Bvh, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let bvh = Bvh::build(&scene);
    /// assert!(bvh.is_current(&scene));
    /// scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// assert!(!bvh.is_current(&scene));
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn is_current(&self, scene: &Scene) -> bool {
        match &self.parts {
            Some(parts) => parts.edits == scene.edits(),
            // Only a tree without primitives costs nothing.
            None => self.sah == 0.0 && scene.visible_count() == 0,
        }
    }

    /// How many times what it would cost if it were built anew the tree costs rays, by the surface
    /// area heuristic: 1 of a fresh tree and of one from a cache. Refits let it grow, since boxes
    /// overlap that were apart, and so do parts that lie within each other. At 1.5,
    /// [`UpdateMode::Auto`] builds everything.
    pub fn cost_growth(&self) -> f64 {
        let Some(parts) = &self.parts else {
            return 1.0;
        };
        let area = |root: usize| f64::from(self.nodes[root].child_bounds().half_area());
        let own = parts
            .own()
            .map(|part| area(part.nodes.start) * part.built_cost);
        let world = area(parts.world_root() as usize) * parts.world.built_cost;
        let area = area(0);
        let instances = parts.instances.map_or(0.0, |(_, cost)| cost);
        let built = area + world + own.sum::<f64>() + instances;
        let growth = self.sah * area / built;
        // Areas beyond single precision tell nothing.
        if area > 0.0 && growth.is_finite() { growth } else { 1.0 }
    }

    /// The tree as a build makes it, for a file: this one, or another if parts have come and gone.
    pub fn as_built(&self, scene: &Scene) -> Cow<'_, Bvh> {
        match &self.parts {
            Some(parts) if !parts.is_whole => Cow::Owned(Bvh::build_with(scene, &parts.settings)),
            _ => Cow::Borrowed(self),
        }
    }

    /// The box around a tree among all; empty for no nodes.
    pub(super) fn bounds_of(&self, nodes: &Range<usize>) -> Bounds {
        match self.nodes.get(nodes.start) {
            Some(root) if !nodes.is_empty() => root.child_bounds(),
            _ => Bounds::EMPTY,
        }
    }
}
