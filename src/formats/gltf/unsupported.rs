//! Features, extensions and primitives of a file that its picture does not show: one warning for
//! all of a kind.

use super::document::GltfMaterial;
use super::source::GltfSource;
use crate::diagnostics::{DiagnosticSink, Span, quoted};
use std::collections::{BTreeMap, BTreeSet};

/// Features by their names, each once.
#[derive(Default)]
pub(super) struct UnsupportedParts {
    features: BTreeSet<&'static str>,
    extensions: BTreeSet<String>,
    /// Primitives of a kind by mesh and index in it, each once, however often a mesh is shown.
    primitives: BTreeMap<&'static str, BTreeSet<(usize, usize)>>,
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

impl UnsupportedParts {
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
        let extensions = &material.extensions;
        let transmission = extensions.transmission.as_ref();
        let glossiness = extensions.specular_glossiness.as_ref();
        let volume = extensions.volume.as_ref();
        for (name, is_present) in [
            ("occlusion textures", material.occlusion_texture.is_some()),
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
            if is_present {
                self.add(name);
            }
        }
        for name in extensions.others.keys() {
            self.add_extension(name);
        }
    }

    /// Adds a primitive of a kind, such as "without positions".
    pub(super) fn add_primitive(&mut self, kind: &'static str, mesh: usize, index: usize) {
        let all = self.primitives.entry(kind).or_default();
        all.insert((mesh, index));
    }

    /// Warns of primitives at the first mesh that has one, and of all others at the file's start.
    pub(super) fn warn(&self, source: &GltfSource, report: &mut DiagnosticSink) {
        for (kind, primitives) in &self.primitives {
            let message = match primitives.len() {
                1 => format!("one primitive {kind} is left out"),
                count => format!("{count} primitives {kind} are left out"),
            };
            let first = primitives.first().map_or(0, |&(mesh, _)| mesh);
            report.warning(source.span_of("meshes", first), message);
        }
        let extensions = self.extensions.iter().take(MAX_NAMES);
        let mut names: Vec<String> = extensions.map(|name| quoted(name)).collect();
        if self.extensions.len() > MAX_NAMES {
            names.push("more extensions".to_owned());
        }
        names.extend(self.features.iter().map(|&feature| feature.to_owned()));
        if !names.is_empty() {
            report.warning(Span::START, format!("not shown: {}", names.join(", ")));
        }
    }
}
