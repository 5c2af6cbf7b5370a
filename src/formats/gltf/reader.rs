//! The reader: meshes of nodes, baked or instanced, and everything around them.

use super::bake::{BadAttributes, BakedMesh, bake_all};
use super::document::GltfDocument;
use super::geometry::{CORNERS_BYTES, PrimitiveGeometry};
use super::materials::{GltfMaterials, UvLayer, VertexPaint};
use super::mesh_instances::{MeshInstances, MeshPart};
use super::nodes::PlacedNode;
use super::placements::{PlacedMesh, Placements, Pose};
use super::skins::Skins;
use super::source::GltfSource;
use super::stored_space::{stored_size, stored_space};
use super::triangle_indices::is_surface;
use super::vertices::PrimitiveVertices;
use super::{cameras, container, extensions, lights, nodes};
use crate::diagnostics::{DiagnosticSink, Span, quoted};
use crate::folder::Folder;
use crate::memory::MemoryLedger;
use crate::mesh::defaults::empty_scene;
use crate::options::ReadOptions;
use crate::origin::{self, Origin, ReadStop};
use crate::read_scene::{self, ReadScene};
use crate::text;
use crate::text::workers;
use glam::DAffine3;
use phalanx_scene::{Bounds, GeometryError, Mesh, NO_NAME, Scene, VisibleVertices};
use std::collections::HashSet;
use std::sync::Arc;

/// The text of a file; empty for a GLB, which has none to show.
pub(crate) fn text(bytes: &[u8]) -> String {
    if is_binary(bytes) { String::new() } else { text::lossy(bytes) }
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
    options: &ReadOptions,
) -> Result<ReadScene, ReadStop> {
    let mut report = if is_binary(bytes) {
        DiagnosticSink::binary()
    } else {
        DiagnosticSink::new(text::utf8(bytes)?.as_bytes())
    };
    let (mut scene, mut objects) = (empty_scene(), Vec::new());
    let opened = container::open(bytes);
    let parsed = opened.and_then(|parts| {
        let count = |byte: u8| memchr::memchr_iter(byte, &bytes[parts.json.clone()]).count() as u64;
        // Names and data in the text stay in memory, and so do the numbers of lists.
        let rows = count(b'{') * ROW_BYTES + count(b',') * NUMBER_BYTES;
        let text = parts.json.len() as u64;
        let taken = (asset_dir.memory()).take(rows + text, "for the rows of the document");
        taken.map_err(|refusal| (Span::START, refusal.into()))?;
        Ok((GltfSource::parse(bytes, &parts)?, parts))
    });
    match parsed {
        Err((span, message)) => report.error(span, message),
        Ok((mut source, parts)) => {
            if let Some((span, message)) = source.minus_one.take() {
                report.warning(span, message);
            }
            let binary = parts.binary.map(|range| &bytes[range]);
            source.load_buffers(binary, asset_dir, &mut report);
            if extensions::are_known(&source, &mut report) && report.is_clean() {
                let mut reader = GltfReader::new(&source, asset_dir, options, scene, report);
                reader.run()?;
                (scene, objects, report) = (reader.scene, reader.objects, reader.report);
                scene.textures = reader.materials.into_textures();
            }
        }
    }
    Ok(ReadScene {
        objects,
        ..read_scene::finish(scene, options, report)?
    })
}

/// Memory for an object of the document, such as a node, and for its results.
const ROW_BYTES: u64 = 1024;
/// Memory for a number of a list, such as a node's children.
const NUMBER_BYTES: u64 = 8;

struct GltfReader<'a, 't> {
    source: &'a GltfSource<'a>,
    options: &'a ReadOptions,
    scene: Scene,
    report: DiagnosticSink<'t>,
    materials: GltfMaterials<'a>,
    memory: &'a MemoryLedger,
    instances: MeshInstances<'a>,
    /// Number of triangles that may still be created: one per byte of the file, plus a few million.
    /// Accessors may be shared any number of times, and nothing else limits that.
    triangles_left: u64,
    /// Number of displacements of vertices that morph targets may still make, likewise.
    displacements_left: u64,
    skins: Skins<'a>,
    /// Meshes about whose vertices there is a warning.
    warned: HashSet<usize>,
    /// Meshes of which there is a warning about attributes with too few rows.
    warned_short: HashSet<usize>,
    /// True if the scene's origin rounds coordinates that are single precision in the file.
    inexact: bool,
    threads: usize,
    /// The first vertex of each mesh that is shown, or stored.
    objects: Vec<u32>,
    /// Meshes that are to be baked and appended, in their order.
    waiting: Vec<BakedMesh<'a>>,
}

