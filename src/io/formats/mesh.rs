//! What the readers of meshes have in common: faults found piece by piece, vertices that are no numbers, and the end.

use super::complete::complete;
use super::faces::{Faces, NORMAL, TEXTURE_PLACE, VERTEX};
use super::mesh_defaults::{BARE, GREY, empty_scene};
use super::origin::{self, Stop};
use super::report::{MAX_DIAGNOSTICS, Place, Report};
use super::workers;
use super::{Loaded, Options};
use phalanx_scene::{Column, Mesh, MeshMaterial, Palette, Prim, Scene, Surface, Vec2s, Vec3s};

/// Something wrong in a piece of the file.
#[derive(Debug)]
pub(super) struct Fault {
    place: Place,
    message: String,
    help: Option<&'static str>,
}

impl Fault {
    pub(super) fn new(place: Place, message: impl Into<String>) -> Fault {
        Fault {
            place,
            message: message.into(),
            help: None,
        }
    }

    pub(super) fn with_help(self, help: &'static str) -> Fault {
        Fault {
            help: Some(help),
            ..self
        }
    }
}

/// The first faults of a piece: no more than will be told.
#[derive(Debug, Default)]
pub(super) struct Faults(Vec<Fault>);

impl Faults {
    pub(super) fn push(&mut self, fault: Fault) {
        if !self.is_full() {
            self.0.push(fault);
        }
    }

    /// Whether reading on is of no use.
    pub(super) fn is_full(&self) -> bool {
        self.0.len() >= MAX_DIAGNOSTICS
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Tells them all.
    pub(super) fn tell(self, report: &mut Report) {
        for fault in self.0 {
            match fault.help {
                Some(help) => report.error_with_help(fault.place, fault.message, help),
                None => report.error(fault.place, fault.message),
            }
        }
    }
}

impl Faults {
    /// Tells them all, as those of another file that is named at `place`.
    pub(super) fn tell_of_other(self, name: &str, text: &[u8], place: Place, report: &mut Report) {
        let mut other = Report::new(text);
        self.tell(&mut other);
        for d in other.finish().err().unwrap_or_default() {
            report.error(
                place,
                format!("{name}:{}:{}: {}", d.line, d.column, d.message),
            );
        }
    }
}

/// How often something was met, and where first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub(super) count: usize,
    pub(super) first: Option<Place>,
}

impl Tally {
    pub(super) fn add(&mut self, place: Place) {
        self.count += 1;
        self.first.get_or_insert(place);
    }

    /// Adds what a later piece met.
    pub(super) fn merge(&mut self, later: Tally) {
        self.count += later.count;
        self.first = self.first.or(later.first);
    }

    /// One warning for all, where there are any.
    pub(super) fn warn(&self, report: &mut Report, message: impl FnOnce(usize) -> String) {
        if let Some(place) = self.first {
            report.warning(place, message(self.count));
        }
    }
}

/// A row that holds NaN or an infinity, and where it stands in the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct NotFinite {
    pub(super) number: u32,
    pub(super) place: Place,
}

/// Tells of vertices that are not finite (ascending): an error where a face uses one. Their rows have been zeroed.
pub(super) fn tell_not_finite<'a>(
    vertices: &[NotFinite],
    corners: impl Iterator<Item = &'a [[u32; 3]]>,
    report: &mut Report,
) {
    if vertices.is_empty() {
        return;
    }
    let mut used = vec![false; vertices.len()];
    for &number in corners.flatten().flatten() {
        if let Ok(k) = vertices.binary_search_by_key(&number, |v| v.number) {
            used[k] = true;
        }
    }
    let mut unused = Tally::default();
    for (vertex, used) in vertices.iter().zip(used) {
        match used {
            true => report.error(
                vertex.place,
                "this vertex is not finite, and a face uses it",
            ),
            false => unused.add(vertex.place),
        }
    }
    unused.warn(report, |count| match count {
        1 => "this vertex is not finite; no face uses it".into(),
        _ => format!("{count} vertices, this one first, are not finite; no face uses them"),
    });
}

