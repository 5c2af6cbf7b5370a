//! Supported extensions of the format.

use super::source::GltfSource;
use super::unsupported::UnsupportedParts;
use crate::diagnostics::{DiagnosticSink, Span, quoted};

/// Extensions that a file may require; others are rejected by name.
const SUPPORTED_EXTENSIONS: [&str; 19] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Unsupported extensions for pictures. Without them only textures are missing, with warnings.
const UNREAD_PICTURES: [&str; 3] = ["EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds"];

/// Advice for a file that requires an extension.
fn advice(name: &str) -> &'static str {
    match name {
        "KHR_draco_mesh_compression" => {
            "export it again without Draco compression, or decompress it: \
             gltf-transform copy IN OUT (Blender's import and export does it, too)"
        }
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "export it again without meshopt compression, or decompress it: \
             gltfpack -noq -i IN -o OUT"
        }
        _ => "export it again without that extension",
    }
}

/// Rejects a file that requires unsupported extensions.
pub(super) fn are_known(source: &GltfSource, report: &mut DiagnosticSink) -> bool {
    let required = &source.document.extensions_required;
    let unknown = required
        .iter()
        .filter(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str()))
        .filter(|name| !UNREAD_PICTURES.contains(&name.as_str()));
    let before = report.is_clean();
    for name in unknown {
        let shown = quoted(name);
        let message = format!("the file requires the extension {shown}, which is not read here");
        report.error_with_help(Span::START, message, advice(name));
    }
    before && report.is_clean()
}

/// Adds extensions that the file uses and does not require, if its picture may lack something
/// without them. Those of materials are named where a material has them.
pub(super) fn add_unknown(source: &GltfSource, unsupported: &mut UnsupportedParts) {
    for name in &source.document.extensions_used {
        let supported = SUPPORTED_EXTENSIONS.contains(&name.as_str());
        if !supported && !name.starts_with("KHR_materials_") {
            unsupported.add_extension(name);
        }
    }
}
