//! The default camera, which shows everything, as large as the picture's shape permits.
//!
//! The direction is given, so a picture is bounded by four planes through the eye. With the axes
//! right, top and back of the view, and the slopes t of its sides, their normals are n = ±right +
//! t·back and ±top + t·back. A point p lies within a side if n · p ≤ n · eye. So only max n · p for
//! each of four normals matters, regardless of the number of points:
//!
//! ```text
//! eye = x right + y top + z back      x = (m₀ − m₁)/2, y = (m₂ − m₃)/2
//!                                     z = max((m₀ + m₁)/2t₀, (m₂ + m₃)/2t₂)
//! ```
//!
//! A turntable sees each point on a circle about the axis through the middle of the scene. The
//! largest n · p on it replaces that of the point.

use glam::{DVec3, Vec3};
use phalanx_scene::{
    Bounds, PrimKind, Scene, UpAxis, View, VisibleVertices, blocks_of_prims, workers,
};

/// The picture that a camera is made up for.
#[derive(Clone, Copy, Debug)]
pub(super) struct PictureShape {
    /// Width over height.
    pub(super) aspect: f64,
    pub(super) up: UpAxis,
    /// True if the camera will go around the scene.
    pub(super) turntable: bool,
}

/// Vertical field of view in degrees: a short telephoto, so that near parts are not blown up.
const FRAMING_FOVY: f32 = 32.0;
/// Direction from the middle toward the camera, as seen from the front: a little from the right, a
/// little from above.
const THREE_QUARTER: DVec3 = DVec3::new(0.45, 0.32, 1.0);
/// Room around the scene.
const MARGIN: f64 = 1.06;
/// Room around the scene as a share of its diagonal, so that a scene of no width keeps the camera
/// at a distance.
const LEAST_ROOM: f64 = 1e-3;

/// The middle of the scene, and half of its size: at least what single precision can resolve there.
/// An empty scene counts as a box of two units.
pub(super) fn middle_and_half(bounds: Bounds) -> (DVec3, DVec3) {
    if bounds.is_empty() {
        return (DVec3::ZERO, DVec3::ONE);
    }
    let (lo, hi) = (bounds.lo.as_dvec3(), bounds.hi.as_dvec3());
    // Four units in the last place.
    let units = 4.0 * f64::from(f32::EPSILON);
    let least = (lo.abs().max(hi.abs()).max_element() * units).max(1e-30);
    let half = (hi - lo) / 2.0;
    if half.max_element() < least {
        ((lo + hi) / 2.0, half.max(DVec3::splat(least)))
    } else {
        ((lo + hi) / 2.0, half)
    }
}

/// A camera in front of the scene, a little to the right and above, from which all of it is in the
/// picture. `bounds` are those of the scene.
pub(super) fn framing(
    scene: &Scene,
    visible: &VisibleVertices,
    bounds: Bounds,
    shape: PictureShape,
) -> View {
    let (middle, half) = middle_and_half(bounds);
    let [right, up, front] = shape.up.frame();
    let back = right * THREE_QUARTER.x + up * THREE_QUARTER.y + front * THREE_QUARTER.z;
    let back = back.normalize();
    let right = up.cross(back).normalize();
    let sides = FrameSides {
        axes: [right, back.cross(right), back],
        slopes: slopes(shape.aspect).map(|slope| slope / MARGIN),
        axis: shape.turntable.then_some(up),
    };
    let room = half.length() * LEAST_ROOM;
    let reach = reach(scene, visible, middle, &sides);
    let mut eye = sides.eye(reach, room);
    let placed = |eye: DVec3| {
        let center = sides.center(eye);
        View {
            eye: (middle + eye).as_vec3(),
            center: (middle + center).as_vec3(),
            up: up.as_vec3(),
            fovy: FRAMING_FOVY,
            ortho: None,
        }
    };
    // Rounding moves the eye and turns the view by next to nothing, unless the scene is small
    // compared with its coordinates.
    let mut view = placed(eye);
    let rounded = f64::from(f32::EPSILON) * (view.eye.abs().max_element() as f64);
    let frame = sides.slopes[0].min(sides.slopes[1]) * eye.dot(back);
    if rounded > 1e-2 * (1.0 - 1.0 / MARGIN) * frame {
        for _ in 0..MAX_STEPS_BACK {
            if fits(scene, visible, &view, middle, shape) {
                break;
            }
            eye += back * eye.dot(back) / 4.0;
            view = placed(eye);
        }
    }
    view
}

