//! Encoding of radiance in the samples of a picture file.

/// Conversion of linear radiance to the sample values of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutputEncoding {
    /// Transfer curve applied after clamping to \[0, 1\].
    pub transfer: Transfer,
    /// Conversion of 255·c to an integer.
    pub quantize: Quantize,
}

impl OutputEncoding {
    /// Linear values, rounded down: the encoding of `.test` and NFF pictures.
    pub const LINEAR: OutputEncoding = OutputEncoding {
        transfer: Transfer::None,
        quantize: Quantize::Floor,
    };
    /// The sRGB curve, rounded to nearest: the encoding of pictures of meshes.
    pub const SRGB: OutputEncoding = OutputEncoding {
        transfer: Transfer::Srgb,
        quantize: Quantize::Round,
    };
}

/// Transfer curve of the written file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// Linear values are written as they are (the `.test` convention).
    None,
    /// The sRGB curve of IEC 61966-2-1.
    Srgb,
}

/// Quantisation of 255·c.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantize {
    /// `floor(255 c)`, the `.test` convention, measured against independent renderings.
    Floor,
    /// Nearest, halves up.
    Round,
}
