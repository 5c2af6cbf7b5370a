//! Every column of a scene except texels, in two lists, because a scene that is written is shared
//! and one that is mapped is not: with names and conditions, and to be mapped.

use crate::column::AnyColumn;
use crate::prims::{ColumnInfo, ColumnTable, PrimKind, RowCheck, parts_mut};
use crate::scene::Scene;
use crate::texture_maps::MapTarget;

impl Scene {
    /// The list of primitives and the columns of all kinds, in the order of scene caches.
    pub fn prim_columns(&self) -> impl Iterator<Item = ColumnInfo<'_>> {
        let known = RowCheck::Prims(self.counts());
        let rows = self.counts().iter().sum();
        let list = ColumnTable::default().of_each("primitive", rows);
        let list = list.column(["primitive list", "row"], &self.prims, known);
        let kinds = PrimKind::FILE_ORDER.into_iter();
        let kinds = kinds.flat_map(|kind| self.columns_of(kind).columns(self.materials.len()));
        list.columns.into_iter().chain(kinds)
    }

    /// The columns that follow those of primitives.
    pub fn other_columns(&self) -> Vec<ColumnInfo<'_>> {
        use RowCheck::{Any, Below, Color, Finite, Positive, Texture, UnitInterval};
        let (meshes, geometries, i) = (&self.meshes, &self.geometries, &self.instances);
        let (m, l) = (&self.materials, &self.lights);
        let (maps, textures) = (&self.maps, self.textures.len());
        let texture = Texture(textures);
        let names = &self.names;
        ColumnTable::default()
            .of_each("mesh", meshes.len())
            .column(["meshes", "size"], &meshes.first, Any)
            .column(["meshes", "size"], &meshes.count, Any)
            .of_each("geometry", geometries.len())
            .column(["geometries", "size"], &geometries.first, Any)
            .column(["geometries", "size"], &geometries.count, Any)
            .column(["geometries", "mask"], &geometries.mask, Any)
            .of_each("mesh", geometries.vertex_runs.len())
            .column(["meshes", "vertices"], &geometries.vertex_runs, Any)
            .of_each("instance", i.len())
            .column(["instances", "mesh"], &i.mesh, Below(meshes.len()))
            .column(["instances", "number"], &i.first, Any)
            .column(["instances", "name"], &i.name, Any)
            .vectors(["instance maps", "transform"], &i.to_world, Finite)
            .vectors(["instance maps", "transform"], &i.to_object, Finite)
            .of_each("byte of names", names.text.len())
            .column(["names", "text"], &names.text, Any)
            .of_each("name", names.len())
            .column(["names", "end"], &names.ends, Any)
            .of_each("run of names", names.runs.len())
            .column(["names", "first primitive"], &names.runs, Any)
            .of_each("material", m.len())
            .vectors(["materials", "ka"], [&m.ka], Finite)
            .vectors(["materials", "ke"], [&m.ke], Finite)
            .vectors(["materials", "kd"], [&m.kd], Finite)
            .vectors(["materials", "ks"], [&m.ks], Finite)
            .vectors(["materials", "highlight"], [&m.highlight], Finite)
            .vectors(["materials", "kt"], [&m.kt], Finite)
            .column(["materials", "shininess"], &m.shininess, Color)
            .column(["materials", "ior"], &m.ior, Positive)
            .column(["materials", "texture"], &m.texture, texture)
            .column(["material gloss", "gloss"], &m.gloss, Color)
            .column(["material opacity", "opacity"], &m.opacity, UnitInterval)
            .column(
                ["material opacity", "opacity texture"],
                &m.opacity_texture,
                texture,
            )
            .column(
                ["material opacity", "cutoff"],
                &m.alpha_cutoff,
                UnitInterval,
            )
            .column(["material flags", "flag"], &m.flags, Any)
            .column(["material maps", "maps"], &m.maps, Any)
            .column(["material lobes", "metallic"], &m.metallic, UnitInterval)
            .column(["material lobes", "roughness"], &m.roughness, UnitInterval)
            .of_each("texture map", maps.len())
            .column(
                ["texture maps", "target"],
                &maps.target,
                Below(MapTarget::COUNT),
            )
            .column(["texture maps", "texture"], &maps.texture, Below(textures))
            .column(["texture maps", "channel"], &maps.channel, Below(3))
            .column(["texture maps", "layer"], &maps.uv_layer, Any)
            .column(["texture maps", "scale"], &maps.scale, Finite)
            .of_each("light", l.len())
            .vectors(["lights", "place"], [&l.position], Finite)
            .vectors(["lights", "color"], [&l.color], Finite)
            .vectors(["lights", "attenuation"], [&l.attenuation], Finite)
            .vectors(["light edges", "edge"], &l.edges, Finite)
            .column(["light radii", "radius"], &l.radius, Color)
            .vectors(["light cones", "axis"], [&l.axis], Finite)
            .column(["light cones", "cone"], &l.cone.x, Finite)
            .column(["light cones", "cone"], &l.cone.y, Finite)
            .column(["light flags", "flag"], &l.flags, Any)
            .columns
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
        self.other_columns_mut().into_iter().try_for_each(map)
    }

    fn other_columns_mut(&mut self) -> Vec<&mut dyn AnyColumn> {
        let (i, m, l) = (&mut self.instances, &mut self.materials, &mut self.lights);
        let maps = &mut self.maps;
        let mut all: Vec<&mut dyn AnyColumn> = vec![
            &mut self.meshes.first,
            &mut self.meshes.count,
            &mut self.geometries.first,
            &mut self.geometries.count,
            &mut self.geometries.mask,
            &mut self.geometries.vertex_runs,
            &mut i.mesh,
            &mut i.first,
            &mut i.name,
        ];
        all.extend(parts_mut(i.to_world.iter_mut().chain(&mut i.to_object)));
        all.push(&mut self.names.text);
        all.push(&mut self.names.ends);
        all.push(&mut self.names.runs);
        all.extend(parts_mut([&mut m.ka, &mut m.ke, &mut m.kd]));
        all.extend(parts_mut([&mut m.ks, &mut m.highlight, &mut m.kt]));
        all.push(&mut m.shininess);
        all.push(&mut m.ior);
        all.push(&mut m.texture);
        all.push(&mut m.gloss);
        all.push(&mut m.opacity);
        all.push(&mut m.opacity_texture);
        all.push(&mut m.alpha_cutoff);
        all.push(&mut m.flags);
        all.push(&mut m.maps);
        all.push(&mut m.metallic);
        all.push(&mut m.roughness);
        all.push(&mut maps.target);
        all.push(&mut maps.texture);
        all.push(&mut maps.channel);
        all.push(&mut maps.uv_layer);
        all.push(&mut maps.scale);
        all.extend(parts_mut([
            &mut l.position,
            &mut l.color,
            &mut l.attenuation,
        ]));
        all.extend(parts_mut(&mut l.edges));
        all.push(&mut l.radius);
        all.extend(parts_mut([&mut l.axis]));
        all.push(&mut l.cone.x);
        all.push(&mut l.cone.y);
        all.push(&mut l.flags);
        all
    }
}
