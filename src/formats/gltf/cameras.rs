//! Cameras: the first one that can be used is the scene's view. The others can be chosen.

use super::document::{GltfCamera, Orthographic};
use super::nodes::PlacedNode;
use super::source::GltfSource;
use crate::diagnostics::DiagnosticSink;
use glam::DVec3;
use phalanx_scene::{Bounds, NO_NAME, Scene, SceneCamera, View};

/// Lens of a camera, and its picture's aspect ratio, if given in the file.
struct Projection {
    /// Vertical field of view in degrees.
    fovy: f32,
    /// Width and height that parallel rays show, in units of the file.
    ortho_size: Option<[f64; 2]>,
    aspect: Option<f64>,
}

/// Ratios of width and height that a picture takes from a camera.
const ASPECTS: std::ops::RangeInclusive<f64> = 0.1..=10.0;
/// Placeholder for the field of view of parallel rays, which do not use it.
const UNUSED_FOVY: f32 = 45.0;

/// Adds the cameras of all nodes that have a usable one, and takes the first: the scene's view, and
/// the width of its picture.
pub(super) fn add_cameras(
    source: &GltfSource,
    nodes: &[PlacedNode],
    bounds: Bounds,
    scene: &mut Scene,
    report: &mut DiagnosticSink,
) {
    for placed in nodes {
        let Some(row) = source.document.nodes[placed.node].camera else {
            continue;
        };
        let Some(camera) = source.document.cameras.get(row) else {
            let message = format!("there is no cameras[{row}]");
            source.error(report, "nodes", placed.node, &message);
            continue;
        };
        let projection = projection(camera);
        let view = projection
            .as_ref()
            .and_then(|projection| view(placed, projection, bounds));
        let (Some(projection), Some(view)) = (projection, view) else {
            let message = "the camera is left out: it has no direction or no field of view";
            report.warning(source.span_of("cameras", row), message);
            continue;
        };
        let node = &source.document.nodes[placed.node];
        let name = match scene.names.intern(node.name.text().as_bytes()) {
            NO_NAME => scene.names.intern(camera.name.text().as_bytes()),
            name => name,
        };
        let aspect = projection.aspect.filter(|a| ASPECTS.contains(a));
        scene.cameras.push(SceneCamera {
            name,
            view,
            ortho_size: projection.ortho_size,
            width: aspect.map_or(scene.width, |aspect| {
                libm::round(f64::from(scene.height) * aspect) as u32
            }),
        });
    }
    if let Some(&first) = scene.cameras.first() {
        scene.use_camera(first);
    }
}

fn projection(camera: &GltfCamera) -> Option<Projection> {
    match (&camera.perspective, &camera.orthographic) {
        (Some(perspective), _) => Some(Projection {
            fovy: perspective.yfov.to_degrees() as f32,
            ortho_size: None,
            aspect: perspective.aspect_ratio,
        }),
        (None, Some(orthographic)) => parallel(orthographic),
        (None, None) => None,
    }
}

/// A lens of parallel rays. The file's picture has the shape of the visible area; a picture of
/// another shape shows all of that, and more.
fn parallel(orthographic: &Orthographic) -> Option<Projection> {
    // Negative ones turn the picture over, which the format discourages.
    let (width, height) = (orthographic.xmag.abs(), orthographic.ymag.abs());
    let aspect = width / height;
    if !(aspect > 0.0 && aspect.is_finite()) {
        return None;
    }
    Some(Projection {
        fovy: UNUSED_FOVY,
        ortho_size: Some([2.0 * width, 2.0 * height]),
        aspect: Some(aspect.clamp(*ASPECTS.start(), *ASPECTS.end())),
    })
}

/// A camera looks along its own −z; its own y points up. Its scale is ignored, as the format
/// requires: a mirroring node turns the camera with its axes, and does not mirror the picture.
fn view(placed: &PlacedNode, projection: &Projection, bounds: Bounds) -> Option<View> {
    let eye = placed.to_world.translation;
    let m = placed.to_world.matrix3;
    let [right, up, back] = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::try_normalize);
    // Two axes give the third, if the node makes one of them vanish.
    let across = |a: Option<DVec3>, b: Option<DVec3>| a?.cross(b?).try_normalize();
    let back = back.or_else(|| across(right, up))?;
    let up = up.or_else(|| across(Some(back), right))?;
    // The target is as far away as the geometry, so that neither rounding nor the point itself
    // changes the scene's scale.
    let middle = if bounds.is_empty() {
        eye - back
    } else {
        (bounds.lo.as_dvec3() + bounds.hi.as_dvec3()) / 2.0
    };
    let distance = match (middle - eye).length() {
        far if far > 0.0 => far,
        _ => 1.0,
    };
    let view = View {
        eye: eye.as_vec3(),
        center: (eye - back * distance).as_vec3(),
        up: up.as_vec3(),
        fovy: projection.fovy,
        ortho: projection.ortho_size.map(|[_, height]| height as f32),
    };
    view.basis().ok().map(|_| view)
}
