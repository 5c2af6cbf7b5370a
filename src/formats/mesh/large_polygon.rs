//! Triangulation of polygons of many corners, by a constrained Delaunay triangulation (the crate
//! spade). It takes n log n steps for outlines of any shape, whereas ear clipping is quadratic as
//! soon as corners coincide or are collinear.
//!
//! An outline encloses everything that an odd number of its edges separates from the outside. An
//! edge that crosses an earlier one is routed along the sides of the triangles that it meets, so
//! the outline always stays closed.

use spade::{
    ConstrainedDelaunayTriangulation, HasPosition, HierarchyHintGenerator, Intersection,
    LineIntersectionIterator, MIN_ALLOWED_VALUE, Point2, Triangulation,
};
use std::collections::HashMap;

/// Maximum number of triangle sides that all edges together may meet, per corner. Outlines that do
/// not cross themselves were observed to meet up to 7. Beyond this limit the outline is a tangle,
/// without proper triangles.
const MAX_STEPS: usize = 32;

/// A corner and its number.
#[derive(Clone, Copy)]
struct OutlineVertex {
    point: Point2<f64>,
    number: u32,
}

impl HasPosition for OutlineVertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.point
    }
}

type Delaunay =
    ConstrainedDelaunayTriangulation<OutlineVertex, (), (), (), HierarchyHintGenerator<f64>>;
type VertexHandle = spade::handles::FixedVertexHandle;

/// Counter-clockwise triangles of an outline, at most two fewer than its corners. A tangle has
/// none, and neither has an outline without area.
pub(super) fn triangulate(outline: &[[f64; 2]]) -> Option<Vec<[u32; 3]>> {
    let (corners, place_of) = distinct(outline);
    let mut delaunay = Delaunay::new();
    let mut vertices = vec![None; outline.len()];
    for corner in shuffled(corners)? {
        vertices[corner.number as usize] = delaunay.insert(corner).ok();
    }
    let edges = odd_edges(&place_of);
    let edges = edges.iter().map(|&[a, b]| {
        let vertex = |corner: u32| vertices[corner as usize];
        Some([vertex(a)?, vertex(b)?])
    });
    let mut edges: Vec<[VertexHandle; 2]> = edges.collect::<Option<_>>()?;
    shuffle(&mut edges);
    let mut steps = Steps(MAX_STEPS * outline.len());
    for &[from, to] in &edges {
        if !steps.is_blocked(&delaunay, from, to)? {
            delaunay.try_add_constraint(from, to);
        }
    }
    let mut outer = vec![false; delaunay.num_undirected_edges()];
    for &[from, to] in &edges {
        steps.trace(&delaunay, from, to, &mut outer)?;
    }
    let mut triangles = enclosed(&delaunay, &outer);
    // An outline that crosses itself may enclose corners, and so have more triangles than there is
    // room for.
    let most = outline.len() - 2;
    if triangles.len() > most {
        triangles.sort_by(|a, b| area(outline, b).total_cmp(&area(outline, a)));
        triangles.truncate(most);
    }
    Some(triangles)
}

/// Twice the area of a counter-clockwise triangle.
fn area(outline: &[[f64; 2]], triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|corner| outline[corner as usize]);
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The first corner at each position, and for each corner the number of that first one.
fn distinct(outline: &[[f64; 2]]) -> (Vec<OutlineVertex>, Vec<u32>) {
    let scale = [0, 1].map(|axis| unit_scale(outline.iter().map(|position| position[axis])));
    let mut first = HashMap::new();
    let mut corners = Vec::new();
    let place_of = outline.iter().enumerate().map(|(k, position)| {
        let [x, y] = [0, 1].map(|axis| match position[axis] * scale[axis] {
            // Zeros of both signs are the same position, and spade does not accept smaller numbers.
            x if x.abs() < MIN_ALLOWED_VALUE => 0.0,
            x => x,
        });
        let number = first.entry([x.to_bits(), y.to_bits()]);
        *number.or_insert_with(|| {
            let (place, number) = (Point2::new(x, y), k as u32);
            corners.push(OutlineVertex {
                point: place,
                number,
            });
            number
        })
    });
    let place_of = place_of.collect();
    (corners, place_of)
}

/// The corners in random order, so that each is inserted in log n steps, wherever it lies (Guibas,
/// Knuth and Sharir, "Randomized Incremental Construction of Delaunay and Voronoi Diagrams", 1992).
/// Three corners that are not collinear come first; `None` if all corners are collinear.
fn shuffled(mut corners: Vec<OutlineVertex>) -> Option<Vec<OutlineVertex>> {
    let first = corners.first()?.point;
    let off = |p: &OutlineVertex| (p.point.x - first.x, p.point.y - first.y);
    let far = |p: &OutlineVertex| off(p).0.abs().max(off(p).1.abs());
    let second =
        (0..corners.len()).max_by(|&a, &b| far(&corners[a]).total_cmp(&far(&corners[b])))?;
    let (x, y) = off(&corners[second]);
    let area = |p: &OutlineVertex| x * off(p).1 - y * off(p).0;
    let third = corners.iter().position(|p| area(p) != 0.0)?;
    for (place, corner) in [(1, second.min(third)), (2, second.max(third))] {
        corners.swap(place, corner);
    }
    shuffle(&mut corners[3..]);
    Some(corners)
}

