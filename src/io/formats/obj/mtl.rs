//! MTL: named materials, and their conversion.
//!
//! The renderer's material is the document's: Ka is added as it is, Ks weighs both the highlight
//! and the mirror ray, and Kt the refracted ray. MTL has an ambient light of its own, highlights
//! without mirrors, and opacity. So they are converted:
//!
//! | material | from |
//! |---|---|
//! | Ka | 0.1 × `Ka` (1); 0.1 × `Kd` where `Ka` is missing or black |
//! | Ke | `Ke` |
//! | Kd | `Kd`, 0.8 if missing |
//! | Ks | `Ks` for `illum` 3 and more; 0.15 × `Ks` for 2 and none; 0 for 0 and 1 (2) |
//! | Kt | (1 - `d`) × `Tf`; `Tr` is 1 - `d`, and is ignored if there is a `d` |
//! | shininess | `Ns` |
//! | index of refraction | `Ni` for `illum` 4 and more; else 1 (3) |
//! | texture | `map_Kd`, which is multiplied with Ka and Kd |
//!
//! 1. The rest of the room is a tenth as bright as a lamp.
//! 2. `illum` 3 and more ask for mirrors. 2 and none ask for a highlight, which gets a faint sheen.
//! 3. A thin surface lets light through unbent.
//!
//! Ka and Kd are multiplied by `d`. Other statements are ignored.

use super::cursor::Cursor;
use crate::formats::diagnostics::Span;
use crate::formats::mesh::{ParseError, ParseErrors};
use glam::Vec3;
use phalanx_scene::{Material, Wrap};

/// Brightness of the room relative to its lamps.
const AMBIENT: f32 = 0.1;
/// Share of a mere highlight that is a mirror.
const SHEEN: f32 = 0.15;
/// The diffuse colour of a material without `Kd`.
const PLAIN: Vec3 = Vec3::splat(0.8);

/// A material as the file has it.
#[derive(Debug)]
pub(super) struct MtlMaterial {
    /// The name, as bytes: as text, different names that are not UTF-8 could become equal.
    pub(super) name: Vec<u8>,
    ka: Option<Vec3>,
    kd: Option<Vec3>,
    ks: Vec3,
    ke: Vec3,
    tf: Vec3,
    ns: f32,
    ni: f32,
    d: Option<f32>,
    tr: Option<f32>,
    illum: Option<f32>,
    /// The diffuse texture.
    pub(super) map: Option<TextureMap>,
}

/// A texture that a material names.
#[derive(Clone, Debug)]
pub(super) struct TextureMap {
    pub(super) file: String,
    pub(super) wrap: [Wrap; 2],
}

impl MtlMaterial {
    fn new(name: Vec<u8>) -> MtlMaterial {
        MtlMaterial {
            name,
            ka: None,
            kd: None,
            ks: Vec3::ZERO,
            ke: Vec3::ZERO,
            tf: Vec3::ONE,
            ns: 1.0,
            ni: 1.0,
            d: None,
            tr: None,
            illum: None,
            map: None,
        }
    }

    /// The scene's material, by the table above.
    pub(super) fn to_material(&self, texture: u32) -> Material {
        let illum = self.illum.unwrap_or(2.0);
        let mirror = match illum {
            i if i >= 3.0 => 1.0,
            i if i >= 2.0 => SHEEN,
            _ => 0.0,
        };
        let opacity = self.d.or(self.tr.map(|tr| 1.0 - tr));
        let opacity = opacity.unwrap_or(1.0).clamp(0.0, 1.0);
        let kd = self.kd.unwrap_or(PLAIN);
        let ka = self.ka.filter(|&ka| ka != Vec3::ZERO).unwrap_or(kd);
        Material {
            ka: ka * AMBIENT * opacity,
            ke: self.ke,
            kd: kd * opacity,
            ks: self.ks * mirror,
            kt: self.tf * (1.0 - opacity),
            shininess: self.ns.max(0.0),
            ior: if illum >= 4.0 && self.ni > 0.0 {
                self.ni
            } else {
                1.0
            },
            texture,
            ..Material::DEFAULT
        }
    }
}

/// A material file: the parts of it that could be read.
#[derive(Debug, Default)]
pub(super) struct MtlFile {
    pub(super) materials: Vec<MtlMaterial>,
    pub(super) errors: ParseErrors,
}

