//! Conversion of MTL's materials.
//!
//! The renderer's material is the document's: Ka is added unchanged, Ks weights both a highlight
//! and the mirror ray, and Kt the refracted ray. MTL has an ambient light of its own, highlights
//! without mirrors, and opacity, so its materials are converted:
//!
//! | material | from |
//! |---|---|
//! | Ka | 0.1 × `Ka` × `Kd` (1); 0.1 × `Kd` where `Ka` is missing, black, or equal to `Kd`; 0.1 × `Ka` with a `map_Ka` |
//! | Ke | `Ke`; times the texture of `map_Ke` (5, 6) |
//! | Kd | `Kd`, 0.8 if missing; 1 if missing or black with a texture (6) |
//! | Ks | `Ks` for `illum` 3 and more, unless `Ns` is 1 or less (8) |
//! | Ks, highlight, shininess | those of a glTF material for `illum` 2 and none, and 3 and more with such an `Ns`: reflectance `Ks` × 8 %, roughness by `Ns` (2); 0 for `illum` 0 and 1 |
//! | their textures | Ks and highlight times that of `map_Ks` (5, 6), shininess times that of `map_Ns` |
//! | opacity | `d`, or 1 − `Tr` where there is no `d` (3), 1 where that is 0 (7) |
//! | its texture | `map_d`: the picture's alpha, or its luminance where it has none (4) |
//! | Kt | (1 − `d`) × `Tf` for glass and coloured sheets (3), else 0 |
//! | shininess of mirrors | `Ns`; 1000 without it (8) |
//! | index of refraction | `Ni` for glass (3), else 1 |
//! | texture | `map_Kd`, or `map_Ka` where there is none; Ka and Kd are multiplied with it |
//! | normal | the texture of `norm`, or of `map_Bump` and `bump`, times `-bm` (9) |
//! | all of Ka, Kd, Ks, highlight, shininess | with `Pr`, `Pm`, `map_Pr` or `map_Pm`: as in glTF, with base colour `Kd`, roughness `Pr` and metallic `Pm` (10) |
//!
//! 1. The rest of the room is a tenth as bright as a lamp, and `Ka` is a tint of what it falls on:
//!    Blender writes `Ka 1 1 1` for every material.
//! 2. `illum` 3 and more request mirrors; 2 and none a highlight, which gets what glTF has for it.
//!    Blender writes the reflectance of its materials as `Ks`, with 0.5 for 4 %, and their
//!    roughness r as `Ns`: 900 (1 − r)² or 1000 (1 − r)², depending on its version. Roughness is
//!    set by hand, so the version is the one by which it is nearer to a hundredth.
//! 3. `illum` 4 and more with an `Ni` other than 1 is glass, which refracts light and casts a full
//!    shadow. Everything else with a `d` below 1 is a partly transparent surface, or, if its `Tf`
//!    is a colour, a sheet that transmits coloured light without bending it. Ka and Kd of glass and
//!    sheets are multiplied by `d`; coverage weights the whole surface.
//! 4. The alpha of `map_Kd` counts if `map_d` names the same file.
//! 5. 0 if the texture cannot be read: the whole surface would glow or mirror evenly.
//! 6. Maya and Google Poly write `Kd 0 0 0` for textured surfaces. The same holds for `Ke`, `Ks`,
//!    `Pr` and `Pm`, which count as 1 if missing or 0 with a texture.
//! 7. OpenMVS, mvs-texturing and MeshLab write `Tr 1` for opaque surfaces. It means clear for glass
//!    and with a coloured `Tf`, which request transmission. `d 0` means opaque if all materials of
//!    a file have it: Blender writes it where its slider of alpha was at 0, with an `illum` of
//!    glass.
//! 8. An `Ns` of at most 1 is no mirror: Blender, Unity, 3ds Max and others write `Ks 0.5` with an
//!    `Ns` of 0 or 1, or without one, for dull surfaces. `illum` 3 and more without `Ns` request
//!    only a mirror, and get a sharp one.
//! 9. Blender writes normal maps as `map_Bump`: a bluish picture is one, any other is heights, for
//!    which MTL has no unit.
//! 10. What is missing is 1 with a texture, else metallic 0, and the roughness of `Ns` (2).