/// Shuffles items into a random order, always the same. Edges need one, too (Shewchuk and Brown,
/// "Fast segment insertion and incremental construction of constrained Delaunay triangulations",
/// 2015).
fn shuffle<T>(items: &mut [T]) {
    let mut random = 1u64;
    for k in (1..items.len()).rev() {
        // Knuth's generator (MMIX); any other would do.
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        items.swap(k, ((random >> 32) % (k as u64 + 1)) as usize);
    }
}

/// The power of two that scales numbers to an extent of about 1. Outlines become as wide as high,
/// so that not all triangles are slivers, and nothing is rounded.
fn unit_scale(numbers: impl Iterator<Item = f64>) -> f64 {
    let (lo, hi) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| {
        (lo.min(x), hi.max(x))
    });
    let exponent = libm::ilogb(hi - lo);
    if hi > lo { libm::ldexp(1.0, -exponent) } else { 1.0 }
}

/// Edges that the outline uses an odd number of times: one there and one back enclose nothing. Each
/// begins at the end where fewer edges meet, because searching around a vertex takes time.
fn odd_edges(place_of: &[u32]) -> Vec<[u32; 2]> {
    let mut visits = vec![0u32; place_of.len()];
    for &place in place_of {
        visits[place as usize] += 1;
    }
    let next = place_of.iter().cycle().skip(1);
    let edges = place_of.iter().zip(next).map(|(&a, &b)| {
        let first = |place: u32| (visits[place as usize], place);
        if first(a) < first(b) { [a, b] } else { [b, a] }
    });
    let mut edges: Vec<[u32; 2]> = edges.filter(|[a, b]| a != b).collect();
    edges.sort_unstable();
    let runs = edges.chunk_by(|a, b| a == b);
    runs.filter(|run| run.len() % 2 == 1)
        .map(|run| run[0])
        .collect()
}

/// The number of triangle sides that edges may still meet.
struct Steps(usize);

impl Steps {
    fn take(&mut self) -> Option<()> {
        self.0 = self.0.checked_sub(1)?;
        Some(())
    }

    /// Returns true if an edge of the outline blocks the straight way; `None` if no steps are left.
    fn is_blocked(
        &mut self,
        delaunay: &Delaunay,
        from: VertexHandle,
        to: VertexHandle,
    ) -> Option<bool> {
        for met in LineIntersectionIterator::new_from_handles(delaunay, from, to) {
            self.take()?;
            if let Intersection::EdgeIntersection(edge) = met
                && edge.is_constraint_edge()
            {
                return Some(true);
            }
        }
        Some(false)
    }

    /// Toggles the sides of all edges on the way from one vertex to another: those on the straight
    /// way, or those next to it where it is blocked.
    fn trace(
        &mut self,
        delaunay: &Delaunay,
        from: VertexHandle,
        to: VertexHandle,
        outer: &mut [bool],
    ) -> Option<()> {
        let mut vertex_handle = from;
        for met in LineIntersectionIterator::new_from_handles(delaunay, from, to) {
            self.take()?;
            let edge = match met {
                Intersection::EdgeOverlap(edge) => edge,
                // The end on the left is that of the edge met before, or its neighbour.
                Intersection::EdgeIntersection(edge) if edge.from().fix() != vertex_handle => {
                    delaunay.get_edge_from_neighbors(vertex_handle, edge.from().fix())?
                }
                Intersection::VertexIntersection(vertex) if vertex.fix() != vertex_handle => {
                    delaunay.get_edge_from_neighbors(vertex_handle, vertex.fix())?
                }
                _ => continue,
            };
            let side = &mut outer[edge.as_undirected().fix().index()];
            *side = !*side;
            vertex_handle = edge.to().fix();
        }
        (vertex_handle == to).then_some(())
    }
}

/// The triangles that an odd number of `outer` edges separates from the outside.
fn enclosed(delaunay: &Delaunay, outer: &[bool]) -> Vec<[u32; 3]> {
    let mut inside: Vec<Option<bool>> = vec![None; delaunay.num_all_faces()];
    inside[delaunay.outer_face().fix().index()] = Some(false);
    let hull = delaunay.convex_hull();
    let from_outside = hull.map(|edge| if edge.is_outer_edge() { edge } else { edge.rev() });
    let mut waiting: Vec<_> = from_outside.collect();
    while let Some(edge) = waiting.pop() {
        let (near, far) = (edge.face().fix().index(), edge.rev().face());
        let (Some(side), None) = (inside[near], inside[far.fix().index()]) else {
            continue;
        };
        let crosses = outer[edge.as_undirected().fix().index()];
        inside[far.fix().index()] = Some(side != crosses);
        if let Some(face) = far.as_inner() {
            waiting.extend(face.adjacent_edges());
        }
    }
    let faces = delaunay.inner_faces();
    let faces = faces.filter(|face| inside[face.fix().index()] == Some(true));
    faces
        .map(|face| face.vertices().map(|vertex| vertex.data().number))
        .collect()
}
