//! Points of eight hits on primitives of one kind: position, normals, and the offset at which
//! secondary rays leave.

use glam::Vec3;
use phalanx_scene::{
    ConeProfile, DOUBLE_ROUNDING, MAX_OFFSET_PER_DISTANCE, OFFSET_PER_COORDINATE, OFFSET_PER_EDGE,
    PAD, PLANE_ROUNDING, PrimKind, Scene, Vec3s,
};
use phalanx_trace::packet::{HitPacket, RayPacket};
use phalanx_trace::simd::{F32x8, F64x8, LANES, LaneMask, Lanes, Mask8, Vec3Lanes, Vec3x8};

/// Point, outward normals and offset, before they are turned.
pub(super) struct SurfacePoint {
    pub(super) point: Vec3x8,
    pub(super) ng: Vec3x8,
    pub(super) ns: Vec3x8,
    /// Mean of a triangle's vertex normals, of unit length: its side is the outside. `ng` if there
    /// are none.
    pub(super) outward: Vec3x8,
    pub(super) offset: F32x8,
}

impl SurfacePoint {
    /// Points of surfaces with one normal.
    fn smooth(point: Vec3x8, n: Vec3x8, offset: F32x8) -> SurfacePoint {
        SurfacePoint {
            point,
            ng: n,
            ns: n,
            outward: n,
            offset,
        }
    }
}

/// Evaluates hits in the space where the primitives are stored. `back` is the unit vector against
/// the rays there; it is the normal of surfaces without one. Within an instance, a ray's own
/// direction is not a unit vector.
pub(super) fn surface_point(
    scene: &Scene,
    kind: PrimKind,
    rows: &[usize; LANES],
    rays: &RayPacket,
    back: Vec3x8,
    hits: &HitPacket,
) -> SurfacePoint {
    match kind {
        PrimKind::Sphere => sphere(scene, rows, rays, back, hits.t),
        PrimKind::Ellipsoid => ellipsoid(scene, rows, rays, back, hits.t),
        PrimKind::Triangle => triangle(scene, rows, rays, back, hits),
        PrimKind::Cone => cone(scene, rows, rays, back, hits.t),
    }
}

/// Rows of a column of vectors.
#[inline(always)]
pub(super) fn gather_column(column: &Vec3s, rows: &[usize; LANES]) -> Vec3x8 {
    Vec3x8::new(
        F32x8::from_lanes(|lane| column.x[rows[lane]]),
        F32x8::from_lanes(|lane| column.y[rows[lane]]),
        F32x8::from_lanes(|lane| column.z[rows[lane]]),
    )
}

fn columns([x, y, z]: [[f32; LANES]; 3]) -> Vec3x8 {
    Vec3x8::new(F32x8::new(x), F32x8::new(y), F32x8::new(z))
}

/// v/|v|, or `otherwise` where v has no length.
pub(super) fn unit_or(v: Vec3x8, otherwise: Vec3x8) -> Vec3x8 {
    let squared = v.dot(v);
    let unit = v.scale(F32x8::ONE / squared.sqrt());
    Vec3x8::select(squared.gt(F32x8::ZERO), unit, otherwise)
}

/// Point where each ray meets its triangle, on the triangle's plane.
fn triangle(
    scene: &Scene,
    rows: &[usize; LANES],
    rays: &RayPacket,
    back: Vec3x8,
    hits: &HitPacket,
) -> SurfacePoint {
    let t = &scene.triangles;
    let mut vertices = [[0; LANES]; 3];
    for (lane, &row) in rows.iter().enumerate() {
        let [a, b, c] = t.corners[row];
        vertices[0][lane] = a as usize;
        vertices[1][lane] = b as usize;
        vertices[2][lane] = c as usize;
    }
    let corners = vertices
        .each_ref()
        .map(|rows| gather_column(&t.vertices, rows));
    let feet = TriangleHitPoints::of(corners, rays, hits);
    let point = feet.point;
    let ng = Vec3x8::select(feet.solid, feet.normal, back);
    let [ns, outward] = if rows.iter().any(|&i| t.normal_rows(i).is_some()) {
        let alpha = (F32x8::ONE - hits.u) - hits.v;
        shading_normals(scene, rows, [alpha, hits.u, hits.v], ng)
    } else {
        [ng, ng]
    };
    let rounding = ng.abs().dot(point.abs()) * F32x8::splat(PLANE_ROUNDING)
        + feet.edges * F32x8::splat(DOUBLE_ROUNDING);
    let [least, most] = OFFSET_PER_EDGE.map(|share| feet.edges * F32x8::splat(share));
    let beyond = point.max_abs() * F32x8::splat(OFFSET_PER_COORDINATE);
    let way = feet.ray_extent * F32x8::splat(MAX_OFFSET_PER_DISTANCE);
    let offset = rounding.max(beyond.max(least).min(most).min(way));
    SurfacePoint {
        point,
        ng,
        ns,
        outward,
        offset,
    }
}

