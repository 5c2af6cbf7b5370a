//! MTL: named materials, as their file has them. Keywords may be in any case of letters.

use super::cursor::{Cursor, KEYWORD_BYTES};
use super::name::without_comment;
use super::texture_map::{self, MtlTexture};
use crate::diagnostics::{MAX_DIAGNOSTICS, Span};
use crate::text::mark_length;
use glam::Vec3;
use std::collections::BTreeMap;

/// A material as the file has it.
#[derive(Debug, Default)]
pub(super) struct MtlMaterial {
    /// Span of the name, perhaps with a comment behind it.
    pub(super) name: Span,
    pub(super) ka: Option<Vec3>,
    pub(super) kd: Option<Vec3>,
    pub(super) ks: Vec3,
    pub(super) ke: Vec3,
    pub(super) tf: Vec3,
    pub(super) ns: Option<f32>,
    pub(super) ni: f32,
    pub(super) d: Option<f32>,
    pub(super) tr: Option<f32>,
    /// Keywords of the last `Kd`, the last `d` and the last `Tr`.
    pub(super) kd_keyword: Span,
    pub(super) d_keyword: Span,
    pub(super) tr_keyword: Span,
    /// Keyword of the first number that must not be negative and was, and is 0 now.
    pub(super) negative: Option<Span>,
    /// True for a `d 0` that is no opacity, because all materials of the file have it.
    pub(super) shown: bool,
    pub(super) illum: Option<f32>,
    /// Roughness and metallic of the PBR extension.
    pub(super) pr: Option<f32>,
    pub(super) pm: Option<f32>,
    pub(super) maps: BTreeMap<MapKind, MtlTexture>,
    /// Statements and options that are omitted, each kind once, and at most [`MAX_DIAGNOSTICS`].
    pub(super) left_out: Vec<MtlOmission>,
}

/// Parameter for which a statement names a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum MapKind {
    Kd,
    Ka,
    D,
    Ke,
    Ks,
    Ns,
    Pr,
    Pm,
    /// A normal map.
    Norm,
    /// Heights, or a normal map: exporters write either.
    Bump,
}

impl MapKind {
    /// The kind of a keyword in lower case.
    fn of(keyword: &[u8]) -> Option<MapKind> {
        Some(match keyword {
            b"map_kd" => MapKind::Kd,
            b"map_ka" => MapKind::Ka,
            b"map_d" => MapKind::D,
            b"map_ke" => MapKind::Ke,
            b"map_ks" => MapKind::Ks,
            b"map_ns" => MapKind::Ns,
            b"map_pr" => MapKind::Pr,
            b"map_pm" => MapKind::Pm,
            b"norm" | b"map_norm" | b"map_normal" | b"map_kn" => MapKind::Norm,
            b"map_bump" | b"bump" => MapKind::Bump,
            _ => return None,
        })
    }
}

/// Something that is omitted: the span of its keyword, and the reason if there is a particular one.
#[derive(Clone, Copy, Debug)]
pub(super) struct MtlOmission {
    pub(super) keyword: Span,
    pub(super) reason: &'static str,
}

/// The reason for statements without an equivalent in the renderer's materials.
const NOT_SHOWN: &str = "not shown";
const NO_NUMBER: &str = "a number is missing, or is none";
const NOT_FINITE: &str = "a number that is not finite";
const NO_NAME: &str = "no name of a file";
const NO_SPECTRUM: &str = "colours are read as red, green and blue only";

impl MtlMaterial {
    fn new(name: Span) -> MtlMaterial {
        MtlMaterial {
            name,
            tf: Vec3::ONE,
            ni: 1.0,
            kd_keyword: name,
            d_keyword: name,
            tr_keyword: name,
            ..MtlMaterial::default()
        }
    }

    /// Takes a number as 0 that must not be negative.
    fn at_least_zero(&mut self, number: f32, keyword: Span) -> f32 {
        if number < 0.0 {
            self.negative.get_or_insert(keyword);
        }
        number.max(0.0)
    }

