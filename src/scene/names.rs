//! Names from files and from callers: of objects, of materials and of cameras.
//!
//! Materials of equal bits share a row, whatever their names, so that hits are shaded together.
//! Therefore a material's name belongs to the primitives that have it, like that of their object.

use crate::SceneError;
use crate::column::Column;
use crate::geometries::{GeomId, Geometry};
use crate::geometry::GeometryError;
use crate::scene::Scene;
use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::HashMap;
use std::fmt;
use std::ops::Range;

/// Stands for no name: 2³² − 1.
pub const NO_NAME: u32 = u32::MAX;

/// Most bytes of a name; longer ones are cut. It bounds what a file can make a message, a table or
/// a picture's header hold.
const MAX_NAME_BYTES: usize = 1024;

/// Names, each stored once, and the runs of primitives that have them.
#[derive(Clone, Default)]
pub struct Names {
    /// All names, one after another, in UTF-8.
    pub text: Column<u8>,
    /// End of each name in the text.
    pub ends: Column<u32>,
    /// Runs of stored primitives, ascending: the first primitive, and the numbers of its object's
    /// and its material's names, or [`NO_NAME`]. Primitives before the first run have no names.
    pub runs: Column<[u32; 3]>,
    /// Numbers of the names that have been looked up; those of a mapped file are added at the first
    /// new one.
    known: HashMap<Box<str>, u32>,
}

impl fmt::Debug for Names {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = (0..self.len() as u32).map(|name| self.get(name));
        f.debug_list().entries(names).entries(&self.runs).finish()
    }
}

impl Names {
    /// Number of names.
    #[inline]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns true if nothing has a name.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The name of a number; `None` for [`NO_NAME`].
    pub fn get(&self, name: u32) -> Option<&str> {
        let end = *self.ends.get(name as usize)?;
        let start = match name {
            0 => 0,
            _ => self.ends[name as usize - 1],
        };
        let bytes = self.text.get(start as usize..end as usize)?;
        std::str::from_utf8(bytes).ok()
    }

    /// The number of a name, which is added if it is new. Equal names have equal numbers. Bytes
    /// that are not UTF-8 are read as Latin-1, so that different names stay different. A name of
    /// nothing but blanks is [`NO_NAME`].
    ///
    /// ```
    /// let mut names = phalanx_scene::Names::default();
    /// let lid = names.intern(b"lid");
    /// assert_eq!((lid, names.intern(b" lid\r")), (0, 0));
    /// let old = names.intern(b"Fl\xe4che");
    /// assert_eq!(names.get(old), Some("Fläche"));
    /// assert_eq!(names.intern(b" "), phalanx_scene::NO_NAME);
    /// ```
    pub fn intern(&mut self, name: &[u8]) -> u32 {
        let name = name.trim_ascii();
        let text = match std::str::from_utf8(name) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) => Cow::Owned(name.iter().map(|&byte| char::from(byte)).collect()),
        };
        let mut end = text.len().min(MAX_NAME_BYTES);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        let text = &text[..end];
        let end = self.text.len() + text.len();
        if text.is_empty() {
            return NO_NAME;
        }
        for number in self.known.len()..self.len() {
            let known = self.get(number as u32).unwrap_or_default().into();
            self.known.insert(known, number as u32);
        }
        if let Some(&number) = self.known.get(text) {
            return number;
        }
        let (Ok(end), number) = (u32::try_from(end), self.len() as u32) else {
            return NO_NAME;
        };
        self.text.extend_from(text.as_bytes());
        self.ends.push(end);
        self.known.insert(text.into(), number);
        number
    }

    /// Names the object of stored primitives, and their material if one is given. Primitives that
    /// are added later have no names.
    pub fn name_run(&mut self, prims: Range<u32>, object: u32, material: Option<u32>) {
        let nothing = object == NO_NAME && material.is_none_or(|name| name == NO_NAME);
        if prims.is_empty() || nothing && self.runs.is_empty() {
            return;
        }
        let first = self.begin_run(prims.start);
        let end = self.begin_run(prims.end);
        for [_, old_object, old_material] in &mut self.runs[first..end] {
            *old_object = object;
            *old_material = material.unwrap_or(*old_material);
        }
    }

    /// The row of the run that begins at a primitive. The run before is divided if there is none.
    fn begin_run(&mut self, prim: u32) -> usize {
        let row = self.runs.partition_point(|run| run[0] < prim);
        if self.runs.get(row).is_none_or(|run| run[0] != prim) {
            let [object, material] = prim
                .checked_sub(1)
                .map_or([NO_NAME; 2], |p| self.of_prim(p));
            self.runs.make_mut().insert(row, [prim, object, material]);
        }
        row
    }

    /// Numbers of the names of a stored primitive's object and material.
    #[inline]
    pub fn of_prim(&self, prim: u32) -> [u32; 2] {
        match self.runs.partition_point(|run| run[0] <= prim) {
            0 => [NO_NAME; 2],
            after => [1, 2].map(|k| self.runs[after - 1][k]),
        }
    }
}

