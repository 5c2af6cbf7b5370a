//! Options for converting radiance to the samples of picture files.

use super::as_text::AsText;
#[cfg(feature = "clap")]
use super::as_text::names;
#[cfg(feature = "clap")]
use super::headings;
use super::numbers::parse_number;
use super::option_row::OptionForm::{Attached, Words};
use super::option_row::{OptionRow, unless_default};
use crate::field_error::FieldError;
#[cfg(feature = "clap")]
use clap::builder::PossibleValue;
use phalanx_image::{Depth, Exposure, MAX_EXPOSURE, ToneCurve};
use phalanx_scene::{OutputEncoding, Quantize, Transfer};
use serde::{Deserialize, Serialize};

/// Transfer function and rounding of integer samples. Options not given are the scene's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = headings::OUTPUT))]
pub struct ToneSpec {
    /// Transfer function of PNG and JPEG samples [default: the scene format's]
    #[cfg_attr(feature = "clap", arg(long, hide_short_help = true, value_parser = names::<Transfer>([PossibleValue::new("none").help("Linear values"), PossibleValue::new("srgb").help("sRGB curve")])))]
    pub transfer: Option<AsText<Transfer>>,
    /// Rounding of PNG and JPEG samples [default: the scene format's]
    #[cfg_attr(feature = "clap", arg(long, hide_short_help = true, value_parser = names::<Quantize>([PossibleValue::new("floor").help("Round down"), PossibleValue::new("round").help("Round to nearest")])))]
    pub quantize: Option<AsText<Quantize>>,
}

/// An exposure, as commands give it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ExposureSpec {
    /// In stops.
    Stops(f32),
    /// Measured before the picture is rendered; see
    /// [`measure_exposure`](crate::measure_exposure). Files have the stops that were measured.
    #[serde(skip)]
    Auto,
}

impl ExposureSpec {
    /// Parses an exposure: auto, or a number of stops.
    ///
    /// # Errors
    /// The expected values.
    pub fn parse(text: &str) -> Result<ExposureSpec, String> {
        if text == "auto" {
            return Ok(ExposureSpec::Auto);
        }
        let expected = format!("auto, or stops from -{MAX_EXPOSURE} to {MAX_EXPOSURE}, as in 0.5");
        let stops = parse_number(text, |stops: &f32| stops.abs() <= MAX_EXPOSURE, expected);
        stops.map(ExposureSpec::Stops)
    }

    /// The stops: 0 until an automatic exposure has been measured.
    pub fn stops(self) -> f32 {
        match self {
            ExposureSpec::Stops(stops) => stops,
            ExposureSpec::Auto => 0.0,
        }
    }
}

/// All options for the samples of a picture's file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = headings::OUTPUT))]
pub struct EncodingSpec {
    /// The tone.
    #[cfg_attr(feature = "clap", command(flatten))]
    pub tone: ToneSpec,
    /// Exposure of PNG and JPEG output: stops, or auto
    ///
    /// Positive values brighten, negative ones darken, as in --exposure=-1.5. auto measures the
    /// light on visible surfaces in a small picture of the whole frame, so that well-lit surfaces
    /// show their own colour. All frames of a sequence use the exposure of its first; reports and
    /// headers give it in stops. [default: 0]
    #[cfg_attr(feature = "clap", arg(long, value_name = "STOPS|auto", hide_short_help = true, value_parser = ExposureSpec::parse))]
    pub exposure: Option<ExposureSpec>,
    /// Tone curve of PNG and JPEG: linear (default) or neutral
    ///
    /// linear clips values above white. neutral (Khronos PBR Neutral) compresses highlights below
    /// white and keeps the base colours of materials. Applied after the exposure. [default: linear]
    #[cfg_attr(feature = "clap", arg(long = "tone", value_name = "NAME", hide_short_help = true, hide_possible_values = true, value_parser = names::<ToneCurve>(["linear", "neutral"])))]
    pub curve: Option<AsText<ToneCurve>>,
    /// Bits per sample: PNG 8 (default) or 16, EXR 32 (default) or 16
    ///
    /// With 16, OpenEXR output has half floats for R, G, B, A, albedo, direct, reflection and
    /// refraction, rounded to nearest even; finite values beyond 65504 become 65504. Its other
    /// layers keep 32 bits. [default: 8 for PNG, 32 for OpenEXR]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", hide_short_help = true, value_parser = parse_bits))]
    pub bits: Option<u8>,
}

