//! Cameras and KHR_lights_punctual.

use super::nodes::PlacedNode;
use super::source::GltfSource;
use crate::formats::diagnostics::DiagnosticSink;
use glam::{DVec3, Vec3};
use phalanx_scene::{Bounds, Scene, View};

/// Takes the camera of the first node with a perspective one: the scene's view, and the width of
/// its picture. Returns true if there is one.
pub(super) fn add_camera(
    source: &GltfSource,
    nodes: &[PlacedNode],
    bounds: Bounds,
    scene: &mut Scene,
    report: &mut DiagnosticSink,
) -> bool {
    for placed in nodes {
        let Some(row) = source.document.nodes[placed.node].camera else {
            continue;
        };
        let Some(camera) = source.document.cameras.get(row) else {
            let message = format!("there is no cameras[{row}]");
            source.error(report, "nodes", placed.node, &message);
            continue;
        };
        let Some(perspective) = &camera.perspective else {
            let message = "an orthographic camera is left out: only those in perspective are used";
            report.warning(source.span_of("cameras", row), message);
            continue;
        };
        let Some(view) = view(placed, perspective.yfov, bounds) else {
            let message = "the camera is left out: it has no direction or no field of view";
            report.warning(source.span_of("cameras", row), message);
            continue;
        };
        scene.view = view;
        if let Some(aspect) = perspective
            .aspect_ratio
            .filter(|a| (0.1..=10.0).contains(a))
        {
            scene.width = libm::round(f64::from(scene.height) * aspect) as u32;
        }
        return true;
    }
    false
}

/// A camera looks along its own −z; its own y points up.
fn view(placed: &PlacedNode, yfov: f64, bounds: Bounds) -> Option<View> {
    let eye = placed.to_world.translation;
    let m = placed.to_world.matrix3;
    let (back, up) = (m.z_axis.try_normalize()?, m.y_axis.try_normalize()?);
    // The target is as far away as the geometry, so that neither rounding nor the point itself
    // changes the scene's scale.
    let middle = match bounds.is_empty() {
        true => eye - back,
        false => (bounds.lo.as_dvec3() + bounds.hi.as_dvec3()) / 2.0,
    };
    let distance = match (middle - eye).length() {
        far if far > 0.0 => far,
        _ => 1.0,
    };
    let view = View {
        eye: eye.as_vec3(),
        center: (eye - back * distance).as_vec3(),
        up: up.as_vec3(),
        fovy: yfov.to_degrees() as f32,
        ortho: None,
    };
    view.basis().ok().map(|_| view)
}

/// Range of irradiance in which lights are left as they are. Beyond it, all lights are scaled so
/// that the scene's middle gets 1.
const EXPOSURE_RANGE: std::ops::RangeInclusive<f64> = 0.25..=4.0;

/// A light in the world. `strength` is colour times intensity over π, the radiance of a white
/// surface that faces it at distance 1 (or anywhere, for a directional one).
enum ConvertedLight {
    Point { position: DVec3, strength: DVec3 },
    Directional { toward: DVec3, strength: DVec3 },
}

/// Adds the file's lights. Returns true if there are any.
pub(super) fn add_lights(
    source: &GltfSource,
    nodes: &[PlacedNode],
    bounds: Bounds,
    scene: &mut Scene,
    report: &mut DiagnosticSink,
) -> bool {
    let mut lamps = Vec::new();
    let mut spots = 0;
    for placed in nodes {
        let Some(index) = &source.document.nodes[placed.node].extensions.light else {
            continue;
        };
        let Some(light) = source.document.extensions.lights.lights.get(index.light) else {
            let message = format!("there is no light {}", index.light);
            source.error(report, "nodes", placed.node, &message);
            continue;
        };
        let intensity = light.intensity.max(0.0) / std::f64::consts::PI;
        let strength = DVec3::from_array(light.color).max(DVec3::ZERO) * intensity;
        let position = placed.to_world.translation;
        match light.kind.as_str() {
            "directional" => match placed.to_world.matrix3.z_axis.try_normalize() {
                Some(toward) => lamps.push(ConvertedLight::Directional { toward, strength }),
                None => source.error(report, "nodes", placed.node, "a light without direction"),
            },
            "point" | "spot" => {
                spots += usize::from(light.kind == "spot");
                lamps.push(ConvertedLight::Point { position, strength });
            }
            _ => source.error(report, "nodes", placed.node, "a light of an unknown type"),
        }
    }
    if spots > 0 {
        let message = format!("{spots} spot lights shine to all sides, as point lights do");
        report.warning(source.span_of("nodes", 0), message);
    }
    let scale = exposure(&lamps, bounds);
    if scale != 1.0 {
        let message =
            format!("the file's lights are scaled by {scale:.3e}, so that its middle is well lit");
        report.warning(source.span_of("nodes", 0), message);
    }
    for lamp in &lamps {
        match *lamp {
            ConvertedLight::Point { position, strength } => {
                let color = bounded(strength * scale);
                scene.lights.add_point(position.as_vec3(), color, Vec3::Z);
            }
            ConvertedLight::Directional { toward, strength } => {
                let color = bounded(strength * scale);
                scene.lights.add_directional(toward.as_vec3(), color);
            }
        }
    }
    !lamps.is_empty()
}

/// Colours, clamped so that single precision adds them up without overflow.
fn bounded(color: DVec3) -> Vec3 {
    color.min(DVec3::splat(1e30)).as_vec3()
}

/// Factor by which all lights are scaled: candela and lux have no bound, and files are written for
/// any exposure.
fn exposure(lamps: &[ConvertedLight], bounds: Bounds) -> f64 {
    let (middle, reach) = match bounds.is_empty() {
        true => (DVec3::ZERO, 1.0),
        false => {
            let (lo, hi) = (bounds.lo.as_dvec3(), bounds.hi.as_dvec3());
            ((lo + hi) / 2.0, (hi - lo).length() / 2.0)
        }
    };
    let light = lamps.iter().map(|lamp| match lamp {
        ConvertedLight::Directional { strength, .. } => strength.max_element(),
        // A light inside the scene counts as if it stood at its edge.
        ConvertedLight::Point { position, strength } => {
            let squared = (*position - middle).length_squared().max(reach * reach);
            strength.max_element() / squared
        }
    });
    let light = light.sum::<f64>();
    match light > 0.0 && light.is_finite() && !EXPOSURE_RANGE.contains(&light) {
        true => 1.0 / light,
        false => 1.0,
    }
}
