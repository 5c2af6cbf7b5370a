//! Features and extensions of a file that its picture does not show, named by one warning.

use super::document::GltfMaterial;
use crate::diagnostics::quoted;
use std::collections::BTreeSet;

/// Features by their names, each once.
#[derive(Default)]
pub(super) struct Unshown {
    features: BTreeSet<&'static str>,
    extensions: BTreeSet<String>,
}

/// Prefixes of extensions that do not affect a picture of the pose at rest: data about the model,
/// behaviour, sound, alternatives to the file's own content, and others that are reported where
/// they occur.
const INVISIBLE_EXTENSIONS: [&str; 24] = [
    "AGI_articulations",
    "CESIUM_primitive_outline",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_meshopt_compression",
    "EXT_structural_metadata",
    "EXT_texture_",
    "FB_geometry_metadata",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_draco_mesh_compression",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_meshopt_compression",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_texture_basisu",
    "KHR_xmp",
    "MSFT_",
    "MX_",
    "VRM",
    "OMI_",
];

/// Maximum number of extensions named in a warning: their names come from the file.
const MAX_NAMES: usize = 12;

impl Unshown {
    pub(super) fn add(&mut self, feature: &'static str) {
        self.features.insert(feature);
    }

    /// Adds an extension by its name in the file, unless it never affects a picture.
    pub(super) fn add_extension(&mut self, name: &str) {
        let mut invisible = INVISIBLE_EXTENSIONS.iter();
        if invisible.any(|start| name.starts_with(start)) {
            return;
        }
        if self.extensions.len() <= MAX_NAMES && !self.extensions.contains(name) {
            self.extensions.insert(name.to_owned());
        }
    }

    /// Adds the features of a material that the parent module's table does not have.
    pub(super) fn add_material(&mut self, material: &GltfMaterial) {
        let metallic = &material.pbr_metallic_roughness;
        let extensions = &material.extensions;
        let transmission = extensions.transmission.as_ref();
        let glossiness = extensions.specular_glossiness.as_ref();
        let volume = extensions.volume.as_ref();
        for (name, there) in [
            ("normal textures", material.normal_texture.is_some()),
            ("occlusion textures", material.occlusion_texture.is_some()),
            (
                "emissive textures (surfaces with one do not glow)",
                material.emissive_texture.is_some(),
            ),
            (
                "metallic-roughness textures",
                metallic.metallic_roughness_texture.is_some(),
            ),
            (
                "transmission textures (nothing is transmitted)",
                transmission.is_some_and(|t| t.transmission_texture.is_some()),
            ),
            (
                "specular-glossiness textures",
                glossiness.is_some_and(|g| g.specular_glossiness_texture.is_some()),
            ),
            (
                "colours of volumes",
                volume.is_some_and(|v| v.attenuation_distance.is_some()),
            ),
        ] {
            if there {
                self.add(name);
            }
        }
        for name in extensions.others.keys() {
            self.add_extension(name);
        }
    }

    /// The warning, if there is anything to say.
    pub(super) fn message(&self) -> Option<String> {
        let extensions = self.extensions.iter().take(MAX_NAMES);
        let mut names: Vec<String> = extensions.map(|name| quoted(name)).collect();
        if self.extensions.len() > MAX_NAMES {
            names.push("more extensions".to_owned());
        }
        names.extend(self.features.iter().map(|&feature| feature.to_owned()));
        (!names.is_empty()).then(|| format!("not shown: {}", names.join(", ")))
    }
}
