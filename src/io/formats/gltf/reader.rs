//! The reader: meshes that the nodes show, baked or instanced, and what surrounds them.

use super::geometry::{BadAttributes, CORNERS_BYTES, PrimitiveGeometry, is_surface};
use super::materials::GltfMaterials;
use super::mesh_instances::{MAX_COPIED_TRIANGLES, MeshInstances, MeshPart};
use super::nodes::PlacedNode;
use super::source::GltfSource;
use super::{container, lights, nodes};
use crate::formats::defaults::{MissingParts, finish_scene};
use crate::formats::diagnostics::{DiagnosticSink, Span, quoted};
use crate::formats::folder::Folder;
use crate::formats::loaded::Loaded;
use crate::formats::memory_budget::MemoryBudget;
use crate::formats::mesh_defaults::{BARE, empty_scene};
use crate::formats::options::Options;
use crate::formats::origin::{self, Origin, ReadStop};
use crate::formats::text;
use crate::formats::texture::TextureLibrary;
use glam::{DAffine3, DVec3};
use phalanx_scene::{Bounds, Scene};

/// Extensions that a file may require; the others are refused by name.
const SUPPORTED_EXTENSIONS: [&str; 16] = [
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// The text of a file; a GLB has none that can be shown.
pub(crate) fn text(bytes: &[u8]) -> String {
    match is_binary(bytes) {
        true => String::new(),
        false => text::lossy(bytes),
    }
}

fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(container::MAGIC)
}

/// Reads a scene from the bytes of a `.gltf` or `.glb` file.
///
/// # Errors
/// Faults of the file.
pub(crate) fn read(
    bytes: &[u8],
    asset_dir: &Folder,
    options: &Options,
) -> Result<Loaded, ReadStop> {
    let mut report = match is_binary(bytes) {
        true => DiagnosticSink::binary(),
        false => DiagnosticSink::new(text::utf8(bytes)?.as_bytes()),
    };
    let mut scene = empty_scene();
    let mut missing = BARE;
    let opened = container::open(bytes);
    let parsed = opened.and_then(|parts| {
        let rows = memchr::memchr_iter(b'{', &bytes[parts.json.clone()]).count() as u64;
        let what = || "for the rows of the document".to_owned();
        // Names and data in the text stay in memory.
        let text = parts.json.len() as u64;
        let allowed = asset_dir.allowance().take(rows * ROW_BYTES + text, what);
        allowed.map_err(|message| (Span::START, message))?;
        Ok((GltfSource::parse(bytes, &parts)?, parts))
    });
    match parsed {
        Err((span, message)) => report.error(span, message),
        Ok((mut source, parts)) => {
            let binary = parts.binary.map(|range| &bytes[range]);
            source.load_buffers(binary, asset_dir, &mut report);
            if extensions_are_known(&source, &mut report) && report.is_clean() {
                let mut reader = GltfReader::new(&source, asset_dir, options, scene, report);
                reader.run(&mut missing)?;
                (scene, report) = (reader.scene, reader.report);
            }
        }
    }
    finish_scene(scene, &missing, options, report)
}

/// Memory for an object of the document, such as a node, and for its results.
const ROW_BYTES: u64 = 1024;

fn extensions_are_known(source: &GltfSource, report: &mut DiagnosticSink) -> bool {
    let required = &source.document.extensions_required;
    let unknown = required
        .iter()
        .filter(|n| !SUPPORTED_EXTENSIONS.contains(&n.as_str()));
    let before = report.is_clean();
    for name in unknown {
        let name = quoted(name);
        let message = format!("the file requires the extension {name}, which is not read here");
        report.error_with_help(
            Span::START,
            message,
            "export it again without compression or that extension",
        );
    }
    before && report.is_clean()
}

