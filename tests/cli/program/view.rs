//! `phalanx view`: what its server gives to whom.

use super::signals::signal;
use super::{SCENE, TestFolder};
use phalanx::formats::read_test;
use phalanx::frame::{Accel, AccelRef, Engine, Settings};
use phalanx::{Ray, RayFilter};
use serde_json::{Value, json};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A served scene.
pub struct ViewProcess {
    pub child: Child,
    pub address: String,
    pub token: String,
}

/// An answer: status, headers, body.
pub struct HttpAnswer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl HttpAnswer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {}", self.head))
    }

    pub fn header(&self, name: &str) -> &str {
        let lines = self.head.lines();
        let field = lines
            .filter_map(|line| line.split_once(": "))
            .find(|(known, _)| *known == name);
        field.unwrap_or_else(|| panic!("{name} in {}", self.head)).1
    }
}

impl ViewProcess {
    pub fn start(folder: &TestFolder, line: &str) -> ViewProcess {
        ViewProcess::spawn(&mut folder.command(line))
    }

    pub fn spawn(command: &mut Command) -> ViewProcess {
        ViewProcess::spawn_with_stderr(command.stderr(Stdio::null()))
    }

    pub fn spawn_with_stderr(command: &mut Command) -> ViewProcess {
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut first = String::new();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        out.read_line(&mut first).unwrap();
        let rest = first.trim().strip_prefix("http://").expect(&first);
        let (address, token) = rest.trim_end_matches('/').split_once('/').unwrap();
        let served = ViewProcess {
            address: address.to_owned(),
            token: token.to_owned(),
            child,
        };
        while served.post("state", json!({})).json()["stage"] != "ready" {
            std::thread::sleep(Duration::from_millis(20));
        }
        served
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.address).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(60)))
            .unwrap();
        stream
    }

    /// The answer to a request of these bytes, after which the connection is closed.
    pub fn ask(&self, request: &str) -> HttpAnswer {
        let reply = self.try_to_ask(request);
        reply.unwrap_or_else(|error| panic!("{request:.99}: {error}"))
    }

    pub fn try_to_ask(&self, request: &str) -> std::io::Result<HttpAnswer> {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes())?;
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes)?;
        let end = bytes
            .windows(4)
            .position(|four| four == b"\r\n\r\n")
            .expect("a head");
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        Ok(HttpAnswer {
            status: head.split(' ').nth(1).unwrap().parse().unwrap(),
            body: bytes[end + 4..].to_vec(),
            head,
        })
    }

    pub fn request(&self, host: &str, more: &str, name: &str, body: &str) -> String {
        let (token, length) = (&self.token, body.len());
        let method = if body.is_empty() { "GET" } else { "POST" };
        format!(
            "{method} /{token}/{name} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\
             Content-Length: {length}\r\n{more}\r\n{body}"
        )
    }

    pub fn post(&self, name: &str, mut body: Value) -> HttpAnswer {
        body["page"] = json!("00112233445566aa");
        self.ask(&self.request(&self.address, "", name, &body.to_string()))
    }
}

impl Drop for ViewProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn view() -> Value {
    json!({ "eye": [0.5, 0.25, 4.5], "center": [0, 0.125, 0], "up": [0, 1, 0], "fovy": 40, "ortho": null })
}

pub fn shot(mode: &str, samples: u32) -> Value {
    json!({ "view": view(), "size": [40, 24], "mode": mode, "samples": samples })
}

pub fn frame(mode: &str, have: u32, samples: u32) -> Value {
    let mut request = shot(mode, samples);
    request["have"] = json!(have);
    request["moving"] = json!(false);
    request["pixels"] = json!(1_000_000);
    request["jpeg"] = json!(false);
    request
}