impl Scene {
    /// Names a geometry: it is the name of its object in Cryptomatte layers. Geometries of one name
    /// are one object there.
    ///
    /// # Errors
    /// [`GeometryError::NoGeometry`].
    ///
    /// ```
    /// use phalanx_scene::{Scene, object_names};
    ///
    /// let mut scene = Scene::new();
    /// let ball = scene.add_spheres(&[[0.0; 3]], &[1.0])?;
    /// scene.set_name(ball, "ball")?;
    /// assert_eq!(scene.prim_names(0), [Some("ball"), None]);
    /// assert_eq!(object_names(&scene).collect::<Vec<_>>(), ["ball"]);
    /// # Ok::<(), phalanx_scene::GeometryError>(())
    /// ```
    pub fn set_name(&mut self, geometry: GeomId, name: &str) -> Result<(), GeometryError> {
        let known = self.geometries.get(geometry);
        let known = known.ok_or(GeometryError::NoGeometry {
            kind: "geometry",
            id: geometry,
        })?;
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
        let [object, material] = self.names.of_prim(resolved.prim);
        let placed = resolved.instance.map(|k| self.instances.name[k as usize]);
        [placed.unwrap_or(object), material].map(|name| self.names.get(name))
    }

    /// The named objects and the named materials, each with the number of its visible primitives,
    /// the largest first.
    pub fn name_sizes(&self) -> [Vec<(&str, u64)>; 2] {
        let mut sizes = [(); 2].map(|()| vec![0u64; self.names.len()]);
        let mut add = |kind: usize, name: u32, count: u64| {
            let size = sizes[kind].get_mut(name as usize);
            size.map(|size| *size += count);
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
        for (k, &mesh) in self.instances.mesh.iter().enumerate() {
            add_runs(
                self.meshes.prims(mesh as usize),
                Some(self.instances.name[k]),
            );
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
        let Names {
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
        match is_text && is_whole && ascending && known {
            true => Ok(()),
            false => Err(SceneError::Names),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::View;
    use crate::cameras::SceneCamera;
    use glam::DAffine3;

    fn all(scene: &Scene) -> Vec<[Option<&str>; 2]> {
        let ids = 0..scene.id_count() as u32;
        ids.map(|prim| scene.prim_names(prim)).collect()
    }

    #[test]
    fn names_are_text_of_bounded_length_stored_once() {
        let mut names = Names::default();
        let long = "\u{e9}".repeat(MAX_NAME_BYTES);
        let given: [&[u8]; 6] = [
            b"a\0\x1b[2J",
            "ü".as_bytes(),
            b"\xfc",
            b"\xff\xfe",
            long.as_bytes(),
            b"b",
        ];
        let ids = given.map(|name| names.intern(name));
        assert_eq!(ids, [0, 1, 1, 2, 3, 4]);
        assert_eq!(names.get(0), Some("a\0\u{1b}[2J"));
        assert_eq!(names.get(2), Some("\u{ff}\u{fe}"));
        assert_eq!(names.get(3), Some(&long[..MAX_NAME_BYTES]));
        assert_eq!(names.intern(format!("x{long}").as_bytes()), 5);
        assert_eq!(names.get(5).map(str::len), Some(MAX_NAME_BYTES - 1));
        assert_eq!(
            [b"" as &[u8], b" \t\r\n"].map(|name| names.intern(name)),
            [NO_NAME; 2]
        );
        assert_eq!([names.get(6), names.get(NO_NAME)], [None; 2]);
        // As after mapping a file: the numbers are found again.
        let mut mapped = Names {
            known: HashMap::new(),
            ..names.clone()
        };
        assert_eq!(
            [b"b" as &[u8], b"c", b"\xfc"].map(|name| mapped.intern(name)),
            [4, 6, 1]
        );
    }

    #[test]
    fn runs_are_divided_and_end_with_their_primitives() {
        let mut names = Names::default();
        let [a, b, m] = [b"a", b"b", b"m"].map(|name| names.intern(name));
        names.name_run(4..4, a, None);
        names.name_run(0..9, NO_NAME, None);
        assert!(names.runs.is_empty());
        names.name_run(2..6, a, Some(m));
        names.name_run(3..5, b, None);
        names.name_run(6..7, NO_NAME, Some(m));
        names.name_run(0..1, b, None);
        let none = NO_NAME;
        let want = [
            [b, none],
            [none; 2],
            [a, m],
            [b, m],
            [b, m],
            [a, m],
            [none, m],
            [none; 2],
        ];
        let found: Vec<_> = (0..8).map(|prim| names.of_prim(prim)).collect();
        assert_eq!(found, want);
        names.name_run(0..7, none, None);
        assert_eq!(names.of_prim(4), [none, m]);
        assert!(names.runs.is_sorted_by(|x, y| x[0] < y[0]));
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
            assert!(matches!(bad.validate(), Err(SceneError::Names)), "{k}");
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