struct GltfReader<'a, 't> {
    source: &'a GltfSource<'a>,
    options: &'a Options,
    scene: Scene,
    report: DiagnosticSink<'t>,
    materials: Option<GltfMaterials<'a>>,
    allowance: &'a MemoryBudget,
    instances: MeshInstances<'a>,
    /// Number of triangles that may still be made: as many as the file has bytes, and a few
    /// million. Accessors may be shared any number of times, and nothing else bounds that.
    triangles_left: u64,
    /// True if the scene's origin rounds coordinates that are single precision in the file.
    inexact: bool,
}

/// Number of triangles that a file of any size may have.
const FREE_TRIANGLES: u64 = 1 << 24;
/// Extents of meshes that are instanced as they are. Beyond this range the stored mesh could not be
/// intersected in single precision.
const SAFE_EXTENTS: std::ops::RangeInclusive<f32> = 1.0 / 268_435_456.0..=268_435_456.0;

/// The map from a mesh's own space to the one in which it is stored, and the map back. The mesh is
/// moved to an origin, and then scaled.
fn stored_space(origin: Option<DVec3>, scale: f64) -> [DAffine3; 2] {
    let origin = origin.unwrap_or_default();
    let scaled = |by: f64| DAffine3::from_scale(DVec3::splat(by));
    [
        scaled(scale) * DAffine3::from_translation(-origin),
        DAffine3::from_translation(origin) * scaled(1.0 / scale),
    ]
}

impl<'a, 't> GltfReader<'a, 't> {
    fn new(
        source: &'a GltfSource<'a>,
        asset_dir: &'a Folder,
        options: &'a Options,
        scene: Scene,
        report: DiagnosticSink<'t>,
    ) -> Self {
        GltfReader {
            source,
            options,
            scene,
            report,
            materials: Some(GltfMaterials::new(source, TextureLibrary::new(asset_dir))),
            allowance: asset_dir.allowance(),
            instances: MeshInstances::of(&source.document),
            triangles_left: FREE_TRIANGLES + source.buffer_bytes(),
            inexact: false,
        }
    }

    fn run(&mut self, missing: &mut MissingParts) -> Result<(), ReadStop> {
        let nodes = nodes::flatten(self.source, self.options.origin, &mut self.report);
        let placements = self.placements(&nodes);
        for (mesh, maps) in self.instances.joined(placements) {
            for part in self.instances.parts(mesh, maps.len()) {
                if self.report.is_full() {
                    return Ok(());
                }
                let times = |map: DAffine3| std::iter::repeat_n(map, part.times);
                let maps: Vec<DAffine3> = maps.iter().copied().flat_map(times).collect();
                if let Err(message) = self.mesh(mesh, &part, &maps) {
                    self.source
                        .error(&mut self.report, "meshes", mesh, &message);
                }
            }
        }
        if !self.report.is_clean() {
            return Ok(());
        }
        if self.inexact {
            return Err(ReadStop::Inexact);
        }
        if self.scene.prims.is_empty() {
            self.report.warning(
                Span::START,
                "the file shows no triangles: the picture will be empty",
            );
        }
        let bounds = self.scene.bounds();
        if self.options.origin == Origin::Auto
            && let Some(far) = origin::of_bounds(bounds)
        {
            return Err(ReadStop::Far(far));
        }
        self.surroundings(&nodes, bounds, missing);
        self.warn_unused(&nodes);
        Ok(())
    }

    fn surroundings(&mut self, nodes: &[PlacedNode], bounds: Bounds, missing: &mut MissingParts) {
        let (source, scene, report) = (self.source, &mut self.scene, &mut self.report);
        missing.view = !lights::add_camera(source, nodes, bounds, scene, report);
        missing.lights = !lights::add_lights(source, nodes, bounds, scene, report);
    }