/// Tells of normals that cannot be used.
pub(super) fn tell_bad_normals(bad: &[NotFinite], report: &mut Report) {
    let Some(first) = bad.first() else {
        return;
    };
    let message = match bad.len() {
        1 => "this normal is zero or not finite: faces that use it are shaded flat".into(),
        count => format!(
            "{count} normals are zero or not finite, this one first: faces that use them are shaded flat"
        ),
    };
    report.warning(first.place, message);
}

/// Columns of the whole file, joined from its pieces.
#[derive(Debug, Default)]
pub(super) struct Joined {
    pub(super) vertices: Vec3s,
    pub(super) vertex_normals: Vec3s,
    pub(super) vertex_uvs: Vec2s,
    pub(super) faces: [Vec<[u32; 3]>; 3],
    pub(super) material: MeshMaterial,
    /// Axes of `vertices` that are the file's own single-precision numbers, and still as they stand there.
    pub(super) single: [bool; 3],
}

/// Joins columns of floats, each of which is given in pieces, on several threads.
pub(super) fn join_floats<const N: usize>(
    threads: usize,
    columns: [Vec<Vec<f32>>; N],
) -> [Column<f32>; N] {
    let mut joined = workers::map(threads, columns.into(), workers::joined).into_iter();
    std::array::from_fn(|_| joined.next().unwrap_or_default().into())
}

/// Joins the faces of all pieces. A column that only some of them have gets rows without numbers for the others.
pub(super) fn join_faces(threads: usize, pieces: Vec<Faces>) -> [Vec<[u32; 3]>; 3] {
    let mut columns: [Vec<Vec<[u32; 3]>>; 3] = Default::default();
    let has = [VERTEX, TEXTURE_PLACE, NORMAL]
        .map(|attribute| pieces.iter().any(|p| !p.columns[attribute].is_empty()));
    for mut piece in pieces {
        let rows = piece.len();
        for (attribute, parts) in columns.iter_mut().enumerate().filter(|(k, _)| has[*k]) {
            let mut part = std::mem::take(&mut piece.columns[attribute]);
            part.resize(rows, [super::faces::NONE; 3]);
            parts.push(part);
        }
    }
    let mut joined = workers::map(threads, columns.into(), workers::joined).into_iter();
    std::array::from_fn(|_| joined.next().unwrap_or_default())
}

/// The surface of triangles for which the file names none.
pub(super) fn default_surface(options: &Options) -> Surface {
    options.material.unwrap_or(GREY)
}

/// A scene of the mesh alone, with its default material as row 0.
pub(super) fn bare_scene(options: &Options, palette: &mut Palette) -> Scene {
    let mut scene = empty_scene();
    palette.row(&default_surface(options), &mut scene.materials);
    scene
}

/// Puts a mesh into its scene, adds what is missing, and checks all of it.
pub(super) fn finish(
    mut scene: Scene,
    mut joined: Joined,
    options: &Options,
    mut report: Report,
) -> Result<Loaded, Stop> {
    if let Some(origin) = options.origin.moved() {
        let (vertices, corners) = (&mut joined.vertices, &joined.faces[VERTEX]);
        origin::move_exactly(vertices, corners, joined.single, origin)?;
    }
    let [corners, uvs, normals] = joined.faces;
    let end = report.end_of_content();
    let most = Prim::MAX_INDEX as usize;
    if corners.len() > most || joined.vertices.len() > most {
        report.error(end, format!("more than {most} triangles or vertices"));
    } else if report.is_clean() {
        if corners.is_empty() {
            report.warning(end, "the file has no faces: the picture will be empty");
        }
        scene.add_mesh(Mesh {
            vertices: joined.vertices,
            corners: corners.into(),
            normals: normals.into(),
            vertex_normals: joined.vertex_normals,
            uvs: uvs.into(),
            vertex_uvs: joined.vertex_uvs,
            material: joined.material,
        });
    }
    complete(scene, &BARE, options, report)
}
