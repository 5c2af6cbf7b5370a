//! Conversion of MTL's materials.
//!
//! The renderer's material is the document's: Ka is added unchanged, Ks weights both the highlight
//! and the mirror ray, and Kt the refracted ray. MTL has an ambient light of its own, highlights
//! without mirrors, and opacity, so its materials are converted:
//!
//! | material | from |
//! |---|---|
//! | Ka | 0.1 × `Ka` (1); 0.1 × `Kd` where `Ka` is missing or black |
//! | Ke | `Ke`; times the texture of `map_Ke` (5, 6) |
//! | Kd | `Kd`, 0.8 if missing; 1 if missing or black with a texture (6) |
//! | Ks | `Ks` for `illum` 3 and more; 0.15 × `Ks` for 2 and none; 0 for 0 and 1 (2), and for matt materials (8); times the texture of `map_Ks` (5, 6) |
//! | opacity | `d`, or 1 − `Tr` where there is no `d` (3), 1 where that is 0 (7) |
//! | its texture | `map_d`: the picture's alpha, or its luminance where it has none (4) |
//! | Kt | (1 − `d`) × `Tf` for glass and coloured sheets (3), else 0 |
//! | shininess | `Ns`; 1000 for a mirror without it (8); times the texture of `map_Ns` |
//! | index of refraction | `Ni` for glass (3), else 1 |
//! | texture | `map_Kd`, or `map_Ka` where there is none; Ka and Kd are multiplied with it |
//! | normal | the texture of `norm`, or of `map_Bump` and `bump`, times `-bm` (9) |
//! | all of Ka, Kd, Ks, shininess | with `Pr`, `Pm`, `map_Pr` or `map_Pm`: as in glTF, with base colour `Kd`, roughness `Pr` and metallic `Pm` (10) |
//!
//! 1. The rest of the room is a tenth as bright as a lamp.
//! 2. `illum` 3 and more request mirrors. 2 and none request a highlight, which gets a faint sheen.
//! 3. `illum` 4 and more with an `Ni` other than 1 is glass, which refracts light and casts a full
//!    shadow. Everything else with a `d` below 1 is a partly transparent surface, or, if its `Tf`
//!    is a colour, a sheet that transmits coloured light without bending it. Ka and Kd of glass and
//!    sheets are multiplied by `d`; coverage weights the whole surface.
//! 4. The alpha of `map_Kd` counts if `map_d` names the same file.
//! 5. 0 if the texture cannot be read: the whole surface would glow or mirror evenly.
//! 6. Maya and Google Poly write `Kd 0 0 0` for textured surfaces. The same holds for `Ke` and
//!    `Ks`, which count as 1 if missing or black with a texture.
//! 7. OpenMVS, mvs-texturing and MeshLab write `Tr 1` for opaque surfaces. It means clear for glass
//!    and with a coloured `Tf`, which request transmission.
//! 8. An `Ns` of at most 1, or none, means that there is no highlight: Blender, Unity, 3ds Max and
//!    others write `Ks 0.5` with an `Ns` of 0 or 1, or without one, for dull surfaces. A lobe of
//!    such an exponent is at least as wide as the diffuse light: a white film over all that is lit,
//!    with a hard edge where the light ends, and a clear image of the sky on a rough surface.
//!    `illum` 3 and more without `Ns` request only a mirror, and get a sharp one.
//! 9. Blender writes normal maps as `map_Bump`: a bluish picture is one, any other is heights, for
//!    which MTL has no unit.
//! 10. What is missing is 1 with a texture, else metallic 0, and the roughness of `Ns`: the one
//!     whose exponent in glTF's table is `Ns`.

use super::mtl::{MapKind, MtlMaterial};
use crate::metallic_roughness::{DIELECTRIC, PbrSurface};
use glam::Vec3;
use phalanx_scene::{Material, MetallicRoughness, NO_TEXTURE};
use std::collections::BTreeMap;

/// Rows of the textures that a material shows and that can be read.
pub(super) type MapTextures = BTreeMap<MapKind, u32>;

/// Brightness of the room relative to its lamps.
const AMBIENT: f32 = 0.1;
/// Share of a mere highlight that is a mirror.
const SHEEN: f32 = 0.15;
/// The diffuse colour of a material without `Kd`.
const PLAIN: Vec3 = Vec3::splat(0.8);
/// Largest exponent that stands for no highlight.
const MATT: f32 = 1.0;
/// The exponent of a mirror that has none: the largest in use.
const SHARP: f32 = 1000.0;

impl MtlMaterial {
    fn refracts(&self) -> bool {
        self.illum.is_some_and(|illum| illum >= 4.0) && self.ni > 0.0 && self.ni != 1.0
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
        self.kd == Some(Vec3::ZERO) && self.maps.contains_key(&MapKind::Kd)
    }

    /// Share of Ks that is a mirror, without regard to its texture.
    fn mirror(&self) -> f32 {
        let illum = self.illum.unwrap_or(2.0);
        match self.ns.map_or(illum < 3.0, |ns| ns <= MATT) {
            false if illum >= 3.0 => 1.0,
            false if illum >= 2.0 => SHEEN,
            _ => 0.0,
        }
    }

    fn is_pbr(&self) -> bool {
        let maps = [MapKind::Pr, MapKind::Pm].map(|kind| self.maps.contains_key(&kind));
        self.pr.is_some() || self.pm.is_some() || maps.contains(&true)
    }