    /// Sets the parameter of a keyword in lower case; else returns the reason why the statement is
    /// omitted. `name` is the keyword's span.
    fn set(&mut self, keyword: &[u8], name: Span, cursor: &mut Cursor) -> Result<(), &'static str> {
        match keyword {
            b"ka" => self.ka = Some(self.color(name, cursor)?),
            b"kd" => (self.kd, self.kd_keyword) = (Some(self.color(name, cursor)?), name),
            b"ks" => self.ks = self.color(name, cursor)?,
            b"ke" => self.ke = self.color(name, cursor)?,
            b"tf" => self.tf = self.color(name, cursor)?,
            b"ns" => self.ns = Some(self.at_least_zero(number(cursor)?, name)),
            b"ni" => self.ni = number(cursor)?,
            b"d" => {
                texture_map::skip_option(cursor, b"-halo", 0);
                (self.d, self.d_keyword) = (Some(number(cursor)?), name);
            }
            b"tr" => (self.tr, self.tr_keyword) = (Some(number(cursor)?), name),
            b"illum" => self.illum = Some(number(cursor)?),
            b"pr" => self.pr = Some(number(cursor)?),
            b"pm" => self.pm = Some(number(cursor)?),
            _ => {
                let kind = MapKind::of(keyword).ok_or(NOT_SHOWN)?;
                let leave_out = |cursor: &Cursor, option| self.leave_out(cursor, option, NOT_SHOWN);
                let map = texture_map::read(cursor, leave_out).ok_or(NO_NAME)?;
                self.maps.insert(kind, map);
            }
        }
        Ok(())
    }

    fn color(&mut self, keyword: Span, cursor: &mut Cursor) -> Result<Vec3, &'static str> {
        Ok(color(cursor)?.map(|c| self.at_least_zero(c, keyword)))
    }

    /// Notes something that is omitted, unless its kind is known to be.
    fn leave_out(&mut self, cursor: &Cursor, keyword: Span, reason: &'static str) {
        let text = cursor.bytes(keyword);
        let same = |other: &MtlOmission| {
            other.reason == reason && cursor.bytes(other.keyword).eq_ignore_ascii_case(text)
        };
        if self.left_out.len() < MAX_DIAGNOSTICS && !self.left_out.iter().any(same) {
            self.left_out.push(MtlOmission { keyword, reason });
        }
    }
}

/// Number of materials that a text may have, at most.
pub(super) fn most_materials(text: &[u8]) -> u64 {
    let starts = memchr::memchr2_iter(b'n', b'N', text);
    let named = |&position: &usize| {
        let word = text.get(position..position + 6);
        word.is_some_and(|word| word.eq_ignore_ascii_case(b"newmtl"))
    };
    starts.filter(named).count() as u64
}

/// Reads an MTL file. Statements that are broken are omitted.
pub(super) fn read(text: &[u8]) -> Vec<MtlMaterial> {
    let mut materials = Vec::new();
    let mut cursor = Cursor {
        text,
        at: mark_length(text),
    };
    loop {
        cursor.skip_to_statement();
        if cursor.is_at_end() {
            return materials;
        }
        if cursor.peek() != Some(b'#') {
            statement(&mut cursor, &mut materials);
        }
        cursor.skip_statement();
    }
}

/// Names of files in a text, also of those that are not shown.
pub(super) fn named_files(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    const KEYWORDS: [&[u8]; 6] = [b"map_", b"bump", b"disp", b"deca", b"refl", b"norm"];
    text.split(|&byte| byte == b'\n').filter_map(|line| {
        let mut cursor = Cursor { text: line, at: 0 };
        cursor.skip_blanks();
        let keyword = cursor.word();
        let keyword = cursor.bytes(keyword).get(..4)?.to_ascii_lowercase();
        let named = KEYWORDS.contains(&&keyword[..]);
        let map = named.then(|| texture_map::read(&mut cursor, |_, _| {}))??;
        Some(without_comment(&line[map.name.range()]))
    })
}

