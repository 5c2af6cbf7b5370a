//! `phalanx view`.

use crate::cli::options::{
    OUTPUT, SceneArgs, SceneInput, TreeArgs, WantedPicture, WorkArgs, resolve_exposure,
};
use crate::cli::output::{self, CliError, interrupt, is_dash};
use crate::view::{MAX_PIXELS, PIXEL_BYTES, Server, ServerError, ViewedFacts, ViewedScene};
use clap::Args;
use phalanx::files::shown_path;
use phalanx::frame::{AccelRef, Engine};
use phalanx::jobs::{EncodingSpec, PixelSpec};
use phalanx::open::standard_name;
use phalanx::standard::parse_spec;
use std::io::{self, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
#[command(
    mut_arg("aa", |arg| arg.hide(true)),
    mut_arg("aov", |arg| arg.hide(true)),
    mut_arg("threshold", |arg| arg.hide(true)),
    mut_arg("region", |arg| arg.hide(true)),
    mut_arg("spp", |arg| arg.help("Samples per pixel at rest [default: 64]").long_help(None)),
)]
pub struct ViewArgs {
    #[arg(help = "Scene file, cache (.phx), standard:NAME[:SIZE], or -")]
    pub scene: PathBuf,
    #[command(flatten)]
    pub scene_args: SceneArgs,
    #[command(flatten)]
    pub pixels: PixelSpec,
    #[command(flatten)]
    pub encoding: EncodingSpec,
    /// Loopback address of the page [default: any port]
    ///
    /// Address and port that only this machine reaches, as in 127.0.0.1:8000, localhost:8000 or
    /// 8000. Port 0 is any free one. [default: 127.0.0.1:0]
    #[arg(long, value_name = "IP:PORT", help_heading = OUTPUT, default_value = "127.0.0.1:0", hide_default_value = true, value_parser = parse_address)]
    pub address: SocketAddr,
    /// Open the page in the browser
    #[arg(long, help_heading = OUTPUT)]
    pub open: bool,
    #[command(flatten)]
    pub tree: TreeArgs,
    #[command(flatten)]
    pub work: WorkArgs,
}

/// Fewest pixels of a picture that is worth its page.
const MIN_PIXELS: u64 = 640 * 480;

/// Memory for the pictures of all pages where no limit is given.
const PICTURES: u64 = 2 << 30;

/// Serves the page, reads the scene, and shows it until the process is interrupted.
pub fn run(args: &ViewArgs) -> Result<(), CliError> {
    check_use(args)?;
    interrupt::listen()?;
    output::advise();
    check_scene(&args.scene)?;
    let server = Server::start(args.address)?;
    output::print(&format!("{}\n", server.url()))?;
    if args.open {
        open_browser(&server.url());
    }
    match load(args, &server) {
        Ok(scene) => server.show(scene),
        Err(error) => {
            server.fail(&error.reason());
            interrupt::remove_shortcut();
            Err(error)
        }
    }
}

/// Opens the browser on a file that leads to the address, since everybody on the machine can read
/// the arguments of a program. The file is its user's alone.
fn open_browser(url: &str) {
    let open = || -> io::Result<()> {
        let mut file = tempfile::Builder::new().suffix(".html").tempfile()?;
        write!(
            file,
            r#"<meta http-equiv="refresh" content="0; url={url}">"#
        )?;
        let (_, path) = file.keep()?;
        interrupt::keep_shortcut(path.clone());
        open::that_detached(path)
    };
    if let Err(error) = open() {
        interrupt::remove_shortcut();
        output::warning(&format!("cannot open a browser: {error}"));
    }
}

/// A socket's address; a port alone, or of localhost, is that of 127.0.0.1.
fn parse_address(text: &str) -> Result<SocketAddr, String> {
    let port = text.strip_prefix("localhost:").unwrap_or(text).parse();
    let address = port.map(|port: u16| SocketAddr::from(([127, 0, 0, 1], port)));
    let address = address.or_else(|_| text.parse());
    address.map_err(|_| "expected IP:PORT or a port, as in 127.0.0.1:8000 or 8000".to_owned())
}

/// Refuses a scene that is not there, before there is a page.
fn check_scene(name: &Path) -> Result<(), CliError> {
    if let Some(standard) = standard_name(name) {
        return Ok(parse_spec(standard).map(drop)?);
    }
    match std::fs::metadata(name) {
        Err(error) if !is_dash(name) => Err(CliError::cannot_read(shown_path(name), error)),
        _ => Ok(()),
    }
}

/// Reads the scene, and builds its tree.
fn load(args: &ViewArgs, server: &Server) -> Result<ViewedScene, CliError> {
    let (name, threads) = (&args.scene, args.work.threads);
    let picture = WantedPicture {
        size: args.pixels.size,
        turntable: false,
    };
    let mut input = SceneInput::load(name, &args.scene_args, picture, threads.unwrap_or(0))?;
    server.set_building(input.scene.id_count());
    let settings = args.work.apply(args.pixels.settings(&input.scene));
    // Pages without --size ask for as many pixels as there is memory for.
    let least = args.pixels.size.map_or(MIN_PIXELS, |_| settings.pixels());
    let bvh = input.tree(&args.tree, settings.threads)?;
    let least = least * PIXEL_BYTES;
    let memory = (input.budget).for_view(&input.scene, &bvh, &settings, least)?;
    // Many frames will use it.
    bvh.build_wide(settings.threads);
    let name = name.to_string_lossy();
    let mut spec = (args.scene_args).picture(name, &args.pixels, &args.encoding)?;
    let tree = Some(AccelRef::Packets(&bvh));
    resolve_exposure(&mut spec.encoding, &mut input, None, tree, &settings)?;
    let facts = ViewedFacts {
        memory: memory.unwrap_or(PICTURES),
        quality: args.tree.quality,
        free_name: |path| output::free_path(path, output::taken).0,
    };
    let viewed = ViewedScene::new(input.scene, bvh, spec, settings, facts);
    viewed.warning().inspect(|warning| output::warning(warning));
    Ok(viewed)
}

/// Refuses options that would have no effect.
fn check_use(args: &ViewArgs) -> Result<(), CliError> {
    let pixels = &args.pixels;
    pixels.check_use().map_err(CliError::Usage)?;
    args.scene_args.no_picture()?;
    let without = [
        ("--region", pixels.region.is_some()),
        ("--aov", !pixels.aov.is_empty()),
        ("--aa", pixels.aa.is_some()),
        ("--engine scalar", args.work.engine == Engine::Scalar),
    ];
    if let Some((width, height)) = pixels.size
        && u64::from(width) * u64::from(height) > MAX_PIXELS
    {
        return Err(CliError::Usage(format!(
            "--size {width}x{height}: a view has at most {MAX_PIXELS} pixels"
        )));
    }
    match without.into_iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(CliError::Usage(format!("{option} has no effect with view"))),
        None => Ok(()),
    }
}

impl From<ServerError> for CliError {
    fn from(error: ServerError) -> CliError {
        match error {
            ServerError::Address(_) => CliError::Usage(error.to_string()).with_hint(
                "from another machine: ssh -L 8000:localhost:8000 USER@HOST, then phalanx view SCENE --address 127.0.0.1:8000",
            ),
            ServerError::Listen { .. } => CliError::Runtime(error.to_string())
                .with_hint("choose another port with --address"),
            ServerError::System(_) => CliError::Runtime(error.to_string()),
        }
    }
}