/// Number of triangles of meshes that are baked together. It does not depend on the number of
/// threads, and so neither do the warnings.
const WAITING_TRIANGLES: usize = 1 << 18;

/// Number of triangles that a file of any size may have.
const FREE_TRIANGLES: u64 = 1 << 24;
/// Number of displacements that a file of any size may have, and more of them for each byte.
const FREE_DISPLACEMENTS: u64 = 1 << 26;
const DISPLACEMENTS_PER_BYTE: u64 = 8;

impl<'a, 't> GltfReader<'a, 't> {
    fn new(
        source: &'a GltfSource<'a>,
        asset_dir: &'a Folder,
        options: &'a ReadOptions,
        scene: Scene,
        report: DiagnosticSink<'t>,
    ) -> Self {
        GltfReader {
            source,
            options,
            scene,
            report,
            materials: GltfMaterials::new(source, asset_dir),
            memory: asset_dir.memory(),
            instances: MeshInstances::of(&source.document),
            triangles_left: FREE_TRIANGLES + source.buffer_bytes(),
            displacements_left: FREE_DISPLACEMENTS + DISPLACEMENTS_PER_BYTE * source.buffer_bytes(),
            skins: Skins::new(source, options.origin),
            warned: HashSet::new(),
            warned_short: HashSet::new(),
            inexact: false,
            threads: workers::thread_count(options.threads),
            objects: Vec::new(),
            waiting: Vec::new(),
        }
    }

    fn run(&mut self) -> Result<(), ReadStop> {
        let nodes = nodes::flatten(self.source, self.options.origin, &mut self.report);
        let (source, report) = (self.source, &mut self.report);
        let placements = Placements::of(source, self.memory, &nodes, report);
        for placed in self.instances.joined(placements) {
            for part in self.instances.parts(&placed) {
                if self.report.is_full() {
                    return Ok(());
                }
                let mut last = (usize::MAX, NO_NAME);
                let maps = placed.maps.iter().flat_map(|&(node, map)| {
                    // A node may have any number of copies.
                    if last.0 != node {
                        last = (node, self.name(node));
                    }
                    std::iter::repeat_n((last.1, map), part.times)
                });
                let maps: Vec<(u32, DAffine3)> = maps.collect();
                if let Err(message) = self.mesh(&placed, &part, &maps) {
                    source.error(&mut self.report, "meshes", placed.mesh, &message);
                }
            }
        }
        self.bake_waiting();
        if !self.report.is_clean() {
            return Ok(());
        }
        if self.inexact {
            return Err(ReadStop::Inexact);
        }
        if self.scene.prims.is_empty() {
            let meshes = self.source.document.meshes.iter();
            if meshes
                .flat_map(|mesh| &mesh.primitives)
                .any(|p| p.mode == 0)
            {
                let message = "the file shows only points, which are drawn from PLY and OBJ alone";
                self.report.error(Span::START, message);
                return Ok(());
            }
            let message = "the file shows no triangles: the picture will be empty";
            self.report.warning(Span::START, message);
        }
        let bounds = VisibleVertices::of(&self.scene, self.threads).bounds(&self.scene);
        if self.options.origin == Origin::Auto
            && let Some(far) = origin::of_bounds(bounds)
        {
            return Err(ReadStop::Far(far));
        }
        self.surroundings(&nodes, bounds);
        self.warn_unsupported(&nodes);
        Ok(())
    }

    fn surroundings(&mut self, nodes: &[PlacedNode], bounds: Bounds) {
        let (source, scene, report) = (self.source, &mut self.scene, &mut self.report);
        cameras::add_cameras(source, nodes, bounds, scene, report);
        scene.emission_lights = true;
        scene.defaulted.light = !lights::add_lights(source, nodes, bounds, scene, report);
    }

    /// The name of the object that a node shows: its own, or that of its mesh.
    fn name(&mut self, node: usize) -> u32 {
        let GltfDocument { nodes, meshes, .. } = &self.source.document;
        let node = &nodes[node];
        let names = &mut self.scene.names;
        match names.intern(node.name.text().as_bytes()) {
            NO_NAME => node.mesh.map_or(NO_NAME, |mesh| {
                names.intern(meshes[mesh].name.text().as_bytes())
            }),
            name => name,
        }
    }