    /// Every mesh that is shown, in the order of its first node, with the maps of its placements.
    fn placements(&mut self, nodes: &[PlacedNode]) -> Vec<(usize, Vec<DAffine3>)> {
        let document = &self.source.document;
        let mut order = Vec::new();
        let mut maps_of: Vec<Vec<DAffine3>> = Vec::new();
        maps_of.resize_with(document.meshes.len(), Vec::new);
        for placed in nodes {
            let Some(mesh) = document.nodes[placed.node].mesh else {
                continue;
            };
            let Some(maps) = maps_of.get_mut(mesh) else {
                let message = format!("there is no meshes[{mesh}]");
                self.source
                    .error(&mut self.report, "nodes", placed.node, &message);
                continue;
            };
            if maps.is_empty() {
                order.push(mesh);
            }
            maps.push(placed.to_world);
        }
        let taken = order.into_iter();
        taken
            .map(|mesh| (mesh, std::mem::take(&mut maps_of[mesh])))
            .collect()
    }

    fn mesh(&mut self, mesh: usize, part: &MeshPart, maps: &[DAffine3]) -> Result<(), String> {
        let shapes = self.shapes(mesh, part)?;
        let bounds = shapes.iter().map(PrimitiveGeometry::bounds);
        let bounds = bounds.fold(Bounds::EMPTY, Bounds::union);
        let extent = bounds.lo.abs().max(bounds.hi.abs()).max_element();
        let triangles: u64 = shapes.iter().map(|shape| shape.len() as u64).sum();
        let copied = triangles.saturating_mul(maps.len() as u64 - 1);
        let size = match SAFE_EXTENTS.contains(&extent) {
            true => Some(1.0),
            false if copied > MAX_COPIED_TRIANGLES => Some(power_of_two_into_range(extent)),
            false => None,
        };
        let (true, Some(size)) = (maps.len() > 1, size) else {
            // The same vertices are bad in each placement.
            let mut bad = BadAttributes::default();
            for map in maps {
                bad = self.bake(&shapes, map)?;
            }
            self.warn_bad_attributes(mesh, bad);
            return Ok(());
        };
        let stored = self.scene.begin_mesh();
        // An origin near the geometry if it is far away in the mesh's own space, too: some files
        // have accessors in the coordinates of a map, and nodes that move them back.
        let own = origin::of_bounds(bounds);
        let [taken, back] = stored_space(own, size);
        let bad = self.bake(&shapes, &taken)?;
        self.scene.end_mesh(stored);
        self.warn_bad_attributes(mesh, bad);
        let mut baked = 0;
        for map in maps {
            // If there is nothing to undo, no product is formed: zeros keep their signs.
            let undone = own.is_none() && size == 1.0;
            let to_world = if undone { *map } else { *map * back };
            if self.scene.add_instance(stored, to_world).is_err() {
                baked += 1;
                self.bake(&shapes, map)?;
            }
        }
        if baked > 0 {
            let message = format!(
                "a mesh is made flat, or too large or small, by the nodes above it: {baked} of its {} copies are stored",
                maps.len()
            );
            let span = self.source.span_of("meshes", mesh);
            self.report.warning(span, message);
        }
        Ok(())
    }

    /// Adds shapes under a map to the scene, and subtracts their triangles from those that may
    /// still be made.
    fn bake(
        &mut self,
        shapes: &[PrimitiveGeometry],
        map: &DAffine3,
    ) -> Result<BadAttributes, String> {
        let mut all = BadAttributes::default();
        let open: usize = shapes.iter().map(PrimitiveGeometry::len).sum();
        let open = open as u64 * CORNERS_BYTES;
        for shape in shapes {
            let left = self.triangles_left.checked_sub(shape.len() as u64);
            self.triangles_left = left.ok_or("its copies have too many triangles for this file")?;
            let what = || format!("for {} more triangles", shape.len());
            let bytes = shape.mesh_bytes();
            self.allowance.lend(open.saturating_add(bytes), what)?;
            self.allowance.take(bytes, what)?;
            let (mesh, bad) = shape.mesh(map, self.options.origin)?;
            self.scene.append_mesh(mesh);
            all.normals += bad.normals;
            all.uvs += bad.uvs;
            self.inexact |= bad.inexact;
        }
        Ok(all)
    }