/// Points where rays meet triangles, computed in `f64` and then rounded. So a point is on its
/// triangle's plane to within its own rounding, regardless of position and size. There is no other
/// error.
struct TriangleHitPoints {
    point: Vec3x8,
    /// Geometric normal, of unit length where `solid`.
    normal: Vec3x8,
    /// Lanes whose triangle has an area.
    solid: Mask8,
    /// Largest component of two edges.
    edges: F32x8,
    /// Largest component of the ray's path to the hit.
    ray_extent: F32x8,
}

impl TriangleHitPoints {
    /// Computes the points. For a triangle that is large at its hit distance, the point is the
    /// ray's point in the plane. For others it is that of the barycentric weights, which is within
    /// the triangle: the smaller the triangle, the more accurate an `f32` weight.
    #[inline(always)]
    fn of(corners: [Vec3x8; 3], rays: &RayPacket, hits: &HitPacket) -> TriangleHitPoints {
        let [a, b, c] = corners.map(Vec3Lanes::from);
        let dir = Vec3Lanes::from(rays.dir);
        let [t, beta, gamma] = [hits.t, hits.u, hits.v].map(F64x8::from);
        // (B − A) × (C − A): counter-clockwise is the front, as in every format; the document's
        // order points the other way.
        let (e1, e2) = (b - a, c - a);
        let normal = e1.cross(e2);
        let edges = max_abs_component(e1).max(max_abs_component(e2));
        let way = t * max_abs_component(dir);
        let alpha = (F64x8::ONE - beta) - gamma;
        let weighed = (a.scale(alpha) + b.scale(beta)) + c.scale(gamma);
        let mut point = weighed.rounded();
        let large = edges.gt(F64x8::splat(MAX_LENGTH_PER_DISTANCE) * way);
        if large.any() {
            let org = Vec3Lanes::from(rays.org);
            let along = normal.dot(a - org) / normal.dot(dir);
            let alike = (along - t).abs().le(F64x8::splat(MAX_DISTANCE_ERROR) * t);
            let met = (org + dir.scale(along)).rounded();
            point = Vec3x8::select(large & alike, met, point);
        }
        let squared = normal.dot(normal);
        let normal = normal.scale(F64x8::ONE / squared.sqrt()).rounded();
        TriangleHitPoints {
            point,
            normal,
            solid: squared.gt(F64x8::splat(0.0)),
            edges: edges.rounded(),
            ray_extent: way.rounded(),
        }
    }
}

/// Largest absolute component.
#[inline(always)]
fn max_abs_component(v: Vec3Lanes<F64x8>) -> F64x8 {
    v.x.abs().max(v.y.abs()).max(v.z.abs())
}

/// Ratio of a triangle's length to the distance of its hit, above which it counts as large: there,
/// the error of the weights could be visible.
const MAX_LENGTH_PER_DISTANCE: f64 = 64.0;

/// Largest relative difference between the distance to the plane and the hit's distance; beyond it
/// the ray lies in the plane.
const MAX_DISTANCE_ERROR: f64 = 1.0 / 4096.0;

/// Interpolated vertex normals, and their means; lanes of triangles without them keep `ng`.
fn shading_normals(
    scene: &Scene,
    rows: &[usize; LANES],
    weights: [F32x8; 3],
    ng: Vec3x8,
) -> [Vec3x8; 2] {
    let t = &scene.triangles;
    let mut normals = [[Vec3::ZERO; 3]; LANES];
    for (target, &row) in normals.iter_mut().zip(rows) {
        if let Some(corners) = t.corner_normals(row) {
            *target = corners;
        }
    }
    let [a, b, c] = corner_columns(normals);
    let [alpha, beta, gamma] = weights;
    let interpolated = (a.scale(alpha) + b.scale(beta)) + c.scale(gamma);
    [unit_or(interpolated, ng), unit_or((a + b) + c, ng)]
}

/// Vectors at the corners of eight triangles, corner by corner.
pub(super) fn corner_columns(corners: [[Vec3; 3]; LANES]) -> [Vec3x8; 3] {
    let mut by_corner = [[[0.0; LANES]; 3]; 3];
    for (lane, corners) in corners.iter().enumerate() {
        for (column, vector) in by_corner.iter_mut().zip(corners) {
            column[0][lane] = vector.x;
            column[1][lane] = vector.y;
            column[2][lane] = vector.z;
        }
    }
    by_corner.map(columns)
}

