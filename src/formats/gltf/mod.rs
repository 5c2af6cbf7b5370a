//! glTF 2.0: a JSON document, and buffers in the file itself (GLB, `data:`) or beside it.
//!
//! | file | content |
//! |---|---|
//! | `container` | the chunks of a GLB |
//! | `version` | the version of a document |
//! | `document` | the JSON's structure |
//! | `lenient_json` | the reader of the document, also if it bends the rules |
//! | `extensions` | extensions that are read |
//! | `source` | buffers, buffer views, and the spans of rows in the text |
//! | `accessor` | typed rows, sparse or not |
//! | `nodes` | the hierarchy, flattened |
//! | `placements` | meshes that nodes show: where, how often, in which pose |
//! | `morph`, `skins` | poses: morph targets and joints |
//! | `vertices` | attributes of a primitive's vertices, morphed |
//! | `triangle_indices` | triangles, strips and fans |
//! | `geometry`, `vertex_columns` | primitives, the vertices that they use, and their columns |
//! | `bake` | primitives under a map, on several threads |
//! | `mesh_instances` | equal meshes and primitives |
//! | `stored_space` | the space in which a mesh of several nodes is stored |
//! | `materials`, `coverage` | materials, and the share of a surface that is there |
//! | `cameras`, `lights` | the view and what lights it |
//! | `unsupported` | what the picture lacks, for warnings |
//! | `reader` | meshes of nodes, baked or instanced |
//!
//! # Scene
//! The default scene is shown; if there is none, the first one; without any scene, all root nodes.
//! KHR_node_visibility hides meshes and lights of a node and of those below it. A mesh that one
//! node shows is baked into the world. A mesh that several nodes show, or one with
//! EXT_mesh_gpu_instancing, is stored once and instanced (it is baked if single precision could not
//! go there and back). Copies of more than 262,144 triangles are stored once and instanced, too:
//! copies of meshes that have the same accessors and materials, of such primitives of one mesh, and
//! of meshes too large or small to be instanced as they are. Points, lines and primitives without
//! positions are left out.
//!
//! # Names
//! An object is what a node shows, whatever materials it has: it has the name of the node, or else
//! of the mesh. All copies that a node makes are one object. A camera has the name of its node, or
//! else its own.
//!
//! # Pose
//! The file's pose at rest, since animations are not played: morph targets by the weights of the
//! node, or else of the mesh, and skins by the nodes of their joints. The node of a mesh with a
//! skin does not move it. Up to eight sets of four joints move a vertex; their weights are divided
//! by their sum.
//!
//! # Materials
//! With base colour c, metallic m, roughness r and gloss g = max(0, 1 − 2r)² (Ks weighs the mirror
//! image, so nothing rough may have any):
//!
//! | parameter | value |
//! |---|---|
//! | Kd | c · (1 − m·g) · (1 − t) |
//! | Ka | Kd / 10 |
//! | Ks | (1 − m)·g·F0 + m·g·c, F0 = 4 %, or that of KHR_materials_ior |
//! | highlight | (1 − m)·F0, of lamps alone |
//! | shininess | 2/r⁴ − 2, at most 10000 |
//! | Kt | c · t, t = transmission · (1 − m); t is 0 with a texture of transmission |
//! | ior | 1, as of a thin sheet; that of KHR_materials_ior if there is a volume |
//! | thin | true if t > 0 and there is no volume |
//! | Ke | emissive factor · strength · texture; 0 if the texture cannot be read |
//! | ns | turned by the normal texture, times its scale |
//! | single-sided | true unless doubleSided, or t > 0; whatever alphaMode is |
//! | opacity | alpha of `MASK` and `BLEND`, by factor, texture and vertices; else 1 |
//!
//! The base colour texture and the vertices' COLOR_0 multiply c. A metal with either, and every
//! material with a metallic-roughness texture, is converted at each hit. Kt is not: its m is 0 with
//! such a texture. Each texture has its own coordinates and KHR_texture_transform. Tangents are the
//! file's, unless the normal texture is turned; missing ones follow the texture coordinates of each
//! triangle. Occlusion textures are left out: V is traced. KHR_materials_unlit becomes Ka = c
//! alone.
//! KHR_materials_pbrSpecularGlossiness: Kd is its diffuse colour, F0 its specular colour, r = 1 −
//! glossiness. A primitive without a material gets the user's, or the grey of all meshes; white, if
//! its vertices have colours. The latter are single-sided, as is the default material of glTF.
//!
//! # Lights and cameras
//! Units are those of [`phalanx_scene::lighting`]. Point and spot lights fade with the square of
//! the distance, whatever their range. If the middle of the scene then gets less than 0.25 or more
//! than 4, all lights and all emission are scaled alike to give it 1, with a warning.
//! The first camera is the view unless the options name another one of the shown nodes, and its
//! aspect ratio is that of the picture. The scale of its node is ignored. An orthographic camera
//! shows all of its width and height, and nothing behind it.

mod accessor;
mod bake;
mod cameras;
mod container;
mod coverage;
mod document;
mod extensions;
mod geometry;
mod lenient_json;
mod lights;
mod materials;
mod mesh_instances;
mod morph;
mod nodes;
mod placements;
mod reader;
mod skins;
mod source;
mod stored_space;
mod triangle_indices;
mod unsupported;
mod version;
mod vertex_columns;
mod vertices;

pub(super) use reader::{read, text};
