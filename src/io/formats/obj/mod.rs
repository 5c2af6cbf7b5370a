//! OBJ with MTL: triangles and polygons over shared vertices, texture places and normals.
//!
//! The text is cut at line ends into pieces that several threads read; numbers that count backward, and names of
//! materials that reach over from the piece before, are settled when all have been read. Faults are found in a second
//! reading, which knows how much of everything there is: files are mostly right, so the first one need not know.

mod cursor;
mod materials;
mod mtl;
mod piece;

use super::allowance::{Allowance, Shared};
use super::faces::{self, Faces, NORMAL, VERTEX};
use super::folder::Folder;
use super::mesh::{self, Joined, NotFinite, Tally};
use super::origin::{self, Origin, Stop};
use super::report::{Place, Report};
use super::workers;
use super::{Loaded, Options};
use glam::DVec3;
use phalanx_scene::{Palette, Vec2s, Vec3s};
use piece::{Limits, Piece, Skipped};
use std::ops::Range;

/// Bytes of a piece: enough to be worth a thread's while, few enough to keep all threads busy to the end.
const PIECE: usize = 1 << 18;

/// Reads an OBJ file; the material files and textures that it names are looked for beside it.
pub(super) fn read(bytes: &[u8], beside: &Folder, options: &Options) -> Result<Loaded, Stop> {
    read_in_pieces(bytes, beside, options, PIECE)
}

fn read_in_pieces(
    bytes: &[u8],
    beside: &Folder,
    options: &Options,
    piece_bytes: usize,
) -> Result<Loaded, Stop> {
    let threads = workers::thread_count(options.threads);
    let mut report = Report::new(bytes);
    if bytes.trim_ascii().is_empty() {
        report.error(Place::START, "the file is empty");
        return Err(Stop::of(report));
    }
    let moved = options.origin.moved();
    let made = beside.allowance().shared();
    let pieces = read_pieces(bytes, threads, (piece_bytes, moved), &made, &mut report);
    let cutting = faces::cutting_bytes(pieces.iter().map(|piece| &piece.faces), threads);
    let needed = made.used().saturating_add(cutting);
    if let Err(message) = beside.allowance().lend(needed, faces::purpose) {
        report.error(Place::START, message);
    }
    let mut palette = Palette::default();
    let mut scene = mesh::bare_scene(options, &mut palette);
    if !report.is_clean() {
        return Err(Stop::of(report));
    }
    tell_skipped(&pieces, &mut report);
    let (mut joined, runs, libraries) = join(pieces, threads, &mut report);
    // Before materials and textures are read in vain.
    if options.origin == Origin::Auto
        && let Some(far) = origin::of_triangles(&joined.vertices, &joined.faces[VERTEX])
    {
        return Err(Stop::Far(far));
    }
    if let Err(message) = beside.allowance().take(made.used(), faces::purpose) {
        report.error(Place::START, message);
    }
    if report.is_clean() {
        let triangles = joined.faces[VERTEX].len();
        let mut shelf = materials::Shelf::new(bytes, beside, &libraries, &mut report);
        joined.material = shelf.rows(runs, triangles, &mut scene, &mut palette, &mut report);
        scene.textures = shelf.into_textures();
    }
    mesh::finish(scene, joined, options, report)
}

/// All pieces, and in the report what is wrong with them; without faces for which there is no
/// memory.
fn read_pieces(
    bytes: &[u8],
    threads: usize,
    (size, moved): (usize, Option<DVec3>),
    made: &Shared,
    report: &mut Report,
) -> Vec<Piece> {
    let ranges = workers::cut(0..bytes.len(), size, |at| line_start(bytes, at));
    let first = ranges.iter().map(|range| (range.clone(), Limits::UNKNOWN));
    let read = |made: &Shared, (range, limits): (Range<usize>, Limits)| {
        let text = &bytes[..range.end];
        piece::read(text, range.start, limits, moved, made.share())
    };
    let pieces = workers::map(threads, first.collect(), |part| read(made, part));
    let limits = limits_of(&pieces);
    let within = |(piece, limits): (&Piece, &Limits)| {
        let ends = |k: usize| i64::from(piece.highest[k]) <= limits.total[k];
        let begins = |k: usize| limits.before[k] + piece.lowest[k] >= 0;
        piece.faults.is_empty() && (0..3).all(|k| ends(k) && begins(k))
    };
    // Nor is it read again what there is no memory for.
    if made.is_over() || pieces.iter().zip(&limits).all(within) {
        return pieces;
    }
    drop(pieces);
    // Room for these has been found.
    let found = Allowance::of(None).shared();
    let parts = ranges.into_iter().zip(limits).collect();
    let again = workers::map(threads, parts, |part| read(&found, part));
    again
        .into_iter()
        .map(|mut piece| {
            std::mem::take(&mut piece.faults).tell(report);
            piece
        })
        .collect()
}

/// Where a statement begins, at or after a place: behind a line end that no `\` hides.
fn line_start(bytes: &[u8], at: usize) -> usize {
    let mut start = at;
    while let Some(end) = memchr::memchr(b'\n', &bytes[start..]) {
        start += end + 1;
        let line = &bytes[..start - 1];
        if !line.strip_suffix(b"\r").unwrap_or(line).ends_with(b"\\") {
            return start;
        }
    }
    bytes.len()
}