use super::mtl::{MapKind, MtlMaterial};
use crate::metallic_roughness::{DIELECTRIC, PbrSurface};
use glam::Vec3;
use phalanx_scene::{Material, MetallicRoughness, NO_TEXTURE};
use std::collections::BTreeMap;

/// Rows of the textures that a material shows and that can be read.
pub(super) type MapTextures = BTreeMap<MapKind, u32>;

/// Brightness of the room relative to its lamps.
const AMBIENT: f32 = 0.1;
/// Reflectance of a mere highlight whose `Ks` is 1.
const GLOSS: f32 = 2.0 * DIELECTRIC;
/// The diffuse colour of a material without `Kd`.
const PLAIN: Vec3 = Vec3::splat(0.8);
/// Largest exponent that stands for no mirror.
const MATT: f32 = 1.0;
/// The exponent of a mirror that has none: the largest in use.
const SHARP: f32 = 1000.0;

impl MtlMaterial {
    /// The model of illumination.
    fn model(&self) -> f32 {
        self.illum.unwrap_or(2.0)
    }

    /// Returns true if the material names a texture of this kind.
    fn has(&self, kind: MapKind) -> bool {
        self.maps.contains_key(&kind)
    }

    fn refracts(&self) -> bool {
        self.model() >= 4.0 && self.ni > 0.0 && self.ni != 1.0
    }

    /// Returns true if nothing of the surface is there, and nothing passes through it.
    pub(super) fn is_invisible(&self) -> bool {
        self.d.is_some_and(|d| d <= 0.0) && !self.has_colored_filter()
    }

    /// Makes an invisible surface opaque. A model of glass asks only for what was invisible.
    pub(super) fn show(&mut self) {
        self.shown = true;
        self.d = Some(1.0);
        self.illum = self.illum.filter(|&illum| illum < 4.0);
    }

    fn has_colored_filter(&self) -> bool {
        self.tf.x != self.tf.y || self.tf.x != self.tf.z
    }

    /// Returns true for a `Tr 1` that means an opacity: nothing else indicates transparency.
    pub(super) fn tr_is_opacity(&self) -> bool {
        let clear = self.refracts() || self.has_colored_filter();
        self.d.is_none() && self.tr == Some(1.0) && !clear
    }

    /// Returns true for a black `Kd` that is only a placeholder for the texture.
    pub(super) fn kd_is_placeholder(&self) -> bool {
        self.kd == Some(Vec3::ZERO) && self.has(MapKind::Kd)
    }

    /// Returns true if `Ns` is the exponent of a mirror or a highlight.
    fn has_exponent(&self) -> bool {
        let mirror = self.model() >= 3.0;
        !self.is_pbr() && self.model() >= 2.0 && self.ns.map_or(mirror, |ns| ns > MATT)
    }

    /// The roughness that Blender writes as `Ns`.
    fn roughness(&self) -> f32 {
        let exponent = self.ns.unwrap_or(0.0);
        let [old, new] = [900.0, 1000.0].map(|most| 1.0 - (exponent / most).min(1.0).sqrt());
        let off = |roughness: f32| (roughness * 100.0 - (roughness * 100.0).round()).abs();
        if off(old) < off(new) { old } else { new }
    }

    fn is_pbr(&self) -> bool {
        self.pr.or(self.pm).is_some() || self.has(MapKind::Pr) || self.has(MapKind::Pm)
    }

    /// Returns true if the material shows the texture of a kind, if it can be read.
    pub(super) fn shows(&self, kind: MapKind) -> bool {
        match kind {
            MapKind::Ka => !self.has(MapKind::Kd),
            MapKind::Ks | MapKind::Ns => self.has_exponent(),
            MapKind::Bump => !self.has(MapKind::Norm),
            _ => true,
        }
    }

