//! Materials of triangles: rows of the scene, with the textures that they name.

use super::conversion::MapTextures;
use super::mtl::{MapKind, MtlMaterial, MtlOmission};
use super::name::{text_of, texture_spellings, without_comment};
use super::runs;
use super::texture_map::{MtlTexture, UvTransform};
use crate::diagnostics::{DiagnosticSink, MAX_DIAGNOSTICS, Span, quoted_bytes};
use crate::folder::{Folder, Found, NamedFile};
use crate::texture::TextureLibrary;
use phalanx_scene::{
    MapTarget, MaterialTable, MeshMaterial, NO_TEXTURE, Scene, Texture, TextureMap,
};
use std::collections::HashSet;
use std::ops::Range;

/// A material file.
pub(super) struct MtlSource {
    pub(super) file: Found,
    /// Its name in the scene file.
    pub(super) name: String,
    pub(super) bytes: Vec<u8>,
    /// The `mtllib` that names it.
    pub(super) library: Span,
}

/// A material, and its file's number.
pub(super) struct KnownMaterial {
    pub(super) material: MtlMaterial,
    pub(super) source: usize,
}

/// A material as triangles have it: its row, and the transform of its UVs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct MaterialLook {
    pub(super) row: u32,
    pub(super) transform: Option<UvTransform>,
}

/// The materials of a mesh.
pub(super) struct MeshMaterials {
    pub(super) rows: MeshMaterial,
    /// Runs of triangles whose UVs are transformed.
    pub(super) transformed: Vec<(Range<usize>, UvTransform)>,
}

impl MeshMaterials {
    /// Materials of `triangles` triangles that change at `runs`.
    pub(super) fn new(runs: &[(usize, MaterialLook)], triangles: usize) -> MeshMaterials {
        let transformed = runs::ranges(runs, triangles)
            .filter_map(|(range, look)| Some((range, look.transform?)));
        MeshMaterials {
            transformed: transformed.collect(),
            rows: expand_runs(runs, triangles),
        }
    }
}

/// One row for all triangles, or one for each.
fn expand_runs(runs: &[(usize, MaterialLook)], triangles: usize) -> MeshMaterial {
    match runs {
        [] => return MeshMaterial::One(0),
        [(0, look), rest @ ..] if rest.iter().all(|(_, other)| other.row == look.row) => {
            return MeshMaterial::One(look.row);
        }
        _ => {}
    }
    let mut rows = vec![0; triangles];
    for (range, look) in runs::ranges(runs, triangles) {
        rows[range].fill(look.row);
    }
    MeshMaterial::Each(rows.into())
}

/// Warns once of everything that a file's materials omit, at its first occurrence.
fn warn_left_out(file: &MtlSource, mut left_out: Vec<MtlOmission>, about: &mut DiagnosticSink) {
    left_out.sort_by_key(|omission| omission.keyword.offset);
    let Some(first) = left_out.first() else {
        return;
    };
    let mut reasons: Vec<&str> = left_out.iter().map(|omission| omission.reason).collect();
    let mut seen = HashSet::new();
    reasons.retain(|reason| seen.insert(*reason));
    let groups = reasons.iter().map(|reason| {
        let same = left_out.iter().filter(|other| other.reason == *reason);
        let names = same.map(|omission| quoted_bytes(&file.bytes[omission.keyword.range()]));
        let names: Vec<String> = names.collect();
        let verb = if names.len() == 1 { "is" } else { "are" };
        format!("{} {verb} left out ({reason})", names.join(", "))
    });
    let groups: Vec<String> = groups.collect();
    about.warning(first.keyword, groups.join("; "));
}

/// Makes rows of the materials that are used, and collects remarks about their files.
pub(super) struct MaterialReader<'a> {
    asset_dir: &'a Folder,
    files: &'a [MtlSource],
    textures: TextureLibrary<'a>,
    /// Remarks about each file.
    reports: Vec<DiagnosticSink<'a>>,
    /// Keywords and kinds of remarks that each file has had, in lower case.
    named: Vec<HashSet<Vec<u8>>>,
    /// Pictures of `map_Bump`, and what they are taken as.
    reliefs: Vec<String>,
    /// Statements that each file's materials leave out, each keyword once, and at most
    /// [`MAX_DIAGNOSTICS`].
    left_out: Vec<Vec<MtlOmission>>,
}