/// What each piece may refer to.
fn limits_of(pieces: &[Piece]) -> Vec<Limits> {
    let mut total = [0; 3];
    let before = pieces.iter().map(|piece| {
        let before = total;
        for (sum, count) in total.iter_mut().zip(piece.counts()) {
            *sum += count as i64;
        }
        before
    });
    let before: Vec<[i64; 3]> = before.collect();
    before
        .into_iter()
        .map(|before| Limits { before, total })
        .collect()
}

fn tell_skipped(pieces: &[Piece], report: &mut Report) {
    let mut skipped = Skipped::default();
    let mut bad_uvs = Tally::default();
    for piece in pieces {
        skipped.merge(piece.skipped);
        bad_uvs.merge(piece.bad_uvs);
    }
    let nothing = pieces
        .iter()
        .all(|piece| piece.counts() == [0; 3] && piece.faces.len() == 0);
    if let (true, Some(place)) = (nothing, skipped.unknown.first) {
        report.error(
            place,
            "this is not an OBJ file: it has no vertices, and this is none of its statements",
        );
    }
    skipped.lines.warn(report, |count| match count {
        1 => "this face of two corners, line or point is skipped".into(),
        _ => format!("{count} faces of two corners, lines or points are skipped, this one first"),
    });
    skipped.free_forms.warn(report, |count| {
        format!("curves and surfaces are skipped: {count} statements, this one first")
    });
    skipped.unknown.warn(report, |count| match count {
        1 => "this statement is unknown, and skipped".into(),
        _ => format!("{count} statements are unknown, this one first, and skipped"),
    });
    bad_uvs.warn(report, |count| match count {
        1 => "this texture place is not finite: (0, 0) is used instead".into(),
        _ => {
            format!("{count} texture places are not finite, this one first: (0, 0) is used instead")
        }
    });
}

/// A run of triangles, up to where the next begins, of a material by the place of its name.
type Run = (usize, Place);

/// Joins the pieces: the columns, where materials change, and the operands of each `mtllib`.
fn join(
    mut pieces: Vec<Piece>,
    threads: usize,
    report: &mut Report,
) -> (Joined, Vec<Run>, Vec<Place>) {
    let limits = limits_of(&pieces);
    let mut not_finite = Vec::new();
    let mut bad_normals = Vec::new();
    for (piece, limits) in pieces.iter_mut().zip(&limits) {
        not_finite.extend(shifted(&piece.not_finite, limits.before[VERTEX]));
        bad_normals.extend(shifted(&piece.bad_normals, limits.before[NORMAL]));
        let before = limits.before.map(|count| count as u32);
        piece.faces.resolve(before);
    }
    let corners = pieces.iter().map(|p| &p.faces.columns[VERTEX][..]);
    mesh::tell_not_finite(&not_finite, corners, report);

    let (vertices, vertex_normals, vertex_uvs) = join_vertices(&mut pieces, threads);
    mesh::tell_bad_normals(&bad_normals, report);
    let bad: Vec<u32> = bad_normals.iter().map(|normal| normal.number).collect();
    let cut = |mut piece: Piece| {
        piece.faces.triangulate(&vertices);
        if !bad.is_empty() {
            piece.faces.without_normals(&bad);
        }
        piece
    };
    let pieces = workers::map(threads, pieces, cut);
    let mut runs = Vec::new();
    let mut libraries = Vec::new();
    let mut triangles = 0;
    let faces = pieces.into_iter().map(|piece| {
        runs.extend(
            piece
                .switches
                .iter()
                .map(|&(first, name)| (triangles + first, name)),
        );
        libraries.extend(piece.libraries);
        triangles += piece.faces.len();
        piece.faces
    });
    let faces: Vec<Faces> = faces.collect();
    let joined = Joined {
        vertices,
        vertex_normals,
        vertex_uvs,
        faces: mesh::join_faces(threads, faces),
        ..Joined::default()
    };
    (joined, runs, libraries)
}

fn shifted(rows: &[NotFinite], before: i64) -> impl Iterator<Item = NotFinite> {
    let shift = move |row: &NotFinite| NotFinite {
        number: row.number + before as u32,
        ..*row
    };
    rows.iter().map(shift)
}

fn join_vertices(pieces: &mut [Piece], threads: usize) -> (Vec3s, Vec3s, Vec2s) {
    let mut columns: [Vec<Vec<f32>>; 8] = Default::default();
    for piece in pieces {
        let parts = piece
            .vertices
            .iter_mut()
            .chain(&mut piece.normals)
            .chain(&mut piece.uvs);
        for (column, part) in columns.iter_mut().zip(parts) {
            column.push(std::mem::take(part));
        }
    }
    let [x, y, z, nx, ny, nz, u, v] = mesh::join_floats(threads, columns);
    (
        Vec3s { x, y, z },
        Vec3s {
            x: nx,
            y: ny,
            z: nz,
        },
        Vec2s { x: u, y: v },
    )
}

#[cfg(test)]
mod tests;
