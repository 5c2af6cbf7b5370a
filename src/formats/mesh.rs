//! Shared parts of the mesh readers: errors found chunk by chunk, vertices that are not finite, and
//! the final step.

use super::defaults::{MissingParts, finish_scene};
use super::diagnostics::{DiagnosticSink, MAX_DIAGNOSTICS, Span};
use super::faces::{Faces, NORMAL, UV, VERTEX};
use super::loaded::Loaded;
use super::mesh_defaults::{BARE, GREY, WHITE, empty_scene};
use super::options::Options;
use super::origin::{self, ReadStop};
use super::vertex_colors::MeshColors;
use super::workers;
use phalanx_scene::{
    Column, Material, MaterialTable, Mesh, MeshMaterial, Prim, Scene, Vec2s, Vec3s,
};

/// An error in a chunk of the file.
#[derive(Debug)]
pub(super) struct ParseError {
    span: Span,
    message: String,
    help: Option<&'static str>,
}

impl ParseError {
    pub(super) fn new(span: Span, message: impl Into<String>) -> ParseError {
        ParseError {
            span,
            message: message.into(),
            help: None,
        }
    }

    pub(super) fn span(&self) -> Span {
        self.span
    }

    pub(super) fn message(&self) -> &str {
        &self.message
    }

    pub(super) fn with_help(self, help: &'static str) -> ParseError {
        ParseError {
            help: Some(help),
            ..self
        }
    }
}

/// The first errors of a chunk: no more than will be reported.
#[derive(Debug, Default)]
pub(super) struct ParseErrors(Vec<ParseError>);

impl ParseErrors {
    pub(super) fn push(&mut self, error: ParseError) {
        if !self.is_full() {
            self.0.push(error);
        }
    }

    /// Returns true if there is no point in reading on.
    pub(super) fn is_full(&self) -> bool {
        self.0.len() >= MAX_DIAGNOSTICS
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Reports all of them.
    pub(super) fn emit(self, report: &mut DiagnosticSink) {
        for error in self.0 {
            match error.help {
                Some(help) => report.error_with_help(error.span, error.message, help),
                None => report.error(error.span, error.message),
            }
        }
    }
}

/// Number of occurrences of something, and the span of the first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Occurrences {
    pub(super) count: usize,
    pub(super) first: Option<Span>,
}

impl Occurrences {
    pub(super) fn add(&mut self, span: Span) {
        self.count += 1;
        self.first.get_or_insert(span);
    }

    /// Adds the occurrences of a later chunk.
    pub(super) fn merge(&mut self, later: Occurrences) {
        self.count += later.count;
        self.first = self.first.or(later.first);
    }

    /// Adds one warning for all occurrences, if there are any.
    pub(super) fn warn(&self, report: &mut DiagnosticSink, message: impl FnOnce(usize) -> String) {
        if let Some(span) = self.first {
            report.warning(span, message(self.count));
        }
    }
}

/// A row whose numbers are not finite or cannot be used, and its span in the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct NotFinite {
    pub(super) number: u32,
    pub(super) span: Span,
}

/// Largest coordinate of a vertex that is taken beside smaller ones. No unit of length explains
/// more, and what lies near 0 would vanish in single precision beside it: real files have 1e30 and
/// the largest of all numbers where nothing was measured.
const FARTHEST: f32 = 1e20;

/// Returns true if all coordinates are finite and at most [`FARTHEST`].
#[inline]
pub(super) fn is_in_reach(position: [f32; 3]) -> bool {
    position.iter().all(|c| c.abs() <= FARTHEST)
}

/// The position as it is stored: 0 if it is not finite.
pub(super) fn stored(position: [f32; 3]) -> [f32; 3] {
    match position.iter().all(|c| c.is_finite()) {
        true => position,
        false => [0.0; 3],
    }
}

/// Leaves out the faces with a vertex that is out of reach ([`is_in_reach`]), and warns of them.
/// The triangles become points, so that all rows keep their numbers. Vertices beyond [`FARTHEST`]
/// are kept if most are: then all of the scene is that large.
pub(super) fn leave_out_unreachable(
    mut lost: Vec<NotFinite>,
    vertices: &mut Vec3s,
    chunks: &mut [&mut Faces],
    report: &mut DiagnosticSink,
) {
    let is_far = |v: &NotFinite| !is_in_reach(vertices.get(v.number as usize).to_array());
    if 2 * lost.iter().filter(|v| is_far(v)).count() > vertices.len() {
        lost.retain(|v| !is_far(v));
    }
    let Some(first) = lost.first().map(|v| v.span) else {
        return;
    };
    for vertex in &lost {
        let row = vertex.number as usize;
        (vertices.x[row], vertices.y[row], vertices.z[row]) = (0.0, 0.0, 0.0);
    }
    let find = |number: &u32| lost.binary_search_by_key(number, |v| v.number);
    let mut corners = chunks
        .iter()
        .flat_map(|faces| faces.columns[VERTEX].as_flattened());
    let home = corners.find(|number| find(number).is_err()).copied();
    let mut used = vec![false; lost.len()];
    let mut is_lost = |number: u32| find(&number).map(|k| used[k] = true).is_ok();
    let triangles = chunks
        .iter_mut()
        .map(|faces| faces.leave_out(home.unwrap_or(0), &mut is_lost));
    let triangles: usize = triangles.sum();
    if home.is_none() && triangles > 0 {
        report.error(first, "no vertex of a face is finite");
    }
    let [mut missed, mut unused] = [Occurrences::default(); 2];
    for (vertex, used) in lost.iter().zip(used) {
        let kind = if used { &mut missed } else { &mut unused };
        kind.add(vertex.span);
    }
    missed.warn(report, |count| {
        let left_out = match triangles {
            1 => "1 triangle is left out".into(),
            _ => format!("{triangles} triangles are left out"),
        };
        match count {
            1 => format!("this vertex is not finite or beyond 1e20: {left_out}"),
            _ => format!(
                "{count} vertices, this one first, are not finite or beyond 1e20: {left_out}"
            ),
        }
    });
    unused.warn(report, |count| match count {
        1 => "this vertex is not finite or beyond 1e20; no face uses it".into(),
        _ => format!(
            "{count} vertices, this one first, are not finite or beyond 1e20; no face uses them"
        ),
    });
}