impl<'a> MaterialReader<'a> {
    pub(super) fn new(
        asset_dir: &'a Folder,
        files: &'a [MtlSource],
        textures: TextureLibrary<'a>,
    ) -> MaterialReader<'a> {
        let reports = files.iter().map(|file| DiagnosticSink::new(&file.bytes));
        MaterialReader {
            asset_dir,
            files,
            textures,
            reports: reports.collect(),
            named: vec![HashSet::new(); files.len()],
            reliefs: Vec::new(),
            left_out: vec![Vec::new(); files.len()],
        }
    }

    /// The row of a material, and what is done with UVs for it.
    pub(super) fn look(
        &mut self,
        known: &KnownMaterial,
        scene: &mut Scene,
        table: &mut MaterialTable,
    ) -> MaterialLook {
        let KnownMaterial { material, source } = known;
        (material.left_out.iter()).for_each(|left_out| self.leave_out(*source, left_out));
        self.warn_of_readings(*source, material);
        let exponents = material.maps.get(&MapKind::Ns);
        if let Some(map) = exponents.filter(|_| !material.shows(MapKind::Ns)) {
            let reason = "it has no effect: the material has no `Ns` above 1 that it could vary";
            self.warn_once(*source, b"map_ns", map, reason);
        }
        let maps = material.maps.iter().map(|(&kind, &map)| (kind, map));
        let shown = maps.filter(|(kind, _)| material.shows(*kind));
        let shown: Vec<(MapKind, MtlTexture)> = shown.collect();
        let mut textures = MapTextures::new();
        for (kind, map) in shown.iter().filter(|(kind, _)| *kind != MapKind::D) {
            let texture = self.texture(*source, map);
            textures.extend((texture != NO_TEXTURE).then_some((*kind, texture)));
        }
        let [kd, ka, mask] =
            [MapKind::Kd, MapKind::Ka, MapKind::D].map(|kind| material.maps.get(&kind).copied());
        let texture = textures.get(&MapKind::Kd).or(textures.get(&MapKind::Ka));
        let (color, texture) = (kd.or(ka), texture.copied().unwrap_or(NO_TEXTURE));
        let mask = mask.map(|map| self.mask(*source, &map, color, texture));
        if let (Some(kd), Some(ka)) = (&kd, &ka)
            && !self.same_file(*source, kd, ka)
        {
            let reason = "its picture is not shown: that of map_Kd colours the ambient light";
            self.warn_once(*source, b"map_ka", ka, reason);
        }
        let first = shown.first();
        let transform = first.map_or(UvTransform::IDENTITY, |(_, map)| map.transform);
        if let Some((_, other)) = shown.iter().find(|(_, map)| map.transform != transform) {
            let reason = "its -s and -o are not used: those of the material's first texture are";
            self.warn_once(*source, b"-s", other, reason);
        }
        let mask = mask.unwrap_or(NO_TEXTURE);
        let mut converted = material.to_material(&textures, mask);
        let row = |(kind, map): &(_, _)| self.row_of(*source, *kind, map, *textures.get(kind)?);
        let maps: Vec<TextureMap> = shown.iter().filter_map(row).collect();
        converted.maps = scene.maps.push_all(&maps);
        let textured = !textures.is_empty() || mask != NO_TEXTURE;
        let moved = textured && transform != UvTransform::IDENTITY;
        MaterialLook {
            row: table.intern(&converted, &mut scene.materials),
            transform: moved.then_some(transform),
        }
    }

    /// The scene's map of a texture, unless it is one of colour or opacity.
    fn row_of(
        &mut self,
        source: usize,
        kind: MapKind,
        map: &MtlTexture,
        texture: u32,
    ) -> Option<TextureMap> {
        let target = match kind {
            MapKind::Kd | MapKind::Ka | MapKind::D => return None,
            MapKind::Ke => MapTarget::Emission,
            MapKind::Ks => MapTarget::Specular,
            MapKind::Ns => MapTarget::Shininess,
            MapKind::Pr => MapTarget::Roughness,
            MapKind::Pm => MapTarget::Metallic,
            MapKind::Norm | MapKind::Bump => MapTarget::Normal,
        };
        let mut shown = texture;
        if kind == MapKind::Bump {
            let report = &mut self.reports[source];
            shown = self.textures.normals_of(texture, || map.name, report);
            self.note_relief(source, map, shown == texture);
        }
        (shown != NO_TEXTURE).then_some(TextureMap {
            target,
            texture: shown,
            channel: map.channel,
            uv_layer: 0,
            scale: map.bump,
        })
    }

    /// Notes what a picture of `map_Bump` is taken as, once, and of the first few.
    fn note_relief(&mut self, source: usize, map: &MtlTexture, is_normals: bool) {
        let name = without_comment(&self.files[source].bytes[map.name.range()]);
        let heights = "heights (`norm` in place of `map_Bump` makes it a normal map)";
        let kind = if is_normals { "a normal map" } else { heights };
        let note = format!("{} is taken as {kind}", quoted_bytes(name));
        if self.reliefs.len() < MAX_DIAGNOSTICS && !self.reliefs.contains(&note) {
            self.reliefs.push(note);
        }
    }

    /// The textures of all rows, and notes on them; remarks about the files go to the scene file's
    /// report.
    pub(super) fn finish(self, report: &mut DiagnosticSink) -> (Vec<Texture>, Vec<String>) {
        let parts = self.files.iter().zip(self.reports).zip(self.left_out);
        for ((file, mut about), left_out) in parts {
            warn_left_out(file, left_out, &mut about);
            about.emit_for_file(&file.name, file.library, report);
        }
        (self.textures.into_textures(), self.reliefs)
    }

    fn texture(&mut self, source: usize, map: &MtlTexture) -> u32 {
        let (name, file) = self.find(source, map);
        let report = &mut self.reports[source];
        let file = file.map(|file| file.accepted(&name, map.name, report));
        self.textures
            .of_file(&name, file, map.sampler, || map.name, report)
    }

    /// The texture of opacity: that of the colour's file is its alpha alone, so that a picture
    /// without alpha is whole.
    fn mask(
        &mut self,
        source: usize,
        map: &MtlTexture,
        color: Option<MtlTexture>,
        texture: u32,
    ) -> u32 {
        let same = color.is_some_and(|color| self.same_file(source, &color, map));
        let row = match color {
            Some(color) if same && color.sampler == map.sampler => texture,
            _ => self.texture(source, map),
        };
        let report = &mut self.reports[source];
        if map.matte || same {
            self.textures.alpha_of(row)
        } else {
            self.textures.mask_of(row, || map.name, report)
        }
    }

    fn same_file(&self, source: usize, a: &MtlTexture, b: &MtlTexture) -> bool {
        let bytes = &self.files[source].bytes;
        if bytes[a.name.range()] == bytes[b.name.range()] {
            return true;
        }
        let [a, b] = [a, b].map(|map| self.find(source, map).1.ok().map(|named| named.file));
        a.is_some() && a == b
    }

    /// The file that a material file names, and its name: without comments unless they are part of
    /// it.
    fn find(&self, source: usize, map: &MtlTexture) -> (String, Result<NamedFile, String>) {
        let file = &self.files[source];
        let text = &file.bytes[map.name.range()];
        let mut last = (String::new(), Err(String::new()));
        for name in texture_spellings(text) {
            let name = text_of(name);
            let named = self.asset_dir.find_for(Some(&file.file), &name);
            last = (name, named);
            if last.1.is_ok() {
                break;
            }
        }
        last
    }

    fn leave_out(&mut self, source: usize, left_out: &MtlOmission) {
        let keyword = self.files[source].bytes[left_out.keyword.range()].to_ascii_lowercase();
        let omissions = &mut self.left_out[source];
        if omissions.len() < MAX_DIAGNOSTICS && self.named[source].insert(keyword) {
            omissions.push(*left_out);
        }
    }

    /// Warns of statements that are read differently from their definition, once for each kind.
    fn warn_of_readings(&mut self, source: usize, material: &MtlMaterial) {
        let mut warn = |applies: bool, keyword: Span, message: &str| {
            if applies && self.named[source].insert(message.as_bytes().to_vec()) {
                self.reports[source].warning(keyword, message);
            }
        };
        let message = "`Tr 1` without a `d` is taken as opaque, because exporters write it so; \
                       as a transparency, it would hide the surface (write `d 0` for that)";
        warn(material.tr_is_opacity(), material.tr_keyword, message);
        let message = "`d 0` in every material of the file is taken as opaque, because exporters \
                       write it so; as an opacity, it would hide the whole model";
        warn(material.shown, material.d_keyword, message);
        if let Some(keyword) = material.negative {
            let message = "negative colours and exponents are taken as 0";
            warn(true, keyword, message);
        }
        let message = "a black `Kd` with a `map_Kd` is taken as 1, because exporters write it so; \
                       multiplied, the texture would be black";
        warn(material.kd_is_placeholder(), material.kd_keyword, message);
    }

    /// Warns of a texture, the first time of its kind.
    fn warn_once(&mut self, source: usize, kind: &[u8], map: &MtlTexture, reason: &str) {
        if self.named[source].insert(kind.to_vec()) {
            let name = text_of(without_comment(&self.files[source].bytes[map.name.range()]));
            let message = format!("{}: {reason}", quoted_bytes(name.as_bytes()));
            self.reports[source].warning(map.name, message);
        }
    }
}
