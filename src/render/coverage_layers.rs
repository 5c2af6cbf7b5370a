//! Layers of a pixel with the surfaces that cover it.

use phalanx_scene::film::{Aov, Aovs, TileBuffer};
use phalanx_scene::sampling::PixelCoverage;
use phalanx_scene::{MatteIds, Scene};

/// Writes the layers of coverage that the tile has.
pub(super) fn write_coverage(
    pixels: &mut TileBuffer,
    (x, y): (u32, u32),
    coverage: &PixelCoverage,
) {
    let aovs = pixels.aovs();
    if aovs.has(Aov::Alpha) {
        pixels.set_layer(x, y, Aov::Alpha, &[coverage.alpha()]);
    }
    for (table, aov) in [Aov::CryptoObject, Aov::CryptoMaterial]
        .into_iter()
        .enumerate()
    {
        if aovs.has(aov) {
            pixels.set_layer(x, y, aov, &coverage.ranks(table));
        }
    }
}

/// Identifiers of surfaces for layers of coverage, if there are any: those of the scene, or none if
/// only the shares are needed.
pub(super) fn mattes_for(scene: &Scene, aovs: Aovs) -> Option<MatteIds> {
    let ids = || {
        if aovs.of_mattes() { MatteIds::of(scene) } else { MatteIds::default() }
    };
    aovs.of_coverage().then(ids)
}
