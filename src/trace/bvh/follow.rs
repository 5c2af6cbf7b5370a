//! Steps of an update, in their order: parts leave, move and come, and are joined.

use super::Bvh;
use super::build_input::BuildInput;
use super::geometry_starts::GeometryStarts;
use super::leaf_column::LeafRow;
use super::leaving::Leaving;
use super::plan::UpdatePlan;
use super::report::{UpdateMode, UpdateReport, UpdateWork};
use super::subtree::{build_subtree, relative_cost};
use super::tree_parts::{TreePart, TreeParts, TreePlace};
use super::wide::WideBvh;
use phalanx_scene::{GeomId, Geometry, Scene};
use std::mem;
use std::ops::Range;

/// Growth of the cost of a part beyond which [`UpdateMode::Auto`] builds it anew.
pub(super) const MAX_COST_GROWTH: f64 = 1.5;

/// A tree that is being changed, with its parts and its wide half taken out.
struct Follower<'a> {
    bvh: &'a mut Bvh,
    parts: &'a mut TreeParts,
    wide: Option<&'a mut WideBvh>,
    scene: &'a Scene,
    input: BuildInput<'a>,
    mode: UpdateMode,
}

impl Bvh {
    /// Carries a plan out; returns `None` if everything has to be built instead.
    pub(super) fn follow(
        &mut self,
        scene: &Scene,
        plan: UpdatePlan,
        mode: UpdateMode,
    ) -> Option<UpdateReport> {
        let mut parts = self.parts.take()?;
        let mut wide = mem::take(&mut self.wide);
        let mut follower = Follower {
            bvh: self,
            parts: &mut parts,
            wide: wide.get_mut().map(|wide| &mut **wide),
            scene,
            input: BuildInput::new(scene, Vec::new()),
            mode,
        };
        let report = follower.run(plan)?;
        self.geometries = GeometryStarts::of(scene);
        parts.edits = scene.edits();
        (self.parts, self.wide) = (Some(parts), wide);
        let outgrown = mode == UpdateMode::Auto && self.cost_growth() > MAX_COST_GROWTH;
        (!outgrown).then_some(report)
    }
}

