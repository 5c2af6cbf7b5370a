//! Lights: KHR_lights_punctual.

use super::document::SpotAngles;
use super::nodes::PlacedNode;
use super::source::GltfSource;
use crate::diagnostics::{DiagnosticSink, quoted};
use glam::{DVec3, Vec3};
use phalanx_scene::lighting::SceneMiddle;
use phalanx_scene::{Bounds, Scene};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Range of irradiance in which lights are left unchanged. Beyond it, all lights are scaled so that
/// the scene's middle receives 1.
const EXPOSURE_RANGE: std::ops::RangeInclusive<f64> = 0.25..=4.0;

/// A light in the world. `strength` is its colour in the scene before scaling, by the units of
/// [`phalanx_scene::lighting`].
struct ConvertedLight {
    strength: DVec3,
    place: LightPlace,
}

enum LightPlace {
    Point(DVec3),
    Spot {
        position: DVec3,
        axis: DVec3,
        angles: [f32; 2],
    },
    /// The direction toward the light.
    Far(DVec3),
}

/// Minimum angle of a spot light's cone. Narrower ones would light nothing.
const MIN_CONE_ANGLE: f64 = 1e-3;

/// The inner and the outer angle of a spot light, within what the format allows.
fn cone(spot: &SpotAngles) -> [f32; 2] {
    let outer = spot.outer_cone_angle.unwrap_or(FRAC_PI_4);
    let outer = outer.clamp(MIN_CONE_ANGLE, FRAC_PI_2);
    // The inner angle must be less than the outer one.
    let inner = spot
        .inner_cone_angle
        .clamp(0.0, outer - MIN_CONE_ANGLE / 2.0);
    [inner as f32, outer as f32]
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
    let mut unknown = None;
    for placed in nodes.iter().filter(|placed| placed.visible) {
        let named = &source.document.nodes[placed.node].extensions.light;
        let Some(index) = named.as_ref().and_then(|named| named.light) else {
            continue;
        };
        let Some(light) = source.document.extensions.lights.lights.get(index) else {
            let message = format!("there is no light {index}");
            source.error(report, "nodes", placed.node, &message);
            continue;
        };
        let intensity = light.intensity.max(0.0) / std::f64::consts::PI;
        let strength = DVec3::from_array(light.color).max(DVec3::ZERO) * intensity;
        let position = placed.to_world.translation;
        // Light is sent along the node's own −z.
        let axis = placed.to_world.matrix3.z_axis.try_normalize();
        let place = match (light.kind.as_str(), axis) {
            ("directional", Some(toward)) => LightPlace::Far(toward),
            ("spot", Some(back)) => LightPlace::Spot {
                position,
                axis: -back,
                angles: cone(&light.spot),
            },
            ("point", _) => LightPlace::Point(position),
            ("directional" | "spot", None) => {
                source.error(report, "nodes", placed.node, "a light without direction");
                continue;
            }
            (kind, _) => {
                unknown.get_or_insert((placed.node, kind));
                continue;
            }
        };
        lamps.push(ConvertedLight { strength, place });
    }
    if let Some((node, kind)) = unknown {
        let kind = match kind {
            "" => "without a type".to_owned(),
            kind => format!("of the unknown type {}", quoted(kind)),
        };
        let message = format!("a light {kind} is left out");
        source.warning(report, "nodes", node, &message);
    }
    let scale = exposure(&lamps, SceneMiddle::of(bounds));
    if scale != 1.0 {
        let message = format!(
            "the file's lights and emission are scaled by {scale:.3e}, so that its middle is well lit"
        );
        report.warning(source.span_of("nodes", 0), message);
        scene.set_light_scale(scale.clamp(1e-30, 1e30) as f32);
    }
    for lamp in &lamps {
        // Clamped so that single precision adds colours up without overflow.
        let color = (lamp.strength * scale).min(DVec3::splat(1e30)).as_vec3();
        let lights = &mut scene.lights;
        match lamp.place {
            LightPlace::Point(position) => lights.add_point(position.as_vec3(), color, Vec3::Z),
            LightPlace::Spot {
                position,
                axis,
                angles,
            } => lights.add_spot(position.as_vec3(), color, Vec3::Z, axis.as_vec3(), angles),
            LightPlace::Far(toward) => lights.add_directional(toward.as_vec3(), color),
        }
    }
    !lamps.is_empty()
}

/// Factor by which all lights are scaled: candela, lux and nits have no bound, and files are
/// written for any exposure.
fn exposure(lamps: &[ConvertedLight], middle: SceneMiddle) -> f64 {
    let light = lamps.iter().map(|lamp| match lamp.place {
        LightPlace::Far(_) => lamp.strength.max_element(),
        LightPlace::Point(position) | LightPlace::Spot { position, .. } => {
            lamp.strength.max_element() / middle.attenuation(position, [0.0, 0.0, 1.0])
        }
    });
    let light = light.sum::<f64>();
    if light > 0.0 && light.is_finite() && !EXPOSURE_RANGE.contains(&light) {
        1.0 / light
    } else {
        1.0
    }
}
