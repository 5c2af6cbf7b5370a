//! Every column of a scene except texels, with names and conditions, and to be mapped: a scene that
//! is written is shared, and one that is mapped is not.

use crate::column::{AnyColumn, Attribute};
use crate::prims::{ColumnInfo, PrimKind, RowCheck, column_infos, column_list};
use crate::scene::Scene;
use crate::texture_maps::MapTarget;

impl Scene {
    /// The list of primitives and the columns of all kinds, in the order of scene caches.
    pub fn prim_columns(&self) -> impl Iterator<Item = ColumnInfo<'_>> {
        let known = RowCheck::Prims(self.counts());
        let rows = self.counts().iter().sum();
        let list = column_infos(
            ("primitive", rows),
            ["primitive list", "row"],
            &self.prims,
            known,
        );
        let kinds = PrimKind::FILE_ORDER.into_iter();
        let kinds = kinds.flat_map(|kind| self.columns_of(kind).columns(self.materials.len()));
        list.chain(kinds)
    }

    /// The columns that follow those of primitives.
    pub fn other_columns(&self) -> Vec<ColumnInfo<'_>> {
        let materials = self.materials.columns(self.textures.len());
        let mut all = self.shown_columns();
        all.extend(materials);
        all.extend(self.lit_columns());
        all
    }

    /// Calls `map` with the columns of [`Scene::prim_columns`] and [`Scene::other_columns`], in the
    /// same order.
    ///
    /// # Errors
    /// The first of `map`.
    pub fn map_columns<E>(
        &mut self,
        mut map: impl FnMut(&mut dyn AnyColumn) -> Result<(), E>,
    ) -> Result<(), E> {
        map(&mut self.prims)?;
        for kind in PrimKind::FILE_ORDER {
            let columns = self.columns_of_mut(kind).columns_mut();
            columns.into_iter().try_for_each(&mut map)?;
        }
        self.shown_columns_mut()
            .into_iter()
            .try_for_each(&mut map)?;
        let materials = self.materials.columns_mut();
        materials.into_iter().try_for_each(&mut map)?;
        self.lit_columns_mut().into_iter().try_for_each(map)
    }

    column_list! {
        /// Columns of meshes, instances and names.
        fn shown_columns(scene), shown_columns_mut;
        "mesh", scene.meshes.len() => {
            meshes.first: ["meshes", "size"], RowCheck::Any;
            meshes.count: ["meshes", "size"], RowCheck::Any;
        }
        "geometry", scene.geometries.len() => {
            geometries.first: ["geometries", "size"], RowCheck::Any;
            geometries.count: ["geometries", "size"], RowCheck::Any;
            geometries.mask: ["geometries", "mask"], RowCheck::Any;
        }
        "mesh", scene.geometries.places.len() => {
            geometries.places: ["meshes", "vertices"], RowCheck::Any;
        }
        "instance", scene.instances.len() => {
            instances.mesh: ["instances", "mesh"], RowCheck::Below(scene.meshes.len());
            instances.first: ["instances", "number"], RowCheck::Any;
            instances.name: ["instances", "name"], RowCheck::Any;
            instances.to_world: ["instance maps", "transform"], RowCheck::Finite;
            instances.to_object: ["instance maps", "transform"], RowCheck::Finite;
        }
        "byte of names", scene.names.text.len() => {
            names.text: ["names", "text"], RowCheck::Any;
        }
        "name", scene.names.len() => {
            names.ends: ["names", "end"], RowCheck::Any;
        }
        "run of names", scene.names.runs.len() => {
            names.runs: ["names", "first primitive"], RowCheck::Any;
        }
    }

    column_list! {
        /// Columns of texture maps and lights.
        fn lit_columns(scene), lit_columns_mut;
        "texture map", scene.maps.len() => {
            maps.target: ["texture maps", "target"], RowCheck::Below(MapTarget::COUNT);
            maps.texture: ["texture maps", "texture"], RowCheck::Below(scene.textures.len());
            maps.channel: ["texture maps", "channel"], RowCheck::Below(3);
            maps.uv_layer: ["texture maps", "layer"], RowCheck::Any;
            maps.scale: ["texture maps", "scale"], RowCheck::Finite;
        }
        "light", scene.lights.len() => {
            lights.position: ["lights", "place"], RowCheck::Finite;
            lights.color: ["lights", "color"], RowCheck::Finite;
            lights.attenuation: ["lights", "attenuation"], RowCheck::Finite;
            lights.edges: ["light edges", "edge"], RowCheck::Finite;
            lights.radius: ["light radii", "radius"], RowCheck::Color;
            lights.axis: ["light cones", "axis"], RowCheck::Finite;
            lights.cone: ["light cones", "cone"], RowCheck::Finite;
            lights.flags: ["light flags", "flag"], RowCheck::Any;
        }
    }
}
