//! A scene in the browser: look around, find the picture, see the rays per second.
//!
//! ```text
//!  page ── connection ──> server ── routes ──> queue ──> tracer
//!                                                          │ moving: pace, one small frame
//!                                                          │ at rest: a frame refined in slices
//!                                                          │ under the pointer: pixel
//!                                                          └ to keep: command, file
//! ```
//!
//! | file | contents |
//! |---|---|
//! | `answer_memory` | memory of answers that wait to be read |
//! | `connection` | HTTP over one socket, with a deadline for every step |
//! | `server` | the loopback address, connections and their threads |
//! | `guard` | the token, and the places that requests may come from |
//! | `served_scene` | state that all connections share |
//! | `routes` | what a request may ask for, and the answers |
//! | `protocol` | requests and answers as JSON |
//! | `document` | the page itself |
//! | `queue` | what the pages wait for, in turn |
//! | `tracer` | the one thread that has the scene, and traces for all pages |
//! | `viewed_scene` | the scene, its tree and its picture, seen from a page's view |
//! | `still_frame` | a page's picture at rest, which gets better |
//! | `pace` | size and bounces of frames while the camera moves |
//! | `painting` | modes: what is rendered for each, and its colours |
//! | `pixel` | what lies under a pixel |
//! | `keeping` | commands and files of pictures |
//!
//! The page asks for every frame, so that a slow connection gets fewer, and a page that is gone
//! gets none.

mod answer_memory;
mod connection;
mod document;
mod guard;
mod keeping;
mod pace;
mod painting;
mod pixel;
mod protocol;
mod queue;
mod routes;
mod served_scene;
mod server;
mod still_frame;
mod tracer;
mod viewed_scene;

pub use protocol::MAX_PIXELS;
pub use server::{Server, ServerError};
pub use viewed_scene::{PIXEL_BYTES, ViewedFacts, ViewedScene};