/// The point is moved back onto the sphere along the normal. With u = 2⁻²⁴ it is off by 4u of the
/// radius, for the normal's length and the product, and by u|n|·|p| for its own rounding. The
/// offset's rounding is as much. The next ray's test loses 3u of the radius: in f·f − r², and in
/// r². [`PAD`] is 32u of it, so that a point where spheres pass through each other is beyond the
/// other one, too.
fn sphere(
    scene: &Scene,
    rows: &[usize; LANES],
    rays: &RayPacket,
    back: Vec3x8,
    t: F32x8,
) -> SurfacePoint {
    let center = gather_column(&scene.spheres.center, rows);
    let radius = F32x8::from_lanes(|lane| scene.spheres.radius[rows[lane]]);
    let n = unit_or((rays.org - center) + rays.dir.scale(t), back);
    let point = center + n.scale(radius);
    let rounding = n.abs().dot(point.abs()) * F32x8::splat(PLANE_ROUNDING);
    SurfacePoint::smooth(point, n, radius * F32x8::splat(PAD) + rounding)
}

/// Point and normal on the unit sphere in object space; the normal is transformed by the inverse
/// transpose. The offset covers the rounding of the next ray's transform into object space, where a
/// step along the normal is scaled by the length of the gradient Mᵀn.
fn ellipsoid(
    scene: &Scene,
    rows: &[usize; LANES],
    rays: &RayPacket,
    back: Vec3x8,
    t: F32x8,
) -> SurfacePoint {
    let e = &scene.ellipsoids;
    let [mx, my, mz, shift] = [0, 1, 2, 3].map(|k| gather_column(&e.to_object[k], rows));
    let [wx, wy, wz, center] = [0, 1, 2, 3].map(|k| gather_column(&e.to_world[k], rows));
    let to_object = |v: Vec3x8| (mx.scale(v.x) + my.scale(v.y)) + mz.scale(v.z);
    let org = to_object(rays.org) + shift;
    let dir = to_object(rays.dir);
    let n = unit_or(org + dir.scale(t), -dir.normalized());
    let point = ((wx.scale(n.x) + wy.scale(n.y)) + wz.scale(n.z)) + center;
    let gradient = Vec3x8::new(mx.dot(n), my.dot(n), mz.dot(n));
    let length = gradient.dot(gradient).sqrt();
    let ng = unit_or(gradient, back);
    let p = point.abs();
    let terms = ((mx.abs().scale(p.x) + my.abs().scale(p.y)) + mz.abs().scale(p.z)) + shift.abs();
    let inside = (terms.max_abs() + F32x8::ONE) / length;
    SurfacePoint::smooth(point, ng, (inside + point.max_abs()) * F32x8::splat(PAD))
}

/// The hit point's distance from the axis and its height are projected onto the line of the cone's
/// profile, perpendicular to that line. So the point moves no farther than necessary, regardless of
/// the slope. Its error is then, per axis, some 6 ulp of the lengths within the cone's box. The
/// next test's transform into the cone's own coordinates adds some 8 of those, times √3 for a
/// slanted normal. [`PAD`] is 32 ulp. The point's world position is rounded twice, as a plane's:
/// [`PLANE_ROUNDING`]. At the very tip there is no direction away from the axis: the normal points
/// back along the ray.
fn cone(
    scene: &Scene,
    rows: &[usize; LANES],
    rays: &RayPacket,
    back: Vec3x8,
    t: F32x8,
) -> SurfacePoint {
    let (base, apex) = (
        gather_column(&scene.cones.base, rows),
        gather_column(&scene.cones.apex, rows),
    );
    let radii = [&scene.cones.base_radius, &scene.cones.apex_radius];
    let [radius, other] = radii.map(|column| F32x8::from_lanes(|lane| column[rows[lane]]));
    let profiles = rows.map(|i| scene.cones.profile(i));
    let column = |value: fn(&ConeProfile) -> f32| F32x8::new(profiles.each_ref().map(value));
    let axis = Vec3x8::new(
        column(|p| p.axis.x),
        column(|p| p.axis.y),
        column(|p| p.axis.z),
    );
    let (cos, sin, slant) = (column(|p| p.cos), column(|p| p.sin), column(|p| p.slant));
    let f = (rays.org - base) + rays.dir.scale(t);
    let height = f.dot(axis);
    let away = f - axis.scale(height);
    let radial = unit_or(away, Vec3x8::ZERO);
    let apart = away.dot(radial);
    let along = (apart - radius) * sin + height * cos;
    let along = along.max(F32x8::ZERO).min(slant);
    let (x, z) = (radius + sin * along, cos * along);
    let slanted = radial.scale(cos) - axis.scale(sin);
    let at_tip = !away.dot(away).gt(F32x8::ZERO);
    let ng = Vec3x8::select(at_tip, back, unit_or(slanted, back));
    let size = (apex - base).max_abs() + radius.max(other);
    let point = base + (radial.scale(x) + axis.scale(z));
    let rounding = ng.abs().dot(point.abs()) * F32x8::splat(PLANE_ROUNDING);
    SurfacePoint::smooth(point, ng, size * F32x8::splat(PAD) + rounding)
}