/// Visible height of an orthographic camera that replaces the one from [`framing`], so that all of
/// the scene is in the picture.
pub(super) fn parallel_height(
    scene: &Scene,
    visible: &VisibleVertices,
    view: &View,
    bounds: Bounds,
    shape: PictureShape,
) -> f64 {
    let (middle, half) = middle_and_half(bounds);
    // Sides of no slope: how far the scene reaches to the right, left, top and bottom.
    let Some(sides) = FrameSides::of(view, [0.0; 2], shape.turntable) else {
        return half.length();
    };
    let reach = reach(scene, visible, middle, &sides);
    let eye = view.eye.as_dvec3() - middle;
    let normals = sides.normals();
    let [right, left, top, bottom] = std::array::from_fn(|k| reach[k] - eye.dot(normals[k]));
    let wide = right.max(left) / shape.aspect;
    let room = half.length() * LEAST_ROOM;
    2.0 * MARGIN * wide.max(top.max(bottom)).max(room)
}

/// Maximum number of times that the camera steps back by a quarter of its distance: 64-fold in
/// total, beyond the sixteen units that a scene of one unit in the last place needs.
const MAX_STEPS_BACK: usize = 19;

/// Slopes of the sides of the picture to the right and at the top.
fn slopes(aspect: f64) -> [f64; 2] {
    let slope = libm::tan(f64::from(FRAMING_FOVY).to_radians() / 2.0);
    [slope * aspect, slope]
}

/// Returns true if a view shows all of the scene as it is rounded.
fn fits(
    scene: &Scene,
    visible: &VisibleVertices,
    view: &View,
    middle: DVec3,
    shape: PictureShape,
) -> bool {
    let Some(sides) = FrameSides::of(view, slopes(shape.aspect), shape.turntable) else {
        return false;
    };
    let reach = reach(scene, visible, middle, &sides);
    let eye = view.eye.as_dvec3() - middle;
    let normals = sides.normals();
    (0..4).all(|side| reach[side] <= eye.dot(normals[side]))
}

/// The planes that bound a picture, except for the position of the eye.
struct FrameSides {
    /// Axes of the view: right, top, back.
    axes: [DVec3; 3],
    /// Slopes of the sides to the right and at the top.
    slopes: [f64; 2],
    /// Axis through the middle that the camera will turn around.
    axis: Option<DVec3>,
}

impl FrameSides {
    /// The sides of a view with these slopes; `None` if it has no basis.
    fn of(view: &View, slopes: [f64; 2], turntable: bool) -> Option<FrameSides> {
        let basis = view.basis().ok()?;
        Some(FrameSides {
            axes: [basis.u, basis.v, basis.w].map(|axis| axis.as_dvec3()),
            slopes,
            axis: turntable.then_some(view.up.as_dvec3()),
        })
    }

    fn normals(&self) -> [DVec3; 4] {
        let [right, top, back] = self.axes;
        let [wide, high] = self.slopes.map(|slope| back * slope);
        [wide + right, wide - right, high + top, high - top]
    }

    /// The eye, from the middle, for a scene that reaches as far as this along each normal, with
    /// room around it.
    fn eye(&self, reach: [f64; 4], room: f64) -> DVec3 {
        let normals = self.normals();
        let [r, l, t, b] = std::array::from_fn(|k| reach[k] + room * normals[k].length());
        let [wide, high] = self.slopes;
        let depth = ((r + l) / (2.0 * wide)).max((t + b) / (2.0 * high));
        let [right, top, back] = self.axes;
        right * ((r - l) / 2.0) + top * ((t - b) / 2.0) + back * depth.max(room)
    }