#[test]
fn what_is_kept_is_what_its_command_writes() {
    let room = TestFolder::new();
    let served = ViewProcess::start(&room, "view a.test --exposure=0.5");
    for (mode, samples) in [
        ("shaded", 1),
        ("shaded", 2),
        ("shaded", 3),
        ("ao", 4),
        ("normals", 1),
        ("depth", 1),
        ("cost", 1),
    ] {
        let reply = served.post("command", shot(mode, samples)).json();
        let command = reply["command"].as_str().unwrap();
        room.ok(command.strip_prefix("phalanx ").unwrap());
        let saved = served.post("save", shot(mode, samples));
        let name = saved
            .header("Content-Disposition")
            .split('"')
            .nth(1)
            .unwrap();
        let rendered = std::fs::read(room.path().join(name)).unwrap();
        assert!(saved.body == rendered, "{mode}, {samples}: {command}");
    }
    // The sequence that the page's key frames make.
    let mut keyframes = shot("shaded", 1);
    keyframes["keyframes"] = json!(true);
    let reply = served.post("command", keyframes).json();
    room.write(
        "views.txt",
        "0 0 1 5 0 0 0 0 1 0 45\n2 1 1 5 0 0 0 0 1 0 45\n",
    );
    room.ok(reply["command"]
        .as_str()
        .unwrap()
        .strip_prefix("phalanx ")
        .unwrap());
    assert!(
        room.names().contains(&"a.0002.png".to_owned()),
        "{:?}",
        room.names()
    );
}

#[test]
fn a_picture_at_rest_gets_better_and_a_moving_one_comes_at_once() {
    let room = TestFolder::new();
    let served = ViewProcess::start(&room, "view a.test");
    let mut have = 0;
    while have < 4 {
        let reply = served.post("frame", frame("shaded", have, 4));
        let info: Value = serde_json::from_str(reply.header("Frame")).unwrap();
        let samples = info["samples"].as_u64().unwrap() as u32;
        assert!(samples > have && samples <= 4, "{info}");
        assert_eq!(reply.body.len(), 40 * 24 * 4);
        have = samples;
        let mut want = reply.body;
        if samples == 4 {
            let saved = served.post("save", shot("shaded", 4));
            let path = room.path().join("saved.png");
            fs::write(&path, &saved.body).unwrap();
            let picture = phalanx::image::load(&path).unwrap();
            want.iter_mut()
                .skip(3)
                .step_by(4)
                .for_each(|alpha| *alpha = 255);
            let rgba = picture.pixels.as_flattened();
            assert!(rgba.iter().map(|&sample| (sample >> 8) as u8).eq(want));
        }
    }
    assert_eq!(served.post("frame", frame("shaded", 4, 4)).status, 204);
    for mode in [
        "normals",
        "depth",
        "albedo",
        "primitives",
        "materials",
        "cost",
    ] {
        let reply = served.post("frame", frame(mode, 0, 64));
        assert_eq!(
            (reply.status, reply.body.len()),
            (200, 40 * 24 * 4),
            "{mode}"
        );
    }
    let mut moving = frame("shaded", 0, 64);
    moving["moving"] = json!(true);
    moving["pixels"] = json!(240);
    moving["jpeg"] = json!(true);
    let reply = served.post("frame", moving);
    let info: Value = serde_json::from_str(reply.header("Frame")).unwrap();
    assert_eq!(
        (&info["width"], &info["height"]),
        (&json!(20), &json!(12)),
        "{info}"
    );
    assert_eq!(reply.body[..2], [0xff, 0xd8]);
}

#[test]
fn a_pixel_has_the_numbers_of_the_library() {
    let room = TestFolder::new();
    let served = ViewProcess::start(&room, "view a.test");
    let scene = read_test(SCENE).unwrap().scene;
    let reply = served.post("state", json!({})).json();
    let accel = Accel::build(&scene, Engine::Simd);
    let AccelRef::Packets(bvh) = accel.accel() else {
        panic!("packets")
    };
    let settings = Settings::of(&scene);
    let mut hits = 0;
    for (x, y) in (0..40)
        .step_by(7)
        .flat_map(|x| (0..24).step_by(5).map(move |y| (x, y)))
    {
        let request = json!({ "view": reply["scene"]["view"], "size": [40, 24], "x": x, "y": y });
        let pixel = served.post("pixel", request).json();
        let [origin, direction] = settings.first_ray(&scene, x, y).unwrap();
        let hit = bvh.intersect_filtered(&Ray::new(origin, direction), &RayFilter::default());
        let number = |name: &str| pixel["hit"][name].as_f64().map(|number| number as f32);
        assert_eq!(number("t"), hit.map(|hit| hit.t), "{x}, {y}: {pixel}");
        assert_eq!(number("u"), hit.map(|hit| hit.u));
        assert_eq!(
            pixel["hit"]["primitive"].as_u64(),
            hit.map(|hit| hit.prim_id.into())
        );
        hits += usize::from(hit.is_some());
    }
    assert!(hits > 4);
    assert_eq!(
        served
            .post(
                "pixel",
                json!({ "view": view(), "size": [4, 4], "x": 4, "y": 0 })
            )
            .status,
        400
    );
}