    /// Metallic and roughness, and true if a texture of `textures` varies them.
    fn lobes(&self, textures: &MapTextures) -> (MetallicRoughness, bool) {
        let [rough, metal] = [MapKind::Pr, MapKind::Pm].map(|kind| textures.contains_key(&kind));
        // Beneath a texture, what is missing or 0 is 1.
        let share = |number: Option<f32>, varied: bool, missing: f32| match number {
            None | Some(0.0) if varied => 1.0,
            number => number.unwrap_or(missing).clamp(0.0, 1.0),
        };
        let lobes = MetallicRoughness {
            metallic: share(self.pm, metal, 0.0),
            roughness: share(self.pr, rough, self.roughness()),
        };
        (lobes, rough || metal)
    }

    /// A colour that its texture multiplies: 0 if that cannot be read, 1 if it is only a
    /// placeholder.
    fn beneath(&self, color: Vec3, kind: MapKind, textures: &MapTextures) -> Vec3 {
        match (self.has(kind), textures.contains_key(&kind)) {
            (true, false) => Vec3::ZERO,
            (true, true) if color == Vec3::ZERO => Vec3::ONE,
            _ => color,
        }
    }

    /// The scene's material with these textures, by the table above.
    pub(super) fn to_material(&self, textures: &MapTextures, opacity_texture: u32) -> Material {
        let tr = self.tr.filter(|_| !self.tr_is_opacity());
        let d = self.d.or(tr.map(|tr| 1.0 - tr));
        let d = d.unwrap_or(1.0).clamp(0.0, 1.0);
        let refracts = self.refracts();
        let transmits = refracts || self.has_colored_filter() && d < 1.0;
        let (share, opacity) = if transmits { (d, 1.0) } else { (1.0, d) };
        let kd = match self.kd {
            Some(kd) if !self.kd_is_placeholder() => kd,
            None if !self.has(MapKind::Kd) && !self.has(MapKind::Ka) => PLAIN,
            _ => Vec3::ONE,
        };
        let is_own = |&ka: &Vec3| ka != Vec3::ZERO && self.kd != Some(ka);
        let ka = match self.ka.filter(is_own) {
            Some(ka) if self.has(MapKind::Ka) => ka,
            tint => tint.unwrap_or(Vec3::ONE) * kd,
        };
        let ks = self.beneath(self.ks, MapKind::Ks, textures);
        let texture = textures.get(&MapKind::Kd).or(textures.get(&MapKind::Ka));
        let texture = texture.copied().unwrap_or(NO_TEXTURE);
        let (lobes, varied) = self.lobes(textures);
        let surface = PbrSurface {
            color: kd * share,
            lobes,
            specular: if self.is_pbr() {
                Vec3::splat(DIELECTRIC)
            } else if self.model() >= 2.0 {
                ks * GLOSS
            } else {
                Vec3::ZERO
            },
            through: 0.0,
        };
        let colored = texture != NO_TEXTURE && surface.has_colored_mirror();
        let mut surface = surface.to_material(varied || colored);
        if !self.is_pbr() {
            surface.ka = ka * AMBIENT * share;
        }
        if self.model() >= 3.0 && self.has_exponent() {
            (surface.ks, surface.highlight) = (ks, Vec3::ZERO);
            surface.shininess = self.ns.unwrap_or(SHARP);
        }
        Material {
            ke: self.beneath(self.ke, MapKind::Ke, textures),
            kt: self.tf * (1.0 - share),
            ior: if refracts { self.ni } else { 1.0 },
            texture,
            opacity,
            opacity_texture,
            thin: transmits && !refracts,
            ..surface
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::mtl;
    use super::*;
    fn surface(body: &str) -> Material {
        let mut materials = mtl::read(format!("newmtl a\n{body}").as_bytes());
        let material = materials.pop().expect("a material");
        material.to_material(&MapTextures::new(), NO_TEXTURE)
    }

    #[test]
    fn the_illumination_model_decides_about_mirrors() {
        let lobes = |illum: &str| {
            let surface = surface(&format!("Ks 1 .5 0\nNs 50\n{illum}\n"));
            (surface.ks, surface.highlight)
        };
        let opaque = Vec3::new(1.0, 0.5, 0.0);
        for highlight in ["", "illum 2"] {
            assert_eq!(lobes(highlight), (Vec3::ZERO, opaque * GLOSS));
        }
        for none in [
            "illum 1",
            "illum 0",
            "illum 2\nmap_Ks a.png",
            "illum 5\nmap_Ks a.png",
        ] {
            assert_eq!(lobes(none), (Vec3::ZERO, Vec3::ZERO), "{none}");
        }
        for mirror in ["illum 3", "illum 5"] {
            assert_eq!(lobes(mirror), (opaque, Vec3::ZERO));
        }
        // The gloss of roughness 0.1: (1 − 2 · 0.1)².
        let polished = surface("Ks .5 .5 .5\nNs 810\nillum 2").ks;
        assert!(
            (polished - 0.04 * 0.64).abs().max_element() < 1e-6,
            "{polished}"
        );
    }

    #[test]
    fn an_exponent_without_a_lobe_is_matt() {
        for ns in ["", "Ns 0", "Ns 1", "Ns .5", "Ns -3", "Ns nan", "Ns"] {
            let dull = surface(&format!("Kd .6 .6 .6\nKs .5 .5 .5\n{ns}\nillum 2"));
            assert_eq!(dull.ks, Vec3::ZERO, "{ns}");
            assert!(dull.shininess < 0.5, "{ns}: {}", dull.shininess);
        }
        assert_eq!(surface("Ks 1\nNs 0\nillum 3").ks, Vec3::ZERO);
        assert_eq!(surface("Ks 1\nNs 1.5\nillum 3").ks, Vec3::ONE);
        let mirror = surface("Ks 1\nillum 3");
        assert_eq!((mirror.ks, mirror.shininess), (Vec3::ONE, SHARP));
    }

    #[test]
    fn opacity_of_glass_is_transmission() {
        let glass = surface("Kd 1 1 1\nd .25\nTr 0\nTf 1 .5 0\nNi 1.5\nillum 7");
        assert_eq!(glass.kt, Vec3::new(0.75, 0.375, 0.0));
        assert_eq!((glass.kd, glass.ior), (Vec3::splat(0.25), 1.5));
        assert_eq!((glass.opacity, glass.thin), (1.0, false));
    }

    #[test]
    fn opacity_of_anything_else_is_coverage() {
        for text in [
            "d .25",
            "d -halo .25",
            "Tr .75",
            "Tr .75\nNi 1.5",
            "d .25\nTr 1\nillum 4\nNi 1",
            "d .25\nTf .5 .5 .5",
        ] {
            let leaf = surface(&format!(
                "Ka 1 1 1\nKd 1 1 1\nKs 1 1 1\nNs 9\nillum 2\n{text}"
            ));
            assert_eq!(
                (leaf.opacity, leaf.kt, leaf.ior),
                (0.25, Vec3::ZERO, 1.0),
                "{text}"
            );
            assert_eq!((leaf.ka, leaf.kd), (Vec3::splat(0.1), Vec3::ONE));
            assert!(!leaf.thin && leaf.highlight.max(leaf.ks) != Vec3::ZERO);
        }
        for (text, opacity) in [("", 1.0), ("d 0", 0.0), ("d -1", 0.0), ("d 7", 1.0)] {
            assert_eq!(surface(text).opacity, opacity);
        }
    }

    #[test]
    fn tr_1_alone_is_opaque() {
        for (text, opacity) in [
            ("Tr 1.000000\nillum 1", 1.0),
            ("Tr 1\nNi 1.5\nillum 2", 1.0),
            ("Tr 0.99", 1.0 - 0.99),
            ("Tr 1\nd 0.5", 0.5),
            ("Tr 1\nd 0", 0.0),
            ("Tr 2", 0.0),
            ("Tr 0", 1.0),
        ] {
            let leaf = surface(text);
            assert_eq!((leaf.opacity, leaf.kt), (opacity, Vec3::ZERO), "{text}");
        }
        for clear in ["Tr 1\nNi 1.5\nillum 7", "Tr 1\nTf 1 .5 0"] {
            assert!(surface(clear).kt.x == 1.0, "{clear}");
        }
    }

    #[test]
    fn black_or_nothing_beneath_a_texture_is_white() {
        for (text, kd) in [
            ("Kd 0 0 0\nmap_Kd a.png", Vec3::ONE),
            ("Kd 0 0 0", Vec3::ZERO),
            ("Kd 0 .1 0\nmap_Kd a.png", Vec3::Y * 0.1),
            ("Kd 0\nmap_Ka a.png", Vec3::ZERO),
            ("map_Kd a.png", Vec3::ONE),
            ("map_Ka a.png", Vec3::ONE),
            ("map_Bump a.png", PLAIN),
        ] {
            let textured = surface(text);
            assert_eq!((textured.kd, textured.ka), (kd, kd * AMBIENT), "{text}");
        }
    }

    #[test]
    fn a_coloured_filter_is_a_sheet() {
        let sheet = surface("Kd 1 1 1\nd .25\nTf 1 .5 0\nNi 1.5");
        assert_eq!(sheet.kt, Vec3::new(0.75, 0.375, 0.0));
        assert_eq!((sheet.kd, sheet.ior), (Vec3::splat(0.25), 1.0));
        assert_eq!((sheet.opacity, sheet.thin), (1.0, true));
        let filtered = surface("Tf 1 .5 0");
        assert_eq!(
            (filtered.kt, filtered.opacity, filtered.thin),
            (Vec3::ZERO, 1.0, false)
        );
    }

    #[test]
    fn ka_is_a_tint_of_kd() {
        for (text, ka) in [
            ("Ka 1 1 1\nKd .4 .05 .02", Vec3::new(0.4, 0.05, 0.02)),
            ("Ka 1 .5 0\nKd .5 .5 .5", Vec3::new(0.5, 0.25, 0.0)),
            ("Ka 1 1 1\nKd .5 .5 .5\nmap_Kd a.png", Vec3::splat(0.5)),
            // As exporters write it that have no colour of their own for it.
            ("Ka .6 .6 .6\nKd .6 .6 .6", Vec3::splat(0.6)),
            ("Ka 1 1 1\nKd 0 0 0", Vec3::ZERO),
            ("Ka 1 1 1\nKd .5 .5 .5\nmap_Ka a.png", Vec3::ONE),
        ] {
            let actual = surface(text).ka;
            assert!(
                (actual - ka * AMBIENT).abs().max_element() < 1e-7,
                "{text}: {actual}"
            );
        }
    }

    #[test]
    fn exponents_are_roughness_as_blender_writes_it() {
        // Old versions write 900 (1 − r)², later ones 1000 (1 − r)².
        for (ns, roughness) in [
            ("272.250012", 0.45f32),
            ("323.999994", 0.4),
            ("225.000000", 0.5),
            ("359.999993", 0.4),
            ("250.000000", 0.5),
            ("640.000000", 0.2),
        ] {
            let actual = surface(&format!("Ks .5\nNs {ns}\nillum 2")).shininess;
            let expected = 2.0 / (roughness * roughness * roughness * roughness) - 2.0;
            assert!(
                (actual / expected - 1.0).abs() < 1e-4,
                "{ns}: {actual}, not {expected}"
            );
        }
        assert_eq!(surface("Ks .5\nNs 1000\nillum 2").shininess, 10_000.0);
        assert_eq!(surface("Ks .5\nNs 1e9\nillum 2").shininess, 10_000.0);
    }

    #[test]
    fn ambient_light_is_a_tenth_of_a_lamp() {
        assert_eq!(surface("Kd 1 .5 0").ka, Vec3::new(0.1, 0.05, 0.0));
        assert_eq!(surface("Ka 0 0 0\nKd 1 .5 0").ka, Vec3::new(0.1, 0.05, 0.0));
        let lamp = surface("Ke 2 3 4\nNs 80\nillum 3");
        assert_eq!((lamp.ke, lamp.shininess), (Vec3::new(2.0, 3.0, 4.0), 80.0));
        assert_eq!(surface("Ke 2 3 4\nmap_Ke a.png").ke, Vec3::ZERO);
    }
}