/// Reads an MTL file.
pub(super) fn read(text: &[u8]) -> MtlFile {
    let mut library = MtlFile::default();
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let mut cursor = Cursor { text, at: 0 };
    loop {
        cursor.skip_to_statement();
        if cursor.is_at_end() || library.errors.is_full() {
            return library;
        }
        if cursor.peek() != Some(b'#')
            && let Err(error) = statement(&mut cursor, &mut library.materials)
        {
            library.errors.push(error);
        }
        cursor.skip_statement();
    }
}

fn statement(cursor: &mut Cursor, materials: &mut Vec<MtlMaterial>) -> Result<(), ParseError> {
    let name = cursor.word();
    let keyword = cursor.bytes(name);
    if keyword == b"newmtl" {
        let name = cursor.rest_of_line();
        materials.push(MtlMaterial::new(cursor.bytes(name).to_vec()));
        return Ok(());
    }
    // Before the first `newmtl` there is no material to which a statement could apply.
    let Some(material) = materials.last_mut() else {
        return Ok(());
    };
    match keyword {
        b"Ka" => material.ka = color(cursor)?.or(material.ka),
        b"Kd" => material.kd = color(cursor)?.or(material.kd),
        b"Ks" => material.ks = color(cursor)?.unwrap_or(material.ks),
        b"Ke" => material.ke = color(cursor)?.unwrap_or(material.ke),
        b"Tf" => material.tf = color(cursor)?.unwrap_or(material.tf),
        b"Ns" => material.ns = number(cursor)?,
        b"Ni" => material.ni = number(cursor)?,
        b"d" => {
            skip_option(cursor, b"-halo", 0);
            material.d = Some(number(cursor)?);
        }
        b"Tr" => material.tr = Some(number(cursor)?),
        b"illum" => material.illum = Some(number(cursor)?),
        b"map_Kd" => material.map = map(cursor),
        _ => {}
    }
    Ok(())
}

/// One number for grey, or three. `None` for a colour by spectral curves or in CIE XYZ, which is
/// left out.
fn color(cursor: &mut Cursor) -> Result<Option<Vec3>, ParseError> {
    cursor.skip_blanks();
    let rest = cursor.text.get(cursor.at..).unwrap_or_default();
    if rest.starts_with(b"spectral") || rest.starts_with(b"xyz") {
        return Ok(None);
    }
    let r = number(cursor)?;
    if cursor.at_statement_end() {
        return Ok(Some(Vec3::splat(r)));
    }
    let (g, b) = (number(cursor)?, number(cursor)?);
    Ok(Some(Vec3::new(r, g, b)))
}

fn number(cursor: &mut Cursor) -> Result<f32, ParseError> {
    cursor.skip_blanks();
    let start = cursor.at;
    let value = cursor.float()?;
    if value.is_finite() {
        return Ok(value);
    }
    let span = Span::between(start, cursor.at);
    let message = format!("{} is not a finite number", cursor.quoted(span));
    Err(ParseError::new(span, message))
}

/// Passes an option and its operands, if there is one here.
fn skip_option(cursor: &mut Cursor, option: &[u8], operands: usize) -> bool {
    let mut ahead = *cursor;
    let word = ahead.word();
    if ahead.bytes(word) != option {
        return false;
    }
    (0..operands).for_each(|_| {
        ahead.word();
    });
    *cursor = ahead;
    true
}

/// Options with a fixed number of operands, and those with up to three numbers.
const OPTIONS: [(&[u8], usize); 10] = [
    (b"-blendu", 1),
    (b"-blendv", 1),
    (b"-boost", 1),
    (b"-bm", 1),
    (b"-cc", 1),
    (b"-imfchan", 1),
    (b"-mm", 2),
    (b"-texres", 1),
    (b"-type", 1),
    (b"-colorspace", 1),
];
const VECTORS: [&[u8]; 3] = [b"-o", b"-s", b"-t"];

/// A file name after options, of which all but `-clamp` are ignored.
fn map(cursor: &mut Cursor) -> Option<TextureMap> {
    let mut wrap = [Wrap::Repeat; 2];
    loop {
        let mut ahead = *cursor;
        let option = ahead.word();
        if ahead.bytes(option) == b"-clamp" {
            let on = ahead.word();
            if ahead.bytes(on) == b"on" {
                wrap = [Wrap::Clamp; 2];
            }
            *cursor = ahead;
        } else if VECTORS.contains(&ahead.bytes(option)) {
            *cursor = ahead;
            for _ in 0..3 {
                if cursor.float().is_err() {
                    break;
                }
                ahead = *cursor;
            }
            *cursor = ahead;
        } else if !OPTIONS
            .iter()
            .any(|&(option, operands)| skip_option(cursor, option, operands))
        {
            break;
        }
    }
    let file = cursor.rest_of_line();
    let file = name_of(cursor, file);
    (!file.is_empty()).then_some(TextureMap { file, wrap })
}