#[test]
fn surfaces_that_a_picture_passes_are_listed() {
    let room = TestFolder::new();
    let data = "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    // The back of a single-sided triangle before the front of another.
    let file = json!({
        "asset": {"version": "2.0"},
        "nodes": [
            {"mesh": 0, "name": "seen"},
            {"mesh": 0, "name": "passed", "rotation": [0, 1, 0, 0], "translation": [1, 0, 1]}
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"name": "red"}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": data}]
    });
    room.write("s.gltf", &file.to_string());
    room.ok("build s.gltf -o s.phx");
    for scene in ["s.gltf", "s.phx"] {
        let served = ViewProcess::start(&room, &format!("view {scene}"));
        let ahead = json!({ "eye": [0.4, 0.2, 5], "center": [0.4, 0.2, 0], "up": [0, 1, 0], "fovy": 40, "ortho": null });
        let request = json!({ "view": ahead, "size": [9, 9], "x": 4, "y": 4, "bounds": true });
        let pixel = served.post("pixel", request).json();
        assert_eq!(pixel["hit"]["object"], "seen", "{pixel}");
        assert_eq!(pixel["passed"].as_array().map(Vec::len), Some(1), "{pixel}");
        assert_eq!(pixel["passed"][0]["object"], "passed");
        // The triangle's own, padded.
        let high = pixel["bounds"][1][0].as_f64().unwrap();
        assert!((1.0..1.001).contains(&high), "{pixel}");
    }
}

#[test]
fn nothing_is_given_to_those_without_the_token_or_from_elsewhere() {
    let room = TestFolder::new();
    let served = ViewProcess::start(&room, "view a.test");
    let (address, port) = (&served.address, served.address.split(':').nth(1).unwrap());
    let page = served.ask(&served.request(address, "", "", ""));
    assert_eq!(page.status, 200);
    let policy = page.header("Content-Security-Policy");
    assert!(
        policy.starts_with("default-src 'none'; script-src 'nonce-"),
        "{policy}"
    );
    let body = frame("shaded", 0, 1);
    let mut body = body.as_object().unwrap().clone();
    body.insert("page".to_owned(), json!("00112233445566aa"));
    let body = Value::from(body).to_string();
    for (host, more, status) in [
        (address.as_str(), "", 200),
        (&format!("localhost:{port}"), "", 200),
        // Forwarded from another port.
        ("localhost:8000", "Origin: http://localhost:8000\r\n", 200),
        ("evil.example", "", 404),
        (&format!("evil.example:{port}"), "", 404),
        (&format!("127.0.0.1.evil.example:{port}"), "", 404),
        ("", "", 404),
        (address, "Origin: http://evil.example\r\n", 404),
        (address, "Origin: null\r\n", 404),
        (address, "Origin: http://localhost:1\r\n", 404),
    ] {
        let reply = served.ask(&served.request(host, more, "frame", &body));
        assert_eq!(reply.status, status, "{host} {more}");
    }
    let token = &served.token;
    for path in [
        "/".to_owned(),
        "/frame".to_owned(),
        format!("/{token}"),
        format!("/{}/frame", &token[1..]),
        format!("/{}-/frame", &token[..31]),
        format!("/{token}0/frame"),
        format!("/{token}/../a.test"),
        format!("/{token}/a.test"),
        format!("/{token}//etc/passwd"),
    ] {
        let request = served.request(address, "", "frame", &body);
        let request = request.replacen(&format!("/{token}/frame"), &path, 1);
        let reply = served.ask(&request);
        assert_eq!(reply.status, 404, "{path}");
        assert_eq!(reply.json(), json!({ "error": "there is nothing here" }));
    }
}

