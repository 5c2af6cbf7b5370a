//! `phalanx view` in Chromium: the page is used with mouse and keys, and what it keeps is compared
//! with what its commands render.
//!
//! `PHALANX_SHOTS=FOLDER` keeps screenshots there, and `PHALANX_VIEW=SCENE` adds a scene.

use super::devtools::Browser;
use super::{BEYOND, CONTRAST, keep_shot};
use phalanx::bvh::Bvh;
use phalanx::formats::Options;
use phalanx::frame::{Sampling, Settings};
use phalanx::glam::DVec3;
use phalanx::open::open;
use phalanx::scene::FileView;
use phalanx::{Ray, RayFilter};
use serde_json::{Value, json};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// A page that shows a scene, and the program that serves it.
struct OpenPage {
    program: Child,
    browser: Browser,
    folder: TempDir,
    scene: String,
}

impl OpenPage {
    /// Opens a page of 1280 by 800 pixels, and waits for its picture.
    fn of(scene: &str, browser: Browser) -> OpenPage {
        let mut program = Command::new(env!("CARGO_BIN_EXE_phalanx"));
        program.args(["view", scene, "--spp", "2"]);
        let mut program = program
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("it runs");
        let mut line = String::new();
        let mut out = BufReader::new(program.stdout.take().expect("it is piped"));
        out.read_line(&mut line).expect("an address");
        let folder = tempfile::tempdir().expect("a folder");
        let mut page = OpenPage {
            program,
            browser,
            folder,
            scene: scene.to_owned(),
        };
        page.resize((1280, 800), "dark");
        let place = page.folder.path().to_str().expect("a path").to_owned();
        let downloads = json!({ "behavior": "allow", "downloadPath": place });
        page.browser.call("Page.setDownloadBehavior", downloads);
        page.browser
            .call("Page.navigate", json!({ "url": line.trim() }));
        page.browser.wait_for("Page.loadEventFired");
        page.until("window.phalanx?.frame");
        page.rest();
        page
    }

    fn resize(&mut self, (width, height): (u32, u32), scheme: &str) {
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
        self.browser
            .call("Emulation.setDeviceMetricsOverride", metrics);
        let feature = json!({ "name": "prefers-color-scheme", "value": scheme });
        self.browser.call(
            "Emulation.setEmulatedMedia",
            json!({ "features": [feature] }),
        );
    }

