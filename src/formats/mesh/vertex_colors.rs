//! Colours of vertices and faces, shared by the mesh readers.
//!
//! Files hold colours as screens show them, on the sRGB curve: Blender, three.js and MeshLab write
//! and read them so. The scene's are linear.

use crate::diagnostics::{ChunkRemarks, Span};
use phalanx_scene::sampling::{linear_of_srgb, srgb_to_linear};
use phalanx_scene::{Column, Vec3s};

/// Bytes of a colour in the scene, with its opacity.
pub(crate) const COLOR_BYTES: u64 = 16;
/// Bytes of a triangle's references to colours in the scene.
pub(crate) const COLOR_ROW_BYTES: u64 = 12;

/// Colours of a mesh. A mesh without any has no rows, and takes no memory.
#[derive(Debug, Default)]
pub(crate) struct MeshColors {
    /// Linear colours, at least 0.
    pub(crate) rgb: Vec3s,
    /// Opacity of each colour, 0 to 1; empty if it is 1 for all.
    pub(crate) opacity: Column<f32>,
    pub(crate) owners: ColorOwners,
}

/// Owners of the colours of a mesh.
#[derive(Debug, Default)]
pub(crate) enum ColorOwners {
    /// One colour for each vertex, of the same number.
    #[default]
    Vertices,
    /// One colour for each triangle: their numbers.
    Triangles(Vec<u32>),
}

impl MeshColors {
    /// Numbers of the colours of triangles with these vertices: empty if there are no colours.
    pub(crate) fn rows(&self, corners: &[[u32; 3]]) -> Vec<[u32; 3]> {
        match &self.owners {
            _ if self.rgb.is_empty() => Vec::new(),
            ColorOwners::Vertices => corners.to_vec(),
            ColorOwners::Triangles(numbers) => numbers.iter().map(|&number| [number; 3]).collect(),
        }
    }
}

/// The linear value of a colour channel that is a byte in the file.
#[inline]
pub(crate) fn linear_of_byte(channel: u8) -> f32 {
    linear_of_srgb()[usize::from(channel)]
}

/// The linear value of a colour channel, clamped to 0 to 1; NaN is 0.
#[inline]
pub(crate) fn linear_of_share(channel: f32) -> f32 {
    if channel >= 1.0 {
        return 1.0;
    }
    // False for NaN, too.
    if channel > 0.0 { srgb_to_linear(f64::from(channel)) as f32 } else { 0.0 }
}

/// Warns of a colour that is not opaque, on the scale from 0 to 1 or on that of bytes.
pub(crate) fn note_opacity(alpha: f32, span: Span, remarks: &mut ChunkRemarks) {
    if alpha < 1.0 || (1.5..255.0).contains(&alpha) {
        remarks.warn(
            span,
            "the opacity of this colour is not used",
            "colours, this one first, have an opacity that is not used",
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn channels_are_decoded_from_srgb() {
        assert_eq!((linear_of_byte(0), linear_of_byte(255)), (0.0, 1.0));
        assert!((linear_of_share(0.5) - 0.214_041_1).abs() < 1e-6);
        assert!((linear_of_share(188.0 / 255.0) - linear_of_byte(188)).abs() < 1e-6);
        for (channel, linear) in [
            (f32::NAN, 0.0),
            (-1.0, 0.0),
            (1.5, 1.0),
            (f32::INFINITY, 1.0),
        ] {
            assert_eq!(linear_of_share(channel), linear);
        }
    }

    #[test]
    fn colours_belong_to_vertices_or_to_triangles() {
        let corners = [[0, 1, 2], [2, 1, 3]];
        let mut colors = MeshColors::default();
        assert!(colors.rows(&corners).is_empty());
        (0..4).for_each(|_| colors.rgb.push(Vec3::ONE));
        assert_eq!(colors.rows(&corners), corners);
        colors.owners = ColorOwners::Triangles(vec![3, 1]);
        assert_eq!(colors.rows(&corners), [[3; 3], [1; 3]]);
    }
}