/// Warns of normals that cannot be used.
pub(super) fn warn_bad_normals(bad: &[NotFinite], report: &mut DiagnosticSink) {
    let Some(first) = bad.first() else {
        return;
    };
    let message = match bad.len() {
        1 => "this normal is zero or not finite: faces that use it are shaded flat".into(),
        count => format!(
            "{count} normals are zero or not finite, this one first: faces that use them are shaded flat"
        ),
    };
    report.warning(first.span, message);
}

/// Columns of the whole file, joined from its chunks.
#[derive(Debug, Default)]
pub(super) struct MergedMesh {
    pub(super) vertices: Vec3s,
    pub(super) vertex_normals: Vec3s,
    pub(super) vertex_uvs: Vec2s,
    pub(super) faces: [Vec<[u32; 3]>; 3],
    pub(super) colors: MeshColors,
    pub(super) material: MeshMaterial,
    /// Axes of `vertices` that are single-precision numbers in the file and have not been changed.
    pub(super) single: [bool; 3],
}

/// Joins columns of floats, each of which is given in chunks, on several threads.
pub(super) fn merge_floats<const N: usize>(
    threads: usize,
    columns: [Vec<Vec<f32>>; N],
) -> [Column<f32>; N] {
    let mut joined = workers::map(threads, columns.into(), workers::joined).into_iter();
    std::array::from_fn(|_| joined.next().unwrap_or_default().into())
}

/// Joins the faces of all chunks. A column that only some chunks have gets rows without numbers for
/// the others.
pub(super) fn merge_faces(threads: usize, chunks: Vec<Faces>) -> [Vec<[u32; 3]>; 3] {
    let mut columns: [Vec<Vec<[u32; 3]>>; 3] = Default::default();
    let has = [VERTEX, UV, NORMAL]
        .map(|attribute| chunks.iter().any(|p| !p.columns[attribute].is_empty()));
    for mut chunk in chunks {
        let rows = chunk.len();
        for (attribute, parts) in columns.iter_mut().enumerate().filter(|(k, _)| has[*k]) {
            let mut part = std::mem::take(&mut chunk.columns[attribute]);
            part.resize(rows, [super::faces::NONE; 3]);
            parts.push(part);
        }
    }
    let mut joined = workers::map(threads, columns.into(), workers::joined).into_iter();
    std::array::from_fn(|_| joined.next().unwrap_or_default())
}

/// The material of triangles for which the file names none.
pub(super) fn default_material(options: &Options) -> Material {
    options.material.unwrap_or(GREY)
}

/// A scene of the mesh alone, with its default material as row 0.
pub(super) fn bare_scene(options: &Options, table: &mut MaterialTable) -> Scene {
    scene_with(&default_material(options), table)
}

/// The same for a mesh of these colours. They are the surface's own, so a default material beneath
/// them is white.
pub(super) fn scene_for(
    colors: &MeshColors,
    options: &Options,
    table: &mut MaterialTable,
) -> Scene {
    match colors.rgb.is_empty() {
        true => bare_scene(options, table),
        false => scene_with(&options.material.unwrap_or(WHITE), table),
    }
}

fn scene_with(material: &Material, table: &mut MaterialTable) -> Scene {
    let mut scene = empty_scene();
    table.intern(material, &mut scene.materials);
    scene
}

/// Puts a mesh into its scene, adds what is missing in a file of nothing but triangles, and checks
/// the whole scene.
pub(super) fn finish(
    scene: Scene,
    joined: MergedMesh,
    options: &Options,
    report: DiagnosticSink,
) -> Result<Loaded, ReadStop> {
    finish_with(scene, joined, &BARE, options, report)
}

/// Puts a mesh into its scene, adds what is missing, and checks the whole scene.
pub(super) fn finish_with(
    mut scene: Scene,
    mut joined: MergedMesh,
    missing: &MissingParts,
    options: &Options,
    mut report: DiagnosticSink,
) -> Result<Loaded, ReadStop> {
    if let Some(origin) = options.origin.offset() {
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
        let colors = joined.colors.rows(&corners);
        scene.append_mesh(Mesh {
            vertices: joined.vertices,
            corners: corners.into(),
            normals: normals.into(),
            vertex_normals: joined.vertex_normals,
            uvs: uvs.into(),
            vertex_uvs: joined.vertex_uvs,
            colors: colors.into(),
            vertex_colors: joined.colors.rgb,
            vertex_opacity: joined.colors.opacity,
            material: joined.material,
        });
    }
    finish_scene(scene, missing, options, report)
}
