//! Colours of vertices and faces: the properties that hold them, and their numbers as linear
//! colours.
//!
//! Numbers are on the sRGB curve, as screens show them. Their scale is inferred from the values,
//! because programs disagree about types: floats are from 0 to 1 (Open3D) or to 255, and integers
//! of any type may be those of bytes. Alpha is not used, as it is seldom meant as opacity; that
//! of vertices gets a warning.

use super::header::{Element, PropertyKind};
use crate::mesh::faces::Faces;
use crate::mesh::vertex_colors::{ColorOwners, MeshColors, linear_of_byte, linear_of_share};
use crate::text::workers;
use phalanx_scene::{NO_INDEX, Vec3s};

/// Names of the properties of a colour.
const NAMES: [[&[u8]; 3]; 3] = [
    [b"red", b"green", b"blue"],
    [b"diffuse_red", b"diffuse_green", b"diffuse_blue"],
    [b"r", b"g", b"b"],
];
/// Names of the property of its opacity.
const ALPHA_NAMES: [&[u8]; 3] = [b"alpha", b"diffuse_alpha", b"a"];

/// The properties of an element that hold a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ColorProperties {
    /// Indices of red, green and blue.
    pub(super) numbers: [usize; 3],
    pub(super) alpha: Option<usize>,
    /// True if they are integers.
    are_integers: bool,
}

impl ColorProperties {
    /// The colour of an element's rows, if they have one.
    pub(super) fn of(element: &Element) -> Option<ColorProperties> {
        let numbers = NAMES.into_iter().find_map(|names| element.numbers(names))?;
        let is_whole = |&index: &usize| matches!(element.properties[index].kind, PropertyKind::One(kind) if kind.is_whole());
        Some(ColorProperties {
            numbers,
            alpha: (ALPHA_NAMES.into_iter()).find_map(|name| element.number(name)),
            are_integers: numbers.iter().all(is_whole),
        })
    }

    /// Turns numbers of a file into linear ones, on several threads.
    fn make_linear(&self, rgb: &mut Vec3s, threads: usize) {
        let blocks = || rgb.parts().into_iter().flat_map(|part| part.chunks(BLOCK));
        let ranges = workers::map(threads, blocks().collect(), NumberRange::of);
        let range = ranges
            .into_iter()
            .fold(NumberRange::default(), NumberRange::join);
        let most = range.scale(self.are_integers);
        let bytes = most == 255.0;
        let parts = rgb.parts_mut().into_iter();
        let blocks = parts.flat_map(|part| part.chunks_mut(BLOCK)).collect();
        workers::map(threads, blocks, |block: &mut [f32]| {
            for channel in block {
                let byte = *channel as u8;
                *channel = if bytes && f32::from(byte) == *channel {
                    linear_of_byte(byte)
                } else {
                    linear_of_share(*channel / most)
                };
            }
        });
    }
}

/// Number of values that a thread examines at a time.
const BLOCK: usize = 1 << 16;

/// The largest of some numbers, and whether any of them is not an integer.
#[derive(Clone, Copy, Debug, Default)]
struct NumberRange {
    most: f32,
    fractions: bool,
}

impl NumberRange {
    fn of(numbers: &[f32]) -> NumberRange {
        let mut range = NumberRange::default();
        for &number in numbers.iter().filter(|number| number.is_finite()) {
            range.most = range.most.max(number);
            range.fractions |= number.fract() != 0.0;
        }
        range
    }

    fn join(self, other: NumberRange) -> NumberRange {
        NumberRange {
            most: self.most.max(other.most),
            fractions: self.fractions | other.fractions,
        }
    }

    /// The number that stands for full intensity.
    fn scale(self, are_integers: bool) -> f32 {
        // Some programs declare bytes and write values from 0 to 1. Sums of weights may exceed 1
        // slightly.
        let shares = !are_integers || self.fractions;
        match self.most {
            ..=1.5 if shares => 1.0,
            ..=255.5 => 255.0,
            ..=65535.5 => 65535.0,
            _ if self.most <= i32::MAX as f32 => i32::MAX as f32,
            _ => u32::MAX as f32,
        }
    }
}

/// Colours of faces, in a chunk.
#[derive(Debug, Default)]
pub(super) struct FaceColors {
    /// Colours as in the file.
    pub(super) rgb: [Vec<f32>; 3],
    /// The number of the colour of each triangle; those at the end may be missing.
    pub(super) numbers: Vec<u32>,
}

impl FaceColors {
    /// Adds the colour of the last triangles, up to the `count`-th.
    pub(super) fn add(&mut self, rgb: [f32; 3], count: usize) {
        let number = self.rgb[0].len() as u32;
        for (column, channel) in self.rgb.iter_mut().zip(rgb) {
            column.push(channel);
        }
        self.numbers.resize(count, number);
    }
}

/// The colours of a mesh whose vertices have them.
pub(super) fn of_vertices(
    mut rgb: Vec3s,
    properties: &ColorProperties,
    threads: usize,
) -> MeshColors {
    properties.make_linear(&mut rgb, threads);
    MeshColors {
        rgb,
        ..MeshColors::default()
    }
}

/// The colours of a mesh whose faces have them.
pub(super) fn of_faces(
    chunks: Vec<FaceColors>,
    faces: &[Faces],
    properties: &ColorProperties,
    threads: usize,
) -> MeshColors {
    let triangles = faces.iter().map(Faces::len).sum();
    let mut numbers = Vec::with_capacity(triangles);
    let mut columns = Vec::new();
    let (mut colors, mut end) = (0, 0);
    for (chunk, faces) in chunks.into_iter().zip(faces) {
        let of_chunk = chunk.numbers.into_iter();
        numbers.extend(of_chunk.map(|number| number + colors));
        // Triangles of strips have none.
        end += faces.len();
        numbers.resize(end, NO_INDEX);
        colors += chunk.rgb[0].len() as u32;
        columns.push(chunk.rgb);
    }
    let [x, y, z] = crate::mesh::merge_floats(threads, columns);
    let rgb = Vec3s { x, y, z };
    MeshColors {
        owners: ColorOwners::Triangles(numbers),
        ..of_vertices(rgb, properties, threads)
    }
}
