//! The plan of an update: which parts of a tree leave, come and move.

use super::report::{UpdateError, UpdateMode, UpdateReport};
use super::tree_parts::{TreeParts, TreePlace};
use phalanx_scene::{GeomId, Geometry, PartChange, PrimPlace, Scene, SceneChanges};

/// The world's primitives over those of its meshes that have moved: up to this quotient, they are
/// refitted in place. Fewer get trees of their own, so that later moves cost only theirs.
const REFITTED_SHARE: usize = 4;

/// The parts that change in an update.
#[derive(Default)]
pub(super) struct UpdatePlan {
    /// Geometries and prototypes that are refitted, built and removed.
    pub(super) report: UpdateReport,
    /// Geometries that leave the place where they are, and whether they have moved in the scene.
    pub(super) leaving: Vec<(GeomId, bool)>,
    /// Instances that come to the top.
    pub(super) placed: Vec<GeomId>,
    /// True if geometries move within the world's tree.
    pub(super) moves_world: bool,
    pub(super) dropped_prototypes: Vec<u32>,
    /// Geometries that have moved within the world's tree, and the numbers of their primitives.
    moved: Vec<(GeomId, usize)>,
}

impl UpdatePlan {
    /// The plan for following a scene; `None` if everything has to be built.
    ///
    /// # Errors
    /// [`UpdateError`].
    pub(super) fn of(
        parts: Option<&TreeParts>,
        scene: &Scene,
        mode: UpdateMode,
    ) -> Result<Option<UpdatePlan>, UpdateError> {
        if mode == UpdateMode::Rebuild {
            return Ok(None);
        }
        let plan = parts.and_then(|parts| {
            let changes = scene.changes_since(&parts.edits);
            UpdatePlan::of_changes(parts, scene, &changes, mode)
        });
        match plan {
            None if mode == UpdateMode::RefitOnly => Err(UpdateError::OtherScene),
            Some(plan) if mode == UpdateMode::RefitOnly && plan.report.has_built() => {
                Err(UpdateError::NotRefittable {
                    geometries: plan.report.built,
                    prototypes: plan.report.built_prototypes,
                })
            }
            plan => Ok(plan),
        }
    }

    fn of_changes(
        parts: &TreeParts,
        scene: &Scene,
        changes: &SceneChanges,
        mode: UpdateMode,
    ) -> Option<UpdatePlan> {
        let is_another = changes.everything
            || changes.geometries.iter().any(|change| {
                let place = parts.geometries.get(change.id as usize);
                place.is_some_and(|place| is_elsewhere(scene, change.id, place))
            });
        if is_another {
            return None;
        }
        let mut plan = UpdatePlan::default();
        for change in &changes.prototypes {
            plan.add_prototype(scene, parts, change);
        }
        for change in &changes.geometries {
            plan.add_geometry(scene, parts, change);
        }
        plan.add_instances_of_changed(scene, parts);
        plan.move_in_world(parts, mode);
        plan.report.sort();
        let come = plan
            .report
            .built
            .iter()
            .map(|&id| scene.geometries.prims_of(id));
        let outweighs = come.sum::<usize>() > parts.world_prims();
        (mode == UpdateMode::RefitOnly || !outweighs).then_some(plan)
    }

    fn add_prototype(&mut self, scene: &Scene, parts: &TreeParts, change: &PartChange) {
        let row = change.id as usize;
        let is_there = scene.meshes.count.get(row).is_some_and(|&count| count > 0);
        let before = parts.prototypes.get(row);
        let was_there = before.is_some_and(|part| !part.nodes.is_empty());
        let report = &mut self.report;
        match (was_there, is_there) {
            (false, false) => {}
            (true, false) => self.dropped_prototypes.push(change.id),
            (true, true) if !change.contents => report.refitted_prototypes.push(change.id),
            (_, true) => report.built_prototypes.push(change.id),
        }
    }

    fn add_geometry(&mut self, scene: &Scene, parts: &TreeParts, change: &PartChange) {
        let &PartChange {
            id,
            contents,
            moved,
        } = change;
        let before = parts.geometries.get(id as usize);
        let before = before.unwrap_or(&TreePlace::Nowhere);
        let was_there = !matches!(before, TreePlace::Nowhere);
        let now = scene.geometries.visible(id);
        let now = now.filter(|now| !matches!(now, Geometry::Prims { count: 0, .. }));
        let stays = was_there && now.is_some();
        match (before, now) {
            // Hidden and shown again.
            _ if stays && !moved => return,
            (TreePlace::World(..), Some(Geometry::Prims { count, .. })) if !contents => {
                self.moved.push((id, count as usize));
                return;
            }
            (TreePlace::Own(_), Some(_)) if !contents => {
                self.report.refitted.push(id);
                return;
            }
            _ => {}
        }
        if was_there {
            self.leaving.push((id, moved));
        }
        match now {
            Some(Geometry::Instance(_)) => self.place(id),
            Some(_) => self.report.built.push(id),
            None => self.report.removed.extend(was_there.then_some(id)),
        }
    }

    fn place(&mut self, instance: GeomId) {
        self.placed.push(instance);
        self.report.refitted.push(instance);
    }

    /// Lets the instances of prototypes that have changed leave the world's tree.
    fn add_instances_of_changed(&mut self, scene: &Scene, parts: &TreeParts) {
        let report = &self.report;
        let changed = [&report.refitted_prototypes, &report.built_prototypes].map(Vec::clone);
        if changed.iter().all(Vec::is_empty) {
            return;
        }
        let leaving = self.leaving.len();
        for (id, place) in (0..).zip(&parts.geometries) {
            if let TreePlace::WorldInstance(row) = place {
                let shows = changed
                    .iter()
                    .any(|ids| ids.binary_search(&row.mesh).is_ok());
                // Geometries come in the order of their numbers.
                let listed = self.leaving[..leaving].binary_search_by_key(&id, |(id, _)| *id);
                if shows && listed.is_err() && scene.geometries.visible(id).is_some() {
                    self.leaving.push((id, true));
                    self.place(id);
                }
            }
        }
    }

    /// Lets geometries move within the world's tree, or leave it for trees of their own.
    fn move_in_world(&mut self, parts: &TreeParts, mode: UpdateMode) {
        let moved: usize = self.moved.iter().map(|(_, prims)| prims).sum();
        let ids = self.moved.iter().map(|(id, _)| *id);
        if mode == UpdateMode::RefitOnly || moved * REFITTED_SHARE >= parts.world_prims() {
            self.moves_world = moved > 0;
            self.report.refitted.extend(ids);
        } else {
            self.leaving.extend(ids.clone().map(|id| (id, true)));
            self.report.built.extend(ids);
        }
    }
}

/// Returns true if a geometry is in another place than the tree has it: the scenes have parted long
/// ago.
fn is_elsewhere(scene: &Scene, id: GeomId, place: &TreePlace) -> bool {
    let now = |place: &PrimPlace| {
        let first = scene.geometries.first.get(id as usize);
        first.is_some_and(|&first| {
            first == place.all_prims().start && scene.geometries.prim_place(first) == Some(*place)
        })
    };
    match place {
        TreePlace::World(place, _) => !now(place),
        _ => false,
    }
}