#[test]
fn bad_requests_are_refused_and_the_next_one_is_served() {
    let room = TestFolder::new();
    let mut served = ViewProcess::start(&room, "view a.test");
    let wrong = |change: fn(&mut Value)| {
        let mut sent = frame("shaded", 0, 1);
        change(&mut sent);
        sent
    };
    let changes: [fn(&mut Value); 9] = [
        |sent| sent["size"] = json!([0, 24]),
        |sent| sent["size"] = json!([100_000, 100_000]),
        |sent| sent["size"] = json!([-1, 24]),
        |sent| sent["samples"] = json!(0),
        |sent| sent["samples"] = json!(1_000_000),
        |sent| sent["mode"] = json!("<script>"),
        |sent| sent["view"]["eye"] = sent["view"]["center"].clone(),
        |sent| sent["view"]["eye"] = json!([1e300, 0, 0]),
        |sent| sent["view"]["fovy"] = json!(180),
    ];
    for change in changes {
        let sent = wrong(change);
        let reply = served.post("frame", sent.clone());
        assert_eq!(reply.status, 400, "{sent}");
        assert!(reply.json()["error"].is_string());
    }
    for (request, status) in [
        ("\0\u{1}\u{2}\r\n\r\n".to_owned(), 400),
        (
            format!("GET / HTTP/1.1\r\nX: {}\r\n\r\n", "x".repeat(70_000)),
            431,
        ),
        (
            "POST / HTTP/1.1\r\nContent-Length: 99999999\r\n\r\n".to_owned(),
            413,
        ),
        (
            "POST / HTTP/1.1\r\nContent-Length: 5\r\nContent-Length: 6\r\n\r\n".to_owned(),
            400,
        ),
        ("DELETE / HTTP/1.1\r\n\r\n".to_owned(), 405),
    ] {
        assert_eq!(served.ask(&request).status, status, "{request:.40}");
    }
    // Half requests, and requests whose answers nobody reads, hold only their own connections.
    let mut held = Vec::new();
    for k in 0..200 {
        let mut stream = served.connect();
        let body = frame("shaded", 0, 64).to_string();
        let request = served.request(&served.address, "", "frame", &body);
        let part = &request.as_bytes()[..(k * 7) % request.len()];
        // Beyond the most connections, the server may have closed it.
        let _ = stream.write_all(part);
        held.push(stream);
    }
    drop(held.split_off(20));
    let state = json!({ "page": "00112233445566aa" }).to_string();
    let state = served.request(&served.address, "", "state", &state);
    while !served
        .try_to_ask(&state)
        .is_ok_and(|reply| reply.status == 200)
    {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(served.post("frame", frame("shaded", 0, 1)).status, 200);
    drop(held);
    signal(&served.child, "INT");
    assert_eq!(served.child.wait().unwrap().code(), Some(130));
}

#[test]
fn a_view_that_cannot_be_is_refused_like_a_render() {
    let room = TestFolder::new();
    let size = &["--size 3000x2000", "at most 4194304 pixels"];
    room.refused("view a.test --size 3000x2000", 2, size);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let taken = listener.local_addr().unwrap();
    room.refused("view b.test", 1, &["cannot read b.test", "No such file"]);
    room.refused("view standard:nothing", 2, &["no standard scene is called"]);
    room.refused(
        "view a.test --aov depth",
        2,
        &["--aov has no effect with view"],
    );
    room.refused("view a.test --engine scalar", 2, &["--engine scalar"]);
    room.refused(
        "view a.test --address 0.0.0.0:8000",
        2,
        &["0.0.0.0", "loopback", "ssh -L"],
    );
    room.refused(
        &format!("view a.test --address {taken}"),
        1,
        &["cannot listen", "--address"],
    );
    drop(listener);
    // Errors of the reader go to the page and to stderr.
    room.write("bad.test", "size 4 4\nsphere 0 0\n");
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    let output = command
        .current_dir(room.path())
        .args(["view", "bad.test"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&output.stderr).contains("bad.test:2:"));
}