#[cfg(feature = "clap")]
fn parse_bits(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        "32" => Ok(32),
        _ => Err("expected 8, 16 or 32".to_owned()),
    }
}

impl ToneSpec {
    /// The scene's encoding with these options applied.
    pub fn encoding(&self, scene: OutputEncoding) -> OutputEncoding {
        OutputEncoding {
            transfer: self.transfer.map_or(scene.transfer, |transfer| transfer.0),
            quantize: self.quantize.map_or(scene.quantize, |quantize| quantize.0),
        }
    }

    /// The options that give this encoding.
    pub fn of(encoding: OutputEncoding) -> ToneSpec {
        ToneSpec {
            transfer: Some(AsText(encoding.transfer)),
            quantize: Some(AsText(encoding.quantize)),
        }
    }
}

impl EncodingSpec {
    /// The options that give this exposure and bit depth.
    pub fn of(exposure: Exposure, depth: Depth) -> EncodingSpec {
        EncodingSpec {
            tone: ToneSpec::of(exposure.encoding),
            exposure: (exposure.stops != 0.0).then_some(ExposureSpec::Stops(exposure.stops)),
            curve: unless_default(Some(AsText(exposure.curve))),
            bits: (depth == Depth::Sixteen).then_some(16),
        }
    }

    fn stops(&self) -> f32 {
        self.exposure.map_or(0.0, ExposureSpec::stops)
    }

    /// The exposure, for a scene with this encoding.
    pub fn exposure(&self, scene: OutputEncoding) -> Exposure {
        Exposure {
            stops: self.stops(),
            curve: self.curve.unwrap_or_default().0,
            encoding: self.tone.encoding(scene),
        }
    }

    /// Bits per sample of PNG and OpenEXR output.
    pub fn depth(&self) -> Depth {
        match self.bits {
            Some(16) => Depth::Sixteen,
            _ => Depth::Standard,
        }
    }

    /// The options in the order of commands.
    pub(super) fn rows(&self) -> Vec<OptionRow> {
        let exposure = self.exposure.map(|exposure| exposure.stops().to_string());
        vec![
            OptionRow::new("transfer", Words, &self.tone.transfer),
            OptionRow::new("quantize", Words, &self.tone.quantize),
            OptionRow::new("bits", Words, &self.bits),
            OptionRow::new("exposure", Attached, &exposure),
            OptionRow::new("tone", Words, &self.curve),
        ]
    }

    /// The options resolved for a scene with this encoding; options without effect are left out.
    pub fn resolve(&self, scene: OutputEncoding) -> EncodingSpec {
        EncodingSpec::of(self.exposure(scene), self.depth())
    }

    /// Checks that [`EncodingSpec::of`] could have made these options, which are not trusted.
    ///
    /// # Errors
    /// The first option with an invalid value.
    pub(crate) fn check(&self) -> Result<(), FieldError> {
        let wrong = |option: &str, value: String, expected: &str| {
            let field = format!("encoding.{option}");
            Err(FieldError::new(field, value, expected))
        };
        let stops = self.stops();
        if !(-MAX_EXPOSURE..=MAX_EXPOSURE).contains(&stops) {
            let range = format!("stops from -{MAX_EXPOSURE} to {MAX_EXPOSURE}");
            return wrong("exposure", stops.to_string(), &range);
        }
        let resolved = self.resolve(OutputEncoding::LINEAR);
        if self.bits != resolved.bits {
            let bits = self.bits.unwrap_or_default().to_string();
            return wrong("bits", bits, "16, or none for the default");
        }
        Ok(())
    }
}