    /// Returns true if the material shows the texture of a kind, if it can be read.
    pub(super) fn shows(&self, kind: MapKind) -> bool {
        match kind {
            MapKind::Ka => !self.maps.contains_key(&MapKind::Kd),
            MapKind::Ks | MapKind::Ns => !self.is_pbr() && self.mirror() > 0.0,
            MapKind::Bump => !self.maps.contains_key(&MapKind::Norm),
            _ => true,
        }
    }

    /// Metallic and roughness, and true if a texture of `textures` varies them.
    fn lobes(&self, textures: &MapTextures) -> (MetallicRoughness, bool) {
        let [rough, metal] = [MapKind::Pr, MapKind::Pm].map(|kind| textures.contains_key(&kind));
        let exponent = self.ns.unwrap_or(MATT).max(0.0);
        let of_exponent = (2.0 / (exponent + 2.0)).sqrt().sqrt();
        let metallic = self.pm.unwrap_or(if metal { 1.0 } else { 0.0 });
        let roughness = self.pr.unwrap_or(if rough { 1.0 } else { of_exponent });
        let lobes = MetallicRoughness {
            metallic: metallic.clamp(0.0, 1.0),
            roughness: roughness.clamp(0.0, 1.0),
        };
        (lobes, rough || metal)
    }

    /// A colour that its texture multiplies: 0 if that cannot be read, 1 if it is only a
    /// placeholder.
    fn beneath(&self, color: Vec3, kind: MapKind, textures: &MapTextures) -> Vec3 {
        match (self.maps.contains_key(&kind), textures.contains_key(&kind)) {
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
        let (there, opacity) = if transmits { (d, 1.0) } else { (1.0, d) };
        let textured = [MapKind::Kd, MapKind::Ka].map(|kind| self.maps.contains_key(&kind));
        let textured = textured.contains(&true);
        let kd = match self.kd {
            Some(kd) if !self.kd_is_placeholder() => kd,
            None if !textured => PLAIN,
            _ => Vec3::ONE,
        };
        let ka = self.ka.filter(|&ka| ka != Vec3::ZERO).unwrap_or(kd);
        let texture = textures.get(&MapKind::Kd).or(textures.get(&MapKind::Ka));
        let texture = texture.copied().unwrap_or(NO_TEXTURE);
        let surface = if self.is_pbr() {
            let (lobes, varied) = self.lobes(textures);
            let surface = PbrSurface {
                color: kd * there,
                lobes,
                specular: Vec3::splat(DIELECTRIC),
                through: 0.0,
            };
            let colored = texture != NO_TEXTURE && surface.has_colored_mirror();
            surface.to_material(varied || colored)
        } else {
            Material {
                ka: ka * AMBIENT * there,
                kd: kd * there,
                ks: self.beneath(self.ks, MapKind::Ks, textures) * self.mirror(),
                shininess: self.ns.unwrap_or(SHARP),
                ..Material::DEFAULT
            }
        };
        Material {
            ke: self.beneath(self.ke, MapKind::Ke, textures),
            kt: if transmits {
                self.tf * (1.0 - d)
            } else {
                Vec3::ZERO
            },
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
        let ks = |illum: &str| surface(&format!("Ks 1 .5 0\nNs 50\n{illum}\n")).ks;
        let whole = Vec3::new(1.0, 0.5, 0.0);
        assert_eq!(ks(""), whole * SHEEN);
        assert_eq!(ks("illum 2"), whole * SHEEN);
        assert_eq!(ks("illum 1"), Vec3::ZERO);
        assert_eq!(ks("illum 0"), Vec3::ZERO);
        assert_eq!(ks("illum 3"), whole);
        assert_eq!(ks("illum 5"), whole);
        assert_eq!(ks("illum 5\nmap_Ks a.png"), Vec3::ZERO);
    }

    #[test]
    fn an_exponent_without_a_highlight_is_matt() {
        for ns in ["", "Ns 0", "Ns 1", "Ns .5", "Ns -3", "Ns nan", "Ns"] {
            let dull = surface(&format!("Kd .6 .6 .6\nKs .5 .5 .5\n{ns}\nillum 2"));
            assert_eq!(dull.ks, Vec3::ZERO, "{ns}");
        }
        assert_eq!(surface("Ks 1\nNs 0\nillum 3").ks, Vec3::ZERO);
        assert_eq!(surface("Ks 1\nNs 1.5").ks, Vec3::splat(SHEEN));
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
            assert!(!leaf.thin && leaf.ks != Vec3::ZERO);
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
        let whole = surface("Tf 1 .5 0");
        assert_eq!(
            (whole.kt, whole.opacity, whole.thin),
            (Vec3::ZERO, 1.0, false)
        );
    }

    #[test]
    fn ambient_light_is_a_tenth_of_a_lamp() {
        assert_eq!(surface("Kd 1 .5 0").ka, Vec3::new(0.1, 0.05, 0.0));
        assert_eq!(surface("Ka 0 0 0\nKd 1 .5 0").ka, Vec3::new(0.1, 0.05, 0.0));
        assert_eq!(surface("Ka 1\nKd 1 .5 0").ka, Vec3::splat(0.1));
        let lamp = surface("Ke 2 3 4\nNs 80");
        assert_eq!((lamp.ke, lamp.shininess), (Vec3::new(2.0, 3.0, 4.0), 80.0));
        assert_eq!(surface("Ke 2 3 4\nmap_Ke a.png").ke, Vec3::ZERO);
    }
}