    /// Waits until an expression holds.
    fn until(&mut self, expression: &str) {
        for _ in 0..1200 {
            if self.browser.evaluate(&format!("!!({expression})")) == json!(true) {
                return;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        panic!("{}: never {expression}", self.scene);
    }

    /// Waits for the best picture of what is seen.
    fn rest(&mut self) {
        self.browser.evaluate("phalanx.idle()");
        let plain = "(() => { const c = document.getElementById('picture'); \
            const { data } = c.getContext('2d').getImageData(0, 0, c.width, c.height); \
            return new Set(new Uint32Array(data.buffer)).size; })()";
        let colors = self.browser.evaluate(plain).as_u64().expect("a number");
        assert!(colors > 1, "{}: a picture of {colors} colours", self.scene);
    }

    fn view(&mut self) -> Value {
        self.browser.evaluate("phalanx.view()")
    }

    /// Asserts that a gesture changes the view, and waits for the picture.
    fn moves(&mut self, gesture: &str, make: impl FnOnce(&mut OpenPage)) {
        let now = "JSON.stringify(phalanx.view())";
        self.browser.evaluate(&format!("window.before = {now}"));
        make(self);
        eprintln!("{}: {gesture}", self.scene);
        self.until(&format!("window.before !== {now}"));
        self.rest();
    }

    fn mouse(&mut self, kind: &str, (x, y): (f64, f64), more: Value) {
        let mut event = json!({ "type": kind, "x": x, "y": y, "button": "left" });
        for (name, value) in more.as_object().into_iter().flatten() {
            event[name] = value.clone();
        }
        self.browser.call("Input.dispatchMouseEvent", event);
    }

    fn drag(&mut self, modifiers: u32) {
        let more =
            |buttons: u32| json!({ "buttons": buttons, "clickCount": 1, "modifiers": modifiers });
        self.mouse("mousePressed", (400.0, 300.0), more(1));
        for k in 1..=12 {
            let point = (400.0 + 6.0 * f64::from(k), 300.0 + 2.0 * f64::from(k));
            self.mouse("mouseMoved", point, more(1));
        }
        self.mouse("mouseReleased", (472.0, 324.0), more(0));
    }

    fn click(&mut self, point: (f64, f64), count: u32) {
        for clicks in 1..=count {
            let more = json!({ "clickCount": clicks, "buttons": 1 });
            self.mouse("mousePressed", point, more.clone());
            self.mouse("mouseReleased", point, more);
        }
    }

    fn key(&mut self, key: &str, code: &str) {
        for kind in ["keyDown", "keyUp"] {
            let event = json!({ "type": kind, "key": key, "code": code });
            self.browser.call("Input.dispatchKeyEvent", event);
            std::thread::sleep(Duration::from_millis(80));
        }
    }

    fn press(&mut self, button: &str) {
        self.browser
            .evaluate(&format!("document.getElementById('{button}').click()"));
    }

    /// Measures the exposure, chooses the neutral tone, and then none of them.
    fn expose(&mut self) {
        let change = |id: &str, set: &str| {
            format!(
                "(() => {{ const e = document.getElementById('{id}'); e.{set}; \
                 e.dispatchEvent(new Event('change', {{ bubbles: true }})); }})()"
            )
        };
        let stops = "document.getElementById('stops').value";
        self.browser.evaluate(&change("stops", "value = '-7'"));
        self.press("meter");
        self.until(&format!("{stops} !== '-7'"));
        self.browser.evaluate(&change("neutral", "checked = true"));
        self.rest();
        self.shot("exposed");
        self.keep();
        let command = self
            .browser
            .evaluate("document.getElementById('text').value");
        assert!(command.to_string().contains("--tone neutral"), "{command}");
        self.browser.evaluate(&change("stops", "value = '0'"));
        self.browser.evaluate(&change("neutral", "checked = false"));
        self.rest();
    }

    /// Saves the picture, and renders it by the command that the page gives.
    fn keep(&mut self) {
        let copied = "document.getElementById('text').value";
        self.browser
            .evaluate("document.getElementById('text').value = ''");
        self.press("copy");
        self.until(copied);
        let command = self.browser.evaluate(copied);
        let command = command.as_str().expect("a command");
        let name = command
            .split(" -o ")
            .nth(1)
            .expect("a file")
            .split(' ')
            .next()
            .expect("its name");
        let name = command
            .split(" --heat nodes ")
            .nth(1)
            .unwrap_or(name)
            .to_owned();
        let file = self.folder.path().join(&name);
        self.press("save");
        for _ in 0..600 {
            if file.exists() {
                break;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        let saved = fs::read(&file).expect("a saved picture");
        let rest = command.strip_prefix("phalanx").expect("our command");
        let mut shell = Command::new("sh");
        let line = format!("exec {}{rest}", env!("CARGO_BIN_EXE_phalanx"));
        // The scene's path is relative to where the program was started.
        let here = std::env::current_dir().expect("a folder");
        let rendered = tempfile::tempdir().expect("a folder");
        let scene = here.join(&self.scene);
        let line = if scene.exists() {
            line.replace(&self.scene, scene.to_str().expect("a path"))
        } else {
            line
        };
        let ran = shell
            .args(["-c", &line])
            .current_dir(rendered.path())
            .output()
            .expect("a shell");
        assert!(
            ran.status.success(),
            "{line}: {}",
            String::from_utf8_lossy(&ran.stderr)
        );
        let rendered = fs::read(rendered.path().join(&name)).expect("a rendered picture");
        assert!(saved == rendered, "{}: {line}", self.scene);
        fs::remove_file(file).expect("it is there");
    }

    /// Pins the pixel in the middle, and compares it with the library's answer.
    fn pin(&mut self) {
        self.press("unpin");
        self.click((450.0, 320.0), 1);
        self.until("phalanx.pinned");
        let (pinned, view) = (self.browser.evaluate("phalanx.pinned"), self.view());
        let size = self
            .browser
            .evaluate("[phalanx.frame.width, phalanx.frame.height]");
        let side = |k: usize| size[k].as_u64().expect("a side") as u32;
        let mut scene = open(Path::new(&self.scene), &Options::default())
            .expect("a scene")
            .scene;
        let vector = |name: &str| {
            DVec3::from_array([0, 1, 2].map(|k| view[name][k].as_f64().expect("a number")))
        };
        scene.view = scene.view_of(&FileView {
            eye: vector("eye"),
            center: vector("center"),
            up: vector("up").as_vec3(),
            fovy: view["fovy"].as_f64().expect("an angle") as f32,
            ortho: view["ortho"].as_f64(),
        });
        let settings = Settings {
            width: side(0),
            height: side(1),
            sampling: Sampling::CENTER,
            ..Settings::of(&scene)
        };
        let pixel = |k: usize| pinned["pixel"][k].as_u64().expect("a pixel") as u32;
        let ray = settings.first_ray(&scene, pixel(0), pixel(1));
        let [origin, direction] = ray.expect("a camera");
        let bvh = Bvh::build(&scene);
        let hit = bvh.intersect_filtered(&Ray::new(origin, direction), &RayFilter::default());
        let number = |name: &str| {
            pinned["hit"][name]
                .as_f64()
                .map(|number| (number as f32).to_bits())
        };
        assert_eq!(number("t"), hit.map(|hit| hit.t.to_bits()), "{pinned}");
        assert_eq!(number("u"), hit.map(|hit| hit.u.to_bits()));
        assert_eq!(number("v"), hit.map(|hit| hit.v.to_bits()));
        assert_eq!(
            pinned["hit"]["primitive"].as_u64(),
            hit.map(|hit| hit.prim_id.into())
        );
    }

    /// Every gesture, mode and file.
    fn try_everything(&mut self) {
        self.moves("orbit", |page| page.drag(0));
        self.moves("pan", |page| page.drag(8));
        self.moves("dolly", |page| {
            page.mouse(
                "mouseWheel",
                (400.0, 300.0),
                json!({ "deltaX": 0, "deltaY": -120 }),
            );
        });
        self.moves("undo", |page| page.press("undo"));
        self.moves("fly", |page| page.key("w", "KeyW"));
        self.key("Escape", "Escape");
        self.keep();
        self.pin();
        self.moves("frame", |page| page.click((450.0, 320.0), 2));
        self.moves("frame all", |page| page.key("f", "KeyF"));
        self.expose();
        for (k, mode) in [
            "ao",
            "normals",
            "depth",
            "albedo",
            "primitives",
            "materials",
            "cost",
        ]
        .into_iter()
        .enumerate()
        {
            let digit = (k + 2).to_string();
            self.key(&digit, &format!("Digit{digit}"));
            self.until(&format!("phalanx.mode() === '{mode}'"));
            self.rest();
            self.shot(mode);
            if ["ao", "normals", "cost"].contains(&mode) {
                self.keep();
            }
        }
        self.key("1", "Digit1");
        self.rest();
        let latency = self
            .browser
            .evaluate("JSON.stringify([phalanx.latency, phalanx.fps])");
        eprintln!("{}: latency and frames per second {latency}", self.scene);
    }

    fn shot(&mut self, what: &str) {
        let name: String = self
            .scene
            .chars()
            .map(|c| if c.is_alphanumeric() { c } else { '-' })
            .collect();
        let start = name.len().saturating_sub(24);
        keep_shot(&mut self.browser, &format!("view{}-{what}", &name[start..]));
    }

    /// Widths and colour schemes, with a pinned pixel and a key frame.
    fn look(&mut self) {
        self.press("add");
        for (size, scheme) in [
            ((1280, 800), "dark"),
            ((1280, 800), "light"),
            ((390, 800), "dark"),
            ((390, 800), "light"),
        ] {
            self.resize(size, scheme);
            std::thread::sleep(Duration::from_millis(300));
            self.rest();
            let place = format!("{} {scheme}", size.0);
            self.shot(&place.replace(' ', "-"));
            let sizes = self
                .browser
                .evaluate("[innerWidth, document.documentElement.scrollWidth]");
            assert_eq!(sizes, json!([size.0, size.0]), "{place}");
            assert_eq!(self.browser.evaluate(BEYOND), json!([]), "{place}");
            let contrast = self.browser.evaluate(CONTRAST).as_f64().expect("a number");
            assert!(contrast >= 4.5, "{place}: contrast {contrast}");
        }
    }

    /// Asserts that the browser has complained about nothing, and has asked nobody else.
    fn close(mut self) -> Browser {
        let events = self.browser.events();
        let bad = |event: &&Value| match event["method"].as_str() {
            // The test reads the canvas itself.
            Some("Log.entryAdded") => event["params"]["entry"]["source"] != "rendering",
            Some("Runtime.consoleAPICalled" | "Runtime.exceptionThrown") => true,
            Some("Network.requestWillBeSent") => {
                let url = event["params"]["request"]["url"]
                    .as_str()
                    .unwrap_or_default();
                !["http://127.0.0.1:", "data:", "blob:"]
                    .iter()
                    .any(|start| url.starts_with(start))
            }
            _ => false,
        };
        let complaints: Vec<&Value> = events.iter().filter(bad).collect();
        assert_eq!(complaints, Vec::<&Value>::new(), "{}", self.scene);
        // The page takes its leave while there is a program.
        self.browser
            .call("Page.navigate", json!({ "url": "about:blank" }));
        self.browser.wait_for("Page.loadEventFired");
        let _ = self.program.kill();
        let _ = self.program.wait();
        self.browser.events();
        self.browser
    }
}

#[test]
fn a_scene_can_be_looked_around_and_kept() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let cameras = folder.path().join("cameras.gltf");
    fs::write(&cameras, TWO_CAMERAS).expect("a scene");
    let cameras = cameras.to_str().expect("a path").to_owned();
    let mut scenes = vec!["standard:street:100k".to_owned(), cameras.clone()];
    scenes.extend(std::env::var("PHALANX_VIEW"));
    for scene in scenes {
        let mut page = OpenPage::of(&scene, browser);
        page.try_everything();
        if scene == cameras {
            page.moves("another camera", |page| {
                page.browser.evaluate(
                    "const s = document.getElementById('camera'); s.value = '1'; \
                     s.dispatchEvent(new Event('change', { bubbles: true }))",
                );
            });
            assert_eq!(page.view()["eye"], json!([0.25, 0.25, 3]));
            page.keep();
        }
        page.look();
        browser = page.close();
    }
}

/// Two triangles before two cameras.
const TWO_CAMERAS: &str = r#"{
    "asset": {"version": "2.0"},
    "nodes": [
        {"mesh": 0, "name": "sail"},
        {"mesh": 0, "name": "jib", "translation": [0.4, 0.1, -0.5]},
        {"camera": 0, "name": "from afar", "translation": [0.5, 0.5, 5]},
        {"camera": 1, "name": "near", "translation": [0.25, 0.25, 3]}
    ],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
    "materials": [{"name": "red", "doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.1, 0.1, 1]}}],
    "cameras": [
        {"type": "perspective", "perspective": {"yfov": 0.6, "znear": 1}},
        {"type": "perspective", "perspective": {"yfov": 0.9, "znear": 1}}
    ],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]
}"#;
