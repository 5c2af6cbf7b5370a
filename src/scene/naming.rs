//! Names of a scene's parts: given, looked up, counted and checked.

use super::{Bounds, GeometryError, NO_NAME, NameTable, Scene, SceneError};
use crate::geometries::{GeomId, Geometry};
use std::cmp::Reverse;
use std::ops::Range;

impl Scene {
    /// Names a geometry: it is the name of its object in Cryptomatte layers. Geometries of one name
    /// are one object there.
    ///
    /// # Errors
    /// [`GeometryError::NoGeometry`].
    ///
    /// ```
    /// # mod phalanx { pub mod scene { pub use phalanx_scene::*; } pub use phalanx_scene::*; }
    /// use phalanx::scene::object_names;
    /// use phalanx::Scene;
    ///
    /// let mut scene = Scene::new();
    /// let ball = scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// scene.set_name(ball, "ball")?;
    /// assert_eq!(scene.prim_names(0), [Some("ball"), None]);
    /// assert_eq!(object_names(&scene).collect::<Vec<_>>(), ["ball"]);
    /// # Ok::<(), phalanx::GeometryError>(())
    /// ```
    pub fn set_name(&mut self, geometry: GeomId, name: &str) -> Result<(), GeometryError> {
        let known = self.geometry(geometry)?;
        let name = self.names.intern(name.as_bytes());
        match known {
            Geometry::Prims { first, count } => {
                self.names.name_run(first..first + count, name, None);
            }
            Geometry::Instance(k) => self.instances.name[k as usize] = name,
        }
        Ok(())
    }

    /// Names of the object and of the material that a `prim_id` belongs to; `None` for those that
    /// were not given, and for no primitive.
    pub fn prim_names(&self, prim_id: u32) -> [Option<&str>; 2] {
        if u64::from(prim_id) >= self.id_count() {
            return [None; 2];
        }
        let resolved = self.resolve(prim_id);
        // The number may be free, of a larger mesh that an instance showed before.
        let shows = |k: u32| {
            let mesh = self.instances.mesh[k as usize] as usize;
            self.meshes.prims(mesh).contains(&resolved.prim)
        };
        if resolved.instance.is_some_and(|k| !shows(k)) {
            return [None; 2];
        }
        let [object, material] = self.names.of_prim(resolved.prim);
        let placed = resolved.instance.map(|k| self.instances.name[k as usize]);
        [placed.unwrap_or(object), material].map(|name| self.names.get(name))
    }

    /// Bounds of what a `prim_id` is a part of: its instance, or the primitives beside it whose
    /// object has the same name; the whole scene where nothing has a name.
    pub fn object_bounds(&self, prim_id: u32) -> Bounds {
        let resolved = self.resolve(prim_id);
        if let Some(k) = resolved.instance {
            let mesh = self.mesh_bounds(self.instances.mesh[k as usize] as usize);
            return self.instances.bounds(k as usize, mesh);
        }
        let [object, _] = self.names.of_prim(resolved.prim);
        if object == NO_NAME {
            return self.bounds();
        }
        let is_part = |prim: &u32| self.names.of_prim(*prim)[0] == object;
        let before = (0..=resolved.prim).rev().take_while(is_part);
        let after = (resolved.prim..self.prim_count() as u32).take_while(is_part);
        before
            .chain(after)
            .fold(Bounds::EMPTY, |all, prim| all.union(self.prim_bounds(prim)))
    }

    /// The named objects and the named materials, each with the number of its visible primitives,
    /// the largest first.
    pub fn name_sizes(&self) -> [Vec<(&str, u64)>; 2] {
        let mut sizes = [(); 2].map(|()| vec![0u64; self.names.len()]);
        let mut add = |kind: usize, name: u32, count: u64| {
            if let Some(size) = sizes[kind].get_mut(name as usize) {
                *size += count;
            }
        };
        let runs = &self.names.runs;
        let ends = runs.iter().skip(1).map(|run| run[0]);
        let ends: Vec<u32> = ends.chain([self.prim_count() as u32]).collect();
        let mut add_runs = |prims: Range<u32>, object: Option<u32>| {
            let first = runs.partition_point(|run| run[0] <= prims.start);
            let rows = first.saturating_sub(1)..runs.partition_point(|run| run[0] < prims.end);
            for (&[start, named, material], &end) in runs[rows.clone()].iter().zip(&ends[rows]) {
                let count = end.min(prims.end).saturating_sub(start.max(prims.start));
                add(0, object.unwrap_or(named), count.into());
                add(1, material, count.into());
            }
        };
        (self.world_runs().into_iter()).for_each(|prims| add_runs(prims, None));
        for k in self.visible_instances() {
            let mesh = self.instances.mesh[k] as usize;
            add_runs(self.meshes.prims(mesh), Some(self.instances.name[k]));
        }
        sizes.map(|sizes| {
            let sizes = (0..).zip(sizes).filter(|(_, size)| *size > 0);
            let names = sizes.filter_map(|(name, size)| Some((self.names.get(name)?, size)));
            let mut all = Vec::from_iter(names);
            all.sort_by_key(|&(_, size)| Reverse(size));
            all
        })
    }