impl Follower<'_> {
    fn run(&mut self, plan: UpdatePlan) -> Option<UpdateReport> {
        let mut report = plan.report;
        self.parts.is_whole &= plan.leaving.is_empty() && plan.dropped_prototypes.is_empty();
        self.bvh.remove_top(self.parts);
        if let Some(wide) = &mut self.wide {
            wide.remove_top();
        }
        self.renumber_instances();
        self.remove(&plan.leaving);
        if plan.moves_world {
            let mut world = mem::take(&mut self.parts.world);
            let has_outgrown = self.refit(&mut world);
            self.parts.world = world;
            if has_outgrown {
                return None;
            }
        }
        for id in plan.dropped_prototypes {
            let part = mem::take(&mut self.parts.prototypes[id as usize]);
            self.parts.free(part);
        }
        self.follow_prototypes(&mut report);
        self.follow_geometries(&mut report);
        self.parts.is_whole &= !report.has_built() && plan.placed.is_empty();
        for id in plan.placed {
            *self.parts.place_of(id) = TreePlace::Top;
        }
        self.bvh.add_top(self.scene, self.parts);
        if let Some(wide) = &mut self.wide {
            wide.add_top(self.bvh, self.parts);
        }
        report.work = UpdateWork::Refitted;
        Some(report)
    }

    /// Gives the world's instances the numbers that they have beside all stored primitives.
    fn renumber_instances(&mut self) {
        let prims = self.scene.prim_count();
        let more = (prims as u32).wrapping_sub(self.parts.prims as u32);
        self.parts.prims = prims;
        if more != 0 {
            for row in self.bvh.slots.instances.iter_mut() {
                row.id_offset = row.id_offset.wrapping_add(more);
            }
        }
    }

    /// Removes geometries from where they are.
    fn remove(&mut self, geometries: &[(GeomId, bool)]) {
        let mut leaving = Leaving::default();
        let mut count = 0;
        for &(id, has_moved) in geometries {
            match mem::take(self.parts.place_of(id)) {
                TreePlace::Nowhere | TreePlace::Top => {}
                TreePlace::Own(part) => self.drop_own(*part),
                TreePlace::World(place, own) => {
                    let prims = place.all_prims();
                    let bounds = match has_moved {
                        true => self.scene.geometries.former_bounds(id),
                        false => self.scene.padded_bounds(prims.clone()),
                    };
                    leaving.add_prims(prims, bounds);
                    count += own;
                }
                TreePlace::WorldInstance(row) => {
                    leaving.add_instance(self.parts.row_key(&row));
                    count += 1;
                }
            }
        }
        let rows = self.bvh.slots.instances.iter();
        leaving.find_instances(rows.map(|row| (row.key(), row.padded_box())));
        if !leaving.is_empty() {
            let erased = self.bvh.erase(&mut self.parts.world, &leaving);
            if erased < count {
                // A copy of the scene has moved them elsewhere.
                leaving.look_everywhere();
                self.bvh.erase(&mut self.parts.world, &leaving);
            }
            if let Some(wide) = &mut self.wide {
                wide.erase(&leaving, &self.bvh.slots);
            }
        }
    }

    fn drop_own(&mut self, part: TreePart) {
        if let Some(wide) = &mut self.wide {
            wide.drop_part(part.nodes.start as u32);
        }
        self.parts.free(part);
    }

    /// Refits the world's tree, or a geometry's; returns true if it should be built anew.
    fn refit(&mut self, part: &mut TreePart) -> bool {
        let has_outgrown = self.refit_binary(part);
        if let Some(wide) = &mut self.wide {
            let (root, leaves) = (part.nodes.start as u32, &self.bvh.slots.triangles);
            wide.refit(root, leaves, part.triangles());
        }
        has_outgrown
    }

    fn refit_binary(&mut self, part: &mut TreePart) -> bool {
        part.weighted_cost = self.bvh.refit(&self.input, part);
        let cost = relative_cost(part.weighted_cost, self.bvh.bounds_of(&part.nodes));
        self.mode == UpdateMode::Auto && cost > MAX_COST_GROWTH * part.built_cost
    }

    /// Builds the tree over primitives, among the others.
    fn build(&mut self, prims: Range<u32>) -> TreePart {
        let quality = self.parts.settings.quality;
        let built = build_subtree(&self.input, self.input.objects(&[prims]), quality);
        let rows = (&mut self.bvh.nodes, &mut self.bvh.slots);
        self.parts.place(rows, built.unwrap_or_default())
    }

    fn follow_prototypes(&mut self, report: &mut UpdateReport) {
        let meshes = self.scene.meshes.len();
        if self.parts.prototypes.len() < meshes {
            self.parts.prototypes.resize_with(meshes, TreePart::default);
        }
        let refitted = mem::take(&mut report.refitted_prototypes);
        for id in refitted {
            let mut part = mem::take(&mut self.parts.prototypes[id as usize]);
            let has_outgrown = self.refit_binary(&mut part);
            self.parts.prototypes[id as usize] = part;
            let list = match has_outgrown {
                true => &mut report.built_prototypes,
                false => &mut report.refitted_prototypes,
            };
            list.push(id);
        }
        report.built_prototypes.sort_unstable();
        for &id in &report.built_prototypes {
            let old = mem::take(&mut self.parts.prototypes[id as usize]);
            self.parts.free(old);
            let part = self.build(self.scene.meshes.prims(id as usize));
            self.parts.prototypes[id as usize] = part;
        }
    }

    fn follow_geometries(&mut self, report: &mut UpdateReport) {
        let refitted = mem::take(&mut report.refitted);
        for id in refitted {
            let mut has_outgrown = false;
            match mem::take(self.parts.place_of(id)) {
                TreePlace::Own(mut part) => {
                    has_outgrown = self.refit(&mut part);
                    if has_outgrown {
                        self.drop_own(*part);
                    } else {
                        *self.parts.place_of(id) = TreePlace::Own(part);
                    }
                }
                elsewhere => *self.parts.place_of(id) = elsewhere,
            }
            if has_outgrown { report.built.push(id) } else { report.refitted.push(id) }
        }
        report.built.sort_unstable();
        for &id in &report.built {
            if let Some(Geometry::Prims { first, count }) = self.scene.geometries.visible(id) {
                let part = self.build(first..first + count);
                if let Some(wide) = &mut self.wide {
                    wide.add_part(self.bvh, part.nodes.start as u32);
                }
                *self.parts.place_of(id) = TreePlace::Own(part.into());
            }
        }
    }
}