    /// Adds a part of a mesh under each of the maps, which have names of objects.
    fn mesh(
        &mut self,
        placed: &PlacedMesh,
        part: &MeshPart,
        maps: &[(u32, DAffine3)],
    ) -> Result<(), String> {
        let mesh = placed.mesh;
        let shapes: Arc<[PrimitiveGeometry]> = self.shapes(mesh, part, &placed.pose)?.into();
        let joints = placed.pose.skin.map(|skin| self.skins.joints(skin));
        let joints = joints.transpose()?;
        let copy = |name: u32, map: DAffine3| BakedMesh {
            mesh,
            shapes: Arc::clone(&shapes),
            name,
            map,
            joints: joints.clone(),
        };
        if maps.is_empty() {
            return Ok(());
        }
        if let &[(name, map)] = maps {
            self.charge(&shapes)?;
            self.waiting.push(copy(name, map));
            let waiting = self.waiting.iter().flat_map(|mesh| &mesh.shapes[..]);
            if waiting.map(PrimitiveGeometry::len).sum::<usize>() >= WAITING_TRIANGLES {
                self.bake_waiting();
            }
            return Ok(());
        }
        self.bake_waiting();
        let bounds = bounds(&shapes, self.threads);
        let Some(size) = stored_size(&shapes, bounds, maps.len()) else {
            // The same vertices are bad in each placement.
            let mut bad = BadAttributes::default();
            for &(name, map) in maps {
                bad = self.bake_one(copy(name, map))?;
            }
            self.warn_bad_attributes(mesh, bad);
            return Ok(());
        };
        let stored = self.scene.begin_mesh();
        // An origin near the geometry if it is far away in the mesh's own space, too: some files
        // have accessors in the coordinates of a map, and nodes that move them back.
        let own = origin::of_bounds(bounds);
        let [taken, back] = stored_space(own, size);
        let bad = self.bake_one(copy(NO_NAME, taken))?;
        self.scene.end_mesh(stored);
        self.warn_bad_attributes(mesh, bad);
        let mut baked = 0;
        for &(name, map) in maps {
            // If there is nothing to undo, no product is computed: zeros keep their signs.
            let undone = own.is_none() && size == 1.0;
            let to_world = if undone { map } else { map * back };
            let placed_before = self.scene.instances.len();
            match self.scene.add_instance(stored, to_world) {
                Ok(_) => self.scene.instances.name[placed_before] = name,
                Err(GeometryError::NotInvertible) => {
                    baked += 1;
                    self.bake_one(copy(name, map))?;
                }
                Err(error) => return Err(error.to_string()),
            }
        }
        if baked > 0 {
            let copies = maps.len();
            let message = format!(
                "a mesh is made flat, or too large or small, by the nodes above it: {baked} of its {copies} copies are stored"
            );
            let span = self.source.span_of("meshes", mesh);
            self.report.warning(span, message);
        }
        Ok(())
    }

    /// Adds a mesh to the scene.
    fn bake_one(&mut self, mesh: BakedMesh) -> Result<BadAttributes, String> {
        self.charge(&mesh.shapes)?;
        Ok(self.bake(&[mesh])[0])
    }

    /// Adds the meshes that wait to the scene.
    fn bake_waiting(&mut self) {
        let waiting = std::mem::take(&mut self.waiting);
        let faults = self.bake(&waiting);
        for (baked, bad) in waiting.iter().zip(faults) {
            self.warn_bad_attributes(baked.mesh, bad);
        }
    }

    /// Adds meshes, for which there is memory, to the scene.
    fn bake(&mut self, meshes: &[BakedMesh]) -> Vec<BadAttributes> {
        let mut faults = vec![BadAttributes::default(); meshes.len()];
        let origin = self.options.origin;
        let mut last = None;
        bake_all(meshes, origin, self.threads, |k, shape, mesh, bad| {
            if last.replace(k) != Some(k) {
                self.objects
                    .push(self.scene.triangles.vertices.len() as u32);
            }
            append(&mut self.scene, mesh, meshes[k].name, shape.name);
            faults[k].add(bad);
        });
        self.inexact |= faults.iter().any(|bad| bad.inexact);
        faults
    }

    /// Subtracts the triangles of shapes from those that may still be made, and takes memory for
    /// them.
    fn charge(&mut self, shapes: &[PrimitiveGeometry]) -> Result<(), String> {
        let open: usize = shapes.iter().map(PrimitiveGeometry::len).sum();
        let open = open as u64 * CORNERS_BYTES;
        for shape in shapes {
            let left = self.triangles_left.checked_sub(shape.len() as u64);
            self.triangles_left = left.ok_or("its copies have too many triangles for this file")?;
            let what = format!("for {} more triangles", shape.len());
            let bytes = shape.mesh_bytes();
            self.memory.lend(open.saturating_add(bytes), &what)?;
            self.memory.take(bytes, &what)?;
            let left = self.displacements_left.checked_sub(shape.displacements());
            self.displacements_left =
                left.ok_or("its morph targets are too many for a file of this size")?;
        }
        Ok(())
    }