    fn warn_bad_attributes(&mut self, mesh: usize, bad: BadAttributes) {
        let normals = match bad.normals {
            0 => None,
            1 => Some("one normal is zero or not finite: faces that use it are shaded flat".into()),
            count => Some(format!(
                "{count} normals are zero or not finite: faces that use them are shaded flat"
            )),
        };
        let uvs = match bad.uvs {
            0 => None,
            1 => Some("one texture place is not finite: faces that use it have no texture".into()),
            count => Some(format!(
                "{count} texture places are not finite: faces that use them have no texture"
            )),
        };
        for message in [normals, uvs].into_iter().flatten() {
            let span = self.source.span_of("meshes", mesh);
            self.report
                .warning(span, format!("meshes[{mesh}]: {message}"));
        }
    }

    fn shapes(
        &mut self,
        mesh: usize,
        part: &MeshPart,
    ) -> Result<Vec<PrimitiveGeometry<'a>>, String> {
        let source = self.source;
        let mut shapes = Vec::new();
        let mut skipped = 0;
        // All primitives of a mesh are open at once, so their sum is checked.
        let mut left = self.triangles_left;
        let mut open = 0;
        for &k in &part.primitives {
            let primitive = &source.document.meshes[mesh].primitives[k];
            if primitive.mode > 6 {
                return Err(format!(
                    "primitives[{k}]: there is no mode {}",
                    primitive.mode
                ));
            }
            if !is_surface(primitive.mode) {
                skipped += 1;
                continue;
            }
            let named = |reason: String| format!("primitives[{k}]: {reason}");
            let Some(converter) = &mut self.materials else {
                continue;
            };
            if primitive.targets.is_some() {
                converter.unused.insert("morph targets");
            }
            let (materials, report) = (&mut self.scene.materials, &mut self.report);
            let material = converter.of(primitive.material, self.options, materials, report);
            let material = material.map_err(named)?;
            let budget = self.allowance;
            let room = |triangles: u64, columns: u64| {
                let what = || format!("for {triangles} more triangles");
                open += triangles * CORNERS_BYTES;
                budget.lend(open.saturating_add(columns), what)
            };
            let shape =
                PrimitiveGeometry::open(source, primitive, &material, left, room).map_err(named)?;
            left -= shape.len() as u64;
            if shape.len() > 0 {
                shapes.push(shape);
            }
        }
        if skipped > 0 {
            let message =
                format!("meshes[{mesh}]: {skipped} primitives of points or lines are left out");
            self.report.warning(source.span_of("meshes", mesh), message);
        }
        Ok(shapes)
    }

    /// Adds one warning for all features that the file has and the picture does not show, then
    /// moves the textures to the scene.
    fn warn_unused(&mut self, nodes: &[PlacedNode]) {
        let Some(mut materials) = self.materials.take() else {
            return;
        };
        let document = &self.source.document;
        let shown = || nodes.iter().map(|placed| &document.nodes[placed.node]);
        if !document.animations.is_empty() {
            materials.unused.insert("animations");
        }
        if shown().any(|node| node.skin.is_some()) {
            materials.unused.insert("skins");
        }
        if shown().any(|node| node.extensions.instancing.is_some()) {
            materials.unused.insert("EXT_mesh_gpu_instancing");
        }
        if !materials.unused.is_empty() {
            let names: Vec<&str> = materials.unused.iter().copied().collect();
            let message = format!("not shown: {}", names.join(", "));
            self.report.warning(Span::START, message);
        }
        self.scene.textures = materials.into_textures();
    }
}

/// The power of two that brings an extent to the nearer end of [`SAFE_EXTENTS`]. As it is a power
/// of two, nothing is rounded.
fn power_of_two_into_range(extent: f32) -> f64 {
    let nearest = extent.clamp(*SAFE_EXTENTS.start(), *SAFE_EXTENTS.end());
    match extent > 0.0 && extent.is_finite() {
        true => libm::ldexp(
            1.0,
            libm::ilogb(f64::from(nearest)) - libm::ilogb(f64::from(extent)),
        ),
        false => 1.0,
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
