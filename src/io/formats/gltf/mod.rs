//! glTF 2.0: a JSON document, and buffers in the file itself (GLB, `data:`) or beside it.
//!
//! | file | content |
//! |---|---|
//! | `container` | the chunks of a GLB |
//! | `document` | the JSON's structure |
//! | `source` | buffers, buffer views, and the spans of rows in the text |
//! | `accessor` | typed rows, sparse or not |
//! | `nodes` | the hierarchy, flattened |
//! | `geometry` | primitives: triangles, strips and fans |
//! | `mesh_instances` | equal meshes and primitives |
//! | `materials` | materials |
//! | `lights` | cameras and lights |
//! | `reader` | meshes of nodes, baked or instanced |
//!
//! # Scene
//! The default scene is shown; if there is none, the first one; without any scene, all root nodes.
//! A mesh that one node shows is baked into the world. A mesh that several nodes show is stored
//! once and instanced (it is baked if single precision could not go there and back). Copies of more
//! than 262,144 triangles are stored once and instanced, too: copies of meshes that have the same
//! accessors and materials, of such primitives of one mesh, and of meshes too large or small to be
//! instanced as they are. Skins and morph targets stay in their rest pose, points and lines are
//! left out, and animations are not played.
//!
//! # Materials
//! With base colour c, metallic m, roughness r and gloss g = max(0, 1 − 2r)² (Ks weighs the mirror
//! image as well as the highlight, so nothing rough may have any):
//!
//! | parameter | value |
//! |---|---|
//! | Kd | c · (1 − m·g) · (1 − t) |
//! | Ka | Kd / 10 |
//! | Ks | (1 − m)·g·F0 + m·g·c, F0 = 4 %, or that of KHR_materials_ior |
//! | shininess | 2/r⁴ − 2, at most 10000 |
//! | Kt | c · t, t = transmission · (1 − m) |
//! | ior | 1, as of a thin sheet; that of KHR_materials_ior if there is a volume |
//! | Ke | emissive factor · strength; 0 if it has a texture, which would have to say where |
//!
//! The base colour texture multiplies Ka and Kd. A metal with a texture, and every material with a
//! metallic-roughness texture, is shown as matt paint of its colour: one number cannot stand for a
//! picture. `BLEND` with an alpha below 1 lets 1 − alpha through, unbent; masks are ignored.
//! KHR_materials_unlit becomes Ka = c alone. KHR_materials_pbrSpecularGlossiness: Kd is its diffuse
//! colour, F0 its specular colour, r = 1 − glossiness. A primitive without a material gets the
//! user's, or the grey of all meshes.
//!
//! # Lights and cameras
//! Candela and lux over π are colours, so that a white surface facing 1 lux of light has radiance
//! 1/π. Point lights fade with the square of the distance. If the middle of the scene then gets
//! less than 0.25 or more than 4, all lights are scaled alike to give it 1, with a warning. Spot
//! lights shine to all sides, with a warning. The first perspective camera is the view, and its
//! aspect ratio is that of the picture. Orthographic ones are left out, with a warning.

mod accessor;
mod container;
mod document;
mod geometry;
mod lights;
mod materials;
mod mesh_instances;
mod nodes;
mod reader;
mod source;

pub(super) use reader::{read, text};