    /// Checks that names are text, and that there is one for each number.
    pub(crate) fn validate_names(&self) -> Result<(), SceneError> {
        let NameTable {
            text, ends, runs, ..
        } = &self.names;
        let is_text = std::str::from_utf8(text).is_ok_and(|text| {
            let mut ends = ends.iter().map(|&end| end as usize);
            ends.all(|end| text.is_char_boundary(end))
        });
        let is_whole = ends.last().map_or(0, |&end| end as usize) == text.len();
        let ascending = ends.is_sorted() && runs.is_sorted_by(|a, b| a[0] < b[0]);
        let of_runs = runs.iter().flat_map(|run| &run[1..]);
        let of_cameras = self.cameras.iter().map(|camera| &camera.name);
        let mut all = of_runs.chain(self.instances.name.iter()).chain(of_cameras);
        let known = all.all(|&name| name == NO_NAME || (name as usize) < ends.len());
        if is_text && is_whole && ascending && known {
            Ok(())
        } else {
            Err(SceneError::DamagedNames)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SceneCamera, View};
    use glam::DAffine3;

    fn all(scene: &Scene) -> Vec<[Option<&str>; 2]> {
        let ids = 0..scene.id_count() as u32;
        ids.map(|prim| scene.prim_names(prim)).collect()
    }

    #[test]
    fn what_is_added_and_named_later_keeps_its_own_name() {
        let mut scene = Scene::new();
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        scene.add_mesh(&corners, &[[0, 1, 2], [2, 1, 0]]).unwrap();
        let balls = scene.add_spheres(&[[0.0; 3]], &[1.0]).unwrap();
        let leaf = scene.add_prototype(&corners, &[[0, 1, 2]]).unwrap();
        let [left, right] = [(); 2].map(|()| scene.add_instance(leaf, DAffine3::IDENTITY).unwrap());
        scene.set_name(0, "sail").unwrap();
        scene.set_name(right, "leaf").unwrap();
        scene.set_name(balls, "ball").unwrap();
        let gold = scene.names.intern(b"gold");
        let none = NO_NAME;
        scene.names.name_run(3..4, none, Some(gold));
        let late = scene.add_mesh(&corners, &[[0, 1, 2]]).unwrap();
        let [sail, ball, leaf] = ["sail", "ball", "leaf"].map(Some);
        let shown = [[None, Some("gold")], [leaf, Some("gold")]];
        let mut want = vec![
            [sail, None],
            [sail, None],
            [ball, None],
            [None, Some("gold")],
            [None; 2],
        ];
        want.extend(shown);
        assert_eq!(all(&scene), want);
        assert_eq!(scene.prim_names(u32::MAX), [None; 2]);
        scene.set_name(late, "sail").unwrap();
        scene.set_name(left, "leaf").unwrap();
        scene.set_name(balls, "").unwrap();
        assert_eq!(all(&scene)[2..5], [[None; 2], want[3], [sail, None]]);
        let [objects, materials] = scene.name_sizes();
        assert_eq!(objects, [("sail", 3), ("leaf", 2)]);
        assert_eq!(materials, [("gold", 2)]);
        assert_eq!(scene.validate(), Ok(()));
        assert!(scene.set_name(9, "x").is_err());
    }

    #[test]
    fn names_that_are_none_are_refused() {
        let mut scene = Scene::new();
        let ball = scene.add_spheres(&[[0.0; 3]], &[1.0]).unwrap();
        scene.set_name(ball, "bäll").unwrap();
        scene.set_name(ball, "b").unwrap();
        let camera = SceneCamera {
            name: 1,
            view: scene.view,
            ortho_size: None,
            width: 4,
        };
        scene.cameras.push(camera);
        assert_eq!(scene.validate(), Ok(()));
        let spoilers: [fn(&mut Scene); 9] = [
            |scene| scene.names.text[0] = 0xff,
            |scene| scene.names.text.push(b'x'),
            |scene| scene.names.ends[0] = 2,
            |scene| scene.names.ends[1] = 4,
            |scene| scene.names.ends[0] = u32::MAX,
            |scene| scene.names.runs[1][0] = 0,
            |scene| scene.names.runs[0][1] = 2,
            |scene| scene.names.runs[1][2] = 2,
            |scene| scene.cameras[0].name = 2,
        ];
        for (k, spoil) in spoilers.into_iter().enumerate() {
            let mut bad = scene.clone();
            spoil(&mut bad);
            assert!(
                matches!(bad.validate(), Err(SceneError::DamagedNames)),
                "{k}"
            );
        }
    }

    #[test]
    fn the_camera_in_use_is_known_by_its_place() {
        let mut scene = Scene::new();
        let view = scene.view;
        let [first, second] = [40.0, 50.0].map(|fovy| SceneCamera {
            name: NO_NAME,
            view: View { fovy, ..view },
            ortho_size: None,
            width: fovy as u32,
        });
        scene.cameras = vec![first, second];
        assert_eq!(scene.used_camera(), None);
        scene.use_camera(second);
        scene.view.ortho = Some(3.0);
        assert_eq!((scene.used_camera(), scene.width), (Some(1), 50));
    }
}
