//! Values of options that plans, keys and commands have as text.

use super::numbers::parse_number;
use phalanx_image::ToneCurve;
use phalanx_render::frame::Filter;
use phalanx_scene::film::{Aov, Aovs};
use phalanx_scene::{Quantize, Transfer, UpAxis};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A value of an option, with one text for each value.
pub trait OptionValue: Sized {
    /// Parses the value.
    ///
    /// # Errors
    /// The expected values.
    fn parse(text: &str) -> Result<Self, String>;

    /// The value's text, which `parse` reads.
    fn text(&self) -> String;
}

/// A value that is text wherever it is stored, and is parsed where it is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AsText<T>(pub T);

impl<T: OptionValue> AsText<T> {
    /// Parses the value.
    ///
    /// # Errors
    /// The expected values.
    pub fn parse(text: &str) -> Result<AsText<T>, String> {
        T::parse(text).map(AsText)
    }
}

impl<T: OptionValue> Serialize for AsText<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0.text())
    }
}

impl<'de, T: OptionValue> Deserialize<'de> for AsText<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<AsText<T>, D::Error> {
        let text = String::deserialize(deserializer)?;
        AsText::parse(&text).map_err(|reason| D::Error::custom(format!("`{text}`: {reason}")))
    }
}

/// A value with a name.
pub trait Named: Copy + PartialEq + Send + Sync + 'static {
    /// The names and their values.
    const NAMES: &'static [(&'static str, Self)];
}

impl<T: Named> OptionValue for T {
    fn parse(text: &str) -> Result<T, String> {
        let named = T::NAMES.iter().find(|(name, _)| *name == text);
        named.map(|(_, value)| *value).ok_or_else(|| {
            let names: Vec<_> = T::NAMES.iter().map(|(name, _)| *name).collect();
            format!("expected one of {}", names.join(", "))
        })
    }

    fn text(&self) -> String {
        let named = T::NAMES.iter().find(|(_, value)| value == self);
        named.map_or(String::new(), |(name, _)| (*name).to_owned())
    }
}

/// A distance above 0, which may be infinite.
impl OptionValue for f32 {
    fn parse(text: &str) -> Result<f32, String> {
        let good = |distance: &f32| *distance > 0.0;
        parse_number(text, good, "a distance greater than 0, as in 2.5, or inf")
    }

    fn text(&self) -> String {
        format!("{self:?}")
    }
}

impl Named for Filter {
    const NAMES: &'static [(&'static str, Filter)] = &Filter::ALL;
}

impl Named for UpAxis {
    const NAMES: &'static [(&'static str, UpAxis)] = &UpAxis::ALL;
}

impl Named for Transfer {
    const NAMES: &'static [(&'static str, Transfer)] =
        &[("none", Transfer::None), ("srgb", Transfer::Srgb)];
}

impl Named for Quantize {
    const NAMES: &'static [(&'static str, Quantize)] =
        &[("floor", Quantize::Floor), ("round", Quantize::Round)];
}

impl Named for ToneCurve {
    const NAMES: &'static [(&'static str, ToneCurve)] = &[
        ("linear", ToneCurve::Linear),
        ("neutral", ToneCurve::Neutral),
    ];
}

/// Value of `--aov` for all layers except alpha and cost.
pub(super) const ALL_AOVS: &str = "all";

impl OptionValue for Aovs {
    fn parse(text: &str) -> Result<Aovs, String> {
        match Aov::named(text) {
            Some(aov) => Ok(Aovs::default().with(aov)),
            // Alpha changes radiance, so it must be requested by name.
            None if text == ALL_AOVS => Ok(Aovs::all().without(Aov::Alpha)),
            None => Err("expected the name of a layer".to_owned()),
        }
    }

    fn text(&self) -> String {
        let layers = Aov::ALL.iter().filter(|(_, aov)| self.has(*aov));
        let names: Vec<_> = layers.map(|(name, _)| *name).collect();
        names.join(",")
    }
}

/// A parser of values that have these names.
#[cfg(feature = "clap")]
pub(super) fn names<T>(
    names: impl IntoIterator<Item = impl Into<clap::builder::PossibleValue>>,
) -> impl clap::builder::TypedValueParser<Value = AsText<T>>
where
    T: OptionValue + Clone + Send + Sync + 'static,
{
    use clap::builder::{PossibleValuesParser, TypedValueParser};
    PossibleValuesParser::new(names).try_map(|name| AsText::parse(&name))
}
