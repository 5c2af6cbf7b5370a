//! Layers of two pictures: channels that both have, by their names.

use super::super::error::{CompareError, DifferentSizes};
use super::super::format::ImageFormat;
use super::super::read::{PictureLayout, PictureReader, SampleKind};
use std::collections::HashMap;

/// Name of the layer of the channels R, G, B and A.
pub(super) const COLOR: &str = "color";

/// Names of the channels of colours, in their usual order.
const RGBA: [&str; 4] = ["R", "G", "B", "A"];

/// A channel that both pictures have.
#[derive(Clone, Debug)]
pub(super) struct ChannelPair {
    /// Name within the layer.
    pub(super) name: String,
    /// Index among the channels of each picture.
    pub(super) index: [usize; 2],
    /// The numbers that it holds in each picture.
    pub(super) kind: [SampleKind; 2],
}

/// A layer that both pictures have.
#[derive(Clone, Debug)]
pub(super) struct LayerPair {
    pub(super) name: String,
    pub(super) channels: Vec<ChannelPair>,
}

impl LayerPair {
    /// The channels that hold red, green and blue.
    pub(super) fn rgb(&self) -> Option<[&ChannelPair; 3]> {
        let named = |name| self.channels.iter().find(|channel| channel.name == name);
        Some([named("R")?, named("G")?, named("B")?])
    }

    /// The channel of straight alpha of one picture: that of samples for a screen. Linear colours
    /// are already weighted by their alpha.
    pub(super) fn straight_alpha(&self, side: usize) -> Option<&ChannelPair> {
        let straight = |channel: &&ChannelPair| channel.kind[side] == SampleKind::Display;
        let mut straight = self.channels.iter().filter(straight);
        straight.find(|channel| channel.name == "A")
    }
}

/// Layers of two pictures.
#[derive(Clone, Debug, Default)]
pub(super) struct LayerPairs {
    /// Those of both, colours first.
    pub(super) common: Vec<LayerPair>,
    /// Names of those layers and channels that one picture lacks, by the picture that has them.
    pub(super) only_in: [Vec<String>; 2],
    /// Names of those that are not compared, because the other file's format only has colours.
    pub(super) left_out: Vec<String>,
}

/// Pairs the layers of two pictures.
pub(super) fn pair_layers(
    a: &PictureReader,
    b: &PictureReader,
) -> Result<LayerPairs, CompareError> {
    let (first, second) = (a.layout(), b.layout());
    let (size_a, size_b) = ((first.width, first.height), (second.width, second.height));
    let meaning = |linear: &PictureReader, display: &PictureReader| CompareError::Meaning {
        linear: linear.path().to_path_buf(),
        display: display.path().to_path_buf(),
    };
    match (first.format.is_linear(), second.format.is_linear()) {
        (true, false) => return Err(meaning(a, b)),
        (false, true) => return Err(meaning(b, a)),
        _ if size_a != size_b => return Err(DifferentSizes(size_a, size_b).into()),
        _ if first.corner != second.corner => {
            return Err(CompareError::Windows(first.corner, second.corner));
        }
        _ => {}
    }
    let mut pairs = LayerPairs {
        common: common_layers(first, second),
        only_in: [only_in(first, second), only_in(second, first)],
        left_out: Vec::new(),
    };
    if pairs.common.is_empty() {
        return Err(CompareError::NothingInCommon(pairs.only_in));
    }
    for (other, layout) in [(1, first), (0, second)] {
        if matches!(layout.format, ImageFormat::Hdr | ImageFormat::Pfm) {
            pairs.left_out.append(&mut pairs.only_in[other]);
        }
    }
    Ok(pairs)
}

/// Layer of a channel, and the channel's name in it.
fn split(name: &str) -> (&str, &str) {
    match name.rsplit_once('.') {
        Some(parts) => parts,
        None if RGBA.contains(&name) => (COLOR, name),
        None => (name, name),
    }
}

fn indices(layout: &PictureLayout) -> HashMap<&str, usize> {
    let names = layout.channels.iter().map(|channel| channel.name.as_str());
    names.zip(0..).collect()
}

fn common_layers(first: &PictureLayout, second: &PictureLayout) -> Vec<LayerPair> {
    let others = indices(second);
    let mut layers: Vec<LayerPair> = Vec::new();
    for (index, channel) in first.channels.iter().enumerate() {
        let Some(&other) = others.get(channel.name.as_str()) else {
            continue;
        };
        let (layer, name) = split(&channel.name);
        let pair = ChannelPair {
            name: name.to_owned(),
            index: [index, other],
            kind: [channel.kind, second.channels[other].kind],
        };
        match layers.iter_mut().find(|known| known.name == layer) {
            Some(layer) => layer.channels.push(pair),
            None => layers.push(LayerPair {
                name: layer.to_owned(),
                channels: vec![pair],
            }),
        }
    }
    // Red, green and blue in their usual order, which files sort by name.
    let rank = |pair: &ChannelPair| RGBA.iter().position(|name| *name == pair.name);
    let rank = |pair: &ChannelPair| rank(pair).unwrap_or(RGBA.len());
    for layer in &mut layers {
        layer.channels.sort_by_key(rank);
    }
    layers.sort_by_key(|layer| layer.name != COLOR);
    layers
}

/// Names that the second picture lacks: layers, and channels of layers that it has.
fn only_in(first: &PictureLayout, second: &PictureLayout) -> Vec<String> {
    let others = indices(second);
    let has_layer = |layer: &str| others.keys().any(|name| split(name).0 == layer);
    let mut missing: Vec<String> = Vec::new();
    for channel in &first.channels {
        let (layer, _) = split(&channel.name);
        if others.contains_key(channel.name.as_str()) {
            continue;
        }
        let name = if has_layer(layer) { channel.name.as_str() } else { layer };
        if !missing.iter().any(|known| known == name) {
            missing.push(name.to_owned());
        }
    }
    missing
}