fn statement(cursor: &mut Cursor, materials: &mut Vec<MtlMaterial>) {
    let name = cursor.word();
    let mut lower = [0; KEYWORD_BYTES];
    let keyword = cursor.keyword(name, &mut lower);
    if keyword == b"newmtl" {
        materials.push(MtlMaterial::new(cursor.rest_of_line()));
        return;
    }
    // Before the first `newmtl` there is no material to which a statement could apply.
    let Some(material) = materials.last_mut() else {
        return;
    };
    if let Err(reason) = material.set(keyword, name, cursor) {
        material.leave_out(cursor, name, reason);
    }
}

/// One number for grey, or three; else the reason why there is no colour.
fn color(cursor: &mut Cursor) -> Result<Vec3, &'static str> {
    cursor.skip_blanks();
    let mut ahead = *cursor;
    let word = ahead.word();
    let word = ahead.bytes(word);
    if word.eq_ignore_ascii_case(b"spectral") || word.eq_ignore_ascii_case(b"xyz") {
        return Err(NO_SPECTRUM);
    }
    let r = number(cursor)?;
    if cursor.at_statement_end() {
        return Ok(Vec3::splat(r));
    }
    Ok(Vec3::new(r, number(cursor)?, number(cursor)?))
}

/// A finite number; else the reason why there is none.
fn number(cursor: &mut Cursor) -> Result<f32, &'static str> {
    let number = cursor.float().map_err(|_| NO_NUMBER)?;
    number.is_finite().then_some(number).ok_or(NOT_FINITE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left_out(text: &str) -> Vec<(String, &'static str)> {
        let materials = read(text.as_bytes());
        let all = materials.iter().flat_map(|m| &m.left_out);
        let words = |l: &MtlOmission| (text[l.keyword.range()].to_owned(), l.reason);
        all.map(words).collect()
    }

    #[test]
    fn keywords_are_read_in_any_case() {
        let text = b"\xef\xbb\xbfNewMtl a \t\nKD 1 0 0\nmap_kd a.png\nTR .5\nILLUM 4\nni 1.5\n";
        let materials = read(text);
        let material = &materials[0];
        assert_eq!(&text[material.name.range()], b"a");
        assert_eq!((material.kd, material.tr), (Some(Vec3::X), Some(0.5)));
        assert!(material.maps.contains_key(&MapKind::Kd));
        assert_eq!((material.illum, material.ni), (Some(4.0), 1.5));
        assert_eq!(most_materials(text), 1);
    }

    #[test]
    fn what_is_left_out_is_noted_once() {
        let text = "newmtl a\nmap_Refl a.png\nMAP_REFL b.png\nwhat 5\nKs xyz 1 2 3\nNs nan\nNi -1.#IND\nPs 1\nmap_Kd\n";
        let names: Vec<String> = left_out(text).into_iter().map(|l| l.0).collect();
        assert_eq!(
            names,
            ["map_Refl", "what", "Ks", "Ns", "Ni", "Ps", "map_Kd"]
        );
        let many: String = (0..1000).map(|k| format!("x{k}\n")).collect();
        assert_eq!(
            left_out(&format!("newmtl a\n{many}")).len(),
            MAX_DIAGNOSTICS
        );
        assert!(left_out("newmtl a\nKd nan 0 0\n")[0].1.contains("finite"));
    }

    #[test]
    fn a_broken_statement_is_left_out() {
        let text =
            "Kd x\nnewmtl a\nKd 1 0\nNs 1,5\nKs spectral a.rfl 1\nillum\nKd\nKa red\nTf 0,5 0 0\n";
        let names: Vec<String> = left_out(text).into_iter().map(|l| l.0).collect();
        assert_eq!(names, ["Kd", "Ns", "Ks", "illum", "Ka", "Tf"]);
        assert!(left_out(text)[1].1.contains("missing"));
        let after = read(format!("{text}Kd 0 1 0").as_bytes());
        assert_eq!((after[0].kd, after[0].ns), (Some(Vec3::Y), None));
    }
}