    fn warn_bad_attributes(&mut self, mesh: usize, bad: BadAttributes) {
        let messages = bad.messages();
        // A mesh may be in several poses.
        if messages.is_empty() || !self.warned.insert(mesh) {
            return;
        }
        let (source, report) = (self.source, &mut self.report);
        (messages.iter()).for_each(|message| source.warning(report, "meshes", mesh, message));
    }

    fn shapes(
        &mut self,
        mesh: usize,
        part: &MeshPart,
        pose: &Pose,
    ) -> Result<Vec<PrimitiveGeometry<'a>>, String> {
        let source = self.source;
        let mut shapes = Vec::new();
        // All primitives of a mesh are open at once, so their sum is checked.
        let mut left = self.triangles_left;
        let mut open = 0;
        for &k in &part.primitives {
            let primitive = &source.document.meshes[mesh].primitives[k];
            let named = |reason: String| format!("primitives[{k}]: {reason}");
            if primitive.mode > 6 {
                return Err(named(format!("there is no mode {}", primitive.mode)));
            }
            let without_positions = !primitive.attributes.contains_key("POSITION");
            if without_positions || !is_surface(primitive.mode) {
                let kind = if is_surface(primitive.mode) {
                    "without positions"
                } else {
                    "of points or lines"
                };
                self.materials.unsupported.add_primitive(kind, mesh, k);
                continue;
            }
            let (scene, report) = (&mut self.scene, &mut self.report);
            let paint = VertexPaint::of(primitive, &source.document);
            let (row, options) = (primitive.material, self.options);
            let material = self.materials.convert(row, paint, options, scene, report);
            let material = material.map_err(named)?;
            let skinned = pose.skin.is_some();
            let weights = pose.weights;
            let vertices = PrimitiveVertices::open(source, primitive, &material, weights, skinned);
            let vertices = vertices.map_err(named)?;
            let has = |layer: &UvLayer| primitive.attributes.contains_key(&layer.set);
            let missing = material.uvs.iter().position(|layer| !has(layer));
            let missing = missing.map(|layer| (layer, &material.uvs[layer].set));
            let remark = match (vertices.too_short.first().map(|name| quoted(name)), missing) {
                (Some(name), _) => format!("{name} is left out: it has fewer rows than POSITION"),
                (_, Some((0, set))) => format!("its texture is not shown: it has no `{set}`"),
                (_, Some((_, set))) => format!("a texture has no `{set}`: the first one's is used"),
                (None, None) => String::new(),
            };
            if !remark.is_empty() && self.warned_short.insert(mesh) {
                source.warning(&mut self.report, "meshes", mesh, &named(remark));
            }
            let memory = self.memory;
            let room = |triangles: u64, columns: u64| {
                open += triangles * CORNERS_BYTES;
                let what = format!("for {triangles} more triangles");
                memory.lend(open.saturating_add(columns), what)
            };
            let name = row.and_then(|row| source.document.materials.get(row));
            let name = name.map_or(String::new(), |material| material.name.text());
            let looks = (&material, self.scene.names.intern(name.as_bytes()));
            let limits = (left, self.threads);
            let shape = PrimitiveGeometry::open(source, primitive, looks, vertices, limits, room);
            let shape = shape.map_err(named)?;
            left -= shape.len() as u64;
            if shape.len() > 0 {
                shapes.push(shape);
            }
        }
        Ok(shapes)
    }

    /// Warns of all that the file has and the picture does not show.
    fn warn_unsupported(&mut self, nodes: &[PlacedNode]) {
        let unsupported = &mut self.materials.unsupported;
        let document = &self.source.document;
        let shown = || nodes.iter().map(|placed| &document.nodes[placed.node]);
        if !document.animations.is_empty() {
            unsupported.add("animations");
        }
        if shown().any(|node| node.skin.is_some() && node.extensions.instancing.is_some()) {
            unsupported.add("copies of meshes with skins");
        }
        let mut lights = document.extensions.lights.lights.iter();
        if lights.any(|light| light.range.is_some()) {
            unsupported.add("ranges of lights");
        }
        extensions::add_unknown(self.source, unsupported);
        unsupported.warn(self.source, &mut self.report);
    }
}

/// Appends a primitive of an object, by the numbers of its own name and of its material's.
fn append(scene: &mut Scene, mesh: Mesh, object: u32, material: u32) {
    let first = scene.append_mesh(mesh);
    let prims = first..scene.prim_count() as u32;
    scene.names.name_run(prims, object, Some(material));
}

/// Bounds of shapes in their mesh's own space.
fn bounds(shapes: &[PrimitiveGeometry], threads: usize) -> Bounds {
    let bounds = shapes.iter().map(|shape| shape.bounds(threads));
    bounds.fold(Bounds::EMPTY, Bounds::union)
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