    /// The point that an eye looks at: on the axis, or as far away as the middle.
    fn center(&self, eye: DVec3) -> DVec3 {
        let [_, _, back] = self.axes;
        let distance = match self.axis {
            Some(axis) => {
                let outward = back - axis * axis.dot(back);
                eye.dot(outward) / back.dot(outward)
            }
            None => eye.dot(back),
        };
        eye - back * distance
    }
}

/// The greatest n · (p − middle) of all visible points, for the normal n of each side.
fn reach(scene: &Scene, visible: &VisibleVertices, middle: DVec3, sides: &FrameSides) -> [f64; 4] {
    let nothing = || FrameReach::new(middle, sides);
    let vertices = &scene.triangles.vertices;
    let mut blocks = visible.map(|block| {
        let mut frame = nothing();
        block.for_each(|vertex| frame.add(vertices.get(vertex).as_dvec3(), 0.0));
        frame
    });
    if scene.triangles.len() < scene.prim_count() {
        let others = workers::map(visible.threads(), blocks_of_prims(scene), |block| {
            let mut frame = nothing();
            block.for_each(|prim| frame.add_prim(scene, prim));
            frame
        });
        blocks.extend(others);
    }
    let mut all = nothing();
    blocks.iter().for_each(|block| all.merge(block));
    all.add_instances(scene);
    if all.reach[0].is_finite() { all.reach } else { [0.0; 4] }
}

/// The greatest n · (p − middle) of the points added so far, for the normal n of each side.
struct FrameReach {
    middle: DVec3,
    normals: [DVec3; 4],
    lengths: [f64; 4],
    axis: Option<DVec3>,
    reach: [f64; 4],
}

impl FrameReach {
    fn new(middle: DVec3, sides: &FrameSides) -> FrameReach {
        let normals = sides.normals();
        FrameReach {
            middle,
            normals,
            lengths: normals.map(DVec3::length),
            axis: sides.axis,
            reach: [f64::NEG_INFINITY; 4],
        }
    }

    fn merge(&mut self, other: &FrameReach) {
        self.reach = std::array::from_fn(|k| self.reach[k].max(other.reach[k]));
    }

    /// Adds a ball; a point is one without radius.
    #[inline]
    fn add(&mut self, center: DVec3, radius: f64) {
        let p = center - self.middle;
        let along = self.axis.map(|axis| {
            let height = axis.dot(p);
            (axis, height, (p - axis * height).length())
        });
        for (k, normal) in self.normals.into_iter().enumerate() {
            let far = match along {
                None => normal.dot(p),
                Some((axis, height, circle)) => {
                    let up = axis.dot(normal);
                    height * up + circle * (normal - axis * up).length()
                }
            };
            self.reach[k] = self.reach[k].max(far + radius * self.lengths[k]);
        }
    }

    fn add_prim(&mut self, scene: &Scene, prim: u32) {
        let prim = scene.prims[prim as usize];
        // Triangles are added by their vertices.
        if prim.kind() != PrimKind::Triangle {
            let mut add = |center: Vec3, radius: f32| self.add(center.as_dvec3(), radius.into());
            let columns = scene.columns_of(prim.kind());
            columns.enclosing_spheres(prim.index(), &mut add);
        }
    }

    /// Adds the boxes of visible instances, as they lie in the world.
    fn add_instances(&mut self, scene: &Scene) {
        let meshes = scene.bounds_of_meshes();
        for k in scene.visible_instances() {
            let columns = scene.instances.world_columns(k).map(|c| c.as_dvec3());
            let [x, y, z, position] = columns;
            let mesh = meshes[scene.instances.mesh[k] as usize];
            for p in mesh.corners().map(Vec3::as_dvec3) {
                self.add(x * p.x + y * p.y + z * p.z + position, 0.0);
            }
        }
    }
}

#[cfg(test)]
#[path = "framing_tests.rs"]
mod tests;