/// A name as text.
pub(super) fn name_of(cursor: &Cursor, span: Span) -> String {
    String::from_utf8_lossy(cursor.bytes(span)).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use phalanx_scene::NO_TEXTURE;

    fn one(body: &str) -> MtlMaterial {
        let mut library = read(format!("newmtl a b \r\n{body}").as_bytes());
        assert!(library.errors.is_empty(), "{body}: {:?}", library.errors);
        library.materials.pop().expect("a material")
    }

    fn surface(body: &str) -> Material {
        one(body).to_material(NO_TEXTURE)
    }

    #[test]
    fn names_may_hold_blanks() {
        assert_eq!(one("").name, b"a b");
    }

    #[test]
    fn the_illumination_model_decides_about_mirrors() {
        let ks = |illum: &str| surface(&format!("Ks 1 .5 0\n{illum}\n")).ks;
        let whole = Vec3::new(1.0, 0.5, 0.0);
        assert_eq!(ks(""), whole * SHEEN);
        assert_eq!(ks("illum 2"), whole * SHEEN);
        assert_eq!(ks("illum 1"), Vec3::ZERO);
        assert_eq!(ks("illum 0"), Vec3::ZERO);
        assert_eq!(ks("illum 3"), whole);
        assert_eq!(ks("illum 5"), whole);
    }

    #[test]
    fn opacity_becomes_transmission() {
        let glass = surface("Kd 1 1 1\nd .25\nTr 0\nTf 1 .5 0\nNi 1.5\nillum 7");
        assert_eq!(glass.kt, Vec3::new(0.75, 0.375, 0.0));
        assert_eq!(glass.kd, Vec3::splat(0.25));
        assert_eq!(glass.ior, 1.5);
        let leaf = surface("Tr .5\nNi 1.5");
        assert_eq!((leaf.kt, leaf.ior), (Vec3::splat(0.5), 1.0));
        assert_eq!(surface("d -halo .5").kt, Vec3::splat(0.5));
    }

    #[test]
    fn ambient_light_is_a_tenth_of_a_lamp() {
        assert_eq!(surface("Kd 1 .5 0").ka, Vec3::new(0.1, 0.05, 0.0));
        assert_eq!(surface("Ka 0 0 0\nKd 1 .5 0").ka, Vec3::new(0.1, 0.05, 0.0));
        assert_eq!(surface("Ka 1\nKd 1 .5 0").ka, Vec3::splat(0.1));
        let lamp = surface("Ke 2 3 4\nNs 80");
        assert_eq!((lamp.ke, lamp.shininess), (Vec3::new(2.0, 3.0, 4.0), 80.0));
    }

    #[test]
    fn options_before_a_texture_are_passed() {
        let file = |line: &str| one(line).map.map(|map| (map.file, map.wrap));
        let repeated = |name: &str| Some((String::from(name), [Wrap::Repeat; 2]));
        assert_eq!(file("map_Kd wood.png"), repeated("wood.png"));
        assert_eq!(
            file("map_Kd  two words.png \r\n"),
            repeated("two words.png")
        );
        assert_eq!(
            file("map_Kd -s 1 2 3 -o .5 -bm 0.2 -mm 0 1 -blendu on 2.png"),
            repeated("2.png")
        );
        assert_eq!(
            file("map_Kd -s 1 1 1 -clamp on a.png"),
            Some(("a.png".into(), [Wrap::Clamp; 2]))
        );
        assert_eq!(file("map_Kd -clamp off a.png"), repeated("a.png"));
        assert_eq!(file("map_Kd"), None);
    }

    #[test]
    fn a_bad_number_is_a_fault_and_other_statements_are_ignored() {
        let library =
            read(b"Kd x\nnewmtl a\nKd 1 0\nNs nan\nKs spectral a.rfl 1\nwhat 5\nKd 1 1 1\n");
        assert_eq!(library.materials.len(), 1);
        let faults = format!("{:?}", library.errors);
        assert!(
            faults.contains("a number is missing") && faults.contains("finite"),
            "{faults}"
        );
    }
}
